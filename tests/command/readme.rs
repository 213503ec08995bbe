//! The README is true: its commands work, and its defaults are those of the program.

use super::report::OF_README;
use crate::common::program::run;
use std::path::Path;

const README: &str = include_str!("../../README.md");

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
    assert!(commands.iter().any(|words| words.join(" ") == OF_README));
    for arguments in commands
        .into_iter()
        .filter(|words| words.join(" ") != OF_README)
    {
        println!("relievo {}", arguments.join(" "));
        run(place.path(), &arguments).done();
        if let Some(at) = arguments.iter().position(|&a| a == "-o") {
            let output = place.path().join(arguments[at + 1]);
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
fn the_recipe_of_the_readme_is_one() {
    let toml = README.split("```toml\n").nth(1);
    let toml = toml.and_then(|rest| rest.split("```").next()).unwrap();
    relievo::cli::recipe::Recipe::parse(Path::new("README.md"), toml).unwrap();
}

/// The help of a command.
fn help_of(command: &str) -> String {
    run(Path::new("."), [command, "--help"]).done().stdout
}

/// The entry of `option` in `help`: its line, and the lines after it up to the next option.
fn entry_of(help: &str, option: &str) -> Option<String> {
    let named = format!("{option} ");
    let mut lines = help
        .lines()
        .map(str::trim)
        .skip_while(|line| !line.starts_with(&named));
    let first = lines.next()?;
    let rest = lines.take_while(|line| !line.is_empty() && !line.starts_with('-'));
    Some(rest.fold(first.into(), |entry, line| entry + " " + line))
}

/// The README's table rows of options: the option and its default.
fn option_rows() -> Vec<(String, String)> {
    let rows = README.lines().filter(|line| line.starts_with("| `--"));
    rows.map(|row| {
        // `| `--name VALUE` | default | meaning |`; a bar inside the first cell is escaped.
        let row = row.replace("\\|", "/");
        let cells: Vec<_> = row.split('|').map(str::trim).collect();
        let option = cells[1].trim_matches('`').split(' ').next().unwrap();
        (option.into(), cells[2].into())
    })
    .collect()
}

#[test]
fn the_defaults_are_those_of_the_program() {
    // An option shared by several commands has the same meaning in all: params hold its default once.
    let helps = ["enhance", "relight", "hatch"].map(help_of);
    let rows = option_rows();
    for (option, default) in &rows {
        let expected = format!("[default: {default}]");
        let entries = helps.iter().filter_map(|help| entry_of(help, option));
        let entries: Vec<_> = entries.collect();
        assert!(!entries.is_empty(), "no command has {option}");
        for entry in entries {
            assert!(
                entry.contains(&expected),
                "README says {expected} of {option}; help: {entry}"
            );
        }
    }
    assert!(
        rows.len() >= 25,
        "only {} options in the README's tables",
        rows.len()
    );
}

#[test]
fn every_option_of_new_light_is_explained() {
    let help = help_of("relight");
    // Light, Light warping, Radiance scaling, Material: all that `relight` adds, to the end of the options.
    let own = help.split("\nLight:").nth(1).unwrap();
    let own = own.split("\nExamples:").next().unwrap();
    let options = own.lines().filter_map(|line| {
        let option = line.trim_start().split(' ').next()?;
        option.starts_with("--").then_some(option)
    });
    let options: Vec<_> = options.collect();
    assert!(options.len() >= 30, "{options:?}");
    let in_table: Vec<_> = option_rows()
        .into_iter()
        .map(|(option, _)| option)
        .collect();
    for option in options {
        let explained = ["`", " "].map(|end| format!("`{option}{end}"));
        assert!(
            explained.iter().any(|text| README.contains(text)),
            "the README does not explain {option}"
        );
        let has_default = entry_of(own, option).unwrap().contains("[default: ");
        assert!(
            !has_default || in_table.iter().any(|row| row == option),
            "{option} has a default and no row"
        );
    }
}
