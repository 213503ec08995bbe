//! Groups of layers that show different things, such as Blender's view layers, and the selection of one.
//!
//! A group is called by what comes before the last word of its layers' names, as `FG` in `FG.Normal.X`, or by its part,
//! where several parts hold layers of the same names. Groups are told apart where a layer of the same name occurs in two
//! of them: `Beauty.RGBA` and `Data.N` are one frame. All other layers are plain: they play the roles that the group in
//! use does not play itself.

use crate::error::{Error, Result};
use crate::io::exr::ExrFile;
use crate::io::roles::{self, Layer, Role};
use crate::product::PART;
use crate::untrusted::{Untrusted, listed, shown};
use std::collections::HashMap;
use std::path::Path;

/// The groups of a file.
#[derive(Default)]
pub(crate) struct Groups {
    /// Their names, in the order of the file.
    pub(crate) names: Vec<String>,
    /// The one whose layers play the roles; `None` where plain layers, or those of all groups, do.
    pub(crate) taken: Option<String>,
    /// What was taken of several, where none was named.
    pub(crate) note: Option<String>,
    /// Layers that play no role unless a flag names them.
    pub(crate) apart: Vec<Layer>,
}

/// Place of the plain layers among the sets of layers; that of a group is one after its place among the names.
const PLAIN: usize = 0;

/// Keeps the layers of one group, the `wanted` or else the default one, and after them the plain ones that it lacks.
///
/// # Errors
/// [`Error::BadParameter`] if no group is called so.
pub(crate) fn keep(
    file: &ExrFile,
    layers: &mut Vec<Layer>,
    wanted: Option<&str>,
) -> Result<Groups> {
    let Marked {
        names,
        set_of,
        collide,
    } = Marked::of(file, layers);
    let there = listed(&names);
    let wanted = match wanted {
        Some(wanted) => Some(place_of(wanted, &names, &file.path)?),
        None if !collide => {
            let note = (names.len() > 1).then(|| {
                format!("layers of several groups ({there}) make up the frame: --layer NAME takes those of one")
            });
            return Ok(Groups {
                names,
                note,
                ..Groups::default()
            });
        }
        None => None,
    };
    let mut sets = vec![Vec::new(); names.len() + 1];
    for (layer, set) in layers.drain(..).zip(set_of) {
        sets[set].push(layer);
    }
    let worth: Vec<ShownByLayers> = sets
        .iter()
        .map(|layers| ShownByLayers::by(layers))
        .collect();
    // Plain layers that are no frame by themselves are shared by all groups.
    let first = usize::from(!(worth[PLAIN].normals && worth[PLAIN].picture));
    let best = |best: usize, next| {
        if worth[next] > worth[best] {
            next
        } else {
            best
        }
    };
    let taken = wanted.unwrap_or_else(|| (first..sets.len()).reduce(best).unwrap_or(PLAIN));
    let is_rival = |set: usize| set != taken && (worth[set].normals || worth[set].picture);
    let is_open = wanted.is_none() && (first..sets.len()).any(is_rival);
    *layers = std::mem::take(&mut sets[taken]);
    let plain = std::mem::take(&mut sets[PLAIN]);
    let mut apart: Vec<Layer> = sets.into_iter().flatten().collect();
    let lacked = lacked(plain, layers, &mut apart);
    layers.extend(lacked);
    let name = taken.checked_sub(1).map(|place| names[place].clone());
    let note = is_open.then(|| {
        let taken = match &name {
            Some(name) => format!("the layers of {}", Untrusted(name)),
            None => "the layers of no group".into(),
        };
        format!("{taken} are taken; of several groups ({there}) --layer NAME takes another")
    });
    Ok(Groups {
        names,
        taken: name,
        note,
        apart,
    })
}

/// What layers show by themselves, the most telling first.
#[derive(PartialEq, PartialOrd)]
struct ShownByLayers {
    normals: bool,
    /// Whether they hold the picture that programs show of the file: the bare channels of the first part.
    default_picture: bool,
    picture: bool,
}

impl ShownByLayers {
    fn by(layers: &[Layer]) -> Self {
        let plays = |role| roles::find(layers, role).is_some();
        let is_default = |l: &Layer| l.part == 0 && l.bare && l.has(&["r", "g", "b"]);
        Self {
            normals: plays(Role::Normal),
            default_picture: layers.iter().any(is_default),
            picture: plays(Role::Color),
        }
    }
}

