//! `relievo report`: its files, its advice, and the cases it checks itself by.

use crate::common::program::Desk;
use serde_json::Value;

/// The report on a command, as numbers and as a page, and what was printed.
fn report(words: &str) -> (Value, String, String) {
    let desk = Desk::new();
    let ran = desk.make(format!("report fixtures/{words} -o report"));
    assert_eq!(desk.at("report").read_dir().unwrap().count(), 2);
    let json = desk.json("report/report.json");
    (json, desk.text("report/report.html"), ran.stdout)
}

fn number(value: &Value) -> f64 {
    let number = value.as_f64();
    number.unwrap_or_else(|| panic!("{value} is no number"))
}

/// The row of a setting, or of a part.
fn row<'a>(rows: &'a Value, key: &str, name: &str) -> &'a Value {
    let mut rows = rows.as_array().unwrap().iter();
    rows.find(|row| row[key] == name)
        .unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn the_report_is_on_the_command_and_the_frame() {
    let (json, page, said) = report("wheel.0001.exr --for 'enhance --scale 20' --budget 16");
    assert_eq!(json["command"], "relievo enhance --scale 20");
    let settings = &json["settings"];
    let of = |flags: &str| number(&row(settings, "flags", flags)["error"]["p99"]);
    // The solver's error is the tolerance's: a tenth of it is a tenth of that.
    let errors = [
        "--tolerance 0.1",
        "--tolerance 0.01",
        "--tolerance 0.001",
        "",
    ]
    .map(of);
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.3 * pair[0], "{errors:?}");
    }
    assert!(number(&json["reference"]["own"]["p99"]) < 0.1 * errors[2]);
    // Quantiles and shares agree.
    for setting in settings.as_array().unwrap() {
        let of = |key| number(&setting["error"][key]);
        let [p50, p99, largest] = ["p50", "p99", "largest"].map(of);
        assert!(p50 <= p99 && p99 <= largest, "{setting}");
        let [one, two] = ["beyond_1", "beyond_2"].map(of);
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
    let loads = page.contains("href=") || page.contains("src=\"http");
    assert!(!loads && page.contains("data:image/png"));
    assert!(page.contains("default-src 'none'"));
    assert!(!page.contains("NaN") && !page.contains("inf\""));
    assert!(
        said.lines().count() < 45 && said.contains("report.html"),
        "{said}"
    );
}

/// The street's road and houses are flat: shape in its picture is a matter of few pixels, without which nothing is lost.
#[test]
fn a_command_that_hardly_shows_is_said_to() {
    let (json, _, said) = report("street.exr --scale 20 --budget 4");
    assert_eq!(json["command"], "relievo enhance");
    assert!(said.contains("this command hardly shows here"), "{said}");
    let verdict = &json["verdict"];
    assert!(number(&verdict["shows"]) < 0.02, "{verdict}");
}

#[test]
fn commands_of_all_kinds_and_recipes_are_reported_on() {
    let desk = Desk::new();
    let recipe = "version = 1\ncommand = \"relight\"\nlight = \"135,40\"\n";
    desk.write("look.toml", recipe);
    let recipe = format!("--recipe {}", desk.at("look.toml").display());
    for (flags, part) in [
        ("--for 'hatch --style pen'", "contours"),
        ("--for 'map --map curvature'", "silhouettes"),
        ("--for shape", "creases"),
        (&recipe, "warping"),
    ] {
        let (json, ..) = report(&format!("wheel.0001.exr {flags} --budget 2 -q"));
        row(&json["parts"], "name", part);
        assert!(number(&json["trust"]["rounds"]) >= 3.0, "{flags}");
        // What floats hold is shown as the picture was, exposure and all: only a PNG is rounded.
        for file in json["files"].as_array().unwrap() {
            let is_float = file["flags"].as_str().unwrap().ends_with("float");
            let largest = number(&file["error"]["largest"]);
            assert!(!is_float || largest < 0.01, "{file}");
        }
    }
}

#[test]
fn what_cannot_be_reported_on_is_refused() {
    let desk = Desk::new();
    desk.copy("fixtures/bust.exr", "report.json");
    let rows = "
        => 2: <IN>
        fixtures/bust.exr --for 'sharpen --scale 2' => 2: --for begins with sharpen; begin it with one of shape, enhance
        fixtures/bust.exr --for 'enhance --scale \"2' => 2: a quote that does not end
        fixtures/bust.exr --for 'enhance --scale' => 2: --scale
        fixtures/bust.exr --recipe nowhere.toml => 1: nowhere.toml
        // No input becomes an output, and no file a directory.
        report.json -o . => 2: report.json
        fixtures/bust.exr -o report.json => 2: report.json
        // The flags of older releases are taken, with a note.
        fixtures/bust.exr --quick --budget 1 => 0: note:
    ";
    desk.check("report {}", rows);
}

#[test]
fn the_cases_end_as_declared() {
    let said = Desk::new().make("report --cases -q").stdout;
    let last = said.lines().last().unwrap();
    assert!(last.ends_with("all as declared"), "{said}");
    let count: usize = last.split(' ').next().unwrap().parse().unwrap();
    assert!((40..=60).contains(&count), "{last}");
}
