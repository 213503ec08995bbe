//! `relievo report`: its files, and bounds on their numbers.

use crate::common::exr::Part;
use crate::common::program::{Ran, fixture, run};
use relievo::frame::Plane;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

/// Rounding of single precision, relative to the largest slope.
const ROUNDING: f64 = 3e-6;

fn relievo(arguments: &[&str]) -> Ran {
    run(Path::new("."), arguments)
}

/// The guide's own report, the slowest of its commands: [`RUN`] makes it.
pub(crate) const OF_GUIDE: &str = "report fixtures/bust.exr -o report --quick --scale 20";

/// One run for all tests, [`OF_GUIDE`] but for its paths, into a directory that holds an older report and something else.
struct Run {
    place: tempfile::TempDir,
    ran: Ran,
    json: Value,
}

static RUN: LazyLock<Run> = LazyLock::new(|| {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("report.md"), "old").unwrap();
    fs::write(place.path().join("notes.txt"), "mine").unwrap();
    let (input, directory) = (fixture("bust.exr"), place.path().to_path_buf());
    let paths = [&input, &directory].map(|p| p.to_str().unwrap());
    let ran = relievo(&[
        "report", paths[0], "-o", paths[1], "--quick", "--scale", "20",
    ])
    .done();
    let json = fs::read_to_string(directory.join("report.json")).unwrap();
    Run {
        place,
        ran,
        json: serde_json::from_str(&json).unwrap(),
    }
});

impl Run {
    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.place.path().join(name)).unwrap()
    }

    /// Every scale of the frame and of every scene, with the scene's name.
    fn scales(&'static self) -> Vec<(String, &'static Value)> {
        let scenes = self.json["scenes"].as_array().unwrap();
        let all = std::iter::once(&self.json["frame"]).chain(scenes);
        all.flat_map(|scene| {
            let named =
                |scale: &'static Value| (format!("{} at {}", scene["name"], scale["scale"]), scale);
            scene["scales"].as_array().unwrap().iter().map(named)
        })
        .collect()
    }

    fn rows(&'static self) -> Vec<(String, &'static Value)> {
        let rows = |(name, scale): (String, &'static Value)| {
            let rows = scale["rows"].as_array().unwrap();
            rows.iter()
                .map(move |row| (format!("{name}, {}", row["setting"]), row))
        };
        self.scales().into_iter().flat_map(rows).collect()
    }
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn the_files_are_there_and_others_stay() {
    assert_eq!(RUN.read("notes.txt"), "mine");
    let page = RUN.read("report.md");
    assert!(page.starts_with("# relievo report: bust.exr\n"), "{page}");
    let plots = page
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .filter(|plot| plot.ends_with(".svg"));
    let mut count = 0;
    for plot in plots {
        let svg = RUN.read(plot);
        assert!(
            svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"),
            "{plot}"
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{plot}");
        count += 1;
    }
    // The frame on two pages, three scenes, directions, the rim, lights and equations, directions of strokes, strokes,
    // mirrors.
    assert_eq!(count, 12);
    // A star that does not mark bold differs from one that does.
    assert!(page.contains(" \\* |") && !page.contains("***"));
    // Every table has rows of as many cells as its head.
    let bars = |line: &str| line.replace("\\|", "").matches('|').count();
    let lines: Vec<_> = page.lines().collect();
    for pair in lines
        .windows(2)
        .filter(|pair| pair.iter().all(|line| line.starts_with('|')))
    {
        assert_eq!(bars(pair[0]), bars(pair[1]), "{pair:?}");
    }
}

/// The page of HTML is one file: it loads nothing, and holds all plots and the sheet.
#[test]
fn the_page_is_one_file() {
    let page = RUN.read("report.html");
    assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"));
    assert_eq!(page.matches("<svg").count(), 12);
    assert_eq!(page.matches("<img").count(), 1);
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 1);
    assert!(
        !page.contains("href=\"http"),
        "something is loaded from elsewhere"
    );
    let png = fs::read(RUN.place.path().join("sheet.png")).unwrap();
    // Three pictures of 480x360 side by side: width and height stand in bytes 16 to 24.
    let side = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    assert_eq!([side(16), side(20)], [3 * 480, 360]);
}

