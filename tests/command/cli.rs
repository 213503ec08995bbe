//! The real binary on the fixtures: its files, its messages, and its refusals.

use crate::common::bits;
use crate::common::exr::Part;
use crate::common::exr::full;
use crate::common::program::{self, Ran, fixture, run};
use relievo::frame::{Plane, Window};
use relievo::io::exr::{ChannelId, ExrFile, Limits};
use relievo::io::inputs::Inputs;
use relievo::io::photo::Photo;
use relievo::scenes::{ExactScene, Surface};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// The layers that `shape` writes, by their short names.
const CONTRACT: [&str; 20] = [
    "normal.x",
    "normal.y",
    "normal.z",
    "weights.confidence",
    "weights.silhouette",
    "weights.crease",
    "weights.conductance",
    "gradient.x",
    "gradient.y",
    "hessian.xx",
    "hessian.xy",
    "hessian.yy",
    "curvature.u",
    "curvature.v",
    "curvature.mean",
    "curvature.kappa",
    "direction.x",
    "direction.y",
    "direction_view.x",
    "direction_view.y",
];

fn relievo<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Ran {
    run(Path::new("."), arguments)
}

/// A directory of one test, and runs that write into it.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Names of all files here, to check that temporary ones are never left behind.
    fn names(&self) -> Vec<String> {
        program::names(self.0.path(), "")
    }

    /// Runs `verb input -o output` with additional `flags`.
    fn run(&self, verb: &str, input: &Path, output: &str, flags: &[&str]) -> Ran {
        let output = self.path(output);
        let head = [
            OsStr::new(verb),
            input.as_os_str(),
            OsStr::new("-o"),
            output.as_os_str(),
        ];
        relievo(head.into_iter().chain(flags.iter().map(OsStr::new)))
    }

    /// Runs it, expects it to be done, and gives back where the output is.
    #[track_caller]
    fn make(&self, verb: &str, input: &Path, output: &str, flags: &[&str]) -> PathBuf {
        self.run(verb, input, output, flags).done();
        self.path(output)
    }

    fn write_exr(&self, name: &str, channels: &[(&str, &Plane)]) -> PathBuf {
        let path = self.path(name);
        Part::of(channels.iter().copied()).write(&path);
        path
    }
}

fn open(path: &Path) -> ExrFile {
    ExrFile::open(path, &Limits::default()).unwrap()
}

fn plane(file: &ExrFile, part: usize, name: &str) -> Plane {
    let channels = &file.parts[part].channels;
    let channel = channels
        .iter()
        .position(|c| c.name == name || c.name == full(name))
        .unwrap_or_else(|| panic!("no {name} in part {part}"));
    let ids = [ChannelId { part, channel }];
    file.read_channels(&ids).unwrap().remove(0)
}

fn names(file: &ExrFile, part: usize) -> Vec<&str> {
    let channels = file.parts[part].channels.iter();
    channels.map(|c| c.name.as_str()).collect()
}

fn photo(path: &Path) -> Photo {
    Photo::read(path).unwrap()
}

/// The largest difference of two pictures, in codes of 8 bits, and the share of samples that differ.
fn difference(a: &Path, b: &Path) -> (f32, f64) {
    let (a, b) = (photo(a), photo(b));
    assert_eq!((a.width, a.height), (b.width, b.height));
    assert_eq!(a.channels.len(), b.channels.len());
    let samples = |photo: &Photo| -> Vec<f32> {
        let planes = photo.channels.iter().flat_map(|p| p.samples());
        planes.copied().collect()
    };
    let (a, b) = (samples(&a), samples(&b));
    let apart: Vec<f32> = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).collect();
    let differ = apart.iter().filter(|&&d| d > 0.0).count();
    let most = apart.iter().copied().fold(0.0, f32::max);
    (most * 255.0, differ as f64 / apart.len() as f64)
}

fn tablet(desk: &Desk, normal: &Path, output: &str, flags: &[&str]) -> PathBuf {
    let normal = ["--normal", normal.to_str().unwrap()];
    let flags = [&normal[..], flags].concat();
    desk.make("enhance", &fixture("tablet.color.jpg"), output, &flags)
}

// Output files.

#[test]
fn every_kind_of_picture_is_written_and_shows_more_shape() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    let extensions = ["png", "jpg", "jpeg", "tif", "tiff", "hdr", "EXR"];
    for extension in extensions {
        let enhanced = desk.make("enhance", &gears, &format!("on.{extension}"), &[]);
        let plain = format!("off.{extension}");
        let plain = desk.make("enhance", &gears, &plain, &["--scaling", "0"]);
        assert_ne!(
            fs::read(&enhanced).unwrap(),
            fs::read(&plain).unwrap(),
            "{extension} shows no more shape"
        );
        if extension == "EXR" {
            assert_eq!(open(&enhanced).parts[1].window, Window::from_size(320, 240));
        } else {
            let read = photo(&enhanced);
            assert_eq!((read.width, read.height), (320, 240), "{extension}");
            assert_eq!(read.channels.len(), 3, "{extension}");
            let bits = if extension == "hdr" { 32 } else { 8 };
            assert_eq!(read.bits, bits, "{extension}");
        }
    }
    assert_eq!(desk.names().len(), 2 * extensions.len());
}

#[test]
fn the_kind_of_file_follows_its_extension() {
    let desk = Desk::new();
    let starts: [(&str, &[u8]); 5] = [
        ("a.png", b"\x89PNG"),
        ("a.jpg", b"\xff\xd8\xff"),
        ("a.tif", b"II*\0"),
        ("a.hdr", b"#?RADIANCE"),
        ("a.exr", b"\x76\x2f\x31\x01"),
    ];
    for (name, start) in starts {
        let bytes = fs::read(desk.make("shape", &fixture("gears.exr"), name, &[])).unwrap();
        assert!(bytes.starts_with(start), "{name}");
    }
}

