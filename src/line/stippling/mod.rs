//! Stippling: tone in dots of about one size, dense in the dark, sparse in the light, and evenly spaced.
//!
//! Theory: weighted stippling [Sec] spreads dots by tone and evens their distances. Changes: dots are placed by error
//! diffusion [FS], which lays as many as tone asks for whatever its course, in linear time, and in place of Voronoi cells
//! neighbours that are nearer than tone has them push each other away. Where dots overlap their areas add up to more than
//! they cover, so that more are laid; then radii are mended so that ink covers what tone says. Practice: all is
//! found from the tone alone, and is the same for a seed.

pub(crate) mod cpu;
mod dark_dots;
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