/// Without a directory the first page is printed, of this frame alone.
#[test]
fn the_first_page_is_two_screens() {
    let ran = relievo(&["report", fixture("bust.exr").to_str().unwrap()]).done();
    let lines: Vec<_> = ran.stdout.lines().collect();
    assert!(lines.len() < 80, "{}", lines.len());
    for heading in [
        "# relievo report: bust.exr",
        "## What is enough",
        "## What a picture of this frame's curvature does not need",
        "## Warnings",
        "## Where the time of all layers goes",
    ] {
        assert!(lines.contains(&heading), "{heading}");
    }
    // No row of the table of settings repeats one above it.
    let flags = lines.iter().filter_map(|line| line.split("| `--").nth(1));
    let flags: Vec<_> = flags.filter_map(|rest| rest.split('`').next()).collect();
    let mut distinct = flags.clone();
    distinct.dedup();
    assert!(!flags.is_empty() && flags == distinct, "{flags:?}");
    assert!(!ran.stderr.contains("mirror ball") && !ran.stderr.contains("extreme"));
}

/// What there is to warn of is said, with what helps: coarse normals, and light that is brighter than white.
#[test]
fn warnings_are_of_the_frame() {
    let warned = |words: &[&str]| {
        let ran = relievo(&[&["report", "-q"], words].concat()).done();
        let rest = ran.stdout.split("## Warnings").nth(1).unwrap().to_string();
        rest.split("## Where").next().unwrap().to_string()
    };
    let [photo, normals, haze] = ["tablet.color.jpg", "tablet.normal.png", "haze.exr"].map(fixture);
    let photo = warned(&[
        photo.to_str().unwrap(),
        "--normal",
        normals.to_str().unwrap(),
    ]);
    // Half a step of 8 bits over -1..1 is 1/255.
    assert!(
        photo.contains("8 bits: normals are rounded by 3.9e-3"),
        "{photo}"
    );
    let haze = warned(&[haze.to_str().unwrap()]);
    assert!(
        haze.contains("clipping: ") && haze.contains("brighter than white"),
        "{haze}"
    );
}

#[test]
fn the_summary_goes_to_stdout_and_progress_to_stderr() {
    let [stdout, stderr] = [&RUN.ran.stdout, &RUN.ran.stderr];
    assert!(
        stdout.starts_with("At sigma 20 px the settings asked for")
            && stdout.contains("report.html"),
        "{stdout}"
    );
    assert!(stdout.contains("all as declared"), "{stdout}");
    // The number of lights that suffices, and whether prefiltered maps are usable.
    assert!(
        stdout.contains("99 pixels in 100 are within 1/255 of white by")
            && stdout.contains("lights for plain diffuse light")
            && stdout.contains("a prefiltered map, unwarped, for diffuse light serves"),
        "{stdout}"
    );
    for sweep in [
        "samples of an environment",
        "equations of light warping",
        "prefiltered light",
        "elementary functions",
        "number of lights",
        "solvers and tolerances",
        "threads",
        "tiles and sweeps per pass",
        "half and byte",
        "ellipsoid: directions",
        "steps of the search",
        "refinements",
        "resolution of the map",
        "foreshortening",
        "extreme",
    ] {
        assert!(stderr.contains(sweep), "{stderr}");
    }
}

