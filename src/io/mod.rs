//! Files to frames, and planes to files.

mod art_map;
pub mod camera;
mod coverage;
mod depth;
mod depth_sense;
pub mod environment;
pub mod exr;
mod fence;
pub mod inputs;
mod light_layers;
mod load;
mod names;
pub mod normal_space;
mod normals;
mod normals_of_points;
pub mod output;
pub mod photo;
pub mod picture;
mod recombination;
pub mod roles;
pub mod sequence;
mod sources;
mod specular;
pub mod srgb;
mod surroundings;
mod survey;
pub mod svg;
mod view;
mod views;

pub use art_map::read_art_map;
pub use environment::{read_environment, read_environment_as, read_lit_sphere};
pub use load::{Finding, Loaded, Needs, load};
pub use specular::{SpecularInputs, load_specular};
pub use surroundings::read_surroundings;
pub use survey::{LayerSurvey, PartSurvey, RoleSurvey, Survey, survey};
