//! Completions, manual pages, and the reference of the guide.

use crate::common::program::{fixture, program, relievo};
use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

fn printed(words: &str) -> String {
    relievo(Path::new("."), words).done().stdout
}

/// What `shell` prints of a script that may call the program, or nothing if there is no such shell here.
fn run_in(shell: &str, arguments: &[&str], directory: &Path, script: &str) -> Option<String> {
    let binary = Path::new(env!("CARGO_BIN_EXE_relievo")).parent().unwrap();
    let path = std::env::var("PATH").unwrap();
    let mut command = Command::new(shell);
    command
        .args(arguments)
        .current_dir(directory)
        .env("PATH", format!("{}:{path}", binary.display()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let Ok(mut child) = command.spawn() else {
        println!("SKIPPED: there is no {shell}");
        return None;
    };
    child
        .stdin
        .take()
        .unwrap()
        .write_all(script.as_bytes())
        .unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{shell}: {said}");
    Some(String::from_utf8(output.stdout).unwrap())
}

/// A shell without a terminal: its arguments, and what has it print the completions of the words in `LINE`.
const SHELLS: [(&str, &[&str], &str); 3] = [
    (
        "bash",
        &["--norc", "-s"],
        "COMP_WORDS=(LINE) COMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n\
         _clap_complete_relievo relievo \"${COMP_WORDS[COMP_CWORD]}\" relievo\n\
         printf '%s\\n' \"${COMPREPLY[@]}\"\n",
    ),
    (
        "zsh",
        &["-f", "-s"],
        "_describe() { print -l -- ${(P)@[-1]} }\n\
         words=(LINE) CURRENT=${#words}\n\
         _clap_dynamic_completer_relievo\n",
    ),
    ("fish", &["--no-config"], "complete -C \"LINE\"\n"),
];

/// Commands and options are completed, and after an option that names a layer, the layers of the file on the line.
#[test]
fn shells_complete_commands_options_and_layers() {
    let place = tempfile::tempdir().unwrap();
    fs::copy(fixture("bust.exr"), place.path().join("shot.0001.exr")).unwrap();
    let file = relievo::io::survey(&fixture("bust.exr"), None).unwrap();
    let layers = file.parts.iter().flat_map(|part| &part.layers);
    let layers = layers.map(|layer| layer.name.as_str());
    let layers: BTreeSet<_> = layers.filter(|name| !name.is_empty()).collect();
    assert!(layers.contains("ViewLayer.Normal"), "{layers:?}");
    let with = |more: &[&'static str]| layers.iter().copied().chain(more.iter().copied()).collect();
    let cases: [(&str, BTreeSet<&str>); 5] = [
        ("relievo enh", BTreeSet::from(["enhance"])),
        (
            "relievo enhance in.exr --invar",
            BTreeSet::from(["--invariant-point"]),
        ),
        (
            "relievo enhance shot.0001.exr --normal ''",
            with(&["shot.0001.exr"]),
        ),
        (
            "relievo hatch -o a.png shot.####.exr --depth ''",
            with(&["none", "shot.0001.exr"]),
        ),
        (
            "relievo inspect shot.0001.exr --normal ViewLayer.N",
            BTreeSet::from(["ViewLayer.Normal"]),
        ),
    ];
    for (shell, arguments, script) in SHELLS {
        // zsh registers with a completion system that only a terminal has.
        let registered = "compdef() { }\n".repeat(usize::from(shell == "zsh"));
        let registered = registered + &printed(&format!("completions {shell}")) + "\n";
        for (line, expected) in &cases {
            // fish takes an empty last word as a space.
            let line = if shell == "fish" {
                line.trim_end_matches('\'')
            } else {
                line
            };
            let script = registered.clone() + &script.replace("LINE", line);
            let Some(found) = run_in(shell, arguments, place.path(), &script) else {
                break;
            };
            // zsh and fish add what a candidate means.
            let names = found
                .lines()
                .filter_map(|line| line.split([':', '\t']).next());
            let names: BTreeSet<_> = names.collect();
            assert_eq!(&names, expected, "{shell}: {line}");
        }
    }
    // As a package installs it for zsh.
    fs::write(place.path().join("_relievo"), printed("completions zsh")).unwrap();
    let (shell, arguments, script) = SHELLS[1];
    let script = "compdef() { }\nfpath=(. $fpath)\nautoload -Uz _relievo\n".to_owned()
        + &script
            .replace("_clap_dynamic_completer_relievo", "_relievo")
            .replace("LINE", "relievo enh");
    if let Some(found) = run_in(shell, arguments, place.path(), &script) {
        assert!(found.starts_with("enhance:"), "{found}");
    }
}

/// Every command has a page that names all of its flags, and that mandoc has nothing to say against.
#[test]
fn every_command_has_a_manual_page() {
    let command = relievo::cli::command();
    for sub in command.get_subcommands() {
        let name = sub.get_name();
        let page = printed(&format!("man {name}"));
        assert!(page.contains(".TH"), "{name}");
        let plain = page.replace("\\-", "-");
        let flags = sub.get_arguments().filter(|arg| !arg.is_hide_set());
        for flag in flags.filter_map(clap::Arg::get_long) {
            assert!(
                plain.contains(&format!("--{flag}")),
                "man {name} lacks --{flag}"
            );
        }
        run_in("mandoc", &["-Tlint", "-Werror"], Path::new("."), &page);
    }
    assert!(printed("man").contains("enhance"));
    let line = relievo(Path::new("."), "man nothing").refused(2);
    assert!(line.contains("nothing"), "{line}");
}

/// A reader that closes the pipe early ends the program without a word.
#[test]
fn a_closed_pipe_is_no_error() {
    let mut child = program(Path::new("."))
        .args(["man", "hatch"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

/// The guide's reference is what the program writes.
#[test]
fn the_reference_of_the_guide_is_fresh() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/reference.md");
    assert!(
        fs::read_to_string(path).unwrap() == printed("reference"),
        "write it anew: cargo run -- reference > docs/guide/reference.md"
    );
}