/// The groups that layers are in.
struct Marked {
    names: Vec<String>,
    /// The set that each layer belongs to. Our own results are plain.
    set_of: Vec<usize>,
    /// Whether a layer of the same name occurs in two sets.
    collide: bool,
}

impl Marked {
    fn of(file: &ExrFile, layers: &[Layer]) -> Self {
        let is_group = parts_of_groups(file, layers);
        let group_of = |layer: &Layer| match &file.parts[layer.part].name {
            Some(part) if is_group[layer.part] => part.clone(),
            _ => layer.prefix(),
        };
        let is_own = |name: &str| name.split('.').next() == Some(PART);
        let (mut names, mut places) = (Vec::new(), HashMap::new());
        for layer in layers {
            let name = group_of(layer);
            let means = is_group[layer.part] || layer.listed_key().is_some();
            if means && !name.is_empty() && !is_own(&name) && !places.contains_key(&name) {
                names.push(name.clone());
                places.insert(name, names.len());
            }
        }
        let set_of = |layer: &Layer| {
            let place = places.get(&group_of(layer));
            let place = place.or_else(|| places.get(&layer.name));
            place.copied().unwrap_or(PLAIN)
        };
        let set_of: Vec<usize> = layers.iter().map(set_of).collect();
        let mut first: HashMap<&str, usize> = HashMap::new();
        let keys = layers.iter().map(Layer::listed_key).zip(&set_of);
        let mut keys = keys.filter_map(|(key, set)| Some((key?, *set)));
        let collide = keys.any(|(key, set)| *first.entry(key).or_insert(set) != set);
        Self {
            names,
            set_of,
            collide: collide || is_group.contains(&true),
        }
    }
}

/// The parts that are groups by themselves: those with a name that hold a layer of the same name as another part, or
/// both picture and depth without a layer's name as another part.
fn parts_of_groups(file: &ExrFile, layers: &[Layer]) -> Vec<bool> {
    let mut is_group = vec![false; file.parts.len()];
    let mut first: HashMap<&str, usize> = HashMap::new();
    for layer in layers {
        let is_frame = layer.has(&["r", "g", "b", "z"]) && !layer.means_something();
        let holds = match layer.bare {
            false if layer.is_listed() => &layer.name,
            true if is_frame => "",
            _ => continue,
        };
        let name = file.parts[layer.part].name.as_deref();
        if name.is_none_or(|name| name == PART) {
            continue;
        }
        let first = *first.entry(holds).or_insert(layer.part);
        if first != layer.part {
            is_group[first] = true;
            is_group[layer.part] = true;
        }
    }
    is_group
}

/// The plain layers without the channels of roles that the layers of a group play, which go `apart`.
fn lacked(plain: Vec<Layer>, own: &[Layer], apart: &mut Vec<Layer>) -> Vec<Layer> {
    let played = roles::assign(own);
    let lacked = plain.into_iter().filter_map(|mut layer| {
        for (role, _) in &played {
            while let Some(found) = roles::find(std::slice::from_ref(&layer), *role) {
                let [rest, taken] = layer.split(&found);
                apart.push(taken);
                layer = rest;
            }
        }
        (!layer.components.is_empty()).then_some(layer)
    });
    lacked.collect()
}

/// Refuses a group of the file `path`, which has none.
///
/// # Errors
/// [`Error::BadParameter`] if one is wanted.
pub(crate) fn refuse(wanted: Option<&str>, path: &Path) -> Result<()> {
    wanted.map_or(Ok(()), |wanted| place_of(wanted, &[], path).map(|_| ()))
}

/// The set of the group called `wanted`.
fn place_of(wanted: &str, names: &[String], path: &Path) -> Result<usize> {
    let place = names
        .iter()
        .position(|name| name.eq_ignore_ascii_case(wanted));
    place.map(|place| place + 1).ok_or_else(|| {
        let there = match names {
            [] => "none".into(),
            names => listed(names),
        };
        Error::BadParameter {
            name: "--layer",
            found: format!(
                "{} is no group of layers in {} (found {there})",
                Untrusted(wanted),
                shown(path)
            ),
            remedy: "name one that is there, or leave it out".into(),
        }
    })
}
