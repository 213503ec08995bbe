//! Views of layers, such as the eyes of a stereo pair, and the selection of one.
//!
//! Files mark views in two ways: a part has a `view`, or a word of a channel's name is one, as in `left.Normal.X` or
//! `Normal.left.X`. Then `multiView` lists the views, and layers without a view's name belong to the first.

use super::exr::ExrFile;
use super::roles::Layer;
use crate::error::{Error, Result};
use crate::untrusted::{Untrusted, listed};

/// Views that need no list where both occur.
const EYES: [&str; 2] = ["left", "right"];

/// Marks each layer with its view, and returns the views, that of the default first. Layers that all views share
/// have none.
pub(super) fn mark(file: &ExrFile, layers: &mut [Layer]) -> Vec<String> {
    let mut views: Vec<String> = Vec::new();
    for layer in layers.iter_mut() {
        layer.view.clone_from(&file.parts[layer.part].view);
        if let Some(view) = layer.view.as_ref().filter(|view| !views.contains(view)) {
            views.push(view.clone());
        }
    }
    if !views.is_empty() {
        return views;
    }
    let listed = file.attributes.get("multiView");
    let words = |layer: &Layer| -> Vec<String> {
        let words = layer.name.split('.').map(str::to_ascii_lowercase);
        words.collect()
    };
    let views: Vec<String> = match listed {
        Some(list) => list.split_whitespace().map(str::to_owned).collect(),
        None => {
            let has = |eye: &&str| layers.iter().any(|l| words(l).contains(&(*eye).into()));
            let both = EYES.iter().all(has);
            EYES.iter().filter(|_| both).map(|&e| e.into()).collect()
        }
    };
    for layer in layers {
        let words = words(layer);
        let named = views.iter().find(|v| words.contains(&v.to_lowercase()));
        layer.view = named
            .or(views.first().filter(|_| listed.is_some()))
            .cloned();
    }
    views
}

/// Keeps the layers of one view: the requested one, else the default. `views` lists all views of the file.
///
/// # Errors
/// [`Error::BadParameter`] for an unknown view.
pub(super) fn keep(
    file: &ExrFile,
    layers: &mut Vec<Layer>,
    views: &[String],
    wanted: Option<&str>,
) -> Result<Option<String>> {
    let same = |view: &&String| wanted.is_some_and(|wanted| view.eq_ignore_ascii_case(wanted));
    let view = match (wanted, views.iter().find(same)) {
        (None, _) => views.first(),
        (Some(_), Some(view)) => Some(view),
        (Some(wanted), None) => {
            let there = match views {
                [] => "no views".into(),
                views => listed(views),
            };
            return Err(Error::MissingAov {
                path: file.path.clone(),
                found: format!("no view called {} (found {there})", Untrusted(wanted)),
                remedy: "name one of them with --view, or leave it out".into(),
            });
        }
    };
    layers.retain(|layer| layer.view.is_none() || layer.view.as_ref() == view);
    Ok(view.cloned())
}
