//! `relievo hatch` as a user runs it.

use crate::common::exr::{Part, channel};
use crate::common::program::{Ran, fixture, relievo, run};
use glam::DVec3;
use relievo::frame::{Plane, Vector3Planes};
use relievo::io::photo::Photo;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::Path;

fn hatch(directory: &Path, input: &str, words: &str) -> Ran {
    let words = words.split_whitespace().map(OsStr::new);
    let input = fixture(input);
    run(
        directory,
        ["hatch".as_ref(), input.as_os_str()]
            .into_iter()
            .chain(words),
    )
}

fn drawn(directory: &Path, input: &str, words: &str) -> Photo {
    hatch(directory, input, &format!("{words} -o drawing.png")).done();
    Photo::read(&directory.join("drawing.png")).unwrap()
}

/// Mean of the picture's light.
fn light(photo: &Photo) -> f32 {
    let grey = &photo.to_linear()[0];
    grey.samples().iter().sum::<f32>() / grey.samples().len() as f32
}

#[test]
fn an_engraving_that_nobody_chose_is_enlarged_unless_a_factor_is_given() {
    let desk = tempfile::tempdir().unwrap();
    // 480 x 360 pixels: to strokes of scale 1 it lacks a factor of 1320 / 415.7 = 3.2.
    for (words, times) in [("", 4), ("--enlarge 1", 1), ("--enlarge 2", 2)] {
        let drawing = drawn(desk.path(), "bust.exr", words);
        let size = (drawing.width, drawing.height);
        assert_eq!(size, (480 * times, 360 * times), "{words}");
    }
}

#[test]
fn renders_and_photos_are_drawn_with_every_tool() {
    let desk = tempfile::tempdir().unwrap();
    let normal = fixture("tablet.normal.png");
    for style in ["pen", "pencil", "lines", "engraving", "stipple"] {
        let bust = drawn(desk.path(), "bust.exr", &format!("--style {style}"));
        assert_eq!((bust.width, bust.height), (480, 360));
        // Paper around the bust, ink on it.
        assert!((0.2..0.98).contains(&light(&bust)), "{}", light(&bust));
        let tablet = drawn(
            desk.path(),
            "tablet.color.jpg",
            &format!("--normal {} --style {style}", normal.display()),
        );
        assert!((0.05..0.95).contains(&light(&tablet)));
    }
}

#[test]
fn a_sequence_is_fitted_to_its_frames_as_they_are_drawn() {
    // Without the planes behind a subject, in pen, as large as they are.
    let desk = tempfile::tempdir().unwrap();
    let levels = |input: &str, words: &str| {
        hatch(
            desk.path(),
            input,
            &format!("{words} --save-recipe look.toml -q"),
        )
        .done();
        let recipe = std::fs::read_to_string(desk.path().join("look.toml")).unwrap();
        let levels = recipe.lines().filter(|line| line.contains("-levels"));
        levels.map(String::from).collect::<Vec<_>>()
    };
    let sequence = levels("wheel.####.exr", "--frames 1-1 -o out.####.png");
    let alone = "--style pen --background strokes -o out.png";
    assert_eq!(sequence, levels("wheel.0001.exr", alone));
    assert_eq!(sequence.len(), 2);
}

