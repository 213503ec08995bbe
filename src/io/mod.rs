//! Files to frames, and planes to files.

mod art_map;
mod axes;
mod borders;
mod bundle;
pub mod camera;
pub mod colorspace;
mod cryptomatte;
mod depth;
mod depth_sense;
pub mod environment;
mod exif;
pub mod exr;
mod fence;
mod finding;
#[cfg(feature = "cli")]
mod footprint;
mod frame_sources;
pub(crate) mod from_depth;
mod gloss;
mod groups;
#[cfg(feature = "cli")]
mod in_strips;
pub mod inputs;
mod integrability;
mod light_layers;
mod load;
mod map_codes;
mod map_writers;
pub mod motion;

mod names;
mod nearest;
mod noise;
mod normal_encoding;
pub mod normal_space;
mod normals_of_points;
mod notes;
mod numbers;
mod objects;
pub(crate) mod open;
mod opened;
pub mod output;
mod pen_way;
pub mod photo;
pub mod picture;
mod points;
mod recombination;
mod rims;
mod role_planes;
pub mod roles;
mod samples_of_layers;
pub mod sequence;
mod sight_turned;
mod silhouettes;
mod sources;
mod specular;
/// The sRGB curve (IEC 61966-2-1).
pub mod srgb {
    pub use crate::srgb::{decoded, encoded};
}
mod step_fit;
mod surface;
mod surroundings;
mod survey;
pub mod svg;
mod text;
mod view;
mod views;
mod words;

pub use art_map::read_art_map;
#[cfg(any(feature = "cli", feature = "host"))]
pub(crate) use borders::wrapped;
pub use environment::{read_environment, read_environment_as, read_lit_sphere};
pub use finding::Finding;
#[cfg(feature = "cli")]
pub(crate) use footprint::{
    decoding_bytes, frame_bytes, picture_size, program_bytes, surroundings_bytes,
};
#[cfg(feature = "cli")]
pub(crate) use frame_sources::motion_layer_names;
#[cfg(feature = "cli")]
pub(crate) use in_strips::InputFiles;
pub use inputs::Needs;
pub use load::{Loaded, load};
#[cfg(feature = "cli")]
pub(crate) use nearest::likest;
pub use objects::ObjectSurvey;
#[cfg(feature = "cli")]
pub(crate) use opened::{PartOfPhotos, WholePhoto};
pub use specular::{SpecularInputs, load_specular};
pub use survey::{LayerSurvey, PartSurvey, RoleSurvey, Survey, survey};
#[cfg(feature = "cli")]
pub(crate) use survey::{groups, layers};
