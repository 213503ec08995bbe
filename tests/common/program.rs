//! The one runner of the program.

use super::exr;
use relievo::frame::Plane;
use relievo::io::exr::{ExrFile, Limits};
use relievo::io::photo::Photo;
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// The program, to be run in a directory.
pub fn program(directory: &Path) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_relievo"));
    // Mesa's choice of a device writes lines of its own to stderr.
    program.current_dir(directory).env("NODEVICE_SELECT", "1");
    program
}

/// Runs the program with these arguments.
pub fn run<A: AsRef<OsStr>>(directory: &Path, arguments: impl IntoIterator<Item = A>) -> Ran {
    Ran::of(program(directory).args(arguments))
}

/// Runs the program with arguments that are separated by spaces; `fixtures/NAME` is a file of the examples.
pub fn relievo(directory: &Path, words: &str) -> Ran {
    run(directory, arguments(words))
}

/// The words of a command line, those in single quotes as one.
pub fn words(command: &str) -> Vec<&str> {
    let parts = command.split('\'').enumerate();
    let words = parts.flat_map(|(i, part)| match i % 2 {
        0 => part.split_whitespace().collect(),
        _ => vec![part],
    });
    words.collect()
}

fn arguments(command: &str) -> impl Iterator<Item = PathBuf> {
    let in_full = |word: &str| match word.strip_prefix("fixtures/") {
        Some(name) => fixture(name),
        None => word.into(),
    };
    words(command).into_iter().map(in_full)
}

/// Runs the program under a limit that the shell sets.
pub fn relievo_within(limit: &str, directory: &Path, words: &str) -> Ran {
    let mut shell = Command::new("sh");
    let script = format!("{limit}; exec \"$0\" \"$@\"");
    let shell = shell.args(["-c", &script, env!("CARGO_BIN_EXE_relievo")]);
    Ran::of(shell.args(arguments(words)).current_dir(directory))
}

/// Expects messages with these parts, written as in `Desk::check`.
#[track_caller]
pub fn tells(said: &str, parts: &str) {
    for part in parts.split(" ... ") {
        let text = part.strip_prefix('!').unwrap_or(part);
        let is_expected = text == part;
        assert_eq!(said.contains(text), is_expected, "{part} in: {said}");
    }
}

/// A temporary folder, and runs of the program in it.
pub struct Desk(tempfile::TempDir);

impl Desk {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// The file of this name, here or in the examples.
    pub fn at(&self, name: &str) -> PathBuf {
        match name.strip_prefix("fixtures/") {
            Some(name) => fixture(name),
            None => self.path().join(name),
        }
    }

    pub fn has(&self, name: &str) -> bool {
        self.at(name).exists()
    }

    /// The names of the files that begin so, sorted.
    pub fn names(&self, begin: &str) -> Vec<String> {
        names(self.path(), begin)
    }

    pub fn run(&self, words: impl AsRef<str>) -> Ran {
        relievo(self.path(), words.as_ref())
    }

    /// Runs the program and expects success.
    #[track_caller]
    pub fn make(&self, words: impl AsRef<str>) -> Ran {
        self.run(words).done()
    }

    /// The picture that a command writes.
    #[track_caller]
    pub fn picture(&self, words: impl AsRef<str>) -> Photo {
        self.make(format!("{} -q -o picture.png", words.as_ref()));
        self.photo("picture.png")
    }

    /// Runs a table of command lines. A row has words, which stand for `{}` in `common`; after `=>` the exit code; and after a
    /// colon what is said, in parts between ` ... `; after `!` is what is not said. Refusals are one line and leave no file.
    #[track_caller]
    pub fn check(&self, common: &str, rows: &str) {
        let rows = rows.lines().map(str::trim);
        for row in rows.filter(|row| !row.is_empty() && !row.starts_with("//")) {
            println!("{row}");
            let (words, expected) = row.split_once("=>").expect("WORDS => CODE: SAID");
            let words = words.trim();
            let (code, parts) = expected.split_once(": ").unwrap_or((expected, ""));
            assert!(
                words.is_empty() || common.contains("{}"),
                "{common} has no place"
            );
            let before = self.names("");
            let ran = self.run(common.replace("{}", words));
            let said = match code.trim().parse().unwrap() {
                0 => {
                    let ran = ran.done();
                    ran.stdout + &ran.stderr
                }
                code => {
                    let line = ran.refused(code);
                    assert_eq!(self.names(""), before, "{row}");
                    line
                }
            };
            tells(&said, parts);
        }
    }