#[test]
fn every_error_is_within_what_was_allowed() {
    let mut expanded = 0;
    for (name, row) in RUN.rows() {
        let [gradient, trace] = [&row["gradient"], &row["trace"]];
        for errors in [gradient, trace] {
            assert_eq!(errors["non_finite"], 0, "{name}");
            let [mean, p99, max] = ["mean", "p99", "max"].map(|key| number(&errors[key]));
            assert!(mean <= max && p99 <= max, "{name}: {errors}");
            assert!(
                errors["worst"].is_array() && number(&errors["pixels"]) > 1000.0,
                "{name}"
            );
        }
        let max = number(&gradient["max"]);
        assert!(number(&row["overshoot"]) <= max + 1e-7, "{name}");
        match row["allowed"].as_f64() {
            Some(allowed) => {
                assert!(max <= allowed + ROUNDING, "{name}: {max} of {allowed}");
                expanded += 1;
            }
            // First-order steps: a few thousandths at the longest.
            None => assert!(max < 1e-2, "{name}: {max}"),
        }
    }
    assert!(expanded > 20, "only {expanded} expansions");
}

#[test]
fn finer_tolerances_and_shorter_steps_are_better() {
    for (name, scale) in RUN.scales() {
        for solver in ["explicit", "chebyshev"] {
            let rows = scale["rows"]
                .as_array()
                .unwrap()
                .iter()
                .filter(|row| row["solver"] == solver);
            let mut rows: Vec<_> = rows.collect();
            rows.sort_by_key(|row| row["applications"].as_u64());
            for pair in rows.windows(2) {
                let [before, after] = [pair[0], pair[1]].map(|row| number(&row["gradient"]["max"]));
                assert!(
                    after < before + ROUNDING,
                    "{name}, {solver}: {before} then {after}"
                );
            }
        }
    }
}

/// Whether each point, [time, error], is on the Pareto front: no other is as good in both, and better in one or earlier
/// in the list; an infinite error is never on it.
fn front(points: &[[f64; 2]]) -> Vec<bool> {
    let is_beaten = |i: usize| {
        points.iter().enumerate().any(|(j, other)| {
            let as_good = (0..2).all(|k| other[k] <= points[i][k]);
            i != j && as_good && (*other != points[i] || j < i)
        })
    };
    (0..points.len())
        .map(|i| points[i].iter().all(|v| v.is_finite()) && !is_beaten(i))
        .collect()
}

#[test]
fn the_front_is_what_nothing_beats() {
    for (name, scale) in RUN.scales() {
        let rows = scale["rows"].as_array().unwrap();
        let points: Vec<_> = rows
            .iter()
            .map(|row| {
                [
                    number(&row["diffusion"]["min"]),
                    number(&row["gradient"]["max"]),
                ]
            })
            .collect();
        let marked: Vec<_> = rows
            .iter()
            .map(|row| row["on_front"].as_bool().unwrap())
            .collect();
        assert_eq!(marked, front(&points), "{name}");
        assert!(marked.contains(&true), "{name}");
        let asked_for = rows.iter().filter(|row| row["asked_for"] == true).count();
        assert_eq!(asked_for, 1, "{name}");
    }
}

#[test]
fn the_closed_forms_are_met() {
    for (name, row) in RUN
        .rows()
        .into_iter()
        .filter(|(name, _)| name.contains("ball") || name.contains("waves"))
    {
        // Sobel's derivative of waves of 64 pixels has a relative error of k^2/4, 2.4e-3 for a trace of 0.067 at slopes
        // of 0.5: 3e-4 relative to the slope; first-order steps of 0.25 add as much.
        let errors = &row["against_closed_form"];
        if row["solver"] == "chebyshev" {
            assert!(number(&errors["max"]) < 8e-4, "{name}: {errors}");
        }
    }
}

