//! Edges that a device found, as lists.

/// A crack with a silhouette. If it is the border of coverage, only its position counts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FoundCrack {
    /// The number of the pixel behind it: below it, or right of it.
    pub(crate) pixel: u32,
    /// Whether it is left of that pixel; otherwise above it.
    pub(crate) is_left: bool,
    /// Offset of the silhouette behind the crack's centre, in pixels.
    pub(crate) offset: f32,
    /// Strength of the edge, 0..1.
    pub(crate) strength: f32,
    /// Logarithm of the depth of its nearer side; 0 where depth is unknown.
    pub(crate) log_depth: f32,
    /// Whether the border of coverage is close beside it.
    pub(crate) is_beside: bool,
}

/// The edges of a frame.
#[derive(Debug)]
pub(crate) struct FoundEdges {
    /// The cracks that silhouettes pass, by pixel, of each pixel the one above it first.
    pub(crate) cracks: Vec<FoundCrack>,
    /// The pixels that have a crease weight, in order, with their weights.
    pub(crate) creases: Vec<(u32, f32)>,
}
