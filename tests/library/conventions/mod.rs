//! Files in the conventions of renderers, all read back to the same frame.

mod backgrounds;
mod forced;
mod layout;
mod renderers;
mod truth;

use crate::common::exr::{Part, Stored, write};
use crate::common::files::try_load;
use crate::prelude::*;
use truth::{display, truth};

const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// The part with a layer of three components, a plane for each.
fn with_layer(
    part: Part,
    (name, components, stored): (&str, [&str; 3], Stored),
    planes: &[Plane; 3],
) -> Part {
    let layer = components.into_iter().zip(planes);
    layer.fold(part, |part, (component, plane)| {
        part.channel(&format!("{name}.{component}"), stored, plane)
    })
}

/// The normals of the scene, changed so, and `background` where there is nothing.
fn normals(background: DVec3, change: impl Fn(DVec3) -> DVec3) -> [Plane; 3] {
    [0, 1, 2].map(|axis| truth().normal(axis, background[axis], &change))
}

/// A file of these parts, read.
fn try_read(
    parts: &[Part],
    change: impl FnOnce(&mut Inputs, &mut Needs),
) -> relievo::Result<Loaded> {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("a.exr");
    write(&path, display(), parts);
    try_load(path, change)
}

#[track_caller]
fn read(parts: &[Part], change: impl FnOnce(&mut Inputs, &mut Needs)) -> Loaded {
    try_read(parts, change).unwrap()
}
