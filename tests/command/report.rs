//! `relievo report`: its files, its advice, and the cases it checks itself by.

use crate::common::program::{Ran, fixture, run};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn relievo(arguments: &[&str]) -> Ran {
    run(Path::new("."), arguments)
}

/// The report on a command, as numbers and as a page, and what was printed.
fn report(input: &str, flags: &[&str]) -> (Value, String, Ran) {
    let place = tempfile::tempdir().unwrap();
    let (input, directory) = (fixture(input), place.path().join("report"));
    let paths = [&input, &directory].map(|path| path.to_str().unwrap());
    let ran = relievo(&[&["report", paths[0], "-o", paths[1]], flags].concat()).done();
    let read = |name: &str| fs::read_to_string(directory.join(name)).unwrap();
    let files = fs::read_dir(&directory).unwrap().count();
    assert_eq!(files, 2, "report.html and report.json");
    (
        serde_json::from_str(&read("report.json")).unwrap(),
        read("report.html"),
        ran,
    )
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// The row of a setting, or of a part.
fn row<'a>(rows: &'a Value, key: &str, name: &str) -> &'a Value {
    let mut rows = rows.as_array().unwrap().iter();
    rows.find(|row| row[key] == name)
        .unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn the_report_is_on_the_command_and_the_frame() {
    let (json, page, ran) = report(
        "wheel.0001.exr",
        &["--for", "enhance --scale 20", "--budget", "16"],
    );
    assert_eq!(json["command"], "relievo enhance --scale 20");
    let settings = &json["settings"];
    let of = |flags: &str, key: &str| number(&row(settings, "flags", flags)["error"][key]);
    // The solver's error is the tolerance's: a tenth of it is a tenth of that.
    let errors = [
        "--tolerance 0.1",
        "--tolerance 0.01",
        "--tolerance 0.001",
        "",
    ]
    .map(|flags| of(flags, "p99"));
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.3 * pair[0], "{errors:?}");
    }
    assert!(number(&json["reference"]["own"]["p99"]) < 0.1 * errors[2]);
    // Quantiles and shares agree.
    for setting in settings.as_array().unwrap() {
        let [p50, p99, largest] =
            ["p50", "p99", "largest"].map(|key| number(&setting["error"][key]));
        assert!(p50 <= p99 && p99 <= largest, "{setting}");
        let [one, two] = ["beyond_1", "beyond_2"].map(|key| number(&setting["error"][key]));
        assert!(two <= one && (largest > 2.0) == (two > 0.0), "{setting}");
    }
    // The same picture with what is chosen given; another without the diffusion.
    let parts = &json["parts"];
    let changes = |name: &str| number(&row(parts, "name", name)["change"]["beyond_2"]);
    assert_eq!(changes("choice of the gain"), 0.0);
    assert!(changes("diffusion") > 0.3 && changes("enhance") > 0.3);
    assert!(json["verdict"]["shows"].as_f64().unwrap() > 0.3);
    // One page that loads nothing.
    assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"));
    assert!(
        !page.contains("href=") && !page.contains("src=\"http") && page.contains("data:image/png")
    );
    assert!(!page.contains("NaN") && !page.contains("inf\""));
    assert!(
        ran.stdout.lines().count() < 45 && ran.stdout.contains("report.html"),
        "{}",
        ran.stdout
    );
}

/// The street's road and houses are flat: shape in its picture is a matter of few pixels, without which nothing is lost.
#[test]
fn a_command_that_hardly_shows_is_said_to() {
    let (json, _, ran) = report("street.exr", &["--scale", "20", "--budget", "4"]);
    assert_eq!(json["command"], "relievo enhance");
    assert!(
        ran.stdout.contains("this command hardly shows here"),
        "{}",
        ran.stdout
    );
    assert!(
        number(&json["verdict"]["shows"]) < 0.02,
        "{}",
        json["verdict"]
    );
}

#[test]
fn commands_of_all_kinds_and_recipes_are_reported_on() {
    let place = tempfile::tempdir().unwrap();
    let recipe = place.path().join("look.toml");
    fs::write(
        &recipe,
        "version = 1\ncommand = \"relight\"\nlight = \"135,40\"\n",
    )
    .unwrap();
    let recipe = recipe.to_str().unwrap();
    for (flags, part) in [
        (["--for", "hatch --style pen"], "contours"),
        (["--for", "map --map curvature"], "silhouettes"),
        (["--for", "shape"], "creases"),
        (["--recipe", recipe], "warping"),
    ] {
        let (json, ..) = report(
            "wheel.0001.exr",
            &[&flags[..], &["--budget", "2", "-q"]].concat(),
        );
        row(&json["parts"], "name", part);
        assert!(number(&json["trust"]["rounds"]) >= 3.0, "{flags:?}");
        // What floats hold is shown as the picture was, exposure and all: only a PNG is rounded.
        for file in json["files"].as_array().unwrap() {
            let is_float = file["flags"].as_str().unwrap().ends_with("float");
            assert!(
                !is_float || number(&file["error"]["largest"]) < 0.01,
                "{file}"
            );
        }
    }
}

