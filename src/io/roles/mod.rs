//! Which layer plays which role, found from its name: first from the table of names, then from its words.
//!
//! A channel is `layer.component`; the layer's own last word, without view-layer prefix, case or
//! punctuation, is looked up in one table. So `ViewLayer.Depth.Z`, `depth.V` and plain `Z` are all
//! depth, while `ViewLayer.Normal.Z` is a component of the normal.

pub(super) mod groups;
pub(super) mod names;
pub(super) mod nearest;
pub(super) mod views;
pub(super) mod words;

use crate::io::exr::{ChannelId, ExrFile, SampleType};
use names::{Arity, RULES, last_word, split_last_word};
use std::cell::OnceCell;
use std::collections::HashMap;
use std::rc::Rc;
use words::{Said, said};

pub use names::Role;

/// The channels of one part that share a name up to their component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Layer {
    /// The part the channels are in.
    pub part: usize,
    /// The name without component; the part's name where the channels have none; may be empty.
    pub name: String,
    /// Component (lower case, `r` for `red`) and channel index within the part.
    pub components: Vec<(String, usize)>,
    /// Whether the name is that of the part, with channels called only `R` or `Z`.
    pub bare: bool,
    /// Its view, such as the left eye's, if any; set before its name is looked at.
    pub view: Option<Rc<str>>,
    /// Meaning of its name, found when first asked for.
    meaning: OnceCell<Meaning>,
}

/// Meaning of a layer's name.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Meaning {
    /// Its key in the table: the last word of its name that is not its view.
    key: String,
    /// Whether it is in the table of names.
    is_listed: bool,
    /// Meaning of its words.
    said: Said,
}

/// The channels that play a role, in the order of its components.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Match {
    /// Name of the layer, as the file has it.
    pub layer: String,
    /// The part the channels are in.
    pub part: usize,
    /// One channel index for a scalar or grey layer, two for motion and for normals without z, else three.
    pub channels: Vec<usize>,
    /// The coverage channel of the layer.
    pub alpha: Option<usize>,
}

impl Match {
    /// Its channels, without coverage, by their places in the file.
    pub(crate) fn ids(&self) -> impl Iterator<Item = ChannelId> {
        let part = self.part;
        let channels = self.channels.iter();
        channels.map(move |&channel| ChannelId { part, channel })
    }
}

const COMPONENTS: &[(&str, &str)] = &[("red", "r"), ("green", "g"), ("blue", "b"), ("alpha", "a")];
const SHORT_COMPONENTS: &[&str] = &["r", "g", "b", "a", "x", "y", "z", "w", "u", "v", "t", "s"];

/// Groups the channels of a file's parts into layers, in the order of the file.
pub(crate) fn layers<'a>(
    parts: impl Iterator<Item = (Option<&'a str>, Vec<&'a str>)>,
) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (part, (part_name, channels)) in parts.enumerate() {
        let mut of_part: HashMap<&str, usize> = HashMap::new();
        for (index, channel) in channels.into_iter().enumerate() {
            let (prefix, component) = split_component(channel);
            let name = if prefix.is_empty() {
                part_name.unwrap_or("")
            } else {
                prefix
            };
            let place = *of_part.entry(name).or_insert_with(|| {
                layers.push(Layer {
                    part,
                    name: name.to_string(),
                    components: Vec::new(),
                    bare: prefix.is_empty(),
                    view: None,
                    meaning: OnceCell::new(),
                });
                layers.len() - 1
            });
            layers[place].components.push((component, index));
        }
    }
    layers
}

/// `ViewLayer.Normal.X` is `ViewLayer.Normal` and `x`; `depth` is a layer with no component.
fn split_component(channel: &str) -> (&str, String) {
    let (prefix, last) = channel.rsplit_once('.').unwrap_or(("", channel));
    let last_lower = last.to_ascii_lowercase();
    if let Some((_, short)) = COMPONENTS.iter().find(|(long, _)| *long == last_lower) {
        return (prefix, (*short).to_string());
    }
    if SHORT_COMPONENTS.contains(&last_lower.as_str()) {
        return (prefix, last_lower);
    }
    (channel, String::new())
}

impl Layer {
    /// It without the channels that `found` takes of it, and with these alone.
    pub(crate) fn split(mut self, found: &Match) -> [Self; 2] {
        let taken = |&(_, channel): &(String, usize)| {
            found.channels.contains(&channel) || found.alpha == Some(channel)
        };
        let mut rest = self.clone();
        rest.components.retain(|component| !taken(component));
        self.components.retain(taken);
        [rest, self]
    }