#[test]
fn shape_appends_the_contracts_layers_and_keeps_the_rest() {
    let desk = Desk::new();
    for fixture_name in ["bust.exr", "gears.exr"] {
        let input = open(&fixture(fixture_name));
        let output = open(&desk.make("shape", &fixture(fixture_name), fixture_name, &[]));

        assert_eq!(output.parts.len(), 2);
        let mut contract = CONTRACT.map(full);
        contract.sort_unstable();
        assert_eq!(output.parts[1].name.as_deref(), Some("relievo"));
        assert_eq!(names(&output, 1), contract);
        let flags = ["--layer-names", "short", "--layers", "results"];
        let short = open(&desk.make("shape", &fixture(fixture_name), "short.exr", &flags));
        let mut contract = CONTRACT;
        contract.sort_unstable();
        assert_eq!(names(&short, 0), contract);
        assert_eq!(output.parts[1].window, input.parts[0].window);
        assert_eq!(output.display_window, input.display_window);

        assert_eq!(output.parts[0].compression, input.parts[0].compression);
        assert_eq!(output.parts[0].channels, input.parts[0].channels);
        for name in names(&input, 0) {
            let kept = bits(&plane(&output, 0, name)) == bits(&plane(&input, 0, name));
            assert!(kept, "{fixture_name}: {name} changed");
        }
        for (name, text) in &input.attributes {
            if !["name", "type", "chunkCount"].contains(&name.as_str()) {
                assert_eq!(output.attributes.get(name), Some(text), "{name}");
            }
        }
        // The input's compressed blocks are copied unchanged: its last bytes are in the output.
        let (old, new) = (
            fs::read(fixture(fixture_name)).unwrap(),
            fs::read(desk.path(fixture_name)).unwrap(),
        );
        let block = &old[old.len() - 2000..];
        assert!(new.windows(block.len()).any(|bytes| bytes == block));
    }
}

#[test]
fn results_alone_hold_the_same_layers() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    let float = ["--depth-of-output", "float"];
    let beside = open(&desk.make("shape", &gears, "beside.exr", &float));
    let flags = [&float[..], &["--layers", "results"]].concat();
    let alone = open(&desk.make("shape", &gears, "alone.exr", &flags));
    assert_eq!(alone.parts.len(), 1);
    assert_eq!(alone.parts[0].channels.len(), CONTRACT.len());
    for name in CONTRACT {
        assert!(
            bits(&plane(&alone, 0, name)) == bits(&plane(&beside, 1, name)),
            "{name}"
        );
    }
    let half = open(&desk.make("shape", &gears, "half.exr", &["--layers", "results"]));
    let rounded = plane(&beside, 1, "curvature.kappa").map(|v| half::f16::from_f32(v).to_f32());
    assert_eq!(bits(&plane(&half, 0, "curvature.kappa")), bits(&rounded));

    let flags = ["--layers", "results", "--compression", "auto"];
    let picture = open(&desk.make("enhance", &gears, "picture.exr", &flags));
    assert_eq!(names(&picture, 0), ["A", "B", "G", "R"]);
    assert_eq!(picture.parts[0].compression, "zip");
}

#[test]
fn of_the_results_those_are_written_that_are_picked() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    let all = open(&desk.make("shape", &gears, "all.exr", &["--layers", "results"]));
    let picks = ["--layers", "results", "--write", "kappa,normal,weights.c*"];
    let picked = open(&desk.make("shape", &gears, "picked.exr", &picks));
    let expected = [
        "curvature.kappa",
        "normal.x",
        "normal.y",
        "normal.z",
        "weights.conductance",
        "weights.confidence",
        "weights.crease",
    ];
    assert_eq!(names(&picked, 0), expected.map(full));
    let named = [
        "--layers",
        "results",
        "--write",
        "CurvatureK*,relievo.Normal.x",
    ];
    let named = open(&desk.make("shape", &gears, "named.exr", &named));
    assert_eq!(names(&named, 0), ["curvature.kappa", "normal.x"].map(full));
    for name in expected {
        assert!(
            bits(&plane(&picked, 0, name)) == bits(&plane(&all, 0, name)),
            "{name}"
        );
    }
    let misspelt = ["--write", "curvature.kapa"];
    let line = desk.run("shape", &gears, "none.exr", &misspelt).refused(2);
    assert!(line.contains("did you mean curvature.kappa?"), "{line}");
    let line = desk
        .run("shape", &gears, "none.png", &["--write", "kappa"])
        .refused(2);
    assert!(
        line.contains("--write is of EXR, NPY and TIFF alone"),
        "{line}"
    );
}

#[test]
fn several_scales_are_layers_named_after_them() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    let flags = |scale| {
        [
            "--layers",
            "results",
            "--curvature-gain",
            "20",
            "--scale",
            scale,
        ]
    };
    let both = open(&desk.make("shape", &gears, "both.exr", &flags("2,5.5")));
    let one = open(&desk.make("shape", &gears, "one.exr", &flags("5.5")));
    for component in ["u", "v", "mean", "kappa"] {
        let further = plane(&both, 0, &format!("curvature_5_5px.{component}"));
        let alone = plane(&one, 0, &format!("curvature.{component}"));
        assert_eq!(further.samples(), alone.samples(), "{component}");
    }
    assert_eq!(both.parts[0].channels.len(), CONTRACT.len() + 4);
    for (verb, scales) in [
        ("hatch", "2,5"),
        ("shape", "2,5"),
        ("enhance", "2,5,9,15,25"),
    ] {
        let line = desk
            .run(verb, &gears, "a.png", &["--scale", scales])
            .refused(2);
        assert!(line.contains("several scales"), "{line}");
    }
}

