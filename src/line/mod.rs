//! Line drawing: stroke directions, strokes, contours and interior lines. Pure kernels, no files, threads or clock.

pub(crate) mod background;
pub mod bilevel;
pub(crate) mod canvas;
mod carried;
pub mod contours;
pub(crate) mod density;
pub(crate) mod direction;
pub(crate) mod direction_field;
pub(crate) mod drawing;
pub(crate) mod fading;
mod grid;
pub mod hatching;
mod ink_cells;
pub(crate) mod interior;
#[cfg(test)]
mod levels;
pub mod linear_camera;
pub(crate) mod normal_rays;
pub(crate) mod page;
pub mod paper;
pub(crate) mod patches;
pub(crate) mod placed;
pub mod propagation;
mod random;
mod response;
pub(crate) mod shape_tone;
pub(crate) mod slice_texture;
mod smooth_step;
pub(crate) mod specular;
pub mod stippling;
pub mod streamlines;
mod stroke_synthesis;
pub(crate) mod stroke_texture;
pub mod texture_coordinates;
pub mod tonal_art_map;
pub(crate) mod tone;
mod turning;
