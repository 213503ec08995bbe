//! Arguments that assign roles to layers and files.

use super::flags::Flag;
use super::named::{Named, given};
use super::still_camera::StillCamera;
use crate::io::inputs::{Conventions, INPUTS, Inputs, NORMAL_ENCODINGS, StoredDepth};
use crate::params::table::rows;
use std::path::Path;

rows! {
    /// Which layers and files play which role.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = INPUTS)]
    pub(crate) struct RoleArgs {
        pub(crate) named: Inputs as flatten;
        /// Heights of the surface, seen from above, in place of normals and depth: a layer of IN or a file.
        height: Option<String> =
            [hide_short_help = true, long, value_name = "NAME|FILE", conflicts_with_all = ["depth", "normal", "depth_kind", "camera"]];
        /// The camera shared by all frames of a sequence, as --save-recipe writes it where it was recovered and stands
        /// still.
        still_camera: Option<StillCamera> =
            [hide_short_help = true, long, value_name = "JSON", conflicts_with = "camera"];
    }
}

/// The flags that make layers be read by these conventions.
pub(super) fn flags_of(conventions: &Conventions) -> Vec<Flag> {
    let Conventions {
        normal_space,
        normal_encoding,
        normal_flip,
        depth_kind,
    } = conventions;
    // Heights have a flag of their own, and names that say so say it of all frames.
    let depth = depth_kind.filter(|kind| *kind != StoredDepth::Height);
    let depth = depth.map(|kind| Flag::new("depth-kind", kind.name()));
    [
        Flag::new("normal-space", normal_space.name()),
        Flag::new("normal-encoding", name(&NORMAL_ENCODINGS, normal_encoding)),
        Flag::new("normal-flip", normal_flip),
    ]
    .into_iter()
    .chain(depth)
    .collect()
}

/// The first name of a value.
fn name<T: PartialEq>(all: &[(T, &'static str)], value: &T) -> &'static str {
    let named = all.iter().find(|(one, _)| one == value);
    named.expect("every value has a word").1
}

/// What --occlusion calls that of the surface itself.
const COMPUTED: &str = "computed";

impl RoleArgs {
    /// Whether occlusion is computed rather than read.
    pub(crate) fn computes_occlusion(&self) -> bool {
        self.named.occlusion.as_deref() == Some(COMPUTED)
    }

    /// Files and layers to read with `picture`.
    pub(crate) fn inputs(&self, picture: &Path) -> Inputs {
        let mut inputs = Inputs {
            picture: picture.to_path_buf(),
            known_camera: self.still_camera.map(|still| still.0),
            ..self.named.clone()
        };
        if self.height.is_some() {
            inputs.depth.clone_from(&self.height);
            inputs.depth_kind = Some(StoredDepth::Height);
        }
        inputs
    }

    /// The layers and files that are named.
    pub(crate) fn names(&mut self) -> Vec<Named<'_>> {
        let (layers, files) = self.named.names();
        let mut all = given(layers, files);
        all.extend(given([&mut self.height], []));
        all
    }
}