#[test]
fn an_svg_holds_lines_in_millimetres() {
    let desk = tempfile::tempdir().unwrap();
    let written = |flags: &str| {
        hatch(
            desk.path(),
            "bust.exr",
            &format!("--style engraving {flags} -o bust.svg"),
        )
        .done();
        std::fs::read_to_string(desk.path().join("bust.svg")).unwrap()
    };
    let page = written("--dpi 96");
    // 480 x 360 pixels at 96 to the inch are 5 x 3.75 inches.
    assert!(page.starts_with("<svg ") && page.ends_with("</svg>\n"));
    let size = "width=\"127.000mm\" height=\"95.250mm\" viewBox=\"0 0 4800 3600\"";
    assert!(page.contains(size));
    assert!(!page.contains("NaN") && !page.contains("inf"));
    let points = points(&page);
    assert!(points.len() > 3000, "{}", points.len());
    let is_on = |&[x, y]: &[i32; 2]| (0..=4800).contains(&x) && (0..=3600).contains(&y);
    assert!(points.iter().all(is_on));
    // Without a plotter every line is an area.
    assert!(!page.contains("stroke-width"));
    assert_eq!(page.matches("<path").count(), page.matches("z\"/>").count());
    for layer in ["strokes", "crossing", "contours", "interior"] {
        let label = format!("inkscape:groupmode=\"layer\" inkscape:label=\"{layer}\"");
        assert!(page.contains(&label), "{layer}");
    }
    let texture = "--style is a texture, and an SVG holds lines";
    for (flags, found) in [
        ("--style pencil", texture),
        ("--style .", texture),
        ("--mix 0.5", "--mix takes a share of ink"),
    ] {
        let ran = hatch(desk.path(), "bust.exr", &format!("{flags} -o other.svg"));
        assert!(ran.error(2).contains(found), "{flags}");
        assert!(!desk.path().join("other.svg").exists());
    }
}

/// All points of all paths.
fn points(page: &str) -> Vec<[i32; 2]> {
    let mut all = Vec::new();
    for path in page.split("<path d=\"M").skip(1) {
        let path = path.split('"').next().unwrap();
        let numbers = path.trim_end_matches("h0").trim_end_matches('z');
        let numbers: Vec<i32> = numbers
            .split(['l', ' '])
            .map(|number| number.parse().unwrap())
            .collect();
        let [mut x, mut y] = [0; 2];
        for step in numbers.chunks(2) {
            (x, y) = (x + step[0], y + step[1]);
            all.push([x, y]);
        }
    }
    all
}

/// A plotter draws each line once, whole, with one of so many pens, and only there a pen is counted.
#[test]
fn a_plotter_draws_with_few_pens() {
    let desk = tempfile::tempdir().unwrap();
    let written = |flags: &str| {
        let words = format!("--style engraving {flags} -o bust.svg");
        hatch(desk.path(), "bust.exr", &words).done();
        std::fs::read_to_string(desk.path().join("bust.svg")).unwrap()
    };
    let count = written("").matches("<path").count();
    for (flags, most) in [
        ("--plotter on", 1),
        ("--pens 1", 1),
        ("--pens 3 --plotter on", 3),
    ] {
        let page = written(flags);
        let widths = page.split("stroke-width=\"").skip(1);
        let widths: BTreeSet<_> = widths.map(|text| text.split('"').next().unwrap()).collect();
        assert_eq!(widths.len(), most, "{flags}");
        assert_eq!(page.matches("<path").count(), count, "{flags}");
        assert!(
            page.contains("<desc>way of the pen in the air: "),
            "{flags}"
        );
    }
    let ran = hatch(
        desk.path(),
        "bust.exr",
        "--pens 2 --plotter off -o other.svg",
    );
    assert!(ran.error(2).contains("--pens counts the pens of a plotter"));
}