/// Both scales of a picture are one, and so is what is said of it and written.
#[test]
fn two_scales_of_a_picture_are_mixed() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    let said = desk.run("enhance", &gears, "a.png", &["--scale", "2,8", "--explain"]);
    let said = said.done().stdout.clone();
    assert!(said.contains("scale 2.00 and 8.00 px"), "{said}");
    for verb in ["enhance", "relight"] {
        let picture = |name, scales: &[&str]| {
            let path = desk.make(verb, &gears, name, scales);
            // Beside its settings, which tell the scales as they were given.
            image::open(path).unwrap().into_rgb8()
        };
        let mixed = picture("mixed.png", &["--scale", "2,8"]);
        for scale in ["2", "8"] {
            assert!(
                mixed != picture("one.png", &["--scale", scale]),
                "{verb} {scale}"
            );
        }
        assert!(
            mixed == picture("turned.png", &["--scale", "8,2"]),
            "{verb}"
        );
    }
    for (flags, reason) in [
        (["--scale", "2,-8"], "--scale is -8"),
        (["--scale", "2,nan"], "NaN"),
        (["--scale", "2,5000"], "--scale is 5000"),
    ] {
        let line = desk.run("enhance", &gears, "a.png", &flags).refused(2);
        assert!(line.contains(reason), "{line}");
    }
    let stepped = ["--scale", "2,8", "--solver", "explicit"];
    let line = desk.run("enhance", &gears, "a.png", &stepped).refused(2);
    assert!(line.contains("explicit steps"), "{line}");
}

#[test]
#[cfg(not(feature = "gpu"))]
fn a_gpu_is_refused_where_the_program_has_none() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    let line = desk.run("enhance", &gears, "a.exr", &["--backend", "gpu"]);
    assert!(line.refused(1).contains("--features gpu"));
    // An unrequested GPU is not missed.
    let ran = desk.run("enhance", &gears, "a.exr", &["--backend", "auto"]);
    assert!(!ran.done().stderr.contains("GPU"));
}

#[test]
fn importance_keeps_detail_where_it_is_low() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    let fine = open(&desk.make("shape", &gears, "fine.exr", &["--iterations", "0"]));
    let window = fine.parts[0].window;
    let share = |x, _| if x < window.width() / 2 { 0.0 } else { 1.0 };
    let map = Plane::from_fn(window.width(), window.height(), share);
    let map = desk.write_exr("map.exr", &[("importance.Y", &map)]);
    let smooth = ["--iterations", "80"];
    let coarse = open(&desk.make("shape", &gears, "coarse.exr", &smooth));
    let flags = [&smooth[..], &["--importance", map.to_str().unwrap()]].concat();
    let found = open(&desk.make("shape", &gears, "found.exr", &flags));
    let slope = |file| plane(file, 1, "gradient.x");
    let (fine, coarse, found) = (slope(&fine), slope(&coarse), slope(&found));
    for y in 0..window.height() {
        let half = window.width() / 2;
        assert_eq!(found.row(y)[..half], fine.row(y)[..half]);
        let rest = found.row(y)[half..].iter().zip(&coarse.row(y)[half..]);
        // Both are expansions within the tolerance.
        assert!(rest.fold(0.0_f32, |m, (a, b)| m.max((a - b).abs())) < 2e-4);
    }
    let unlike = Plane::filled(8, 8, 1.0);
    let unlike = desk.write_exr("unlike.exr", &[("importance.Y", &unlike)]);
    let flags = ["--importance", unlike.to_str().unwrap()];
    let line = desk.run("shape", &gears, "a.png", &flags).refused(1);
    assert!(
        line.contains("unlike.exr") && line.contains("8x8"),
        "{line}"
    );
}

#[test]
fn the_layers_keep_to_their_ranges() {
    let desk = Desk::new();
    let bust = fixture("bust.exr");
    let flags = ["--layers", "results", "--depth-of-output", "float"];
    let file = open(&desk.make("shape", &bust, "shape.exr", &flags));
    let covered = mask_of(&bust);
    let count = covered.iter().filter(|&&c| c).count();
    assert!(count > 10_000 && count < covered.len() / 2);
    let layer = |name: &str| plane(&file, 0, name);
    for name in CONTRACT {
        let plane = layer(name);
        assert!(plane.samples().iter().all(|v| v.is_finite()), "{name}");
        let used = plane.samples().iter().any(|&v| v != plane.at(0, 0));
        // The frame is sharp.
        let same = name == "weights.confidence" && plane.at(0, 0) == 1.0;
        assert!(used != same, "{name} is the same everywhere");
    }
    for name in CONTRACT.iter().filter(|name| name.starts_with("weights.")) {
        let plane = layer(name);
        assert!(plane.samples().iter().all(|v| (0.0..=1.0).contains(v)));
    }
    let kappa = layer("curvature.kappa");
    assert!(kappa.samples().iter().all(|v| (-1.0..=1.0).contains(v)));
    for (name, dimension) in [("normal", 3), ("direction", 2), ("direction_view", 2)] {
        let components: Vec<Plane> = ["x", "y", "z"][..dimension]
            .iter()
            .map(|c| layer(&format!("{name}.{c}")))
            .collect();
        let mut units = 0;
        for (i, &covered) in covered.iter().enumerate() {
            let square: f32 = components.iter().map(|c| c.samples()[i].powi(2)).sum();
            let is_unit = (square - 1.0).abs() < 1e-4;
            units += usize::from(is_unit);
            assert!(is_unit || square == 0.0, "{name} at {i}: {square}");
            assert!(covered || square == 0.0, "{name} outside the mask at {i}");
            assert!(
                name == "direction_view" || is_unit == covered,
                "{name} at {i}"
            );
        }
        assert!(2 * units > count, "{name}: {units} of {count}");
    }
    let (u, v) = (layer("curvature.u"), layer("curvature.v"));
    assert!(u.samples().iter().zip(v.samples()).all(|(u, v)| u >= v));
}

