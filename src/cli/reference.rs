//! Test: the guide's page of commands, options, recipe keys, layers, stages and exit codes is that of the tables that
//! the program itself goes by.

use super::exit::{DONE, FAILED, MISUSED, SOME_FAILED, STOPPED};
use crate::command::args::LayerNames;
use crate::command::commands::{COMMANDS, program};
use crate::command::recipe::{is_setting, is_switch};
use crate::error::short as short_number;
use crate::params::{Choice, Kind, Many, Param};
use crate::product::{Product, ProductRow};
use crate::stages::stages;
use clap::{Arg, ArgAction};
use std::fs;
use std::path::Path;

/// All exit codes and what they mean.
const EXIT_CODES: [(i32, &str); 6] = [
    (DONE, "done"),
    (FAILED, "failed"),
    (MISUSED, "wrong usage: the command line or a recipe"),
    (
        SOME_FAILED,
        "some frames of a sequence, or some of several pictures, failed",
    ),
    (STOPPED + 2, "stopped by SIGINT"),
    (STOPPED + 15, "stopped by SIGTERM"),
];

/// If this variable is set, the page is written.
const WRITES: &str = "RELIEVO_WRITE_REFERENCE";

#[test]
fn the_reference_of_the_guide_is_fresh() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/reference.md");
    let page = page();
    if std::env::var_os(WRITES).is_some() {
        fs::write(&path, &page).unwrap();
    }
    let is_fresh = fs::read_to_string(path).unwrap() == page;
    assert!(
        is_fresh,
        "write it anew: {WRITES}=1 cargo test --lib reference"
    );
}

/// The page in Markdown.
fn page() -> String {
    let options = options();
    let mut page = ReferencePage(String::new());
    page.say(
        "# Reference\n\n\
         Everything that the program has, from its own tables. The other chapters say what to do with it.",
    );
    page.say("## Commands");
    page.table(&["command", "what it does"], commands());
    page.say(&format!(
        "## Options\n\n\
         In \"commands\", *all* means those that a recipe can run: {}. A number has the range and unit given; a value \
         outside is refused.",
        in_code(COMMANDS)
    ));
    for section in sections(&options) {
        page.say(&format!("### {section}"));
        let of_section = options.iter().filter(|option| option.section() == section);
        let head = ["option", "values", "default", "commands", "what it does"];
        page.table(&head, of_section.map(ArgumentRow::cells));
    }
    page.say(&recipe_keys(&options));
    page.say(
        "## Results\n\n\
         With their channels in an EXR, by short and full names: `--write` takes either, or any word of them. Devices \
         agree with the CPU within the last column, relative to the largest value.",
    );
    let head = [
        "result",
        "channels",
        "full names",
        "values",
        "made",
        "within",
    ];
    page.table(&head, Product::all().map(|product| result(product.row())));
    page.say(
        "## Stages\n\n\
         In the order in which they run. `--explain` prints those that ran, with their time and the reasons of their steps; \
         `--timings` has a time for each stage.",
    );
    page.table(&["stage", "steps", "results"], stages().map(stage));
    page.say("## Exit codes");
    let codes = EXIT_CODES.map(|(code, meaning)| [code.to_string(), meaning.into()]);
    page.table(&["code", "meaning"], codes);
    page.0
}

struct ReferencePage(String);

impl ReferencePage {
    /// A paragraph or a heading.
    fn say(&mut self, text: &str) {
        let space = if self.0.is_empty() { "" } else { "\n" };
        self.0 += &format!("{space}{text}\n");
    }

    fn table<const N: usize>(
        &mut self,
        head: &[&str; N],
        rows: impl IntoIterator<Item = [String; N]>,
    ) {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule = "|---".repeat(N) + "|\n";
        let rows = rows
            .into_iter()
            .map(|row| line(&row.map(|cell| cell.replace('|', "\\|"))));
        self.0 += "\n";
        self.0 += &line(&head.map(String::from));
        self.0 += &rule;
        self.0.extend(rows);
    }
}