    pub fn copy(&self, from: &str, to: &str) {
        fs::copy(self.at(from), self.at(to)).unwrap();
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.at(name), content).unwrap();
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.at(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The bytes of a file; for a PNG those of its pixels, since the others record its settings.
    pub fn shown(&self, name: &str) -> Vec<u8> {
        let file = self.bytes(name);
        samples_of_png(&file).unwrap_or(file)
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.text(name)).unwrap()
    }

    pub fn photo(&self, name: &str) -> Photo {
        Photo::read(&self.at(name)).unwrap()
    }

    pub fn exr(&self, name: &str) -> ExrFile {
        ExrFile::open(&self.at(name), &Limits::default()).unwrap()
    }

    /// The first channel called so, or so in full, of any part of a file.
    pub fn channel(&self, file: &str, name: &str) -> Plane {
        exr::channel(&self.at(file), name)
    }
}

fn samples_of_png(file: &[u8]) -> Option<Vec<u8>> {
    let mut reader = png::Decoder::new(Cursor::new(file)).read_info().ok()?;
    let mut samples = vec![0; reader.output_buffer_size()?];
    reader.next_frame(&mut samples).ok()?;
    Some(samples)
}

/// Messages without the line of a build with the GPU backend on a machine that has no GPU, which tests of backends expect.
fn without_devices(said: String) -> String {
    if env!("CARGO_CRATE_NAME") == "backends" {
        return said;
    }
    let lines = said.split_inclusive('\n');
    let is_kept = |line: &&str| !line.starts_with("warning: no GPU: no adapter in hardware");
    lines.filter(is_kept).collect()
}

/// The outcome of a run.
#[derive(Debug)]
pub struct Ran {
    /// `None` where a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Ran {
    pub fn of(command: &mut Command) -> Self {
        Self::of_output(command.output().unwrap())
    }

    fn of_output(output: Output) -> Self {
        let Output {
            status,
            stdout,
            stderr,
        } = output;
        Self {
            code: status.code(),
            stdout: String::from_utf8(stdout).unwrap(),
            stderr: without_devices(String::from_utf8(stderr).unwrap()),
        }
    }

    /// The outcome, and the most memory that the run has held, in bytes, as far as Linux tells.
    pub fn measured(command: &mut Command) -> (Self, u64) {
        let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = piped.spawn().unwrap();
        let status = format!("/proc/{}/status", child.id());
        let mut peak = 0;
        while child.try_wait().unwrap().is_none() {
            let text = std::fs::read_to_string(&status).unwrap_or_default();
            let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let kib = line.and_then(|rest| rest.trim().strip_suffix(" kB")?.parse::<u64>().ok());
            peak = kib.map_or(peak, |kib| kib << 10);
            std::thread::sleep(Duration::from_millis(1));
        }
        (Self::of_output(child.wait_with_output().unwrap()), peak)
    }

    /// Expects success.
    #[track_caller]
    pub fn done(self) -> Self {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self
    }

    /// The messages of a run that ended with `code`.
    #[track_caller]
    pub fn ended(self, code: i32) -> String {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        self.stderr
    }

    /// The one error among the messages of a run that ended with `code`.
    #[track_caller]
    pub fn error(self, code: i32) -> String {
        let said = self.ended(code);
        let errors: Vec<_> = said
            .lines()
            .filter(|line| line.starts_with("error: "))
            .collect();
        assert_eq!(errors.len(), 1, "{said}");
        errors[0].into()
    }

    /// The only line of a refusal with exit code `code`; it must name a remedy.
    #[track_caller]
    pub fn refused(self, code: i32) -> String {
        assert_eq!(self.stdout, "", "an error leaves stdout alone");
        let line = self.ended(code);
        assert!(line.starts_with("error: "), "{line}");
        assert!(line.ends_with('\n'), "{line}");
        assert_eq!(line.lines().count(), 1, "{line}");
        // Refusals by the system carry its own explanation.
        let advises = line.contains("; ") || line.contains(": cannot ");
        assert!(advises, "no word on what to do next: {line}");
        line
    }
}

/// A file of the examples.
pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures")
        .join(name)
}

/// The names of the files in a directory that begin so, sorted.
pub fn names(directory: &Path, begin: &str) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| name.starts_with(begin)).collect();
    names.sort();
    names
}
