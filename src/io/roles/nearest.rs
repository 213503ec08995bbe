//! The layer that was probably meant: suggestions for a misspelt name.

use crate::io::roles::{Layer, Role};

/// Similarity from which on a name is suggested as the intended one, 0..1.
const ALIKE: f64 = 0.8;

/// Most layers that are compared for a suggestion, which takes long.
const MOST_COMPARED: usize = 1000;

/// The layer with the channels of `role` whose name comes nearest to those that mean it.
pub(crate) fn nearest(layers: &[Layer], role: Role) -> Option<&str> {
    // Names of a letter or two are like many.
    let names: Vec<&str> = role
        .names()
        .iter()
        .copied()
        .filter(|n| n.len() > 2)
        .collect();
    let likeness_of_word = |word: &String| {
        let likeness = names.iter().map(|name| strsim::jaro_winkler(word, name));
        likeness.fold(0.0, f64::max)
    };
    let likeness = |layer: &Layer| {
        let words = layer.said().words.iter();
        words.map(likeness_of_word).fold(0.0, f64::max)
    };
    let able = layers
        .iter()
        .filter(|layer| !layer.is_listed() && layer.matched(role).is_some());
    best(
        able.take(MOST_COMPARED)
            .map(|layer| (layer.name.as_str(), likeness(layer))),
    )
}

/// The layer whose name is most like `name`.
pub(crate) fn alike<'a>(layers: impl Iterator<Item = &'a Layer>, name: &str) -> Option<&'a str> {
    let name = name.to_lowercase();
    let likeness = |layer: &Layer| {
        let own = layer.name.to_lowercase();
        let last = own.rsplit('.').next().unwrap_or(&own);
        strsim::jaro_winkler(&own, &name).max(strsim::jaro_winkler(last, &name))
    };
    best(
        layers
            .take(MOST_COMPARED)
            .map(|layer| (layer.name.as_str(), likeness(layer))),
    )
}

/// The name that is most like `name`, if one is like enough.
pub(crate) fn likest<'a>(names: &[&'a str], name: &str) -> Option<&'a str> {
    let name = name.to_lowercase();
    let likeness = |own: &str| strsim::jaro_winkler(&own.to_lowercase(), &name);
    best(names.iter().map(|own| (*own, likeness(own))))
}

/// The first of the likest names, if it is like enough and not empty.
fn best<'a>(names: impl Iterator<Item = (&'a str, f64)>) -> Option<&'a str> {
    let able = names.filter(|(name, likeness)| !name.is_empty() && *likeness >= ALIKE);
    let better = |best: (_, f64), next: (_, f64)| if next.1 > best.1 { next } else { best };
    able.reduce(better).map(|(name, _)| name)
}