#[test]
fn ways_of_running_change_no_bit() {
    let runs = RUN.json["runs"].as_array().unwrap();
    assert!(runs.iter().all(|run| run["same_bits"] == true), "{runs:?}");
    let of = |dimension: &str| {
        let rows = runs.iter().filter(|run| run["dimension"] == dimension);
        rows.collect::<Vec<_>>()
    };
    assert!(!of("threads").is_empty());
    let values = |dimension| {
        of(dimension)
            .iter()
            .map(|run| &run["value"])
            .collect::<Vec<_>>()
    };
    let tiles = values("tile");
    assert!(tiles[0].as_str().unwrap().ends_with(", default"));
    // The bust is 480 by 360: a tile of 512 would be all of it once more.
    assert_eq!(tiles[1..], ["64x64", "256x256", "480x360"]);
    assert_eq!(values("sweeps per pass"), ["64, default", "8", "16", "32"]);
    for run in [of("tile"), of("sweeps per pass")].concat() {
        assert_eq!(run["scale"], "sigma 20 px", "{run}");
    }
    let page = RUN.read("report.md");
    for row in ["| tile | 64x64 | sigma 20 px |", "| sweeps per pass | 8 |"] {
        assert!(page.contains(row), "{row}");
    }
}

#[test]
fn steps_turn_directions_as_they_should() {
    let sweep = &RUN.json["directions"];
    let rows = sweep["rows"].as_array().unwrap();
    // Three roundings, five steps and the automatic one.
    assert_eq!(rows.len(), 18);
    assert!(number(&sweep["pixels"]) > 5000.0, "{}", sweep["pixels"]);
    let p95 = |stored: &str, step: Option<u64>| {
        let mut rows = rows.iter();
        let row = rows.find(|row| row["stored"] == stored && row["step_px"].as_u64() == step);
        number(&row.unwrap()["p95"])
    };
    for row in rows {
        let [mean, p95, max] = ["mean", "p95", "max"].map(|key| number(&row[key]));
        assert!(
            0.0 < mean && mean < p95 && p95 < max && max <= 90.0,
            "{row}"
        );
        assert!(number(&row["stage"]["min"]) > 0.0, "{row}");
    }
    // From normals alone 95 % are within 1.1 degree on an ellipsoid of 32 px, to the second order of the
    // step over the size: 1.1 (32/108)^2 = 0.097 where its longest half axis is 0.45 of 240 px.
    let exact = p95("float", Some(1));
    assert!(exact < 0.1, "{exact}");
    // Twice the step is four times the error, to leading order: 3 to 5 up to 4 px.
    for step in [1, 2] {
        let ratio = p95("float", Some(2 * step)) / p95("float", Some(step));
        assert!((3.0..5.0).contains(&ratio), "{step}: {ratio}");
    }
    assert_eq!(p95("float", None), exact);
    let [auto, one] = [None, Some(1)].map(|step| p95("byte", step));
    assert!(auto <= one, "8 bits: {auto} of {one}");
    // Bytes are 16 times as far apart as half floats just below 1.
    assert!(one > p95("half", Some(1)) && p95("half", Some(1)) > exact);
    let page = RUN.read("report.md");
    assert!(
        page.contains("## Directions of the surface's curvature")
            && page.contains("| auto: 4 to 16 |")
    );
}

#[test]
fn half_floats_cost_less_than_bytes() {
    let rows = RUN.json["precision"].as_array().unwrap();
    let max = |frame: &str, stored: &str| {
        let row = rows
            .iter()
            .find(|row| row["frame"] == frame && row["stored"] == stored);
        number(&row.unwrap()["gradient"]["max"])
    };
    for frame in ["bust.exr", "ball"] {
        assert!(max(frame, "float") < ROUNDING, "{frame}");
        assert!(
            max(frame, "float") < max(frame, "half") && max(frame, "half") < max(frame, "byte")
        );
    }
}

/// Measurements of light on the frame.
fn light_on_frame() -> &'static Value {
    let subjects = RUN.json["light"]["subjects"].as_array().unwrap();
    assert_eq!(subjects.len(), 1, "a quick report lights the frame alone");
    &subjects[0]
}