fn mask_of(path: &Path) -> Vec<bool> {
    let inputs = Inputs {
        picture: path.to_path_buf(),
        ..Inputs::default()
    };
    let loaded = relievo::io::load(
        &inputs,
        relievo::io::Needs {
            color: false,
            projection: true,
            ..relievo::io::Needs::default()
        },
    )
    .unwrap();
    loaded.frame.mask.plane().samples().to_vec()
}

#[test]
fn the_background_keeps_its_bits() {
    let desk = Desk::new();
    for name in ["bust.exr", "gears.exr"] {
        let input = fixture(name);
        let covered = mask_of(&input);
        assert!(covered.contains(&false), "{name} has no background");
        for (scaling, all) in [("3", false), ("0", true)] {
            let output = desk.make("enhance", &input, name, &["--scaling", scaling]);
            let (input, output) = (open(&input), open(&output));
            for component in ["R", "G", "B", "A"] {
                let ours = bits(&plane(&output, 1, &format!("relievo.{component}")));
                let theirs = bits(&plane(
                    &input,
                    0,
                    &format!("ViewLayer.Combined.{component}"),
                ));
                let mut pixels = ours.iter().zip(&theirs).zip(&covered);
                if all || component == "A" {
                    assert!(ours == theirs, "{name}, {component}, --scaling {scaling}");
                } else {
                    let changed = pixels.clone().filter(|((a, b), _)| a != b).count();
                    assert!(changed > 1000, "{name}: only {changed} samples changed");
                    let kept = pixels.all(|((ours, theirs), &covered)| covered || ours == theirs);
                    assert!(kept, "{name}: {component} changed outside the mask");
                }
            }
        }
    }
}

#[test]
fn a_picture_that_is_not_scaled_keeps_every_code() {
    let desk = Desk::new();
    // Every code of 8 bits, and codes of 16 bits from end to end.
    let (width, height) = (48, 40);
    let code = |x: u32, y: u32, c: u32| (x + width * y) * 7 + 85 * c;
    let rgb8 = image::RgbImage::from_fn(width, height, |x, y| {
        image::Rgb([0, 1, 2].map(|c| (code(x, y, c) % 256) as u8))
    });
    let rgb16 = image::ImageBuffer::from_fn(width, height, |x, y| {
        image::Rgb([0, 1, 2].map(|c| (code(x, y, c) * 4099 % 65536) as u16))
    });
    let rgba8 = image::RgbaImage::from_fn(width, height, |x, y| {
        let [r, g, b] = [0, 1, 2].map(|c| (code(x, y, c) % 256) as u8);
        image::Rgba([r, g, b, (64 + (5 * x + 3 * y) % 192) as u8])
    });
    let rgba16 = image::ImageBuffer::from_fn(width, height, |x, y| {
        let [r, g, b] = [0, 1, 2].map(|c| (code(x, y, c) * 4099 % 65536) as u16);
        image::Rgba([r, g, b, (20_000 + (997 * x + 331 * y) % 45_000) as u16])
    });
    let normal = image::RgbImage::from_fn(width, height, |x, y| {
        image::Rgb([100 + x as u8, 110 + y as u8, 250])
    });
    normal.save(desk.path("normal.png")).unwrap();
    rgb8.save(desk.path("rgb8.png")).unwrap();
    image::DynamicImage::ImageRgb16(rgb16)
        .save(desk.path("rgb16.png"))
        .unwrap();
    rgba8.save(desk.path("rgba8.png")).unwrap();
    image::DynamicImage::ImageRgba16(rgba16)
        .save(desk.path("rgba16.png"))
        .unwrap();
    let normal = desk.path("normal.png");
    for name in ["rgb8", "rgb16", "rgba8", "rgba16"] {
        let input = desk.path(&format!("{name}.png"));
        for extension in ["png", "tif"] {
            let output = format!("{name}.out.{extension}");
            let flags = ["--normal", normal.to_str().unwrap(), "--scaling", "0"];
            let output = desk.make("enhance", &input, &output, &flags);
            assert!(photo(&output) == photo(&input), "{name} to {extension}");
        }
    }
}

#[test]
fn threads_change_no_byte() {
    let desk = Desk::new();
    for (verb, name) in [("enhance", "a.exr"), ("shape", "b.exr"), ("shape", "c.png")] {
        let bytes = ["1", "8"].map(|threads| {
            let flags = ["--threads", threads];
            fs::read(desk.make(verb, &fixture("bust.exr"), name, &flags)).unwrap()
        });
        assert!(bytes[0] == bytes[1], "{verb} {name}");
    }
}

// Messages.

#[test]
fn inspect_tells_roles_camera_and_space() {
    let cases = [("bust.exr", "perspective"), ("gears.exr", "orthographic")];
    for (name, projection) in cases {
        let path = fixture(name);
        let ran = relievo([OsStr::new("inspect"), path.as_os_str()]).done();
        assert_eq!(ran.stderr, "");
        let line_of = |start: &str| {
            let found = |line: &&str| line.trim_start().starts_with(start);
            let line = ran.stdout.lines().find(found);
            line.unwrap_or_else(|| panic!("no {start} in {}", ran.stdout))
        };
        for (role, layer) in [
            ("color ", "ViewLayer.Combined.R"),
            ("normal ", "ViewLayer.Normal.X"),
            ("depth ", "ViewLayer.Depth.Z"),
            ("position ", "ViewLayer.Position.X"),
        ] {
            assert!(line_of(role).contains(layer), "{}", line_of(role));
        }
        assert!(line_of("camera ").contains(projection));
        assert!(line_of("normal space").contains("world"));
    }
}

