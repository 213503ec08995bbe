//! The bodies of the fuzz targets. `tests/corpus.rs` includes this folder, so a kept file goes through the code that found it.

#![allow(
    unreachable_pub,
    reason = "public for the fuzz targets, private in the test that includes it"
)]

mod camera_and_light;
mod command_line;
mod desk;
mod exr_to_frame;
mod frame_syntax;
mod photo_and_recipe;
mod pictures;

/// A body: panics where a property does not hold.
pub type Target = fn(&[u8]);

/// Every target by its name.
pub const TARGETS: [(&str, Target); 6] = [
    ("camera_and_light", camera_and_light::run),
    ("command_line", command_line::run),
    ("exr_to_frame", exr_to_frame::run),
    ("frame_syntax", frame_syntax::run),
    ("photo_and_recipe", photo_and_recipe::run),
    ("pictures", pictures::run),
];

/// Runs the target `name`.
///
/// # Panics
/// If there is none, or where a property does not hold.
pub fn run(name: &str, data: &[u8]) {
    let found = TARGETS.iter().find(|(known, _)| *known == name);
    let (_, target) = found.unwrap_or_else(|| panic!("no target is called {name}"));
    target(data);
}