/// Every series of samples by growing number: name, and number with the difference from the reference.
fn light_series() -> Vec<(String, Vec<(u64, &'static Value)>)> {
    let subject = light_on_frame();
    let series = |name: String, rows: &'static Value| {
        let rows = rows.as_array().unwrap().iter();
        let row = |row: &'static Value| (row["count"].as_u64().unwrap(), &row["difference"]);
        (name, rows.map(row).collect())
    };
    let mut all = Vec::new();
    for sweep in subject["samples"].as_array().unwrap() {
        let name = format!("{}, {}", sweep["surface"], sweep["method"]);
        all.push(series(name, &sweep["rows"]));
    }
    for sweep in subject["equations"].as_array().unwrap() {
        for equation in ["lookups", "lights"] {
            let name = format!("{} by {equation}", sweep["surface"]);
            all.push(series(name, &sweep[equation]));
        }
    }
    all
}

#[test]
fn more_samples_are_better() {
    let all = light_series();
    // Two surfaces, plain and warped; both by two equations.
    assert_eq!(all.len(), 8);
    for (name, series) in all {
        for (count, difference) in &series {
            let errors = &difference["errors"];
            assert_eq!(errors["non_finite"], 0, "{name}, {count}");
            let [mean, p99, max] = ["mean", "p99", "max"].map(|key| number(&errors[key]));
            assert!(mean <= max && p99 <= max, "{name}, {count}: {errors}");
            let [grey, most] = ["grey_p99", "grey_max"].map(|key| number(&difference[key]));
            assert!(grey <= most && most <= 255.0, "{name}, {count}");
        }
        // A few lights see nothing but where the light is; from 16 on four times as many are better, until
        // the reference's own error, some thousandths, is reached.
        let mean = |row: &(u64, &Value)| number(&row.1["errors"]["mean"]);
        let fourfold: Vec<_> = series
            .iter()
            .filter(|row| row.0 >= 16 && row.0 != 54)
            .collect();
        assert!(fourfold.len() >= 3, "{name}");
        for pair in fourfold.windows(2) {
            let [before, after] = [mean(pair[0]), mean(pair[1])];
            assert_eq!(pair[1].0, 4 * pair[0].0, "{name}");
            assert!(
                after < 0.7 * before || after < 1e-3,
                "{name}: {before} then {after}"
            );
        }
    }
}

#[test]
fn few_hundred_lights_are_enough_for_diffuse_light() {
    let subject = light_on_frame();
    for sweep in subject["samples"].as_array().unwrap() {
        // 16384 terms of single precision, each off by half of 6e-8 and of sums up to ten times white.
        assert!(number(&sweep["reference_rounding"]) < 5e-5, "{sweep}");
        let rows = sweep["rows"].as_array().unwrap();
        let p99 = |row: &Value| number(&row["difference"]["errors"]["p99"]);
        let points: Vec<_> = rows
            .iter()
            .map(|row| [number(&row["relight"]["min"]), p99(row)])
            .collect();
        let marked: Vec<_> = rows.iter().map(|row| row["on_front"] == true).collect();
        assert_eq!(marked, front(&points), "{}", sweep["surface"]);
        let first = rows.iter().find(|row| p99(row) < 1.0 / 255.0);
        assert_eq!(
            sweep["enough"],
            first.map_or(Value::Null, |row| row["count"].clone())
        );
        if sweep["surface"] == "lambert" {
            let enough = sweep["enough"].as_u64().expect("some number is enough");
            assert!((16..=1024).contains(&enough), "{enough}");
        }
    }
}

#[test]
fn prefiltered_diffuse_light_is_the_sum() {
    let rows = light_on_frame()["prefiltered"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let plain_diffuse = row["surface"] == "lambert" && row["method"] == "plain";
        let p99 = number(&row["difference"]["errors"]["p99"]);
        assert_eq!(row["serves"] == true, p99 < 1.0 / 255.0, "{row}");
        // Highlights are cut off at the horizon by the sum alone; a warp bends more than one look-up.
        assert!(row["serves"] == true || !plain_diffuse, "{row}");
        assert!(number(&row["prefilter"]["min"]) > 0.0 && number(&row["relight"]["min"]) > 0.0);
    }
}

