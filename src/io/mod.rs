//! Files to frames, and planes to files.

pub mod camera;
mod codec;
mod fence;
mod finding;
pub mod inputs;
mod judge;
mod load;
pub mod motion;

mod noise;
pub(crate) mod open;
pub mod output;
pub mod roles;
pub mod sequence;
/// The sRGB curve (IEC 61966-2-1).
pub mod srgb {
    pub use crate::srgb::{decoded, encoded};
}
mod text;

pub(crate) use codec::svg;
pub use codec::{colorspace, exr, photo, picture};
pub use finding::Finding;
pub use inputs::Needs;
#[cfg(any(feature = "cli", feature = "host"))]
pub(crate) use judge::borders::wrapped;
pub use judge::normal_space;
pub use load::art_map::read_art_map;
pub(crate) use load::environment;
pub use load::environment::{read_environment, read_lit_sphere};
#[cfg(feature = "cli")]
pub(crate) use load::footprint::{
    decoding_bytes, frame_bytes, picture_size, program_bytes, surroundings_bytes,
};
#[cfg(feature = "cli")]
pub(crate) use load::frame_sources::motion_layer_names;
#[cfg(feature = "host")]
pub(crate) use load::from_depth;
#[cfg(feature = "cli")]
pub(crate) use load::in_strips::InputFiles;
pub use load::objects::ObjectSurvey;
#[cfg(feature = "cli")]
pub(crate) use load::opened::{Holding, PartOfPhotos, WholePhoto};
pub use load::specular::{SpecularInputs, load_specular};
pub use load::survey::{LayerSurvey, PartSurvey, RoleSurvey, Survey, survey};
#[cfg(feature = "cli")]
pub(crate) use load::survey::{groups, layers};
pub use load::{Loaded, load};
#[cfg(feature = "cli")]
pub(crate) use roles::nearest::likest;