#[test]
fn a_drawing_is_put_on_its_page() {
    let desk = tempfile::tempdir().unwrap();
    let written = |flags: &str| {
        hatch(
            desk.path(),
            "bust.exr",
            &format!("--style engraving {flags} -o bust.svg"),
        )
        .done();
        let page = std::fs::read_to_string(desk.path().join("bust.svg")).unwrap();
        let number = |name: &str| {
            let text = page.split(&format!(" {name}=\"")).nth(1).unwrap();
            text.split('"').next().unwrap().to_string()
        };
        let size = [number("width"), number("height")].join(" by ");
        let size_px: Vec<f32> = number("viewBox")
            .split(' ')
            .skip(2)
            .map(|side| side.parse::<f32>().unwrap() / 10.0)
            .collect();
        (size, size_px, points(&page))
    };
    // 480 x 360 pixels. On A4, 12 mm around: 273 mm across, 186 down: 360 pixels in 186 mm, so 297 mm are 574.8 pixels
    // and the drawing begins (574.8 - 480) / 2 = 47.4 from the left, 12 mm or 23.2 pixels from above.
    let (size, size_px, points) = written("--page A4");
    assert_eq!(size, "297.000mm by 210.000mm");
    assert!(
        (size_px[0] - 574.8).abs() < 0.2 && (size_px[1] - 406.5).abs() < 0.2,
        "{size_px:?}"
    );
    for &[x, y] in &points {
        assert!(
            (474..=5275).contains(&x) && (232..=3833).contains(&y),
            "{x} {y}"
        );
    }
    // 480 pixels in 297 - 40 mm.
    let (size, size_px, _) = written("--page A3 --margin 20mm --landscape off --pens 1");
    assert_eq!(size, "297.000mm by 420.000mm");
    assert!(
        (size_px[0] - 480.0 * 297.0 / 257.0).abs() < 0.2,
        "{size_px:?}"
    );
    let (size, ..) = written("--page 100x80mm --margin 0 --landscape on");
    assert_eq!(size, "100.000mm by 80.000mm");
    // Dots of a millimetre: 480 pixels in 100 mm, a radius of 2.4.
    let dots = "--style stipple --stroke-scale 1mm --page 100x80mm --margin 0 -o dots.svg";
    hatch(desk.path(), "bust.exr", dots).done();
    let page = std::fs::read_to_string(desk.path().join("dots.svg")).unwrap();
    let radii = page.split(" r=\"").skip(1);
    let radii: Vec<f32> = radii
        .map(|text| text.split('"').next().unwrap().parse().unwrap())
        .collect();
    let mean = radii.iter().sum::<f32>() / radii.len() as f32;
    assert!((mean - 24.0).abs() < 2.4, "{mean}");
    for (flags, said) in [
        ("--page A4 -o a.png", "write a .svg or leave it out"),
        ("--page A4 --size 65x90mm -o a.svg", "cannot be used with"),
        ("--page A4 --dpi 300 -o a.svg", "leave one out"),
        ("--page A4 --margin 105mm -o a.svg", "--margin is 105 mm"),
        ("--page letter -o a.svg", "expected A3, A4"),
    ] {
        let ran = hatch(desk.path(), "bust.exr", flags);
        assert!(ran.error(2).contains(said), "{flags}");
    }
}

#[test]
fn a_print_has_its_size_and_black_and_white_alone() {
    let desk = tempfile::tempdir().unwrap();
    // 480 x 360 pixels: 65 mm at 300 to the inch are 767.7 pixels across, and 575.8 down, three quarters of that.
    let size = "--size 65x90mm --dpi 300";
    let grey = drawn(desk.path(), "bust.exr", size);
    assert_eq!((grey.width, grey.height), (767, 575));
    let printed = drawn(desk.path(), "bust.exr", &format!("{size} --ink bilevel"));
    assert_eq!((printed.width, printed.height), (767, 575));
    let values = printed.channels[0].samples();
    assert!(values.iter().all(|&v| v == 0.0 || v == 1.0));
    // The share of white is the light of the drawing.
    let [of_grey, of_printed] = [light(&grey), light(&printed)];
    assert!(
        (of_grey - of_printed).abs() < 0.005,
        "{of_grey} {of_printed}"
    );
    hatch(
        desk.path(),
        "bust.exr",
        &format!("{size} --style lines -o a.svg"),
    )
    .done();
    let page = std::fs::read_to_string(desk.path().join("a.svg")).unwrap();
    // 767 of 300 to the inch.
    assert!(page.contains("width=\"64.939mm\""), "{}", &page[..200]);
    for (flags, said) in [
        ("--size 30x30mm -o a.png", "give --dpi 407 or more"),
        ("--size 65x90mm --enlarge 2 -o a.png", "cannot be used with"),
        ("--ink bilevel -o a.jpg", "write a .png or .tif"),
        (
            "--ink bilevel --style pencil -o a.png",
            "give --style pen or lines",
        ),
    ] {
        let line = hatch(desk.path(), "bust.exr", flags).error(2);
        assert!(line.contains(said), "{flags}: {line}");
    }
}

