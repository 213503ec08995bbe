//! Choices from a whole picture: the gain, white levels, the albedo. A picture that comes some rows at a time gives the same
//! as the whole.

use crate::frame::percentile::{InLooks, Known, PictureSample};
use crate::frame::{Extent, Frame, Mask};
use crate::plan::Plan;
use crate::plan::execution::{Execution, StripRows};
use crate::product::Product;
use std::borrow::Cow;

/// A search for something that is chosen from the pixels of a picture. All its rows are passed from top to bottom to survey
/// them, then as often as its samples are open.
pub(crate) trait Search: Send {
    /// Products of the shape that it looks at.
    fn takes(&self, _plan: &Plan) -> Vec<Product> {
        Vec::new()
    }

    /// Learns from rows of the picture what the samples depend on, before any is taken.
    fn survey(&mut self, _run: &Execution) {}

    /// Adds values of the rows to the samples.
    fn look(&mut self, run: &mut Execution);

    /// Samples of the values that it chooses by.
    fn samples(&mut self) -> Vec<&mut dyn InLooks>;

    /// Whether another look is taken.
    fn is_open(&mut self) -> bool {
        self.samples().iter().any(|sample| sample.is_open())
    }

    /// What fixes the choice in a plan, after the last look.
    fn found(self: Box<Self>) -> Settle;
}

/// Fixes a choice in a plan.
pub(crate) type Settle = Box<dyn Fn(&mut Plan) + Send + Sync>;

/// The pixels that something is chosen from, and the planes that hold them.
pub(crate) struct ChosenFrom<'a> {
    pub(crate) mask: Cow<'a, Mask>,
    pub(crate) frame: &'a Frame,
    /// Where the first pixel of the mask is in the planes of the frame.
    at: [isize; 2],
    pub(crate) strip: StripRows,
}

impl<'a> ChosenFrom<'a> {
    /// All of a frame.
    pub(crate) fn whole(frame: &'a Frame) -> Self {
        let (width, height) = (frame.mask.width(), frame.mask.height());
        Self {
            mask: Cow::Borrowed(&frame.mask),
            frame,
            at: [0, 0],
            strip: StripRows {
                rows: 0..height,
                top: 0,
                whole: [width, height],
            },
        }
    }

    /// Where a pixel of the mask is in the planes, if it is there.
    #[inline]
    pub(crate) fn place(&self, x: usize, y: usize) -> Option<[usize; 2]> {
        let place = |i: usize, at: isize, most: usize| {
            let i = i.checked_add_signed(at);
            i.filter(|&i| i < most)
        };
        let planes = &self.frame.mask;
        let x = place(x, self.at[0], planes.width())?;
        Some([x, place(y, self.at[1], planes.height())?])
    }

    /// Adds values at pixels of the planes to a sample.
    pub(crate) fn add_to<T: Known>(
        &self,
        sample: &mut PictureSample<T>,
        value: impl Fn(usize, usize) -> Option<T> + Sync,
    ) {
        let rows = self.strip.rows.clone();
        sample.add(&self.mask, rows, self.strip.top, |x, y| {
            let [x, y] = self.place(x, y)?;
            value(x, y)
        });
    }
}

impl Plan {
    /// The pixels of a frame that something is chosen from: of one that repeats a tile, the tile.
    pub(crate) fn chosen_from<'f>(&self, frame: &'f Frame) -> ChosenFrom<'f> {
        let whole = ChosenFrom::whole(frame);
        let Some(tile) = self.tile else {
            return whole;
        };
        let (window, at) = (tile.window, tile.window.relative_to(frame.data_window));
        ChosenFrom {
            mask: Cow::Owned(frame.mask.crop(frame.data_window, window)),
            at: [at.x0 as isize, at.y0 as isize],
            strip: StripRows {
                rows: 0..window.height(),
                top: 0,
                whole: [window.width(), window.height()],
            },
            ..whole
        }
    }
}

impl<'a> Execution<'a> {
    /// The pixels that something is chosen from by the picture: of a part of a frame, all of that one.
    pub(crate) fn chosen_from(&self) -> ChosenFrom<'a> {
        let mut from = match self.whole {
            Some(whole) => ChosenFrom::whole(whole),
            None => self.plan.chosen_from(self.frame),
        };
        if let Some(strip) = &self.strip {
            from.strip = strip.clone();
        }
        from
    }

    /// The pixels that something is chosen from by planes that are made: of a part of a frame, those of the part alone.
    pub(crate) fn chosen_from_made(&self) -> ChosenFrom<'a> {
        let from = self.chosen_from();
        let at = from.frame.data_window;
        let at = at.relative_to(self.frame.data_window);
        match self.whole {
            Some(_) => ChosenFrom {
                frame: self.frame,
                at: [at.x0 as isize, at.y0 as isize],
                ..from
            },
            None => from,
        }
    }

    /// Searches all of the picture.
    pub(crate) fn searched<S: Search>(&mut self, mut search: S) -> S {
        search.survey(self);
        let extent = Extent::of(&self.chosen_from().mask);
        let samples = search.samples();
        samples.into_iter().for_each(|sample| sample.begin(&extent));
        while search.is_open() {
            search.look(self);
            search.samples().into_iter().for_each(InLooks::end_look);
        }
        search
    }
}
