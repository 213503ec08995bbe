//! Completions by the shell: commands, options, values, and the layers of the file on the line.

use super::{PROGRAM, command, exit, message};
use crate::command::commands::{CompletionsArgs, command_named};
use crate::command::frames_there::frames_on_disk;
use crate::error::{Error, Result};
use crate::io::sequence::path_of_frame;
use crate::io::{groups, layers};
use crate::untrusted::Untrusted;
use clap::ValueHint;
use clap_complete::Shell;
use clap_complete::engine::{
    ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter,
};
use clap_complete::env::{CompleteEnv, Shells};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Set by a shell to its name when it asks for completions.
const VARIABLE: &str = "RELIEVO_COMPLETE";

/// The first words of a value that names a layer of the input.
const LAYER: &str = "NAME|FILE";

/// The option that names a group of layers of the input.
const GROUP: &str = "layer";

/// A file `_relievo` on zsh's path is the body of a function: its first call has to complete too.
const ZSH_AUTOLOAD: &str = "\
if [[ ${funcstack[1]} == _relievo ]]; then
    _clap_dynamic_completer_relievo
fi
";

/// Prints the lines that make a shell ask this program for completions.
pub(super) fn script(args: &CompletionsArgs) -> Result<()> {
    let name = args.shell.to_string();
    let shells = Shells::builtins();
    let shell = shells.completer(&name).expect("both lists are clap's");
    let mut text = Vec::new();
    let written = shell.write_registration(VARIABLE, PROGRAM, PROGRAM, PROGRAM, &mut text);
    written.map_err(Error::io(Path::new("stdout"), "write"))?;
    let mut text = String::from_utf8_lossy(&text).into_owned();
    if args.shell == Shell::Zsh {
        text += ZSH_AUTOLOAD;
    }
    message::print(&text)
}

/// Prints completions of `words` and returns the exit code, if a shell asks for them.
pub(super) fn answered(words: &[OsString]) -> Option<i32> {
    let here = std::env::current_dir().ok();
    let program = CompleteEnv::with_factory(|| with_layers(words)).var(VARIABLE);
    match program.try_complete(words, here.as_deref()) {
        Ok(false) => None,
        Ok(true) => Some(exit::DONE),
        Err(error) => Some(message::misuse(&error)),
    }
}

/// The program, whose options know the files that there are, and the layers of the input among `words`.
fn with_layers(words: &[OsString]) -> clap::Command {
    let input = input_of(words);
    command().mut_subcommands(|command| {
        command.mut_args(|arg| {
            if arg.get_id() == GROUP {
                let input = input.clone();
                return arg.add(offering(move |typed| of_group(typed, input.as_deref())));
            }
            let form = arg.get_value_names().and_then(<[_]>::first);
            let layer = form.and_then(|form| form.strip_prefix(LAYER));
            let Some(rest) = layer else {
                return match files_of(arg.get_value_hint()) {
                    Some(files) => arg.add(offering(move |typed| files.complete(typed))),
                    None => arg,
                };
            };
            let (none, input) = (rest.strip_prefix('|').map(String::from), input.clone());
            arg.add(offering(move |typed| {
                named(typed, input.as_deref(), none.as_deref())
            }))
        })
    })
}

/// Offers those of the candidates that a shell takes as they stand: names of layers and files are untrusted, and bash
/// runs what is in some of them.
fn offering<C>(candidates: C) -> ArgValueCompleter
where
    C: Fn(&OsStr) -> Vec<CompletionCandidate> + Send + Sync + 'static,
{
    ArgValueCompleter::new(move |typed: &OsStr| {
        let mut offered = candidates(typed);
        offered.retain(|one| {
            let word = one.get_value().to_str();
            word.is_some_and(|word| Untrusted(word).shell_word().is_some())
        });
        offered
    })
}

/// The files that a value of this kind may name.
fn files_of(hint: ValueHint) -> Option<PathCompleter> {
    match hint {
        ValueHint::AnyPath => Some(PathCompleter::any()),
        ValueHint::FilePath => Some(PathCompleter::file()),
        ValueHint::DirPath => Some(PathCompleter::dir()),
        _ => None,
    }
}

/// The input of the command line after `--`: its first frame if it is a sequence.
fn input_of(words: &[OsString]) -> Option<PathBuf> {
    let typed = words.iter().skip_while(|word| *word != "--").skip(2);
    let name = typed.clone().next()?.to_str()?;
    let command = command_named(name).ignore_errors(true);
    let matches = command.try_get_matches_from(typed).ok()?;
    let given = |id| matches.try_get_raw(id).ok()??.next();
    let input = Path::new(["input", "files"].into_iter().find_map(given)?);
    match frames_on_disk(input) {
        Some(frames) => path_of_frame(input, *frames.first()?),
        None => Some(input.into()),
    }
}

/// Groups of layers whose names begin with `typed`.
fn of_group(typed: &OsStr, input: Option<&Path>) -> Vec<CompletionCandidate> {
    let found = input.and_then(|input| groups(input).ok());
    let mut found = found.unwrap_or_default();
    found.retain(|name| name.starts_with(&*typed.to_string_lossy()));
    found.into_iter().map(CompletionCandidate::new).collect()
}

/// Layers whose names begin with `typed`, with their components; the word `none` where it is taken; files.
fn named(typed: &OsStr, input: Option<&Path>, none: Option<&str>) -> Vec<CompletionCandidate> {
    let found = input.and_then(|input| layers(input).ok());
    let layers = found.into_iter().flatten();
    let layers = layers.filter(|layer| !layer.name.is_empty());
    let layers = layers.map(|layer| {
        let components = Untrusted(&layer.components.join(" ")).to_string();
        CompletionCandidate::new(layer.name).help(Some(components.into()))
    });
    let typed_text = typed.to_string_lossy();
    layers
        .chain(none.map(CompletionCandidate::new))
        .filter(|one| one.get_value().to_string_lossy().starts_with(&*typed_text))
        .chain(PathCompleter::file().complete(typed))
        .collect()
}