    /// Meaning of the words of its name.
    pub(crate) fn said(&self) -> &Said {
        &self.meaning().said
    }

    /// Whether its name means a role, by the table of names or by its words.
    pub(crate) fn means_something(&self) -> bool {
        self.is_listed() || self.said().role.is_some()
    }

    /// Whether its name means this role.
    fn means(&self, role: Role) -> bool {
        let key = self.meaning().key.as_str();
        match self.is_listed() {
            true => role.names().contains(&key),
            false => self.said().role == Some(role),
        }
    }

    /// Whether its name is a single letter, which is ambiguous: some use `c` for a picture.
    pub(crate) fn is_letter(&self) -> bool {
        self.meaning().key.len() == 1
    }

    /// Whether it is in the table of names.
    pub(crate) fn is_listed(&self) -> bool {
        self.meaning().is_listed
    }

    fn meaning(&self) -> &Meaning {
        self.meaning.get_or_init(|| {
            let key = names::key(last_word(&self.viewless_name()));
            let mut rules = RULES.iter();
            Meaning {
                is_listed: rules.any(|(_, _, names)| names.contains(&key.as_str())),
                key,
                said: said(&self.name, self.view.as_deref()),
            }
        })
    }

    /// Its name without that of its view.
    fn viewless_name(&self) -> String {
        let view = self.view.as_deref();
        let is_view = |word: &&str| view.is_some_and(|view| word.eq_ignore_ascii_case(view));
        let words: Vec<&str> = self.name.split('.').filter(|w| !is_view(w)).collect();
        words.join(".")
    }

    /// What comes before the last word of its name, but for its view.
    pub(crate) fn prefix(&self) -> String {
        split_last_word(&self.viewless_name()).0.into()
    }

    /// The last word of its name as the table has it, if it is there.
    pub(crate) fn listed_key(&self) -> Option<&str> {
        let key = self.meaning().key.as_str();
        (self.is_listed() && !key.is_empty()).then_some(key)
    }

    /// Whether it has components of all these names.
    pub(crate) fn has(&self, names: &[&str]) -> bool {
        names.iter().all(|name| self.component(name).is_some())
    }

    /// The channel of the component `name`.
    pub(crate) fn component(&self, name: &str) -> Option<usize> {
        let mut components = self.components.iter();
        components.find_map(|(own, channel)| (own == name).then_some(*channel))
    }

    /// These channels of it, for a role.
    pub(crate) fn with_channels(&self, channels: Vec<usize>, alpha: Option<usize>) -> Match {
        Match {
            layer: self.name.clone(),
            part: self.part,
            channels,
            alpha,
        }
    }

    /// Whether it could be anything: its name means nothing, and its numbers are floating-point.
    pub(crate) fn is_open(&self, file: &ExrFile) -> bool {
        !self.means_something() && !self.said().is_excluded && self.is_float(file)
    }

    pub(crate) fn is_float(&self, file: &ExrFile) -> bool {
        let channels = &file.parts[self.part].channels;
        let mut own = self
            .components
            .iter()
            .map(|&(_, c)| channels[c].sample_type);
        own.all(|kind| kind != SampleType::Uint)
    }

    /// The layer's channels in the order that `role` wants, if it has them.
    pub(crate) fn matched(&self, role: Role) -> Option<Match> {
        let component = |name: &str| self.component(name);
        let all = |names: &[&str]| {
            let found = names.iter().map(|name| component(name));
            found.collect::<Option<Vec<_>>>()
        };
        let one = |names: &[&str]| names.iter().find_map(|n| component(n)).map(|c| vec![c]);
        let alone = || (self.components.len() == 1).then(|| vec![self.components[0].1]);
        let channels = match role.arity() {
            Arity::Vector => all(&["x", "y", "z"])
                .or_else(|| all(&["r", "g", "b"]))
                .or_else(|| all(&["x", "y"]).filter(|_| role == Role::Normal)),
            Arity::Pair => [["x", "y"], ["u", "v"], ["r", "g"]]
                .iter()
                .find_map(|pair| all(pair)),
            // Beside x and z, y is no luminance; alpha alone is no colour.
            Arity::Color => all(&["r", "g", "b"])
                .or_else(|| one(&["y"]).filter(|_| component("x").is_none()))
                .or_else(|| alone().filter(|_| !role.is_color() || component("a").is_none())),
            Arity::Scalar => one(&["z", "v", "t", "", "r"]).or_else(alone),
        }?;
        let alpha = component("a").filter(|a| !channels.contains(a));
        Some(self.with_channels(channels, alpha))
    }
}

