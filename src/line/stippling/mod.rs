//! Stippling: tone in dots of about one size, dense in the dark, sparse in the light, and evenly spaced.
//!
//! Theory: weighted stippling [Sec] distributes dots by tone and evens their distances. Changes: dots are placed by
//! error diffusion [FS], which places as many as the tone requires for any gradient, in linear time, and instead of
//! Voronoi cells, neighbours closer than their tone implies repel each other. Overlapping dots cover less than the sum
//! of their areas, so more are placed; then radii are corrected so that ink matches the tone. Practice: everything is
//! computed from the tone alone, and is the same for a seed. In a sequence `settled` leaves dots on the surface as it
//! moves, and `room` gives each the size that its tone needs there.

pub(crate) mod cpu;
mod dark_dots;
mod room;
mod settled;
mod spread;
pub(crate) mod stage;

use glam::Vec2;

/// A dot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Its middle, in pixels from the upper left corner of the data window, y down.
    pub at: Vec2,
    /// Its radius, in pixels.
    pub radius: f32,
}

/// A dot as it is carried from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LaidDot {
    /// Its middle, in pixels of the window, y down.
    pub(crate) at: Vec2,
    /// Share of the area of a whole dot, 0..1.
    pub(crate) share: f32,
    /// Whether it is about to vanish.
    pub(crate) is_going: bool,
}
