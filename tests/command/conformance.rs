//! The binary on third-party files: every known kind of OpenEXR, damaged ones, and real renders.
//!
//! The files are not part of this project; where they are missing the tests print a notice and pass.

use crate::common::program::{Desk, Ran};
use crate::common::real_files::real;
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time for any file.
const TIME_LIMIT: Duration = Duration::from_secs(10);
/// Most memory for any file, in units of 1024 bytes.
const MEMORY_LIMIT: u32 = 2_000_000;

/// All files under `directory`, in order.
fn files(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let all = paths.into_iter().flat_map(|path| match path.is_dir() {
        true => files(&path),
        false => vec![path],
    });
    all.collect()
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().and_then(OsStr::to_str);
    extension.is_some_and(|e| extensions.contains(&e))
}

/// Runs the binary within the limits; a run past them, or ended by a signal, fails the test.
fn relievo(directory: &Path, args: &[&OsStr]) -> Ran {
    let binary = env!("CARGO_BIN_EXE_relievo");
    let mut command = Command::new("sh");
    // Elsewhere memory has no such limit.
    let limit = if cfg!(target_os = "linux") {
        format!("ulimit -v {MEMORY_LIMIT}; ")
    } else {
        String::new()
    };
    let script = limit + r#"exec "$0" "$@""#;
    let [out, err] = [(); 2].map(|_| tempfile::NamedTempFile::new().unwrap());
    let mut child = command
        .args(["-c", &script, binary])
        .args(args)
        .current_dir(directory)
        .env("RAYON_NUM_THREADS", "2")
        .stdin(Stdio::null())
        .stdout(out.reopen().unwrap())
        .stderr(err.reopen().unwrap())
        .spawn()
        .unwrap();
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > TIME_LIMIT {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{args:?} takes longer than {TIME_LIMIT:?}");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let [stdout, stderr] = [out, err].map(|file| fs::read_to_string(file.path()).unwrap());
    let code = status.code();
    assert!(code.is_some(), "{args:?} ended with {status}: {stderr}");
    Ran {
        code,
        stdout,
        stderr,
    }
}

/// Expects success, or exit code 1 with one line that names the file.
fn assert_done_or_told(ran: &Ran, file: &Path, verb: &str) {
    let name = file.file_name().unwrap().to_string_lossy();
    let case = format!("{verb} {name}: exit code {:?}\n{}", ran.code, ran.stderr);
    match ran.code {
        Some(0) => assert!(!ran.stderr.contains("error"), "{case}"),
        Some(1) => {
            let errors = ran.stderr.lines().filter(|l| l.starts_with("error: "));
            assert_eq!(errors.count(), 1, "{case}");
            let rest = ran.stderr.lines().filter(|l| !l.starts_with("warning: "));
            assert_eq!(rest.count(), 1, "{case}");
            assert!(ran.stderr.contains(&*name), "{case}");
            assert_eq!(ran.stdout, "", "{case}");
        }
        _ => panic!("{case}"),
    }
}

#[test]
fn any_file_is_read_or_refused_with_one_line() {
    let Some(directory) = real("conformance") else {
        return;
    };
    let files = files(&directory);
    assert!(files.len() > 100, "only {} files", files.len());
    let mut done = [0; 3];
    for file in &files {
        let desk = Desk::new();
        let run = |words: &[&str]| {
            // The file stands for FILE.
            let words = words.iter().map(|word| match *word {
                "FILE" => file.as_os_str(),
                word => word.as_ref(),
            });
            relievo(desk.path(), &words.collect::<Vec<_>>())
        };
        let inspected = run(&["inspect", "FILE"]);
        assert_done_or_told(&inspected, file, "inspect");
        done[0] += usize::from(inspected.code == Some(0));

        // Once as it is, and once with its picture as normals, so that every pixel is decoded.
        for (i, words) in [
            "enhance FILE -o a.png",
            "enhance FILE -o a.exr --normal FILE --normal-space view --normal-encoding signed",
        ]
        .into_iter()
        .enumerate()
        {
            let ran = run(&words.split(' ').collect::<Vec<_>>());
            assert_done_or_told(&ran, file, "enhance");
            done[i + 1] += usize::from(ran.code == Some(0));
            // The whole output or nothing at all.
            let expected = if ran.code == Some(0) {
                vec![["a.png", "a.exr"][i]]
            } else {
                vec![]
            };
            let left = desk.names("");
            assert_eq!(left, expected, "{}", file.display());
            left.iter()
                .for_each(|name| fs::remove_file(desk.at(name)).unwrap());
        }
    }
    println!("{} files, done {done:?}", files.len());
    assert!(done[0] > 50 && done[2] > 30, "{done:?}");
    assert!(done[0] < files.len() - 30, "damaged files pass: {done:?}");
}

/// `inspect --json` of one file.
fn inspection(file: &Path) -> Value {
    let words = ["inspect".as_ref(), "--json".as_ref(), file.as_os_str()];
    let ran = relievo(Path::new("."), &words);
    assert_eq!(ran.code, Some(0), "{}: {}", file.display(), ran.stderr);
    let mut json: Value = serde_json::from_str(&ran.stdout).unwrap();
    json[0].take()
}

/// Pairs of a role and the layer that plays it.
fn roles<'a>(inspection: &'a Value) -> Vec<(&'a str, &'a str)> {
    let roles = inspection["roles"].as_array().unwrap();
    let text = |value: &'a Value| value.as_str().unwrap();
    let pairs = roles.iter().map(|r| (text(&r["role"]), text(&r["layer"])));
    pairs.collect()
}

