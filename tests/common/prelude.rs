//! What nearly every test of the library names.

pub use super::cpu;
pub use super::planes::planes;
pub use super::real_files::real;
pub use super::*;
pub use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, Vec2, Vec3};
pub use relievo::engine::*;
pub use relievo::frame::*;
pub use relievo::io::inputs::*;
pub use relievo::io::{Loaded, Needs};
pub use relievo::light::environment::Environment;
pub use relievo::light::lights::{DirectionalLight, Illumination, direction_of};
pub use relievo::params::*;
pub use relievo::plan::*;
pub use relievo::product::Product;
pub use relievo::scenes::frames::*;
pub use relievo::scenes::*;
