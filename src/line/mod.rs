//! Lines along the surface: the directions they follow, the strokes drawn along them. Pure kernels, no
//! files, threads or clock.

pub mod contours;
pub mod crack;
pub mod direction;
pub mod direction_field;
pub mod gaps;
pub mod hatching;
pub mod lattice;
pub mod network;
pub mod normal_rays;
pub mod patches;
pub mod polyline;
mod random;
mod response;
pub mod ridge;
pub mod round_stroke;
mod slice_texture;
mod stroke_synthesis;
mod stroke_texture;
pub mod texture_coordinates;
pub mod tonal_art_map;