fn commands() -> impl Iterator<Item = [String; 2]> {
    let commands = program().get_subcommands();
    commands.map(|command| {
        let about = command.get_about().map(ToString::to_string);
        [
            format!("`{}`", command.get_name()),
            plain(&about.unwrap_or_default()),
        ]
    })
}

/// An argument, and the commands that have it with the same meaning.
struct ArgumentRow {
    arg: &'static Arg,
    commands: Vec<&'static str>,
}

/// All arguments, in the order of the commands.
fn options() -> Vec<ArgumentRow> {
    let mut rows: Vec<ArgumentRow> = Vec::new();
    for command in program().get_subcommands() {
        for arg in command.get_arguments().filter(|arg| !arg.is_hide_set()) {
            let same = |row: &&mut ArgumentRow| {
                row.arg.get_id() == arg.get_id() && help(row.arg) == help(arg)
            };
            match rows.iter_mut().find(same) {
                Some(row) => row.commands.push(command.get_name()),
                None => rows.push(ArgumentRow {
                    arg,
                    commands: vec![command.get_name()],
                }),
            }
        }
    }
    rows
}

/// The headings of help, files and arguments first.
fn sections(rows: &[ArgumentRow]) -> Vec<&'static str> {
    let mut sections = Vec::new();
    for row in rows {
        if !sections.contains(&row.section()) {
            sections.push(row.section());
        }
    }
    sections
}

impl ArgumentRow {
    fn section(&self) -> &'static str {
        match self.arg.get_help_heading() {
            _ if self.arg.is_positional() => "Arguments",
            Some(heading) => heading,
            None => "Of one command",
        }
    }

    fn cells(&self) -> [String; 5] {
        let row = self.arg.get_long().and_then(Param::named);
        let default = self.arg.get_default_values().iter();
        let default: Vec<_> = default.map(|value| value.to_string_lossy()).collect();
        let default = match is_switch(self.arg) {
            true => String::new(),
            false => default.join(","),
        };
        let words = row.map_or(&[][..], words);
        let words = words.iter().filter_map(explained);
        let help = std::iter::once(help(self.arg)).chain(words);
        [
            spelled(self.arg),
            row.map_or_else(|| values(self.arg), of_param),
            default,
            self.within(),
            help.collect::<Vec<_>>().join("; "),
        ]
    }

    /// The commands that have it.
    fn within(&self) -> String {
        let all = COMMANDS.iter().all(|name| self.commands.contains(name));
        let others = self.commands.iter().copied();
        let others = others.filter(|name| !all || !COMMANDS.contains(name));
        let names = all.then_some("all").into_iter().chain(others);
        names.collect::<Vec<_>>().join(", ")
    }
}

/// An argument as typed.
fn spelled(arg: &Arg) -> String {
    let forms = arg.get_value_names().unwrap_or_default();
    let form = forms.first().map_or("", |form| form.as_str());
    let form = if is_switch(arg) { "" } else { form };
    let short = arg.get_short().map(|letter| format!("-{letter}"));
    let aliases = arg.get_visible_aliases().unwrap_or_default();
    let longs = arg.get_long().into_iter().chain(aliases);
    let longs = longs.map(|name| format!("--{name} {form}"));
    let names = short.into_iter().chain(longs);
    let names: Vec<_> = names.map(|name| format!("`{}`", name.trim_end())).collect();
    match names.is_empty() {
        true => format!("`{form}`"),
        false => names.join(", "),
    }
}

fn help(arg: &Arg) -> String {
    plain(&arg.get_help().map_or(String::new(), ToString::to_string))
}

/// A text without what Markdown would take for marks.
fn plain(text: &str) -> String {
    text.replace('*', "\\*").replace('<', "\\<")
}

