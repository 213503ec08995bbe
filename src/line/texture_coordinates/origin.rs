//! Position of a pixel's surface in the previous frame.

/// Position of a pixel's surface in the previous frame: between four pixels.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Origin {
    /// Column and row of the left upper one; one less than the first may be meant.
    pub(crate) left: i32,
    pub(crate) top: i32,
    /// Offset to the right of it and below.
    pub(crate) across: f32,
    pub(crate) down: f32,
    /// Which of the four show that surface, a bit each, row by row.
    pub(crate) seen: u8,
    /// Whether all of them do that have a weight.
    pub(crate) whole: bool,
}

impl Origin {
    /// Whether the surface was visible at all.
    pub(crate) fn is_known(&self) -> bool {
        self.seen != 0
    }

    /// Offset of the surface from one of the four pixels.
    #[inline(always)]
    pub(crate) fn offset(&self, k: usize) -> [f32; 2] {
        [self.across - (k % 2) as f32, self.down - (k / 2) as f32]
    }

    #[inline(always)]
    pub(crate) fn weight(&self, k: usize) -> f32 {
        let [x, y] = self.offset(k);
        (1.0 - x.abs()) * (1.0 - y.abs())
    }

    /// Column and row of one of the four, if it has a weight and is within `width` x `height`.
    #[inline(always)]
    pub(crate) fn pixel(&self, k: usize, width: usize, height: usize) -> Option<[usize; 2]> {
        let (x, y) = (self.left + (k % 2) as i32, self.top + (k / 2) as i32);
        let inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
        inside.then_some([x as usize, y as usize])
    }

    #[inline(always)]
    pub(crate) fn is_seen(&self, k: usize) -> bool {
        self.seen >> k & 1 == 1
    }
}