/// The layer that plays `role` by its name, else the best by the words of its name.
pub(crate) fn find(layers: &[Layer], role: Role) -> Option<Match> {
    by_name(layers, role).or_else(|| by_words(layers, role).into_iter().next())
}

/// The layer that plays `role`, by the table's order of preference, then the file's.
pub(crate) fn by_name(layers: &[Layer], role: Role) -> Option<Match> {
    let mut names = role.names().iter();
    names
        .find_map(|name| {
            layers
                .iter()
                .filter(|layer| layer.meaning().key == *name)
                .find_map(|layer| {
                    // A nameless layer is depth only by its component Z, never for being alone.
                    let bare_depth = role == Role::Depth && name.is_empty();
                    let is_depth = !bare_depth || layer.has(&["z"]) && !layer.has(&["x", "y"]);
                    layer.matched(role).filter(|_| is_depth)
                })
        })
        .or_else(|| in_first_part(layers, role))
        .map(|found| match role {
            Role::Color => with_alpha_apart(found, layers),
            _ => found,
        })
}

/// A picture with the alpha of its part, where that is a layer by itself: RenderMan writes `A` beside `Ci`.
fn with_alpha_apart(mut picture: Match, layers: &[Layer]) -> Match {
    let mut of_part = layers.iter().filter(|layer| layer.part == picture.part);
    let apart = of_part.find_map(|layer| match &layer.components[..] {
        [(component, channel)] if layer.bare && component == "a" => Some(*channel),
        _ => None,
    });
    picture.alpha = picture.alpha.or(apart);
    picture
}

/// The layers given `role` by their words if their names are not in the table, the best first.
pub(crate) fn by_words(layers: &[Layer], role: Role) -> Vec<Match> {
    let mut found: Vec<_> = layers
        .iter()
        .filter(|layer| !layer.is_listed() && layer.said().role == Some(role))
        .filter_map(|layer| Some((layer.said().rank, layer.matched(role)?)))
        .collect();
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, found)| found).collect()
}

/// Colour or depth of a first part with any name ("main", "subimage00") whose channels have no layer names of their
/// own: read like nameless channels, unless the part's name means something else. The first part of a group counts too,
/// and Z beside the R, G and B of any part or layer called a picture.
fn in_first_part(layers: &[Layer], role: Role) -> Option<Match> {
    let first = layers.first()?.part;
    layers.iter().find_map(|layer| {
        let has_picture = layer.has(&["r", "g", "b"]);
        let plays = match role {
            Role::Color => has_picture,
            Role::Depth => layer.has(&["z"]) && !layer.has(&["x"]),
            _ => false,
        };
        let may = match layer.means_something() {
            true => role == Role::Depth && has_picture && layer.means(Role::Color),
            false => layer.bare && [first, 0].contains(&layer.part),
        };
        layer.matched(role).filter(|_| plays && may)
    })
}

/// The layer that a user called `name`: its full name, else its last word, in any case.
pub(crate) fn named(layers: &[Layer], name: &str, role: Role) -> Option<Match> {
    let exact = layers.iter().find(|l| l.name.eq_ignore_ascii_case(name));
    let key = names::key(name);
    let by_last_word = || {
        layers.iter().find(|l| {
            let last = l.name.rsplit('.').next();
            last.is_some_and(|last| last.eq_ignore_ascii_case(name))
                || l.view.is_some() && l.meaning().key == key
        })
    };
    // `--depth Z` may also name a single channel of a layer: `ViewLayer.Depth.Z`, or bare `Z`.
    let by_channel = || {
        let (prefix, component) = split_component(name);
        let layer = layers
            .iter()
            .find(|l| l.name.eq_ignore_ascii_case(prefix))?;
        let channel = layer.component(&component)?;
        Some(Match {
            layer: name.into(),
            ..layer.with_channels(vec![channel], None)
        })
    };
    exact
        .or_else(by_last_word)
        .and_then(|layer| layer.matched(role))
        .or_else(by_channel)
}