#[test]
fn tone_comes_from_new_light_where_there_is_any() {
    let desk = tempfile::tempdir().unwrap();
    let flags = |light| {
        format!("--style pen --tone relight --light {light} --albedo-from white --contours off")
    };
    let lit = drawn(desk.path(), "bust.exr", &flags("90,80"));
    let raking = drawn(desk.path(), "bust.exr", &flags("0,2"));
    assert!(light(&lit) > light(&raking) + 0.03);
    // Shape is shown in any light.
    let explained = |flags: &str| {
        let words = format!("--style pen {flags} --explain -v -o a.png");
        hatch(desk.path(), "bust.exr", &words).stdout
    };
    let plan = explained("--light 90,80");
    for stage in ["light-sum: ", "ran   shape-tone "] {
        assert!(plan.contains(stage), "{plan}");
    }
    // Without a picture there is a lamp.
    let plan = explained("--tone relight");
    assert!(plan.contains("light-sum: "), "{plan}");
    let plan = explained("--tone picture");
    for stage in ["diffusion", "trace", "radiance-scaling", "light-sum"] {
        let skipped = format!("-     {stage} ");
        assert!(
            plan.lines().any(|line| line.starts_with(&skipped)),
            "{stage}: {plan}"
        );
    }
}

#[test]
fn layers_of_a_drawing_lie_beside_the_input_and_strokes_cover_what_is_asked() {
    let desk = tempfile::tempdir().unwrap();
    for style in ["pen", "pencil"] {
        let words = format!("--style {style} -o drawing.exr");
        hatch(desk.path(), "bust.exr", &words).done();
        let file = desk.path().join("drawing.exr");
        channel(&file, "relievo.R");
        let covered = |name: &str| {
            let plane = channel(&file, name);
            plane.samples().iter().sum::<f32>() / plane.samples().len() as f32
        };
        let [strokes, asked] = ["strokes.hatching", "strokes.tone"].map(covered);
        assert!((strokes / asked - 1.0).abs() < 0.02, "{strokes} of {asked}");
        assert!(covered("strokes.contours") > 0.0 && covered("strokes.interior") > 0.0);
    }
}

#[test]
fn a_folder_of_pictures_draws_and_one_without_is_refused() {
    let desk = tempfile::tempdir().unwrap();
    let folder = desk.path().join("dots");
    std::fs::create_dir(&folder).unwrap();
    let refused = hatch(desk.path(), "bust.exr", "--style dots -o a.png");
    assert!(refused.error(1).contains("holds 0 pictures"));
    for (name, size) in [("light.png", 2), ("dark.png", 6)] {
        let dots = image::GrayImage::from_fn(64, 64, |x, y| {
            image::Luma([if x % 8 < size && y % 8 < size { 0 } else { 255 }])
        });
        dots.save(folder.join(name)).unwrap();
    }
    std::fs::write(folder.join("notes.txt"), "not a picture").unwrap();
    let dotted = drawn(desk.path(), "bust.exr", "--style dots");
    assert!((0.2..0.98).contains(&light(&dotted)));
    let refused = hatch(
        desk.path(),
        "bust.exr",
        "--style dots --stroke-scale 0.3mm -o a.png",
    );
    assert!(refused.error(2).contains("--stroke-scale"));
    image::GrayImage::new(32, 64)
        .save(folder.join("odd.png"))
        .unwrap();
    let refused = hatch(desk.path(), "bust.exr", "--style dots -o a.png");
    assert!(refused.error(1).contains("odd.png"));
}

/// A frame of 40 by 32 pixels, a dome on a floor, whose coverage is `alpha`.
fn dome(path: &Path, alpha: impl Fn(usize, usize) -> f32) {
    let (width, height) = (40, 32);
    let normal = Vector3Planes::from_fn(width, height, |x, y| {
        let [right, up] = [x as f64 - 19.5, 15.5 - y as f64].map(|v| v / 12.0);
        let toward = 1.0 - right * right - up * up;
        match toward > 0.0 {
            true => DVec3::new(right, up, toward.sqrt()),
            false => DVec3::Z,
        }
    });
    let grey = Plane::from_fn(width, height, |x, _| 0.2 + 0.01 * x as f32);
    let alpha = Plane::from_fn(width, height, alpha);
    let of_normal = [("N.X", &normal.x), ("N.Y", &normal.y), ("N.Z", &normal.z)];
    let of_picture = [("R", &grey), ("G", &grey), ("B", &grey), ("A", &alpha)];
    Part::of(of_normal.into_iter().chain(of_picture)).write(path);
}