#[test]
fn elementary_functions_are_within_what_they_promise() {
    let rows = RUN.json["light"]["functions"].as_array().unwrap();
    // The errors that their documentation states, in ulp.
    let promised = [("exp", 1.03), ("ln", 1.0), ("tanh", 2.5), ("atan", 1.93)];
    assert_eq!(rows.len(), promised.len());
    for (row, (name, ulp)) in rows.iter().zip(promised) {
        assert_eq!(row["name"], name);
        assert!(number(&row["fast"]["ulp"]) <= ulp, "{row}");
        for measured in [&row["fast"], &row["std"]] {
            assert!(number(&measured["relative"]) < 2e-7, "{row}");
            assert!(number(&measured["nanoseconds"]) > 0.0, "{row}");
        }
    }
}

#[test]
fn cost_by_lights_has_its_line() {
    let cost = &RUN.json["light"]["cost"];
    let rows = cost["rows"].as_array().unwrap();
    let counts: Vec<_> = rows
        .iter()
        .map(|row| row["lights"].as_u64().unwrap())
        .collect();
    assert_eq!(counts, [1, 4, 16, 64, 256, 1024]);
    let explained = number(&cost["line"]["told"]);
    assert!((0.0..=1.0).contains(&explained), "{explained}");
    let pixels: Vec<_> = cost["covered"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| number(&row["pixels"]))
        .collect();
    // A disc of a tenth of the frame, to a border of pixels.
    assert!((pixels[1] / pixels[0] - 0.1).abs() < 2e-3, "{pixels:?}");
}

#[test]
fn directions_of_strokes_come_nearer_to_the_full_field() {
    let fields = RUN.json["drawing"]["fields"].as_array().unwrap();
    let names: Vec<_> = fields.iter().map(|f| f["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["bust.exr", "ellipsoid", "ellipsoid, normals of 8 bits"]
    );
    for field in fields {
        let rows = field["rows"].as_array().unwrap();
        // 8, 4, 2 and 1 pixels of the picture to one of the field: the finer the nearer, and the last is it.
        let p95: Vec<_> = rows[..4]
            .iter()
            .map(|row| number(&row["from_full"]["p95"]))
            .collect();
        assert!(p95.windows(2).all(|w| w[1] < w[0]), "{field}: {p95:?}");
        assert_eq!(p95[3], 0.0);
        // More passes are calmer.
        let turn = |passes: u64| {
            let at = |row: &&Value| row["cell_px"] == 4 && row["passes"] == passes;
            number(&rows.iter().find(at).unwrap()["turn"])
        };
        assert!((1..=6).all(|passes| turn(passes) < turn(passes - 1)));
        let known = field["name"] != "bust.exr";
        assert!(
            rows.iter()
                .all(|row| row["from_exact"].is_object() == known)
        );
    }
}

#[test]
fn a_dozen_or_two_levels_break_the_fewest_strokes() {
    let rows = RUN.json["drawing"]["strokes"]["rows"].as_array().unwrap();
    for sets in [1, 2, 4] {
        let unbroken = |levels: u64| {
            let at = |row: &&Value| row["sets"] == sets && row["levels"] == levels;
            number(&rows.iter().find(at).unwrap()["unbroken"])
        };
        let best = [12, 16, 24].map(unbroken);
        // [LA] section 6.2 uses 12 to 24. Fewer turn in jumps, more cut strokes to pieces.
        for levels in [4, 72, 360] {
            let worse = unbroken(levels);
            assert!(
                best.iter().all(|b| worse < 0.6 * b),
                "{levels}: {worse}, {best:?}"
            );
        }
    }
}

#[test]
fn tones_are_drawn_within_two_hundredths() {
    let tones = RUN.json["drawing"]["tones"].as_array().unwrap();
    assert_eq!(tones.len(), 2 * 9);
    for row in tones {
        assert!(number(&row["worst"]) < 0.02, "{row}");
    }
    let page = RUN.read("report.md");
    for said in [
        "## Drawing",
        "### Tones",
        "strokes.svg",
        "stroke-directions.svg",
    ] {
        assert!(page.contains(said), "{said}");
    }
}

/// Measurements of mirrors by `steps`, `refinements` or `map_heights`.
fn mirror_rows(varied: &str) -> &'static [Value] {
    RUN.json["mirrors"][varied].as_array().unwrap()
}