/// Every role that some layer plays, with that layer.
pub(crate) fn assign(layers: &[Layer]) -> Vec<(Role, Match)> {
    RULES
        .iter()
        .filter_map(|&(role, ..)| find(layers, role).map(|m| (role, m)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single_part(channels: &[&'static str]) -> Vec<Layer> {
        layers([(None, channels.to_vec())].into_iter())
    }

    fn role_names(layers: &[Layer], role: Role) -> Option<String> {
        find(layers, role).map(|m| m.layer)
    }

    #[test]
    fn bare_channels_of_a_first_part_are_picture_and_depth() {
        let parts = |name| {
            let first = (
                Some(name),
                vec!["A", "B", "G", "N.x", "N.y", "N.z", "R", "Z"],
            );
            layers([first, (Some("specular"), vec!["B", "G", "R"])].into_iter())
        };
        for name in ["main", "subimage00", "relievo"] {
            let color = find(&parts(name), Role::Color).unwrap();
            assert_eq!((color.channels, color.alpha), (vec![6, 2, 1], Some(0)));
            assert_eq!(find(&parts(name), Role::Depth).unwrap().channels, [7]);
            assert_eq!(
                find(&parts(name), Role::Normal).unwrap().channels,
                [3, 4, 5]
            );
        }
        // Z beside a picture is depth, whatever part it is.
        for name in ["rgba", "beauty", "Beauty_main"] {
            let picture = (Some(name), vec!["A", "B", "G", "R", "Z"]);
            let normals = (Some("N"), vec!["X", "Y", "Z"]);
            let depth = |parts: Vec<(Option<&'static str>, Vec<&'static str>)>| {
                find(&layers(parts.into_iter()), Role::Depth).map(|found| found.part)
            };
            assert_eq!(depth(vec![picture.clone(), normals.clone()]), Some(0));
            assert_eq!(depth(vec![normals, picture]), Some(1));
        }
        let layer = single_part(&["beauty.A", "beauty.B", "beauty.G", "beauty.R", "beauty.Z"]);
        assert_eq!(find(&layer, Role::Depth).unwrap().channels, [4]);
        // A name that means something else is believed, and a later part's is no picture.
        assert_eq!(find(&parts("albedo"), Role::Color), None);
        let vector = layers([(Some("offset"), vec!["X", "Y", "Z"])].into_iter());
        assert_eq!(find(&vector, Role::Depth), None);
    }

    #[test]
    fn blender_single_part_names() {
        let layers = single_part(&[
            "ViewLayer.Combined.A",
            "ViewLayer.Combined.B",
            "ViewLayer.Combined.G",
            "ViewLayer.Combined.R",
            "ViewLayer.Combined_key.B",
            "ViewLayer.Combined_key.G",
            "ViewLayer.Combined_key.R",
            "ViewLayer.Depth.Z",
            "ViewLayer.DiffDir.B",
            "ViewLayer.DiffDir.G",
            "ViewLayer.DiffDir.R",
            "ViewLayer.Mist.Z",
            "ViewLayer.Normal.X",
            "ViewLayer.Normal.Y",
            "ViewLayer.Normal.Z",
            "ViewLayer.Position.X",
            "ViewLayer.Position.Y",
            "ViewLayer.Position.Z",
        ]);
        let color = find(&layers, Role::Color).unwrap();
        assert_eq!((color.channels, color.alpha), (vec![3, 2, 1], Some(0)));
        assert_eq!(find(&layers, Role::Depth).unwrap().channels, [7]);
        assert_eq!(find(&layers, Role::Mist).unwrap().channels, [11]);
        assert_eq!(find(&layers, Role::Normal).unwrap().channels, [12, 13, 14]);
        assert_eq!(
            find(&layers, Role::Position).unwrap().channels,
            [15, 16, 17]
        );
        assert_eq!(
            role_names(&layers, Role::DiffuseDirect).unwrap(),
            "ViewLayer.DiffDir"
        );
    }

    #[test]
    fn blender_five_parts_and_spaces() {
        let layers = layers(
            [
                (Some("ViewLayer.Combined"), vec!["ViewLayer.Combined.R"]),
                (Some("ViewLayer.Depth"), vec!["ViewLayer.Depth.Z"]),
                (
                    Some("ViewLayer.Ambient Occlusion"),
                    vec![
                        "ViewLayer.Ambient Occlusion.B",
                        "ViewLayer.Ambient Occlusion.G",
                        "ViewLayer.Ambient Occlusion.R",
                    ],
                ),
            ]
            .into_iter(),
        );
        let occlusion = find(&layers, Role::Occlusion).unwrap();
        assert_eq!((occlusion.part, occlusion.channels), (2, vec![2, 1, 0]));
        assert_eq!(find(&layers, Role::Depth).unwrap().part, 1);
    }

    #[test]
    fn plain_names() {
        let layers = single_part(&[
            "A", "B", "G", "N.X", "N.Y", "N.Z", "P.x", "P.y", "P.z", "R", "Z",
        ]);
        assert_eq!(find(&layers, Role::Color).unwrap().channels, [9, 2, 1]);
        assert_eq!(find(&layers, Role::Color).unwrap().alpha, Some(0));
        assert_eq!(find(&layers, Role::Normal).unwrap().channels, [3, 4, 5]);
        assert_eq!(find(&layers, Role::Position).unwrap().channels, [6, 7, 8]);
        assert_eq!(find(&layers, Role::Depth).unwrap().channels, [10]);
        let layers = single_part(&["depth", "normals.b", "normals.g", "normals.r"]);
        assert_eq!(find(&layers, Role::Depth).unwrap().channels, [0]);
        assert_eq!(find(&layers, Role::Normal).unwrap().channels, [3, 2, 1]);
    }

    #[test]
    fn bare_color_is_not_depth() {
        assert_eq!(find(&single_part(&["B", "G", "R"]), Role::Depth), None);
    }

    #[test]
    fn alpha_alone_is_no_picture() {
        let apart = single_part(&["A", "Ci.b", "Ci.g", "Ci.r", "N.x", "N.y", "N.z"]);
        let color = find(&apart, Role::Color).unwrap();
        assert_eq!(
            (color.layer.as_str(), color.channels),
            ("Ci", vec![3, 2, 1])
        );
        assert_eq!(color.alpha, Some(0));
        assert_eq!(find(&single_part(&["A", "Z"]), Role::Color), None);
        // As a mask it can be named.
        assert_eq!(named(&apart, "A", Role::Mask).unwrap().channels, [0]);
    }

    #[test]
    fn a_part_name_names_bare_channels() {
        let layers = layers(
            [
                (Some("rgba"), vec!["B", "G", "R"]),
                (Some("N"), vec!["X", "Y", "Z"]),
            ]
            .into_iter(),
        );
        assert_eq!(find(&layers, Role::Normal).unwrap().part, 1);
        assert_eq!(find(&layers, Role::Depth), None);
    }

    #[test]
    fn motion_is_a_pair() {
        // Blender 3.4 and 5.0: XY lead back to the frame before, ZW on to the next.
        let whole = single_part(&[
            "ViewLayer.Normal.X",
            "ViewLayer.Normal.Y",
            "ViewLayer.Normal.Z",
            "ViewLayer.Vector.W",
            "ViewLayer.Vector.X",
            "ViewLayer.Vector.Y",
            "ViewLayer.Vector.Z",
        ]);
        assert_eq!(find(&whole, Role::Motion).unwrap().channels, [4, 5]);
        let half = single_part(&["ViewLayer.Vector.X", "ViewLayer.Vector.Y"]);
        assert_eq!(find(&half, Role::Motion).unwrap().channels, [0, 1]);
        let part = layers([(Some("Motion"), vec!["R", "G", "B"])].into_iter());
        assert_eq!(find(&part, Role::Motion).unwrap().channels, [0, 1]);
        let backward = single_part(&["backward.u", "backward.v", "forward.u", "forward.v"]);
        assert_eq!(find(&backward, Role::Motion).unwrap().channels, [0, 1]);
        // Motion to the next frame only is not motion back.
        let forward = single_part(&["forward.u", "forward.v"]);
        assert_eq!(find(&forward, Role::Motion), None);
        assert_eq!(
            named(&forward, "forward", Role::Motion).unwrap().channels,
            [0, 1]
        );
    }

    #[test]
    fn users_name_layers_loosely() {
        let layers = single_part(&[
            "ViewLayer.Depth.Z",
            "ViewLayer.camN.B",
            "ViewLayer.camN.G",
            "ViewLayer.camN.R",
        ]);
        for name in ["ViewLayer.camN", "camN", "camn"] {
            assert_eq!(
                named(&layers, name, Role::Normal).unwrap().channels,
                [3, 2, 1]
            );
        }
        assert_eq!(
            named(&layers, "ViewLayer.Depth.Z", Role::Depth)
                .unwrap()
                .channels,
            [0]
        );
        assert_eq!(named(&layers, "nothing", Role::Normal), None);
    }
}
