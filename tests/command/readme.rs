//! The README and the guide are true: their commands work, their links lead somewhere, and their defaults are those of
//! the program.

use crate::common::program::{Desk, run, words};
use relievo::frame::Window;
use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

/// The README, a chapter of the guide, or ARCHITECTURE.md.
struct Page {
    path: PathBuf,
    text: String,
}

impl Page {
    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).unwrap();
        Self { path, text }
    }

    /// Its code blocks in `language`.
    fn blocks(&self, language: &str) -> Vec<&str> {
        let begin = format!("```{language}\n");
        let rests = self.text.split(&begin).skip(1);
        rests.filter_map(|rest| rest.split("```").next()).collect()
    }
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn chapter(name: &str) -> Page {
    Page::read(file("docs/guide").join(name))
}

/// All pages, the README first.
fn pages() -> Vec<Page> {
    let entries = fs::read_dir(file("docs/guide")).unwrap();
    let chapters = entries.map(|entry| entry.unwrap().path());
    let chapters = chapters.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
    let chapters: BTreeSet<_> = chapters.collect();
    let mut paths = vec![file("README.md"), file("docs/ARCHITECTURE.md")];
    paths.extend(chapters);
    paths.into_iter().map(Page::read).collect()
}

/// The pages that people wrote: all but the reference.
fn written_pages() -> Vec<Page> {
    let mut pages = pages();
    pages.retain(|page| !page.path.ends_with("reference.md"));
    pages
}

/// The `relievo` commands in the shell blocks of `pages`.
fn commands<'a>(pages: &'a [Page]) -> Vec<&'a str> {
    let blocks = pages.iter().flat_map(|page| page.blocks("sh"));
    let starts = ["cargo run --release -- ", "relievo "];
    let command = |line: &'a str| starts.iter().find_map(|start| line.strip_prefix(start));
    blocks.flat_map(str::lines).filter_map(command).collect()
}

#[test]
fn every_command_works() {
    let desk = Desk::new();
    fs::create_dir(desk.path().join("fixtures")).unwrap();
    for entry in fs::read_dir(file("fixtures")).unwrap() {
        let from = entry.unwrap();
        let to = desk.path().join("fixtures").join(from.file_name());
        fs::copy(from.path(), to).unwrap();
    }
    let pages = pages();
    let commands = commands(&pages);
    assert!(commands.len() >= 20, "only {} commands", commands.len());
    let distinct = BTreeSet::from_iter(&commands).len();
    let runs_twice = "a command stands in two places, and would run twice";
    assert_eq!(distinct, commands.len(), "{runs_twice}");
    // Names of outputs, by the rest of their command and the kind of file: each is made once.
    let mut made: HashMap<String, &str> = HashMap::new();
    for command in commands {
        println!("relievo {command}");
        let arguments = words(command);
        let after = |flag: &str| {
            let at = arguments.iter().position(|&a| a == flag)?;
            arguments.get(at + 1).copied()
        };
        let output = after("-o");
        if let Some(name) = output {
            let kind = Path::new(name).extension().unwrap_or_default();
            let others = command.replace(name, &kind.to_string_lossy());
            if let Some(before) = made.get(&others) {
                desk.copy(before, name);
                continue;
            }
            made.insert(others, name);
        }
        run(desk.path(), &arguments).done();
        if let Some(name) = output {
            let map = after("--map").and_then(|maps| maps.split(',').next());
            let output = name.replace("{map}", map.unwrap_or_default());
            let length = desk.at(&output).metadata().unwrap().len();
            assert!(length > 1000, "{output} is empty");
        }
    }
}

#[test]
fn the_camera_of_the_guide_is_read() {
    let page = chapter("files.md");
    let json = page.blocks("json")[0];
    let desk = Desk::new();
    desk.write("camera.json", json);
    let (path, window) = (desk.at("camera.json"), Window::from_size(640, 480));
    let camera = relievo::io::camera::read_camera(&path, window, 1.0).unwrap();
    // Looks along +y, from (0, -5, 1.2).
    let eye = camera.view_from_world.inverse().translation;
    let expected = glam::DVec3::new(0.0, -5.0, 1.2);
    assert!(eye.distance(expected) < 1e-9, "the eye is at {eye}");
}

#[test]
fn the_recipe_of_the_guide_is_one() {
    let page = chapter("sequences.md");
    let toml = page.blocks("toml")[0];
    relievo::cli::recipe::Recipe::parse(&page.path, toml).unwrap();
}