/// Whether each value is at most `ratio` of the one before.
fn falls(values: &[f64], ratio: f64) -> bool {
    values.len() > 1 && values.windows(2).all(|pair| pair[1] <= ratio * pair[0])
}

#[test]
fn mirrors_are_found_by_steps_refinements_and_rows() {
    let of = |varied, number: fn(&Value) -> f64| -> Vec<f64> {
        mirror_rows(varied).iter().map(number).collect()
    };
    let astray = |row: &Value| 1.0 - number(&row["found"]) + number(&row["wrong_surface"]);
    // More of everything leads fewer sight lines astray.
    for varied in ["steps", "refinements", "map_heights"] {
        let astray = of(varied, astray);
        assert!(falls(&astray, 1.0), "{varied}: {astray:?}");
        assert!(astray.last() < Some(&0.02), "{varied}: {astray:?}");
    }
    // Steps of a quarter of the length pass by fewer columns.
    let missed = of("steps", |row| number(&row["columns_missed"]));
    for pair in missed.windows(3) {
        assert!(pair[2] < 0.6 * pair[0], "{missed:?}");
    }
    // Walls are planes: each refinement comes closer, down to the rounding of samples, 2^-24 of their size.
    let median = of("refinements", |row| number(&row["position"]["median"]));
    for pair in median.windows(2) {
        assert!(pair[1] <= (0.5 * pair[0]).max(6e-8), "{median:?}");
    }
    assert!(median[3] < 1e-7, "{median:?}");
    // Columns are round: planes of half the size are off by a quarter, once several meet a column.
    let columns = of("map_heights", |row| {
        number(&row["position_on_columns"]["median"])
    });
    assert!(
        falls(&columns[2..], 0.4) && columns[5] < 1e-4,
        "{columns:?}"
    );
    // So are the directions of their curvature, up to errors from the spacing of adjacent hits.
    let turned = of("map_heights", |row| {
        number(&row["direction_on_columns"]["median"])
    });
    assert!(falls(&turned[1..5], 0.5) && turned[5] < 0.05, "{turned:?}");
}

#[test]
fn mirrors_are_on_the_page() {
    for varied in ["steps", "refinements", "map_heights"] {
        let rows = mirror_rows(varied);
        let usual = rows.iter().filter(|row| {
            let setting = &row["setting"];
            let search = relievo::params::SearchParams::default();
            setting["search"]["steps"] == search.steps
                && setting["search"]["refinements"] == search.refinements
        });
        assert!(usual.count() >= 1, "{varied}");
        for row in rows {
            assert!(number(&row["stage"]["min"]) > 0.0, "{row}");
            for errors in ["position", "direction"] {
                let [median, p95] = ["median", "p95"].map(|key| number(&row[errors][key]));
                assert!(median <= p95, "{row}");
            }
        }
    }
    let page = RUN.read("report.md");
    let stdout = &RUN.ran.stdout;
    for said in [
        "## Mirrors and lenses",
        "mirrors.svg",
        "| rows of the map |",
    ] {
        assert!(page.contains(said), "{said}");
    }
    let advice = "In the report's mirror ball ";
    assert!(page.contains(advice) && stdout.contains(advice), "{stdout}");
}

