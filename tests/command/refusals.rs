//! What cannot be done is one line, with its exit code and what to do next; nothing is written, and no input touched.

use crate::common::exr::Part;
use crate::common::program::Desk;
use relievo::frame::Plane;
use relievo::io::colorspace::ColorSpace;
use std::fs;

#[test]
fn misuse_is_one_line_and_exit_code_2() {
    let desk = Desk::new();
    let rows = "
        enhance => 2: --output
        enchant => 2: enchant
        inspect => 2: <FILE>
    ";
    desk.check("{}", rows);
    let rows = "
        a.bmp => 2: .png
        a => 2: .png
        a.png b.png => 2: give -o b.png
        a.png --scaling lots => 2: --scaling
        a.png --scaling -1 => 2: --scaling
        a.png --scaling inf => 2: --scaling
        a.png --invariant-point 1.5 => 2: --invariant-point
        a.png --foreshortening 5 => 2: --foreshortening
        a.png --direction-step 1.5 => 2: --direction-step
        a.png --direction-step 65 => 2: --direction-step
        a.png --iterations 2.5 => 2: --iterations
        a.png --iterations ten => 2: a whole number
        a.png --silhouette 0.4,0.3 => 2: --silhouette
        a.png --crease 60 => 2: --crease
        a.png --curvature-gain 0 => 2: --curvature-gain
        a.png --normal-flip w => 2: --normal-flip
        a.png --threads 0 => 2: --threads
        a.png --threads 65535 => 2: 65535 is not in 1..=512
        a.png --layers some => 2: keep
        a.png --strength 50% => 2: 0.5 for 50%
        a.png --colour x => 2: --color
        // No similar flag exists; values that begin with dashes are not mentioned.
        a.png --zoom 3 => 2: --zoom ... !tip
    ";
    desk.check("enhance fixtures/gears.exr -o {}", rows);
    let rows = "
        --levels 0 => 2: --levels
        --stroke-scale 0 => 2: --stroke-scale
        --style crayon => 2: --style
        --passes 99 => 2: --passes
        --tone-gamma nan => 2: --tone-gamma
    ";
    desk.check("hatch fixtures/bust.exr -o a.png {}", rows);
    let rows = "
        --ambient 0 => 2: --light AZ,EL
        --light 1 => 2: expected 2 numbers
        --light 1,2,-1,0,0 => 2: colour of 0 or more
        --light 0,45 --material mirror => 2: --environment
        --light 0,45 --material wood => 2: ashikhmin-shirley
        --light 0,45 --warp -1 => 2: --warp is -1; give 0 to 1e6
        --light 0,45 --contrast 2 => 2: -1 to 1
        --light 0,45 --toon-levels 0 => 2: 1 to 1024
        --light 0,45 --samples 1000000 => 2: up to 100000
        --light 0,45 --albedo-from layer => 2: --albedo-from
    ";
    desk.check("relight fixtures/bust.exr -o a.png {}", rows);
}

#[test]
fn numbers_out_of_range_are_refused_with_their_range() {
    let desk = Desk::of_frames(1..=1);
    let rows = "
        enhance --scaling 1e30 => 2: --scaling is 1e30; give 0 to 1e6
        enhance --scaling nan => 2: --scaling is NaN; give 0 to 1e6
        enhance --curvature-gain 1e-40 => 2: --curvature-gain is 1e-40; give 1e-30 to 1e30
        enhance --white-level 1e-40 => 2: --white-level is 1e-40; give 1e-38 to 3.4028235e38
        enhance --term-white-level diffuse=1e-40 => 2: --term-white-level is 1e-40; give
        enhance --tolerance 1e-30 => 2: --tolerance is 1e-30; give 1e-9 to 1000
        enhance --crease 1,1e38 => 2: --crease is 1e38; give 1 to 1e30
        enhance --iterations 4294967295 => 2: --iterations is 4294967295; give 0 to 41943039
        enhance --iterations 4000000 --solver explicit => 2: --solver takes 4000000 explicit steps
        enhance --scale 4097 => 2: --scale is 4097; give 0 to 4096
        enhance --reference-height 0 => 2: --reference-height is 0; give 1 or more
        relight --light 30,40 --warp 1e30 => 2: --warp is 1e30; give 0 to 1e6
        relight --light 30,40 --shininess 1e30 => 2: --shininess is 1e30; give 0 to 1e6
        relight --light 30,40 --coat 1e38,1e38 => 2: --coat is 1e38; give 0 to 1e6
        relight --light 30,40 --tangent 1e30 => 2: --tangent is 1e30; give -1e6 to 1e6
        relight --light 30,40 --diffuse-gain inf => 2: --diffuse-gain is inf; give 0 to 1e6
        relight --light 30,40,1e38,1,1 => 2: --light is 1e38; give 0 to 1e12
        relight --point-light 0,0,1e38 => 2: --point-light is 1e38; give -1e9 to 1e9
        relight --area-light 0,0,1e38 => 2: --area-light is 1e38; give 0 to 180
        relight --light 30,40 --environment-rotate inf => 2: --environment-rotate is inf; give
        hatch --fallback 1e30 => 2: --fallback is 1e30; give -1e6 to 1e6
        hatch --white-point 1e-40 => 2: --white-point is 1e-40; give 1e-38 to
    ";
    desk.check("{} in.0001.exr -o out.png", rows);
    // That many lights must not be created first, nor as many scales.
    let lights = "--area-light 1,1,1 ".repeat(1000);
    let lights = format!("relight {lights} --samples 100000 in.0001.exr -o out.png");
    desk.check(
        &lights,
        "=> 2: --light makes 100000000 lights; give at most 100000",
    );
    for (count, expected) in [
        (100_000, "2: --scale names 100000 scales; give at most 64"),
        (65, "2: --scale names 65 scales; give at most 64"),
        (64, "0"),
    ] {
        let scales: Vec<_> = (1..=count).map(|i| (i as f32 / 32.0).to_string()).collect();
        let scales = scales.join(", ");
        desk.write(
            "look.toml",
            format!("version = 1\ncommand = \"shape\"\nscale = [{scales}]\n"),
        );
        desk.check(
            "run look.toml in.0001.exr -o out.exr",
            &format!("=> {expected}"),
        );
    }
}

