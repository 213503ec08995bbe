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

pub use crate::plan::drawing::Dot;
pub(crate) use crate::plan::drawing::LaidDot;
