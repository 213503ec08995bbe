//! What nearly every test of the library names.

pub(crate) use crate::common::cpu;
pub(crate) use crate::common::planes::planes;
pub(crate) use crate::common::real_files::real;
pub(crate) use crate::common::*;
pub(crate) use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};
pub(crate) use relievo::engine::*;
pub(crate) use relievo::frame::*;
pub(crate) use relievo::io::inputs::*;
pub(crate) use relievo::io::{Loaded, Needs};
pub(crate) use relievo::light::environment::Environment;
pub(crate) use relievo::light::lights::{DirectionalLight, Illumination, direction_of};
pub(crate) use relievo::params::*;
pub(crate) use relievo::plan::*;
pub(crate) use relievo::product::Product;
pub(crate) use relievo::scenes::frames::*;
pub(crate) use relievo::scenes::*;
