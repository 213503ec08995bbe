//! The README is true: its commands work, and its defaults are those of the program.

use std::path::Path;
use std::process::Command;

const README: &str = include_str!("../README.md");

/// The arguments of every `relievo` command in the README's shell blocks.
fn commands() -> Vec<Vec<&'static str>> {
    let blocks = README
        .split("```sh\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next());
    blocks
        .flat_map(str::lines)
        .filter_map(|line| {
            line.strip_prefix("cargo run --release -- ")
                .or(line.strip_prefix("relievo "))
        })
        .map(|arguments| arguments.split_whitespace().collect())
        .collect()
}

#[test]
fn every_command_works() {
    let place = tempfile::tempdir().unwrap();
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    std::fs::create_dir(place.path().join("fixtures")).unwrap();
    for entry in std::fs::read_dir(fixtures).unwrap() {
        let file = entry.unwrap();
        std::fs::copy(
            file.path(),
            place.path().join("fixtures").join(file.file_name()),
        )
        .unwrap();
    }
    let commands = commands();
    assert!(
        commands.len() >= 6,
        "the README shows {} commands",
        commands.len()
    );
    for arguments in commands {
        let run = Command::new(env!("CARGO_BIN_EXE_relievo"))
            .args(&arguments)
            .current_dir(place.path())
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&run.stderr);
        assert!(
            run.status.success(),
            "relievo {}: {stderr}",
            arguments.join(" ")
        );
        if let Some(at) = arguments.iter().position(|&a| a == "-o") {
            let mut output = place.path().join(arguments[at + 1]);
            if output.is_dir() {
                output.push("report.md");
            }
            assert!(
                output.metadata().unwrap().len() > 1000,
                "{} is empty",
                output.display()
            );
        }
    }
}

#[test]
fn the_camera_of_the_readme_is_read() {
    let json = README
        .split("```json\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .unwrap();
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("camera.json");
    std::fs::write(&path, json).unwrap();
    let window = relievo::frame::Window::from_size(640, 480);
    let camera = relievo::io::camera::read_camera(&path, window, 1.0).unwrap();
    // Looks along +y, from (0, -5, 1.2).
    let eye = camera.view_from_world.inverse().translation;
    assert!(
        eye.distance(glam::DVec3::new(0.0, -5.0, 1.2)) < 1e-9,
        "the eye is at {eye}"
    );
}

#[test]
fn the_defaults_are_those_of_the_program() {
    let help = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(["enhance", "--help"])
        .output()
        .unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let rows = README.lines().filter(|line| line.starts_with("| `--"));
    let mut checked = 0;
    for row in rows {
        // `| `--name VALUE` | default | meaning |`; a bar inside the first cell is escaped.
        let row = row.replace("\\|", "/");
        let cells: Vec<_> = row.split('|').map(str::trim).collect();
        let option = cells[1].trim_matches('`').split(' ').next().unwrap();
        let line = help
            .lines()
            .find(|line| line.trim_start().starts_with(option))
            .unwrap();
        let expected = format!("[default: {}]", cells[2]);
        assert!(
            line.contains(&expected),
            "README says {expected} of {option}; help: {line}"
        );
        checked += 1;
    }
    assert!(checked >= 8, "only {checked} options in the README's table");
}
