//! What a build pulls in.

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

/// A build without the window says how to come by one.
#[cfg(not(feature = "view"))]
#[test]
fn a_build_without_a_window_says_so_in_one_line() {
    let run = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(["view", "fixtures/bust.exr"])
        .output()
        .unwrap();
    let said = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1));
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(
        said.contains("cargo build --release --features view"),
        "{said}"
    );
}
