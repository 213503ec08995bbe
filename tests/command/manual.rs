//! Completions and manual pages.

use crate::common::exr::Part;
use crate::common::program::{Desk, fixture, program, relievo};
use relievo::frame::Plane;
use std::collections::BTreeSet;
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
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(script.as_bytes()).unwrap();
    drop(stdin);
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

/// The lines that make `shell` complete.
fn registered(shell: &str) -> String {
    // zsh registers with a completion system that only a terminal has.
    let system = "compdef() { }\n".repeat(usize::from(shell == "zsh"));
    system + &printed(&format!("completions {shell}")) + "\n"
}

fn survey(path: &Path) -> relievo::io::Survey {
    let inputs = relievo::io::inputs::Inputs {
        picture: path.into(),
        ..Default::default()
    };
    relievo::io::survey(&inputs).unwrap()
}

/// What a shell offers after this line: the words alone, without what zsh and fish add of what a candidate means.
fn offered(shell: usize, line: &str, directory: &Path) -> Option<Vec<String>> {
    let (shell, arguments, script) = SHELLS[shell];
    // fish takes an empty last word as a space.
    let line = match shell {
        "fish" => line.trim_end_matches('\''),
        _ => line,
    };
    let script = registered(shell) + &script.replace("LINE", line);
    let found = run_in(shell, arguments, directory, &script)?;
    let is_plain = |c: char| !c.is_control() || c == '\n' || c == '\t';
    assert!(found.chars().all(is_plain), "{shell}: {found:?}");
    let words = found
        .lines()
        .map(|line| line.split([':', '\t']).next().unwrap());
    Some(words.map(String::from).collect())
}

/// Commands and options are completed, and after an option that names a layer, the layers of the file on the line.
#[test]
fn shells_complete_commands_options_and_layers() {
    let desk = Desk::new();
    desk.copy("fixtures/bust.exr", "shot.0001.exr");
    let file = survey(&fixture("bust.exr"));
    let layers = file.parts.iter().flat_map(|part| &part.layers);
    let layers = layers.map(|layer| layer.name.as_str());
    let layers: BTreeSet<_> = layers.filter(|name| !name.is_empty()).collect();
    assert!(layers.contains("ViewLayer.Normal"), "{layers:?}");
    // After ALL every layer is offered too.
    let rows = "
        relievo enh => enhance
        relievo enhance in.exr --invar => --invariant-point
        relievo enhance shot.0001.exr --normal '' => ALL shot.0001.exr
        relievo hatch -o a.png shot.####.exr --depth '' => ALL none shot.0001.exr
        relievo inspect shot.0001.exr --normal ViewLayer.N => ViewLayer.Normal
        relievo inspect shot.0001.exr --layer '' => ViewLayer
    ";
    for shell in 0..SHELLS.len() {
        for row in rows.trim().lines() {
            let (line, expected) = row.split_once("=>").unwrap();
            let mut expected = BTreeSet::from_iter(expected.split_whitespace());
            if expected.remove("ALL") {
                expected.extend(&layers);
            }
            let Some(found) = offered(shell, line.trim(), desk.path()) else {
                break;
            };
            let found = BTreeSet::from_iter(found.iter().map(String::as_str));
            assert_eq!(found, expected, "{shell}: {line}");
        }
    }
    // As a package installs it for zsh.
    desk.write("_relievo", printed("completions zsh"));
    let (shell, arguments, script) = SHELLS[1];
    let script = script.replace("_clap_dynamic_completer_relievo", "_relievo");
    let script = script.replace("LINE", "relievo enh");
    let head = "compdef() { }\nfpath=(. $fpath)\nautoload -Uz _relievo\n";
    if let Some(found) = run_in(shell, arguments, desk.path(), &(head.to_owned() + &script)) {
        assert!(found.starts_with("enhance:"), "{found}");
    }
}

/// Names of layers and files that a shell would run or change are not offered, and those that are, it takes as they stand.
#[cfg(unix)]
#[test]
fn no_name_is_run_by_a_shell() {
    let desk = Desk::new();
    let plane = Plane::filled(4, 4, 0.5);
    #[rustfmt::skip]
    let hostile = [
        "$(touch pwned)Normal", "`touch pwned`", "a;touch pwned;", "a\ntouch pwned", "a\u{b}$(touch pwned)",
        "a&touch pwned", "a|touch pwned", "two words", "{a,b}", "*", "?", "[a]", "~", "!x", "a\tb", "a\u{1b}[31m",
        "'", "\"", "\\", "#a", "<a", ">pwned", "--output=pwned",
    ];
    let names = hostile.iter().chain(&["Fine_Normal-1"]);
    let channels = names.flat_map(|name| ["X", "Y", "Z"].map(|axis| format!("{name}.{axis}")));
    // A component is shown beside a name.
    let component = "Fine_Normal-1.\u{1b}]0;\u{7}".to_string();
    let groups = hostile.iter().chain(&["Fine"]);
    let groups = groups.map(|name| format!("{name}.N.X"));
    let channels = channels.chain([component]).chain(groups);
    Part::of(channels.map(|name| (name, &plane))).write(&desk.at("in.exr"));
    for name in hostile {
        desk.write(&format!("{name}.png"), "");
    }
    let file = survey(&desk.at("in.exr"));
    let layers = file.parts[0].layers.iter();
    let layers: Vec<_> = layers.map(|layer| layer.name.as_str()).collect();
    let has_all = hostile.iter().all(|name| layers.contains(name));
    assert!(has_all, "{layers:?}");
    for (shell, (name, arguments, _)) in SHELLS.into_iter().enumerate() {
        for (line, expected) in [
            (
                "inspect in.exr --normal ''",
                &["Fine_Normal-1", "in.exr"][..],
            ),
            ("inspect ''", &["in.exr"]),
            ("inspect in.exr --layer ''", &["Fine"]),
            (
                "enhance in.exr --normal=",
                &["--normal=Fine_Normal-1", "--normal=in.exr"],
            ),
        ] {
            let line = format!("relievo {line}");
            let Some(offered) = offered(shell, &line, desk.path()) else {
                break;
            };
            for expected in expected {
                let is_offered = offered.iter().any(|word| word == expected);
                assert!(is_offered, "{name}: {line}: {offered:?}");
            }
            let is_word = |c: char| c.is_alphanumeric() || "._-:/+@,=".contains(c);
            for word in offered {
                let is_option = word.starts_with('-') && word != "--output=pwned";
                let is_sane = word.chars().all(is_word) && !word.is_empty();
                assert!(is_sane, "{name}: {word:?}");
                assert!(is_option || !word.starts_with('-'), "{name}: {word:?}");
                // As if it were accepted and entered.
                if !is_option {
                    let entered = format!("relievo inspect in.exr --normal {word}; true\n");
                    run_in(name, arguments, desk.path(), &entered);
                }
            }
        }
    }
    assert!(!desk.has("pwned"), "a shell has run a name");
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
            let is_told = plain.contains(&format!("--{flag}"));
            assert!(is_told, "man {name} lacks --{flag}");
        }
        run_in("mandoc", &["-Tlint", "-Werror"], Path::new("."), &page);
    }
    assert!(printed("man").contains("enhance"));
    Desk::new().check("man nothing", "=> 2: nothing");
}

/// A reader that closes the pipe early ends the program without a word.
#[test]
fn a_closed_pipe_is_no_error() {
    for words in ["man hatch", "--help", "hatch --help-all"] {
        let mut child = program(Path::new("."))
            .args(words.split(' '))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stderr), "");
        assert_eq!(output.status.code(), Some(0), "{words}");
    }
}
