//! Dependencies of a build.

#[cfg(not(feature = "view"))]
use crate::common::program::Desk;
use std::process::Command;

#[test]
fn without_features_there_is_neither_a_window_nor_a_graphics_device() {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let tree = Command::new(cargo)
        .args(["tree", "--locked", "--edges", "normal", "--prefix", "none"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&tree.stderr);
    assert!(tree.status.success(), "{errors}");
    let tree = String::from_utf8(tree.stdout).unwrap();
    let names: Vec<&str> = tree.lines().filter_map(|l| l.split(' ').next()).collect();
    assert!(names.contains(&"clap"), "{tree}");
    for heavy in ["wgpu", "naga", "egui", "eframe", "winit", "rfd"] {
        assert!(!names.contains(&heavy), "{heavy} is pulled in");
    }
}

/// A build without the window names the way to get one.
#[cfg(not(feature = "view"))]
#[test]
fn a_build_without_a_window_says_so_in_one_line() {
    let row = "=> 1: cargo build --release --features view";
    Desk::new().check("view fixtures/bust.exr", row);
}
