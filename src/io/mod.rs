//! Files to frames, and planes to files.

mod art_map;
pub mod camera;
pub mod colorspace;
mod depth;
mod depth_sense;
pub mod environment;
pub mod exr;
mod fence;
mod finding;
#[cfg(feature = "cli")]
mod footprint;
mod frame_sources;
pub mod inputs;
mod light_layers;
mod load;
mod names;
mod normal_encoding;
pub mod normal_space;
mod normals_of_points;
mod notes;
pub(crate) mod open;
mod opened;
pub mod output;
pub mod photo;
pub mod picture;
mod recombination;
mod role_planes;
pub mod roles;
pub mod sequence;
mod sources;
mod specular;
pub mod srgb;
mod surface;
mod surroundings;
mod survey;
pub mod svg;
mod view;
mod views;

pub use art_map::read_art_map;
pub use environment::{read_environment, read_environment_as, read_lit_sphere};
pub use finding::Finding;
#[cfg(feature = "cli")]
pub(crate) use footprint::frame_bytes;
pub use inputs::Needs;
pub use load::{Extent, InputFiles, Loaded, load};
pub use specular::{SpecularInputs, load_specular};
#[cfg(feature = "cli")]
pub(crate) use surroundings::surroundings_bytes;
pub use survey::{LayerSurvey, PartSurvey, RoleSurvey, Survey, survey};