/// Values of an argument that is no parameter.
fn values(arg: &Arg) -> String {
    if is_switch(arg) {
        return String::new();
    }
    let words = arg.get_possible_values();
    let several = match arg.get_action() {
        ArgAction::Append if arg.get_value_delimiter().is_some() => "several by commas",
        ArgAction::Append => "may be repeated",
        _ => "",
    };
    joined([&in_code(words.iter().map(|word| word.get_name())), several])
}

/// Values of a parameter.
fn of_param(row: &Param) -> String {
    let kind = match row.kind {
        Kind::Switch => return String::new(),
        Kind::Choice(all) => in_code(all.iter().map(|choice| choice.name)),
        Kind::ChoiceOrFolder(all) => in_code(all.iter().map(|choice| choice.name)) + " or a folder",
        Kind::Number { whole: true, .. } => "whole number".into(),
        Kind::Number { whole: false, .. } => "number".into(),
        Kind::Pair => "two numbers".into(),
        Kind::Text => String::new(),
    };
    let (from, to) = (*row.valid.start(), *row.valid.end());
    let range = match (from.is_finite(), to.is_finite()) {
        (true, true) => format!("{} to {}", short_number(from), short_number(to)),
        (true, false) => format!("{} or more", short_number(from)),
        _ => String::new(),
    };
    let range = format!("{range} {}", row.unit.suffix());
    let word = row
        .word()
        .map_or(String::new(), |word| format!("or `{word}`"));
    let several = match row.many {
        Many::One => "",
        Many::Listed => "several by commas",
        Many::Repeated => "may be repeated",
    };
    joined([&kind, range.trim(), &word, several])
}

fn joined<const N: usize>(parts: [&str; N]) -> String {
    let parts = parts.into_iter().filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join(", ")
}

fn in_code<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let words = words.into_iter().map(|word| format!("`{word}`"));
    words.collect::<Vec<_>>().join(", ")
}

/// The words that a parameter accepts.
fn words(row: &Param) -> &'static [Choice] {
    match row.kind {
        Kind::Choice(all) | Kind::ChoiceOrFolder(all) => all,
        _ => &[],
    }
}

/// A word with what it means.
fn explained(word: &Choice) -> Option<String> {
    let lines: Vec<_> = word.doc.iter().map(|line| line.trim()).collect();
    let text = plain(lines.join(" ").trim_end_matches('.'));
    (!text.is_empty()).then(|| format!("`{}`: {text}", word.name))
}

fn recipe_keys(rows: &[ArgumentRow]) -> String {
    let of_recipes = |row: &&ArgumentRow| row.commands.iter().any(|name| COMMANDS.contains(name));
    let left_out = rows.iter().filter(of_recipes);
    let left_out = left_out.filter(|row| !is_setting(row.arg));
    let left_out = left_out.filter_map(|row| row.arg.get_long());
    format!(
        "## Recipe keys\n\n\
         `version` and `command`; then every option of that command, under its name without dashes, except {}. `chosen` \
         is a table of the same keys, and of `frames`. `relievo schema` prints the JSON schema.",
        in_code(left_out)
    )
}

fn result(row: &ProductRow) -> [String; 6] {
    let short: Vec<_> = row.product.channels().collect();
    let full: Vec<_> = short.iter().map(|name| LayerNames::Full.of(name)).collect();
    let made = match row.on_request {
        true => "if `--write` names it",
        false if row.at_scales => "at each scale",
        false => "",
    };
    [
        row.name.into(),
        in_code(short.iter().map(String::as_str)),
        in_code(full.iter().map(String::as_str)),
        row.unit.into(),
        made.into(),
        short_number(row.tolerance),
    ]
}

fn stage(stage: &'static crate::plan::stage::Stage) -> [String; 3] {
    let steps = stage.steps.iter().map(|step| step.name);
    let mut results = Vec::new();
    for product in stage.gives() {
        let name = product.row().name;
        if !results.contains(&name) {
            results.push(name);
        }
    }
    [
        stage.name.into(),
        steps.collect::<Vec<_>>().join(", "),
        results.join(", "),
    ]
}
