//! Files as they are stored: OpenEXR, pictures, arrays of numbers, SVG.

pub mod colorspace;
pub(super) mod exif;
pub mod exr;
pub(super) mod outline;
pub(super) mod pen_way;
pub mod photo;
pub mod picture;
pub(crate) mod svg;