#[test]
fn cameras_out_of_range_are_refused() {
    let desk = Desk::of_frames(1..=1);
    for (camera, expected) in [
        (
            r#"{"focal_px": 1e-300}"#,
            "cam.json: its focal length is 1e-300 px; give 0.01 to 1e9",
        ),
        (r#"{"focal_px": 0.005}"#, "its focal length is 0.005 px"),
        (
            r#"{"focal_px": 64, "principal_point_px": [1e300, 32]}"#,
            "its principal point is 1e300 px; give -1e7 to 1e7",
        ),
        (
            r#"{"pixels_per_unit": 1e-300}"#,
            "its number of pixels per unit is 1e-300; give 1e-6 to 1e9",
        ),
        (
            r#"{"focal_px": 64, "resolution": [1e300, 1e300]}"#,
            "its resolution is 1e300; give 1 to",
        ),
    ] {
        desk.write("cam.json", camera);
        for command in ["enhance", "shape", "relight --light 30,40", "hatch"] {
            let words = "--foreshortening 1 in.0001.exr --camera cam.json -o out.exr";
            desk.check(&format!("{command} {words}"), &format!("=> 1: {expected}"));
        }
    }
    // The same as text of a sequence.
    let still = r#"{"view_from_world":[1.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0],"is_placed":false,"projection":{"type":"perspective","fx":1e-300,"fy":64.0,"cx":32.0,"cy":32.0}}"#;
    let words = format!("shape in.0001.exr --still-camera {still} -o out.exr");
    desk.check(
        &words,
        "=> 2: --still-camera is out of range: its focal length is 1e-300 px",
    );
}

#[test]
fn what_overflows_in_spite_of_all_ranges_is_not_written() {
    let desk = Desk::new();
    // Stages stay within single precision, up to 3.4e38. But for AP1 a display shows 1.7 times the red, less others:
    // for a grey of 3e38 that overflows on the way.
    let plane = |value| Plane::filled(16, 16, value);
    let (grey, zero, one) = (plane(3e38), plane(0.0), plane(1.0));
    let picture = ["R", "G", "B"].map(|name| (name, &grey));
    let normals = [("N.X", &zero), ("N.Y", &zero), ("N.Z", &one)];
    let part = Part::of(picture.into_iter().chain(normals)).chromaticities(ColorSpace::AP1);
    for name in ["in.0001.exr", "in.0002.exr"] {
        part.clone().write(&desk.at(name));
    }
    let found = "in.0001.exr: picture at (0, 0) is not finite, from inputs that are; give numbers that are less extreme";
    for out in ["out.png", "out.hdr", "out.tif"] {
        desk.check(
            &format!("enhance in.0001.exr -o {out}"),
            &format!("=> 1: {found}"),
        );
    }
    let said = desk
        .run("enhance in.####.exr --frames 1-2 --keep-going -o out.####.png")
        .ended(1);
    for name in ["in.0001.exr", "in.0002.exr"] {
        let line = format!("error: {name}: picture at (0, 0) is not finite");
        assert_eq!(said.matches(&line).count(), 1, "{said}");
    }
    assert_eq!(desk.names(""), ["in.0001.exr", "in.0002.exr"]);
    // Layers stay in AP1, and finite.
    desk.make("enhance in.0001.exr -o whole.exr");
}

#[test]
fn samples_too_large_for_half_floats_are_clamped_with_one_warning() {
    let desk = Desk::new();
    desk.write_frame(1, 64, 1e6);
    let float = "--depth-of-output float --compression zip";
    for (how, expected) in [
        ("--compression dwaa", float),
        ("--compression dwab --depth-of-output half", float),
        (
            "--depth-of-output half",
            "keep them with --depth-of-output float\n",
        ),
    ] {
        let said = desk
            .make(format!(
                "enhance in.0001.exr {how} --layers results -o out.exr"
            ))
            .stderr;
        let warnings: Vec<_> = said.lines().filter(|l| l.starts_with("warning")).collect();
        assert_eq!(warnings.len(), 1, "{said}");
        let clamped = " samples are too large for half floats and clamped";
        assert!(
            warnings[0].contains(clamped) && said.contains(expected),
            "{said}"
        );
        let file = desk.exr("out.exr");
        let all: Vec<_> = file.channel_ids().collect();
        let planes = file.read_channels(&all).unwrap();
        let mut samples = planes.iter().flat_map(|plane| plane.samples());
        assert!(samples.all(|sample| sample.is_finite()), "{how}");
    }
    desk.check(
        "enhance in.0001.exr --layers results -o out.exr",
        "=> 0: !warning",
    );
}

#[test]
fn an_older_output_is_replaced_unless_told_not_to() {
    let desk = Desk::new();
    desk.write("a.png", "older");
    desk.check(
        "enhance fixtures/gears.exr -o a.png --no-clobber",
        "=> 2: a.png",
    );
    assert_eq!(desk.text("a.png"), "older");
    desk.make("enhance fixtures/gears.exr -o a.png");
    assert_eq!(desk.photo("a.png").width, 320);
    desk.make("enhance fixtures/gears.exr -o b.png --no-clobber");
    assert_eq!(desk.names(""), ["a.png", "b.png"]);
}

#[test]
fn inputs_that_cannot_be_read_are_named() {
    let desk = Desk::new();
    fs::create_dir(desk.at("empty")).unwrap();
    let normals = [0.5, 0.5, 1.0].map(|v| Plane::filled(128, 256, v));
    desk.write_codes("small.png", normals, 8);
    // World-space normals, and no evidence for a camera.
    let picture = ["R", "G", "B", "A"].map(|c| format!("ViewLayer.Combined.{c}"));
    let normal = ["X", "Y", "Z"].map(|c| format!("ViewLayer.Normal.{c}"));
    let names = picture.into_iter().chain(normal);
    let planes = names.map(|name| (desk.channel("fixtures/bust.exr", &name), name));
    let planes: Vec<_> = planes.collect();
    let channels = planes.iter().map(|(plane, name)| (name, plane));
    Part::of(channels).write(&desk.at("lost.exr"));
    // A picture cut short, in its pixels and in its header.
    let whole = desk.bytes("fixtures/bust.exr");
    desk.write("pixels.exr", &whole[..whole.len() / 2]);
    desk.write("header.exr", &whole[..200]);
    desk.write("cut.jpg", &desk.bytes("fixtures/tablet.color.jpg")[..5000]);
    let rows = "
        inspect pixels.exr => 1: pixels.exr
        inspect header.exr => 1: header.exr
        relight fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png --point-light 0,0,1 -o a.png => 2: --point-light ... depth
        relight fixtures/bust.exr --environment nowhere.hdr -o a.png => 1: nowhere.hdr
    ";
    desk.check("{}", rows);
    let rows = "
        none.exr => 1: none.exr
        fixtures/tablet.color.jpg => 1: tablet.color.jpg ... --normal
        fixtures/tablet.color.jpg --normal none.png => 1: none.png is no file ... no layer
        fixtures/tablet.color.jpg --normal small.png => 1: 256x256 ... 128x256
        fixtures/bust.exr --normal ViewLayer.Nrmal => 1: ViewLayer.Nrmal ... ViewLayer.Normal,
        fixtures/bust.exr --camera none.json => 1: none.json
        fixtures/bust.exr --camera fixtures/PROVENANCE.md => 1: PROVENANCE.md
        fixtures/PROVENANCE.md => 1: PROVENANCE.md
        empty => 1: holds no image
        lost.exr => 1: lost.exr ... world ... --camera
        pixels.exr => 1: pixels.exr
        header.exr => 1: header.exr
        cut.jpg => 1: cut.jpg
    ";
    desk.check("enhance -o out.png {}", rows);
}
