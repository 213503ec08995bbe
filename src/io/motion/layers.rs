//! Which layers may hold motion: by their names, else those whose names mean nothing.
//!
//! To add a name, put it into [`NAMES`], or into the motion row of the table of names if it means the same everywhere.

use super::MotionConvention;
use crate::error::Result;
use crate::io::load::opened::Opened;
use crate::io::load::sources::RoleSource;
use crate::io::roles::names;
use crate::io::roles::{Layer, Role};
use crate::io::text::is_one_of;
use std::rc::Rc;

/// Names of motion whose sign and unit differ between renderers and their settings, without case and punctuation:
/// Arnold's `motionvector`, RenderMan's `motionFore` and `motionBack`, V-Ray's `VRayVelocity`, Nuke's `forward`, Mantra's
/// `Vpixel`, `MotionVectors` of Karma, Redshift, Octane and Unreal, and the common `mv`.
const NAMES: &str = "motionvector motionvectors motionvec motionback motionbackward motionfore motionforward velocity \
                     forward backwards vectors vpixel mv mvec mvecs opticalflow flow";

/// Components that are x and y of motion, the best first. Blender's `Vector` leads to the previous frame by x and y, and
/// from the next by z and w.
const PAIRS: [[&str; 2]; 5] = [["x", "y"], ["z", "w"], ["u", "v"], ["r", "g"], ["b", "a"]];

/// Most pairs that are looked at.
const MOST_PAIRS: usize = 8;

/// The layers that may hold motion: those of the `named` layer or file, else those found by name, else all with
/// meaningless names.
///
/// # Errors
/// [`crate::Error::MissingAov`] where nothing is called so, and those of reading the header of a file.
pub(in crate::io) fn motion_sources(
    named: Option<&str>,
    main: &Rc<Opened>,
) -> Result<Vec<RoleSource>> {
    if named.is_some() {
        let resolved = RoleSource::resolve(Role::Motion, named, main)?;
        return Ok(resolved.map_or_else(Vec::new, pairs_beside));
    }
    let (Some(file), layers) = (main.exr(), &main.layers) else {
        return Ok(Vec::new());
    };
    let pairs = |layer: &Layer| pairs_of(layer, main);
    let of_motion = layers.iter().filter(|l| is_motion(l));
    // Layers whose name fixes the convention come first.
    let of_motion = of_motion.flat_map(|layer| {
        let pairs = pairs(layer).into_iter();
        pairs.map(|source| (convention_of(layer, &source).is_none(), source))
    });
    let mut named: Vec<_> = of_motion.collect();
    named.sort_by_key(|(is_open, _)| *is_open);
    let mut found: Vec<_> = named.into_iter().map(|(_, source)| source).collect();
    if found.is_empty() {
        let open = layers.iter().filter(|layer| layer.is_open(file));
        found = open.flat_map(pairs).take(MOST_PAIRS).collect();
    }
    found.truncate(MOST_PAIRS);
    Ok(found)
}

/// Whether the name of the layer that `source` was found in means motion.
#[cfg(feature = "cli")]
pub(in crate::io) fn means_motion(source: &RoleSource) -> bool {
    layer_of(source).is_some_and(is_motion)
}

/// The pairs of the layer that `source` was found in; a photo, or a channel, is one.
fn pairs_beside(source: RoleSource) -> Vec<RoleSource> {
    let pairs: Vec<_> = match layer_of(&source) {
        Some(layer) => pairs_of(layer, &source.file),
        None => Vec::new(),
    };
    match pairs.is_empty() {
        true => vec![source],
        false => pairs,
    }
}

/// The whole layer that `source` has channels of.
fn layer_of(source: &RoleSource) -> Option<&Layer> {
    let found = source.found()?;
    let is_it = |layer: &&Layer| layer.part == found.part && layer.name == found.layer;
    source.file.all_layers().find(is_it)
}

/// Whether the name of a layer means motion, whatever its sign and unit.
fn is_motion(layer: &Layer) -> bool {
    let listed = Role::Motion.names();
    let mut words = layer.said().words.iter().map(String::as_str);
    layer.matched(Role::Motion).is_some()
        && words.any(|word| listed.contains(&word) || is_one_of(word, NAMES))
}

fn pairs_of(layer: &Layer, file: &Rc<Opened>) -> Vec<RoleSource> {
    let pair = |[x, y]: [&str; 2]| {
        let channels = vec![layer.component(x)?, layer.component(y)?];
        let found = layer.with_channels(channels, None);
        Some(RoleSource::of(Role::Motion, file, Some(found), None))
    };
    PAIRS.into_iter().filter_map(pair).collect()
}

/// Whether the layer that `source` was found in has three components, as motion in world space has.
pub(super) fn has_third(source: &RoleSource) -> bool {
    layer_of(source).is_some_and(|layer| layer.components.len() == 3)
}

/// The convention implied by the name of the layer, if all writers agree on it.
pub(super) fn convention_by_name(source: &RoleSource) -> Option<MotionConvention> {
    convention_of(layer_of(source)?, source)
}

/// The same, of a source found in `layer`.
fn convention_of(layer: &Layer, source: &RoleSource) -> Option<MotionConvention> {
    let found = source.found()?;
    let is_first = layer.matched(Role::Motion)?.channels == found.channels;
    let key = names::key(names::last_word(&layer.name));
    let is_named =
        Role::Motion.names().contains(&key.as_str()) || layer.said().role == Some(Role::Motion);
    (is_first && is_named).then_some(MotionConvention::BACK)
}