#[test]
fn inspect_json_is_an_array_of_files() {
    let (bust, tablet) = (fixture("bust.exr"), fixture("tablet.color.jpg"));
    let args = [
        OsStr::new("inspect"),
        OsStr::new("--json"),
        bust.as_os_str(),
        tablet.as_os_str(),
    ];
    let ran = relievo(args).done();
    let json: Value = serde_json::from_str(&ran.stdout).unwrap();
    let files = json.as_array().unwrap();
    assert_eq!(files.len(), 2);

    let roles = files[0]["roles"].as_array().unwrap();
    let found: Vec<_> = roles
        .iter()
        .map(|r| (r["role"].as_str().unwrap(), r["layer"].as_str().unwrap()))
        .collect();
    let expected = [
        ("color", "ViewLayer.Combined"),
        ("normal", "ViewLayer.Normal"),
        ("depth", "ViewLayer.Depth"),
        ("position", "ViewLayer.Position"),
    ];
    assert_eq!(found, expected);
    let conclusion = |subject: &str| {
        let findings = files[0]["findings"].as_array().unwrap();
        let finding = findings.iter().find(|f| f["subject"] == subject);
        finding.unwrap()["conclusion"].as_str().unwrap()
    };
    assert_eq!(conclusion("normal space"), "world");
    assert!(conclusion("camera").starts_with("perspective, focal 880.0 px"));
    assert_eq!(files[0]["problem"], Value::Null);

    // A photo alone has no normals: a problem that is reported, not an error.
    assert!(files[1]["problem"].as_str().unwrap().contains("--normal"));
    assert_eq!(files[1]["display_window"]["x1"], 256);
}

#[test]
fn explain_tells_why_each_stage_runs_or_not() {
    let desk = Desk::new();
    let explained = |verb: &str, input: &Path, output: &str, flags: &[&str]| {
        let flags = [flags, &["--explain"]].concat();
        desk.run(verb, input, output, &flags).done().stdout
    };
    let verdict = |text: &str, stage: &str| {
        let mut lines = text.lines().map(|l| l.split_whitespace());
        let line = lines.find(|l| l.clone().nth(1) == Some(stage));
        let mut line = line.unwrap_or_else(|| panic!("no {stage} in {text}"));
        let verdict = line.next().unwrap().to_string();
        assert!(line.count() > 1, "{stage} has no reason");
        verdict
    };
    let gears = fixture("gears.exr");
    let usual = explained("enhance", &gears, "a.png", &[]);
    assert_eq!(verdict(&usual, "diffusion"), "ran");
    assert!(usual.contains("depth-silhouettes: gaps"), "{usual}");
    assert!(!usual.lines().any(|line| line.starts_with('-')), "{usual}");
    let usual = explained("enhance", &gears, "a.png", &["-v"]);
    assert_eq!(verdict(&usual, "directions"), "-");
    assert_eq!(verdict(&usual, "normal-rays"), "-");
    let fine = explained("enhance", &gears, "b.png", &["--iterations", "0", "-v"]);
    assert_eq!(verdict(&fine, "diffusion"), "-");
    let layers = explained("shape", &gears, "c.exr", &["-v"]);
    assert_eq!(verdict(&layers, "curvature"), "ran");
    assert!(layers.contains("directions: asked for"), "{layers}");
    assert_eq!(verdict(&layers, "normal-rays"), "ran");
    assert_eq!(verdict(&layers, "radiance-scaling"), "-");
    let referred = explained("shape", &gears, "f.png", &["--reference-height", "120"]);
    // 240 lines: ten steps of 0.2 have a sigma of 2, and 4 where two pixels count as one.
    for text in ["scale 4.00 px (2.00 px at a height of 120)", "times 2"] {
        assert!(referred.contains(text), "no {text} in {referred}");
    }
    let idle = explained("enhance", &gears, "d.png", &["--scaling", "0", "-v"]);
    let ran = idle.lines().filter_map(|line| line.strip_prefix("ran   "));
    let ran: Vec<_> = ran.filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(ran, ["read", "write"], "{idle}");
    // Two stops darker nothing is near white, two stops brighter some is. Pixels in focus show one surface each.
    let has_nothing = |input: &str, flags: &[&str], stage: &str| {
        let said = explained("enhance", &fixture(input), "g.png", flags);
        said.lines()
            .any(|line| line.starts_with("idle") && line.contains(stage))
    };
    assert!(has_nothing(
        "gears.exr",
        &["--exposure", "-2"],
        "highlights"
    ));
    assert!(!has_nothing(
        "gears.exr",
        &["--exposure", "2"],
        "highlights"
    ));
    assert!(has_nothing("gears.exr", &[], "fade"));
    assert!(!has_nothing("blur.exr", &[], "fade"));
    let normal = fixture("tablet.normal.png");
    let flags = ["--normal", normal.to_str().unwrap(), "-v"];
    let photo = explained("enhance", &fixture("tablet.color.jpg"), "e.png", &flags);
    assert_eq!(verdict(&photo, "depth-silhouettes"), "-");
    assert!(photo.contains("border-silhouettes: "), "{photo}");
}

