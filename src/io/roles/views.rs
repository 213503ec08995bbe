//! Views of layers, such as the eyes of a stereo pair, and the selection of one.
//!
//! Files mark views in two ways: a part has a `view`, or a word of a channel's name is one, as in `left.Normal.X` or
//! `Normal.left.X`. Then `multiView` lists the views, and layers without a view's name belong to the first.

use crate::error::{Error, Result};
use crate::io::exr::ExrFile;
use crate::io::roles::Layer;
use crate::untrusted::{Untrusted, listed};
use std::collections::HashMap;
use std::rc::Rc;

/// Views that need no list where both occur.
const EYES: [&str; 2] = ["left", "right"];

/// Marks each layer with its view, and returns the views, that of the default first. Layers that all views share
/// have none.
pub(crate) fn mark(file: &ExrFile, layers: &mut [Layer]) -> Vec<String> {
    let views = mark_by_part(file, layers);
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
    let shared: Vec<Rc<str>> = views.iter().map(|view| view.as_str().into()).collect();
    // Of views that differ only by case the first one counts.
    let mut places: HashMap<String, usize> = HashMap::new();
    for (place, view) in views.iter().enumerate() {
        places.entry(view.to_lowercase()).or_insert(place);
    }
    for layer in layers {
        let words = words(layer);
        let named = words.iter().filter_map(|word| places.get(word)).min();
        let named = named.map(|&place| &shared[place]);
        layer.view = named
            .or(shared.first().filter(|_| listed.is_some()))
            .cloned();
    }
    views
}

/// Marks each layer with the view of its part, and returns those views.
fn mark_by_part(file: &ExrFile, layers: &mut [Layer]) -> Vec<String> {
    let mut views: Vec<String> = Vec::new();
    // Each view once: its name may be long.
    let mut shared: HashMap<&str, Rc<str>> = HashMap::new();
    let of_parts = file.parts.iter().map(|part| {
        let view = part.view.as_deref()?;
        let own = shared.entry(view).or_insert_with(|| {
            views.push(view.to_owned());
            view.into()
        });
        Some(own.clone())
    });
    let of_parts: Vec<Option<Rc<str>>> = of_parts.collect();
    for layer in layers {
        layer.view.clone_from(&of_parts[layer.part]);
    }
    views
}

/// Keeps the layers of one view: the requested one, else the default. `views` lists all views of the file.
///
/// # Errors
/// [`Error::BadParameter`] for an unknown view.
pub(crate) fn keep(
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
    // Layers share the names of their views, which may be long: equal ones are the same.
    let of_view = |own: &Rc<str>| view.is_some_and(|view| **own == **view);
    let kept = layers.iter().find_map(|l| l.view.clone().filter(of_view));
    layers.retain(|layer| layer.view.is_none() || layer.view == kept);
    Ok(view.cloned())
}