/// `cargo test` runs the program in the crate's documentation; the README shows its middle.
#[test]
fn the_program_of_the_readme_is_that_of_the_crate() {
    let readme = Page::read(file("README.md"));
    let documented = fs::read_to_string(file("src/lib.rs")).unwrap();
    let program = readme.blocks("rust")[0].lines();
    let program: String = program.map(|line| format!("//! {line}\n")).collect();
    assert!(documented.contains(&program), "src/lib.rs lacks\n{program}");
}

#[test]
fn links_lead_to_files_and_headings() {
    let summary = chapter("SUMMARY.md").text;
    for Page { path, text } in pages() {
        let (folder, name) = (path.parent().unwrap(), path.file_name().unwrap());
        let named = format!("({})", name.to_str().unwrap());
        let is_listed = name == "SUMMARY.md" || summary.contains(&named);
        assert!(
            folder != file("docs/guide") || is_listed,
            "SUMMARY.md lacks {named}"
        );
        let targets = text.split("](").skip(1);
        let targets = targets.filter_map(|rest| rest.split(')').next());
        for target in targets.filter(|target| !target.starts_with("https:")) {
            let shown = path.display();
            let (other, heading) = target.split_once('#').unwrap_or((target, ""));
            let other = match other {
                "" => path.clone(),
                _ => folder.join(other),
            };
            assert!(other.exists(), "{shown} links to {target}");
            let is_there = heading.is_empty() || anchors(&Page::read(other)).contains(heading);
            assert!(is_there, "{shown} links to {target}");
        }
    }
}

/// The anchors of a page's headings, as GitHub and mdBook make them.
fn anchors(page: &Page) -> BTreeSet<String> {
    let headings = page.text.lines().filter(|line| line.starts_with('#'));
    let anchor = |line: &str| {
        let heading = line.trim_start_matches('#').trim().to_lowercase();
        let dropped = |c: char| !c.is_alphanumeric() && !" -_".contains(c);
        heading.replace(dropped, "").replace(' ', "-")
    };
    headings.map(anchor).collect()
}

/// The help of a command.
fn help_of(command: &str) -> String {
    run(Path::new("."), [command, "--help-all"]).done().stdout
}

/// The entry of `option` in `help`: its line, and the lines after it up to the next option.
fn entry_of(help: &str, option: &str) -> Option<String> {
    let named = format!("{option} ");
    let lines = help.lines().map(str::trim);
    let mut lines = lines.skip_while(|line| !line.starts_with(&named));
    let first = lines.next()?;
    let rest = lines.take_while(|line| !line.is_empty() && !line.starts_with('-'));
    Some(rest.fold(first.into(), |entry, line| entry + " " + line))
}

/// The rows of options in the tables of chapters: the option and its default.
fn option_rows() -> Vec<(String, String)> {
    let pages = written_pages();
    let lines = pages.iter().flat_map(|page| page.text.lines());
    let rows = lines.filter(|line| line.starts_with("| `--"));
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
    let of_map = help_of("map");
    let rows = option_rows();
    for (option, default) in &rows {
        let expected = format!("[default: {default}]");
        let entries = helps.iter().filter_map(|help| entry_of(help, option));
        let mut entries: Vec<_> = entries.collect();
        if entries.is_empty() {
            entries.extend(entry_of(&of_map, option));
        }
        assert!(!entries.is_empty(), "no command has {option}");
        for entry in entries {
            let is_default = entry.contains(&expected);
            assert!(
                is_default,
                "the guide says {expected} of {option}; help: {entry}"
            );
        }
    }
    let distinct: BTreeSet<_> = rows.iter().map(|(option, _)| option).collect();
    assert_eq!(distinct.len(), rows.len(), "an option stands in two tables");
    assert!(rows.len() >= 40, "only {} options in tables", rows.len());
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
    let rows = option_rows();
    let pages = written_pages();
    for option in options {
        let explained = ["`", " "].map(|end| format!("`{option}{end}"));
        let explains = |page: &Page| explained.iter().any(|text| page.text.contains(text));
        let is_explained = pages.iter().any(explains);
        assert!(is_explained, "the guide does not explain {option}");
        let has_default = entry_of(own, option).unwrap().contains("[default: ");
        let has_row = rows.iter().any(|(row, _)| row == option);
        assert!(!has_default || has_row, "{option} has a default and no row");
    }
}
