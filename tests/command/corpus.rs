//! Everything that fuzzing has ever found, each file through the code that found it: see `tests/fuzz/README.md`.

#[path = "../fuzz/src/targets/mod.rs"]
mod targets;

use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time for one file.
const LIMIT: Duration = Duration::from_secs(10);

/// Address space for one file, in KiB: threads reserve far more than they use.
const MOST_KIB: u64 = 4 << 20;

/// Names the file for [`one_file`].
const FILE: &str = "RELIEVO_CORPUS_FILE";

/// The files of the corpus.
fn corpus() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/found");
    let in_folder = |folder: &Path| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    };
    let targets = in_folder(&folder).into_iter().filter(|p| p.is_dir());
    targets.flat_map(|target| in_folder(&target)).collect()
}

#[test]
fn what_was_found_stays_mended() {
    let files = corpus();
    let targets = targets::TARGETS.len();
    assert!(
        files.len() > targets,
        "the corpus has {} files",
        files.len()
    );
    let failures: Vec<String> = files.par_iter().filter_map(|file| failure(file)).collect();
    let [failed, all] = [failures.len(), files.len()];
    assert!(
        failed == 0,
        "{failed} of {all} files fail:\n{}",
        failures.join("\n")
    );
}

/// The failure of a file, in a process of its own.
fn failure(file: &Path) -> Option<String> {
    let place = tempfile::tempdir().unwrap();
    let said = place.path().join("said");
    let output = std::fs::File::create(&said).unwrap();
    let mut run = Command::new("sh")
        .arg("-c")
        .arg(format!(
            "ulimit -v {MOST_KIB} 2>/dev/null; exec \"$0\" \"$@\""
        ))
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "corpus::one_file", "--ignored", "--nocapture"])
        .env(FILE, file)
        .env("TMPDIR", place.path())
        .stdin(Stdio::null())
        .stdout(output.try_clone().unwrap())
        .stderr(output)
        .spawn()
        .unwrap();
    let start = Instant::now();
    let status = loop {
        if let Some(status) = run.try_wait().unwrap() {
            break status.to_string();
        }
        if start.elapsed() > LIMIT {
            run.kill().unwrap();
            run.wait().unwrap();
            break format!("it takes more than {} s", LIMIT.as_secs());
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let said = String::from_utf8_lossy(&std::fs::read(&said).unwrap()).into_owned();
    let lines: Vec<_> = said.lines().rev().take(12).collect();
    let said = lines.into_iter().rev().collect::<Vec<_>>().join("\n    ");
    (status != "exit status: 0").then(|| format!("{}: {status}\n    {said}", file.display()))
}

/// One file, as [`what_was_found_stays_mended`] runs it.
#[test]
#[ignore = "run by the other test, once for each file"]
fn one_file() {
    let Some(file) = std::env::var_os(FILE).map(PathBuf::from) else {
        return;
    };
    let folder = file.parent().and_then(Path::file_name).unwrap();
    targets::run(&folder.to_string_lossy(), &std::fs::read(&file).unwrap());
}