#[test]
fn every_extreme_case_is_reported_as_declared() {
    let cases = RUN.json["stability"].as_array().unwrap();
    assert!(cases.len() >= 100);
    for case in cases {
        assert_eq!(case["as_expected"], true, "{case}");
        assert_eq!(case["verdict"]["outcome"], case["expected"], "{case}");
    }
}

#[test]
fn what_cannot_be_done_is_said_in_one_line() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("file");
    fs::write(&file, "not a directory").unwrap();
    let new = place.path().join("new");
    let bust = fixture("bust.exr");
    let [bust, file, new] = [&bust, &file, &new].map(|p| p.to_str().unwrap());
    for (arguments, code, reason) in [
        (vec!["report", bust, "-o", file], 2, "not a directory"),
        (vec!["report", "none.exr", "-o", new], 1, "none.exr"),
        (
            vec!["report", bust, "-o", new, "--tolerance", "0"],
            2,
            "--tolerance",
        ),
        (
            vec!["report", bust, "-o", new, "--scale", "2,5"],
            2,
            "several scales",
        ),
        (
            vec!["report", bust, "-o", new, "--importance", "Depth"],
            2,
            "--importance",
        ),
    ] {
        let line = relievo(&arguments).refused(code);
        assert!(line.contains(reason), "{line}");
    }
    assert!(
        !Path::new(new).exists(),
        "a refusal leaves a directory behind"
    );
    assert_eq!(fs::read_to_string(file).unwrap(), "not a directory");
}

/// A name that looks like markup, of Markdown or HTML, is a text on the page.
#[cfg(unix)]
#[test]
fn no_name_is_markup() {
    let place = tempfile::tempdir().unwrap();
    let name = "<img src=x onerror=alert(1)><script>alert(2)</script>".replace('/', "&sol;")
        + "[a](javascript:alert(3))![b](http:b)`c`|*d*&lt;\u{1b}";
    let plane = Plane::from_fn(24, 24, |x, y| (x + y) as f32 / 48.0);
    let up = Plane::filled(24, 24, 1.0);
    let flat = Plane::filled(24, 24, 0.0);
    let picture = ["R", "G", "B"].map(|channel| (channel, &plane));
    let normals = [("N.X", &flat), ("N.Y", &flat), ("N.Z", &up)];
    Part::of(picture.into_iter().chain(normals)).write(&place.path().join(&name));
    run(place.path(), ["report", &name, "-o", "report"]).done();
    let read = |file: &str| fs::read_to_string(place.path().join("report").join(file)).unwrap();
    let page = read("report.html");
    let shown = "&lt;img src=x onerror=alert(1)&gt;&lt;script&gt;alert(2)&lt;&amp;sol;script&gt;\
        [a](javascript:alert(3))![b](http:b)`c`|*d*&amp;lt;\\u001b";
    assert!(
        page.contains(&format!("<h1>relievo report: {shown}</h1>")),
        "{page}"
    );
    assert!(
        page.contains("content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:\"")
    );
    // Every tag is one that we write, without a handler.
    let known = [
        "!doctype", "html", "head", "meta", "title", "style", "body", "h1", "h2", "h3", "p",
        "table", "thead", "tbody", "tr", "th", "td", "ul", "li", "code", "strong", "em", "figure",
        "img", "svg", "rect", "text", "line", "circle", "polyline", "polygon", "path",
    ];
    for tag in page.split('<').skip(1) {
        let tag = tag.split('>').next().unwrap();
        let kind = tag
            .trim_start_matches('/')
            .split([' ', '/', '\n'])
            .next()
            .unwrap();
        assert!(known.contains(&kind) && !tag.contains(" on"), "<{tag}>");
        assert!(kind != "img" || tag.contains("src=\"data:"), "<{tag}>");
    }
    let text = read("report.md");
    assert!(!text.contains("<img") && !text.contains("<script") && !text.contains("[a]"));
    let json: Value = serde_json::from_str(&read("report.json")).unwrap();
    assert_eq!(json["frame"]["name"].as_str(), Some(&*name));
}
