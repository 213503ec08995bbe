//! The one runner of the program.

use std::ffi::OsStr;
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

/// Runs the program with arguments that are separated by spaces.
pub fn relievo(directory: &Path, words: &str) -> Ran {
    run(directory, words.split_whitespace())
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