#[test]
fn timings_hold_every_stage_that_ran() {
    let desk = Desk::new();
    let json = |verb: &str, output: &str, flags: &[&str]| -> Value {
        let path = desk.path("timings.json");
        let timings = ["--timings", path.to_str().unwrap(), "--threads", "3"];
        let flags = [&timings[..], flags].concat();
        desk.make(verb, &fixture("gears.exr"), output, &flags);
        serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
    };
    let stages = |json: &Value| -> Vec<String> {
        let stages = json["stages"].as_array().unwrap();
        for stage in stages {
            assert!(stage["seconds"].as_f64().unwrap() >= 0.0);
        }
        let name = |s: &Value| s["stage"].as_str().unwrap().to_string();
        stages.iter().map(name).collect()
    };
    let usual = json("enhance", "a.png", &[]);
    assert_eq!(
        (&usual["width"], &usual["height"]),
        (&320.into(), &240.into())
    );
    assert_eq!(usual["threads"], 3);
    let covered = usual["covered_pixels"].as_u64().unwrap();
    assert!(covered > 0 && covered < 320 * 240);
    assert!(usual["total_seconds"].as_f64().unwrap() > 0.0);
    let usual = stages(&usual);
    assert_eq!(usual.first().unwrap(), "read");
    assert_eq!(usual.last().unwrap(), "write");
    // They are read where the file holds them.
    assert!(!usual.contains(&"normals".into()), "{usual:?}");
    let of_depth = stages(&json("enhance", "d.png", &["--height", "ViewLayer.Depth"]));
    assert_eq!(of_depth[..2], ["read", "normals"]);
    assert!(usual.iter().any(|s| s == "diffusion"), "{usual:?}");
    let fine = stages(&json("enhance", "b.png", &["--iterations", "0"]));
    assert!(!fine.iter().any(|s| s == "diffusion"), "{fine:?}");
    let idle = stages(&json("enhance", "c.png", &["--scaling", "0"]));
    assert_eq!(idle, ["read", "write"]);
}

#[test]
fn quiet_says_nothing_and_verbose_says_what_was_concluded() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    // A magnitude that is warned about.
    let flags = ["--scaling", "9", "-q"];
    let quiet = desk.run("enhance", &gears, "a.png", &flags).done();
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    let usual = desk.run("enhance", &gears, "b.png", &flags[..2]).done();
    assert_eq!(usual.stdout, "");
    assert!(usual.stderr.contains("warning: --scaling 9"));
    assert!(usual.stderr.contains("curvature gain"));
    let verbose = desk.run("enhance", &gears, "c.png", &["-v"]).done();
    assert!(verbose.stderr.contains("orthographic"));
    // Errors are printed even so.
    desk.run("enhance", Path::new("none.exr"), "d.png", &["-q"])
        .refused(1);
}