#[test]
fn what_cannot_be_reported_on_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let bust = fixture("bust.exr");
    let bust = bust.to_str().unwrap();
    for (flags, said) in [
        (
            ["--for", "sharpen --scale 2"],
            "--for begins with sharpen; begin it with one of shape, enhance",
        ),
        (
            ["--for", "enhance --scale \"2"],
            "a quote that does not end",
        ),
        (["--for", "enhance --scale"], "--scale"),
        (["--recipe", "nowhere.toml"], "nowhere.toml"),
    ] {
        let ran = relievo(&["report", bust, flags[0], flags[1]]);
        assert_ne!(ran.code, Some(0), "{flags:?}");
        assert!(ran.stderr.contains(said), "{}", ran.stderr);
        assert_eq!(
            ran.stderr
                .trim()
                .lines()
                .filter(|l| l.starts_with("error"))
                .count(),
            1
        );
    }
    // No input becomes an output, and no file a directory.
    let input = place.path().join("report.json");
    fs::copy(fixture("bust.exr"), &input).unwrap();
    let paths = [input.to_str().unwrap(), place.path().to_str().unwrap()];
    assert_eq!(relievo(&["report", paths[0], "-o", paths[1]]).code, Some(2));
    assert_eq!(relievo(&["report", bust, "-o", paths[0]]).code, Some(2));
    let none = relievo(&["report"]);
    assert_eq!(none.code, Some(2), "{}", none.stderr);
}

/// The flags of older releases are taken, with a note.
#[test]
fn older_flags_are_taken() {
    let bust = fixture("bust.exr");
    let ran = relievo(&["report", bust.to_str().unwrap(), "--quick", "--budget", "1"]).done();
    assert!(ran.stderr.contains("note: "), "{}", ran.stderr);
}

#[test]
fn the_cases_end_as_declared() {
    let ran = relievo(&["report", "--cases", "-q"]).done();
    let last = ran.stdout.lines().last().unwrap();
    assert!(last.ends_with("all as declared"), "{}", ran.stdout);
    let count: usize = last.split(' ').next().unwrap().parse().unwrap();
    assert!((40..=60).contains(&count), "{last}");
}

/// What --explain says ran is what --timings has.
#[test]
fn what_is_explained_is_what_ran() {
    let place = tempfile::tempdir().unwrap();
    let timings = place.path().join("timings.json");
    let timings = timings.to_str().unwrap();
    let [bust, street, shot, photo, normals] = [
        "bust.exr",
        "street.exr",
        "wheel.0001.exr",
        "tablet.color.jpg",
        "tablet.normal.png",
    ]
    .map(fixture);
    let path = |path: &std::path::PathBuf| path.to_str().unwrap().to_string();
    let of_photo = format!("{} --normal {}", path(&photo), path(&normals));
    let mut count = 0;
    for command in [
        "enhance -o o.png",
        "enhance -o o.png --scaling 0",
        "enhance -o o.png --mix 0",
        "enhance -o o.exr --iterations 0",
        "enhance -o o.png --scale 20 --curvature-gain 4",
        "enhance -o o.png --max-memory 40M",
        "shape -o o.png",
        "shape -o o.exr",
        "shape -o o.exr --scale 2,8",
        "relight -o o.png --light 135,40",
        "relight -o o.exr --light 135,40 --method plain",
        "relight -o o.png --light 135,40 --method scale --albedo-from white",
        "hatch -o o.png",
        "hatch -o o.svg",
        "hatch -o o.png --lines-only",
        "hatch -o o.png --style stipple",
        "map -o o.png",
        "map -o o_{map}.png --map curvature,edges,height",
    ] {
        for input in [path(&bust), path(&street), path(&shot), of_photo.clone()] {
            let words = command.split_whitespace().chain(input.split_whitespace());
            let more = ["--explain", "--timings", timings, "-q"];
            let words: Vec<_> = words.chain(more).collect();
            let ran = run(place.path(), &words);
            if ran.code != Some(0) {
                // Photos are no frames of strips, and so on: what is refused explains nothing.
                assert!(!ran.stdout.contains("ran "), "{words:?}");
                continue;
            }
            let json: Value = serde_json::from_str(&fs::read_to_string(timings).unwrap()).unwrap();
            let stages = json["stages"].as_array().unwrap().iter();
            let stages: Vec<_> = stages
                .map(|stage| stage["stage"].as_str().unwrap())
                .collect();
            let told = ran
                .stdout
                .lines()
                .filter_map(|line| line.strip_prefix("ran   "));
            let told: Vec<_> = told
                .filter_map(|line| line.split_whitespace().next())
                .collect();
            assert_eq!(told, stages, "{words:?}\n{}", ran.stdout);
            count += 1;
        }
    }
    assert!(count >= 60, "{count} command lines ran");
}
