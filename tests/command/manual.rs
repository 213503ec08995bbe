//! Completions and manual pages.

use crate::common::program::{program, relievo};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

fn printed(words: &str) -> String {
    relievo(Path::new("."), words).done().stdout
}

/// What `shell` prints of a script, or nothing if there is no such shell here.
fn run_in(shell: &str, arguments: &[&str], script: &str) -> Option<String> {
    let mut command = Command::new(shell);
    let piped = command.args(arguments).stdin(Stdio::piped());
    let Ok(mut child) = piped.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn() else {
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

#[test]
fn shells_complete_commands_and_flags() {
    let bash = printed("completions bash");
    let script = bash
        + "\nCOMP_WORDS=(relievo enh) COMP_CWORD=1\n_relievo relievo enh relievo\necho \"${COMPREPLY[@]}\"\n\
           COMP_WORDS=(relievo enhance in.exr --invar) COMP_CWORD=3\n_relievo relievo --invar in.exr\necho \"${COMPREPLY[@]}\"\n";
    if let Some(found) = run_in("bash", &["--norc", "-s"], &script) {
        assert_eq!(found, "enhance\n--invariant-point\n");
    }
    let fish = printed("completions fish")
        + "\ncomplete -C 'relievo hatch --stip'\ncomplete -C 'relievo ma'\n";
    if let Some(found) = run_in("fish", &["--no-config"], &fish) {
        let found: Vec<_> = found.split_whitespace().collect();
        assert!(
            found.contains(&"map") && found.contains(&"man"),
            "{found:?}"
        );
    }
    let zsh = printed("completions zsh");
    assert!(zsh.starts_with("#compdef relievo"), "{}", &zsh[..80]);
    // It parses; what it completes takes a terminal to see.
    run_in("zsh", &["-n"], &zsh);
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
        run_in("mandoc", &["-Tlint", "-Werror"], &page);
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