#[test]
fn help_and_version_are_results() {
    for args in [
        &["--help"][..],
        &["enhance", "--help"],
        &["enhance", "--help-all"],
        &["--help-all"],
        &["--version"],
    ] {
        let ran = relievo(args).done();
        assert_eq!(ran.stderr, "", "{args:?}");
        assert!(ran.stdout.contains("relievo"), "{args:?}");
    }
    // Help is what fits a screen or two; all of it is longer.
    for command in ["shape", "enhance", "relight", "hatch", "map"] {
        let [short, all] = ["-h", "--help-all"].map(|flag| relievo([command, flag]).done().stdout);
        let has = |help: &str, flag: &str| help.contains(&format!("--{flag} "));
        assert!(
            has(&short, "iterations") && !has(&short, "solver"),
            "{short}"
        );
        assert!(has(&all, "iterations") && has(&all, "solver"), "{all}");
        assert!(
            short.lines().count() <= 100,
            "{command}: {}",
            short.lines().count()
        );
    }
    let bare = relievo::<&str>([]);
    assert_eq!((bare.code, bare.stdout.as_str()), (Some(2), ""));
    assert!(bare.stderr.contains("Usage"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_told_and_one_behind_stderr_is_survived() {
    let full = || fs::OpenOptions::new().write(true).open("/dev/full");
    let gears = fixture("gears.exr");
    let here = Path::new(".");
    let mut inspect = program::program(here);
    inspect.arg("inspect").arg(&gears).stdout(full().unwrap());
    let line = Ran::of(&mut inspect).refused(1);
    assert!(line.starts_with("error: stdout: cannot write"), "{line}");

    for (input, code) in [(gears.as_path(), 0), (Path::new("none.exr"), 1)] {
        let desk = Desk::new();
        let enhance = program::program(here)
            .args([OsStr::new("enhance"), input.as_os_str(), OsStr::new("-o")])
            .arg(desk.path("a.png"))
            .stderr(full().unwrap())
            .status()
            .unwrap();
        assert_eq!(enhance.code(), Some(code));
        assert_eq!(desk.path("a.png").exists(), code == 0);
    }
}

// Refusals.

#[test]
fn misuse_is_one_line_and_exit_code_2() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    let cases: [(&str, &[&str], &str); 21] = [
        ("a.bmp", &[], ".png"),
        ("a", &[], ".png"),
        ("a.png", &["--scaling", "lots"], "--scaling"),
        ("a.png", &["--scaling", "-1"], "--scaling"),
        ("a.png", &["--scaling", "nan"], "--scaling"),
        ("a.png", &["--scaling", "inf"], "--scaling"),
        ("a.png", &["--invariant-point", "1.5"], "--invariant-point"),
        ("a.png", &["--foreshortening", "5"], "--foreshortening"),
        ("a.png", &["--direction-step", "1.5"], "--direction-step"),
        ("a.png", &["--direction-step", "65"], "--direction-step"),
        ("a.png", &["--iterations", "2.5"], "--iterations"),
        ("a.png", &["--silhouette", "0.4,0.3"], "--silhouette"),
        ("a.png", &["--crease", "60"], "--crease"),
        ("a.png", &["--curvature-gain", "0"], "--curvature-gain"),
        ("a.png", &["--normal-flip", "w"], "--normal-flip"),
        ("a.png", &["--threads", "0"], "--threads"),
        ("a.png", &["--layers", "some"], "keep"),
        ("a.png", &["--colour", "x"], "--color"),
        ("a.png", &["--strength", "50%"], "0.5 for 50%"),
        ("a.png", &["--iterations", "ten"], "a whole number"),
        ("a.png", &["b.png"], "give -o b.png"),
    ];
    for (output, flags, expected) in cases {
        let line = desk.run("enhance", &gears, output, flags).refused(2);
        assert!(line.contains(expected), "{line}");
    }
    // No similar flag exists; values that begin with dashes are not mentioned.
    let line = desk
        .run("enhance", &gears, "a.png", &["--zoom", "3"])
        .refused(2);
    assert!(line.contains("--zoom") && !line.contains("tip"), "{line}");
    assert!(relievo(["enhance"]).refused(2).contains("--output"));
    assert!(relievo(["enchant"]).refused(2).contains("enchant"));
    assert!(relievo(["inspect"]).refused(2).contains("<FILE>"));
    assert_eq!(desk.names(), [""; 0]);
}

#[test]
fn inputs_are_never_replaced() {
    let desk = Desk::new();
    let copy = |from: &str, to: &str| {
        fs::copy(fixture(from), desk.path(to)).unwrap();
        desk.path(to)
    };
    let render = copy("gears.exr", "gears.exr");
    let camera = copy("gears.camera.json", "camera.json");
    let normal = copy("tablet.normal.png", "normal.png");
    let color = copy("tablet.color.jpg", "color.jpg");
    let before = [&render, &camera, &normal, &color].map(|path| fs::read(path).unwrap());
    let listed = desk.names();

    let text = |path: &Path| path.to_str().unwrap().to_string();
    for verb in ["enhance", "shape"] {
        desk.run(verb, &render, "gears.exr", &[]).refused(2);
    }
    let line = desk
        .run(
            "enhance",
            &color,
            "normal.png",
            &["--normal", &text(&normal)],
        )
        .refused(2);
    assert!(line.contains("normal.png"), "{line}");
    // Under another spelling of its name, and as the file of timings.
    let around = text(&desk.path(".").join("gears.exr"));
    desk.run("enhance", Path::new(&around), "gears.exr", &[])
        .refused(2);
    for name in [&render, &camera] {
        let flags = ["--camera", &text(&camera), "--timings", &text(name)];
        desk.run("enhance", &render, "out.png", &flags).refused(2);
    }
    let flags = ["--timings", &text(&desk.path("out.png"))];
    desk.run("enhance", &render, "out.png", &flags).refused(2);

    let after = [&render, &camera, &normal, &color].map(|path| fs::read(path).unwrap());
    assert!(before == after, "an input was touched");
    assert_eq!(desk.names(), listed);
}

#[test]
fn an_older_output_is_replaced_unless_told_not_to() {
    let desk = Desk::new();
    let gears = fixture("gears.exr");
    fs::write(desk.path("a.png"), "older").unwrap();
    let line = desk
        .run("enhance", &gears, "a.png", &["--no-clobber"])
        .refused(2);
    assert!(line.contains("a.png"), "{line}");
    assert_eq!(fs::read(desk.path("a.png")).unwrap(), b"older");
    desk.make("enhance", &gears, "a.png", &[]);
    assert_eq!(photo(&desk.path("a.png")).width, 320);
    desk.make("enhance", &gears, "b.png", &["--no-clobber"]);
    assert_eq!(desk.names(), ["a.png", "b.png"]);
}

#[test]
fn what_cannot_be_done_is_one_line_and_exit_code_1() {
    let desk = Desk::new();
    let says = |ran: Ran, expected: &[&str]| {
        let line = ran.refused(1);
        for text in expected {
            assert!(line.contains(text), "no {text} in {line}");
        }
    };
    let color = fixture("tablet.color.jpg");
    let bust = fixture("bust.exr");
    let run = |input: &Path, flags: &[&str]| desk.run("enhance", input, "out.png", flags);

    says(run(Path::new("none.exr"), &[]), &["none.exr"]);
    says(run(&color, &[]), &["tablet.color.jpg", "--normal"]);
    let none = ["none.png is no file", "no layer"];
    says(run(&color, &["--normal", "none.png"]), &none);
    let flags = ["--normal", "ViewLayer.Nrmal"];
    says(
        run(&bust, &flags),
        &["ViewLayer.Nrmal", "ViewLayer.Normal,"],
    );
    says(run(&bust, &["--camera", "none.json"]), &["none.json"]);
    let not_a_camera = fixture("PROVENANCE.md");
    let flags = ["--camera", not_a_camera.to_str().unwrap()];
    says(run(&bust, &flags), &["PROVENANCE.md"]);
    says(run(&not_a_camera, &[]), &["PROVENANCE.md"]);
    let empty = Desk::new();
    says(run(empty.0.path(), &[]), &["holds no image"]);

    let small = image::RgbImage::from_pixel(128, 256, image::Rgb([128, 128, 255]));
    let inputs = Desk::new();
    small.save(inputs.path("small.png")).unwrap();
    let small = inputs.path("small.png");
    let flags = ["--normal", small.to_str().unwrap()];
    says(run(&color, &flags), &["256x256", "128x256"]);

    // World-space normals, and no evidence for a camera.
    let file = open(&bust);
    let planes = ["Combined.R", "Combined.G", "Combined.B", "Combined.A"]
        .into_iter()
        .chain(["Normal.X", "Normal.Y", "Normal.Z"])
        .map(|name| format!("ViewLayer.{name}"))
        .map(|name| (plane(&file, 0, &name), name));
    let planes: Vec<_> = planes.collect();
    let channels: Vec<_> = planes.iter().map(|(p, name)| (name.as_str(), p)).collect();
    let lost = inputs.write_exr("lost.exr", &channels);
    says(run(&lost, &[]), &["lost.exr", "world", "--camera"]);

    // A picture cut short, in its pixels and in its header.
    let whole = fs::read(&bust).unwrap();
    for (name, length) in [("pixels.exr", whole.len() / 2), ("header.exr", 200)] {
        fs::write(inputs.path(name), &whole[..length]).unwrap();
        says(run(&inputs.path(name), &[]), &[name]);
        relievo([OsStr::new("inspect"), inputs.path(name).as_os_str()]).refused(1);
    }
    let cut = &fs::read(&color).unwrap()[..5000];
    fs::write(inputs.path("cut.jpg"), cut).unwrap();
    says(run(&inputs.path("cut.jpg"), &[]), &["cut.jpg"]);
    assert_eq!(desk.names(), [""; 0]);

    let nowhere = desk.run("enhance", &bust, "none/out.png", &["-q"]);
    says(nowhere, &["none"]);
    fs::create_dir(desk.path("taken.png")).unwrap();
    let taken = desk.run("enhance", &bust, "taken.png", &["-q"]);
    says(taken, &["taken.png"]);
    assert_eq!(desk.names(), ["taken.png"]);
}

// Interpretation of inputs.

#[test]
fn a_camera_file_gives_the_picture_of_the_recovered_camera() {
    let desk = Desk::new();
    let others = ["gears.camera.json", "bust.camera.json"];
    for (name, other_camera) in ["bust", "gears"].into_iter().zip(others) {
        let render = fixture(&format!("{name}.exr"));
        let camera = fixture(&format!("{name}.camera.json"));
        let recovered = desk.make("enhance", &render, "recovered.png", &[]);
        let flags = ["--camera", camera.to_str().unwrap()];
        let given = desk.make("enhance", &render, "given.png", &flags);
        let (most, differ) = difference(&recovered, &given);
        assert!(most < 1.5 && differ < 0.01, "{name}: {most}, {differ}");
        // Another camera is another picture, so the file is not simply left aside.
        let other = fixture(other_camera);
        let mut json: Value = serde_json::from_str(&fs::read_to_string(other).unwrap()).unwrap();
        let own: Value = serde_json::from_str(&fs::read_to_string(&camera).unwrap()).unwrap();
        for key in ["resolution", "intrinsics_px", "camera_type"] {
            json[key] = own[key].clone();
        }
        fs::write(desk.path("other.json"), json.to_string()).unwrap();
        let other = desk.path("other.json");
        let flags = [
            "--camera",
            other.to_str().unwrap(),
            "--normal-space",
            "world",
        ];
        let wrong = desk.make("enhance", &render, "wrong.png", &flags);
        let (most, differ) = difference(&recovered, &wrong);
        assert!(most > 3.0 && differ > 0.1, "{name}: {most}, {differ}");
    }
}

#[test]
fn flipping_an_axis_undoes_a_flipped_map() {
    let desk = Desk::new();
    let right = fixture("tablet.normal.png");
    let mut map = image::open(&right).unwrap().to_rgb8();
    for pixel in map.pixels_mut() {
        pixel.0[1] = 255 - pixel.0[1];
    }
    let flipped = desk.path("flipped.png");
    map.save(&flipped).unwrap();
    let plain = tablet(&desk, &right, "plain.png", &[]);
    let wrong = tablet(&desk, &right, "wrong.png", &["--normal-flip", "y"]);
    let undone = tablet(&desk, &flipped, "undone.png", &["--normal-flip", "y"]);
    let (most, differ) = difference(&plain, &wrong);
    assert!(most > 20.0 && differ > 0.1, "{most}, {differ}");
    // Without the flag the slopes decide: their curl is a thirtieth of that with y reversed. A flag overrides them.
    let told = tablet(&desk, &flipped, "told.png", &[]);
    assert!(difference(&plain, &told).0 < 1.5);
    let kept = tablet(&desk, &flipped, "kept.png", &["--normal-flip", "none"]);
    assert!(difference(&wrong, &kept).0 < 1.5);
    let (most, differ) = difference(&plain, &undone);
    assert!(most < 1.5 && differ < 0.001, "{most}, {differ}");
}

#[test]
fn a_normal_map_of_16_bits_is_finer_than_one_of_8() {
    let desk = Desk::new();
    let frame = ExactScene::orthographic(Surface::ball(60.0), 64.3, 63.8).frame(128, 128);
    let n = &frame.normal;
    let exact = desk.write_exr("n.exr", &[("N.x", &n.x), ("N.y", &n.y), ("N.z", &n.z)]);
    let code = |x: u32, y: u32, max: f32| {
        let at = |p: &Plane| p.at(x as usize, y as usize);
        [at(&n.x), at(&n.y), at(&n.z)].map(|v| ((0.5 * v + 0.5) * max).round())
    };
    image::RgbImage::from_fn(128, 128, |x, y| {
        image::Rgb(code(x, y, 255.0).map(|c| c as u8))
    })
    .save(desk.path("n8.png"))
    .unwrap();
    let n16 = image::ImageBuffer::from_fn(128, 128, |x, y| {
        image::Rgb(code(x, y, 65535.0).map(|c| c as u16))
    });
    image::DynamicImage::ImageRgb16(n16)
        .save(desk.path("n16.png"))
        .unwrap();
    image::RgbImage::from_pixel(128, 128, image::Rgb([150, 140, 120]))
        .save(desk.path("photo.png"))
        .unwrap();

    let enhanced = |normal: &Path, output: &str| {
        let flags = ["--normal", normal.to_str().unwrap()];
        let fine = ["--iterations", "0", "--curvature-gain", "30"];
        let flags = [&flags[..], &fine, &["--normal-space", "view"]].concat();
        desk.make("enhance", &desk.path("photo.png"), output, &flags)
    };
    let exact = enhanced(&exact, "exact.png");
    let (most_16, _) = difference(&exact, &enhanced(&desk.path("n16.png"), "16.png"));
    let (most_8, differ_8) = difference(&exact, &enhanced(&desk.path("n8.png"), "8.png"));
    assert!(most_16 < 1.5, "16 bits differ by {most_16}");
    assert!(most_8 > 4.0 && differ_8 > 0.1, "{most_8}, {differ_8}");
}