fn layer_names(inspection: &Value) -> Vec<&str> {
    let parts = inspection["parts"].as_array().unwrap().iter();
    parts
        .flat_map(|part| part["layers"].as_array().unwrap())
        .map(|layer| layer["name"].as_str().unwrap())
        .collect()
}

#[test]
fn renders_show_their_roles() {
    let Some(directory) = real("renders") else {
        return;
    };
    let known = [
        ("ViewLayer.Combined", "color"),
        ("ViewLayer.Normal", "normal"),
        ("ViewLayer.Depth", "depth"),
        ("ViewLayer.Position", "position"),
    ];
    let mut seen = [0; 4];
    for file in files(&directory) {
        if !has_extension(&file, &["exr"]) {
            continue;
        }
        let inspection = inspection(&file);
        let (roles, layers) = (roles(&inspection), layer_names(&inspection));
        for (count, (layer, role)) in seen.iter_mut().zip(known) {
            let expected = layers.contains(&layer).then_some(layer);
            let found = roles.iter().find(|(r, _)| *r == role).map(|(_, l)| *l);
            assert_eq!(found, expected, "{role} of {}", file.display());
            *count += usize::from(expected.is_some());
        }
        // A problem, if there is one, names the flag that solves it.
        if let Some(problem) = inspection["problem"].as_str() {
            assert!(problem.contains("--"), "{problem}");
        }
    }
    assert!(seen.iter().all(|&count| count >= 8), "{seen:?}");
}

#[test]
fn the_light_passes_of_blender_are_known() {
    let Some(directory) = real("renders") else {
        return;
    };
    let common = [
        ("color", "Combined", "Combined"),
        ("normal", "Normal", "Normal"),
        ("depth", "Depth", "Depth"),
        ("position", "Position", "Position"),
        ("occlusion", "AO", "Ambient Occlusion"),
        ("diffuse-direct", "DiffDir", "Diffuse Direct"),
        ("diffuse-indirect", "DiffInd", "Diffuse Indirect"),
        ("diffuse-color", "DiffCol", "Diffuse Color"),
        ("glossy-direct", "GlossDir", "Glossy Direct"),
        ("glossy-indirect", "GlossInd", "Glossy Indirect"),
        ("glossy-color", "GlossCol", "Glossy Color"),
        ("transmission-direct", "TransDir", "Transmission Direct"),
        ("emission", "Emit", "Emission"),
        ("environment", "Env", "Environment"),
        ("motion", "Vector", "Vector"),
        ("mist", "Mist", "Mist"),
        ("object-index", "IndexOB", "Object Index"),
        ("material-index", "IndexMA", "Material Index"),
    ];
    let files = [
        "suzanne_480_allpasses_b34_dwaa.exr",
        "suzanne_480_allpasses_b50_multipart_dwaa.exr",
    ];
    for (i, name) in files.into_iter().enumerate() {
        let inspection = inspection(&directory.join(name));
        let found = roles(&inspection);
        for (role, old, new) in common {
            let layer = format!("ViewLayer.{}", [old, new][i]);
            assert!(found.contains(&(role, &layer)), "{name}: no {role} {layer}");
        }
        let findings = inspection["findings"].as_array().unwrap();
        let space = findings.iter().find(|f| f["subject"] == "normal space");
        assert_eq!(space.unwrap()["conclusion"], "world", "{name}");
        let warnings = inspection["warnings"].to_string();
        assert!(warnings.contains("ViewLayer.Normal.Y"), "{warnings}");
    }
}

#[test]
fn photos_are_pictures_and_serve_as_normal_maps() {
    let Some(directory) = real("rgbn") else {
        return;
    };
    let mut photos = 0;
    for file in files(&directory) {
        if has_extension(&file, &["exr", "jpg", "png"]) {
            let inspection = inspection(&file);
            let roles = roles(&inspection);
            assert!(roles.iter().any(|(r, _)| *r == "color"), "{roles:?}");
            photos += 1;
        }
    }
    assert!(photos >= 6);

    // The same map as OpenGL and as DirectX, whose green points down.
    let desk = Desk::new();
    let photo = directory.join("Bricks102_1K-JPG");
    let photo = photo.display();
    let enhanced = |map: &str| {
        let words = format!("{photo}_Color.jpg --normal {photo}_{map}");
        desk.make(format!("enhance {words} -o a.png"));
        image::open(desk.at("a.png")).unwrap().to_rgb8()
    };
    let right = enhanced("NormalGL.jpg");
    let mean_apart = |other: &image::RgbImage| {
        let pairs = right.iter().zip(other.iter());
        let apart = pairs.map(|(a, b)| f64::from(a.abs_diff(*b)));
        apart.sum::<f64>() / right.len() as f64
    };
    let flipped = mean_apart(&enhanced("NormalDX.jpg --normal-flip y"));
    let told = mean_apart(&enhanced("NormalDX.jpg"));
    assert_eq!(told, flipped, "the curl of its slopes tells it");
    let wrong = mean_apart(&enhanced("NormalDX.jpg --normal-flip none"));
    assert!(
        10.0 * flipped < wrong,
        "{flipped} flipped, {wrong} as it is"
    );
}
