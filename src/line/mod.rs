//! Lines along the surface: the directions they follow, the strokes drawn along them. Pure kernels, no
//! files, threads or clock.

pub mod contours;
pub mod crack;
pub mod direction;
pub mod gaps;
pub mod hatching;
pub mod lattice;
pub mod network;
pub mod normal_rays;
pub mod polyline;
mod random;
pub mod ridge;
pub mod round_stroke;
mod stroke_synthesis;
pub mod tonal_art_map;