/// What a drawing is written as has the size of its frame: in every style, across every border, of a part or all.
#[test]
fn drawings_of_tiles_have_the_size_of_their_frame() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    dome(&here.join("in.exr"), |x, _| if x < 3 { 0.0 } else { 1.0 });
    let mask = Plane::from_fn(40, 32, |x, _| x as f32 / 39.0);
    Part::of([("mask.Y", &mask)]).write(&here.join("mask.exr"));
    let styles = ["pen", "pencil", "lines", "engraving", "stipple"];
    let wraps = ["x", "y", "xy", "auto"];
    let others = [
        "",
        " --mask mask.exr",
        " --enlarge 2 --layers results",
        " --contours off --interior off",
    ];
    // Every two of them meet.
    for (i, j) in (0..styles.len()).flat_map(|i| (0..wraps.len()).map(move |j| (i, j))) {
        let (style, wrap, more) = (styles[i], wraps[j], others[(i + j) % others.len()]);
        let times = if more.contains("enlarge") { 2 } else { 1 };
        let words = format!("hatch in.exr --style {style} --wrap {wrap}{more} -q");
        relievo(here, &format!("{words} -o out.exr")).done();
        let strokes = channel(&here.join("out.exr"), "strokes.hatching");
        assert_eq!(
            (strokes.width(), strokes.height()),
            (40 * times, 32 * times),
            "{words}"
        );
        relievo(here, &format!("{words} -o out.png")).done();
        let picture = Photo::read(&here.join("out.png")).unwrap();
        assert_eq!(
            (picture.width, picture.height),
            (40 * times, 32 * times),
            "{words}"
        );
        assert!((0.02..1.0).contains(&light(&picture)), "{words}");
        if style == "pencil" || more.contains("mask") {
            continue;
        }
        relievo(here, &format!("{words} -o out.svg")).done();
        let page = std::fs::read_to_string(here.join("out.svg")).unwrap();
        assert!(page.contains(&format!("viewBox=\"0 0 {}0 {}0\"", 40 * times, 32 * times)));
    }
}

/// Coverage is read as a share: beyond 0 and 1 it draws what 0 and 1 draw.
#[test]
fn coverage_beyond_its_range_is_brought_into_it() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let wild = [1e10, f32::NEG_INFINITY, 1e38, f32::NAN, 0.5, -1e30, 65504.0];
    let stored = |x: usize, y: usize| match (x * y) % 5 {
        0 => wild[(x + 3 * y) % 7],
        _ => f32::from(u8::from(x > 5)),
    };
    dome(&here.join("wild.exr"), stored);
    dome(&here.join("sane.exr"), |x, y| {
        let share = stored(x, y);
        if share > 0.0 { share.min(1.0) } else { 0.0 }
    });
    for style in ["pen", "lines", "engraving", "stipple"] {
        let [wild, sane] = ["wild", "sane"].map(|name| {
            let words = format!("hatch {name}.exr --style {style} -o drawing.png -q");
            relievo(here, &words).done();
            Photo::read(&here.join("drawing.png")).unwrap().channels
        });
        assert!(wild == sane, "{style}");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_in_one_line() {
    let desk = tempfile::tempdir().unwrap();
    for (flags, said) in [
        ("--levels 0", "--levels"),
        ("--stroke-scale 0", "--stroke-scale"),
        ("--style crayon", "--style"),
        ("--passes 99", "--passes"),
        ("--tone-gamma nan", "--tone-gamma"),
    ] {
        let ran = hatch(desk.path(), "bust.exr", &format!("{flags} -o a.png"));
        let refused = ran.error(2);
        assert!(refused.contains(said), "{refused}");
        assert!(!desk.path().join("a.png").exists());
    }
}
