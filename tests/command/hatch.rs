//! `relievo hatch` as a user runs it.

use crate::common::exr::Part;
use crate::common::mean;
use crate::common::program::Desk;
use glam::DVec3;
use relievo::frame::{Plane, Vector3Planes};
use relievo::io::photo::Photo;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const BUST: &str = "hatch fixtures/bust.exr";

fn size(photo: &Photo) -> [usize; 2] {
    [photo.width, photo.height]
}

/// Mean of the picture's light.
fn light(photo: &Photo) -> f64 {
    mean(&photo.to_linear()[0])
}

/// The drawing of the bust as a page.
fn page(desk: &Desk, flags: &str) -> String {
    desk.make(format!("{BUST} {flags} -o bust.svg"));
    desk.text("bust.svg")
}

/// What follows each `key="`, up to the next quote.
fn values<'a>(page: &'a str, key: &str) -> Vec<&'a str> {
    let key = format!("{key}=\"");
    let rests = page.split(&key).skip(1);
    rests.filter_map(|rest| rest.split('"').next()).collect()
}

#[test]
fn an_engraving_that_nobody_chose_is_enlarged_unless_a_factor_is_given() {
    let desk = Desk::new();
    // 480 x 360 pixels: to strokes of scale 1 it lacks a factor of 1320 / 415.7 = 3.2.
    for (words, times) in [("", 4), ("--enlarge 1", 1), ("--enlarge 2", 2)] {
        let drawing = desk.picture(format!("{BUST} {words}"));
        assert_eq!(size(&drawing), [480 * times, 360 * times], "{words}");
    }
}

#[test]
fn renders_and_photos_are_drawn_with_every_tool() {
    let desk = Desk::new();
    let tablet = "hatch fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png";
    for style in ["pen", "pencil", "lines", "engraving", "stipple"] {
        let bust = desk.picture(format!("{BUST} --style {style}"));
        assert_eq!(size(&bust), [480, 360]);
        // Paper around the bust, ink on it.
        assert!((0.2..0.98).contains(&light(&bust)), "{}", light(&bust));
        let tablet = desk.picture(format!("{tablet} --style {style}"));
        assert!((0.05..0.95).contains(&light(&tablet)));
    }
}

#[test]
fn a_sequence_is_fitted_to_its_frames_as_they_are_drawn() {
    // Without the planes behind a subject, in pen, as large as they are.
    let desk = Desk::new();
    let levels = |words: &str| {
        desk.make(format!("hatch {words} --save-recipe look.toml -q"));
        let recipe = desk.text("look.toml");
        let levels = recipe.lines().filter(|line| line.contains("-levels"));
        levels.map(String::from).collect::<Vec<_>>()
    };
    let sequence = levels("fixtures/wheel.####.exr --frames 1-1 -o out.####.png");
    let alone = "fixtures/wheel.0001.exr --style pen --background strokes -o out.png";
    assert_eq!(sequence, levels(alone));
    assert_eq!(sequence.len(), 2);
}

#[test]
fn an_svg_holds_lines_in_millimetres() {
    let desk = Desk::new();
    let page = page(&desk, "--style engraving --dpi 96");
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
}

/// All points of all paths.
fn points(page: &str) -> Vec<[i32; 2]> {
    let mut all = Vec::new();
    for path in values(page, "<path d") {
        let numbers = path.trim_end_matches("h0").trim_end_matches('z');
        let numbers = numbers.trim_start_matches('M').split(['l', ' ']);
        let numbers: Vec<i32> = numbers.map(|number| number.parse().unwrap()).collect();
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
    let desk = Desk::new();
    let written = |flags: &str| page(&desk, &format!("--style engraving {flags}"));
    let count = written("").matches("<path").count();
    for (flags, most) in [
        ("--plotter on", 1),
        ("--pens 1", 1),
        ("--pens 3 --plotter on", 3),
    ] {
        let page = written(flags);
        let widths = BTreeSet::from_iter(values(&page, "stroke-width"));
        assert_eq!(widths.len(), most, "{flags}");
        assert_eq!(page.matches("<path").count(), count, "{flags}");
        let tells = page.contains("<desc>way of the pen in the air: ");
        assert!(tells, "{flags}");
    }
}

#[test]
fn a_drawing_is_put_on_its_page() {
    let desk = Desk::new();
    let written = |flags: &str| {
        let page = page(&desk, &format!("--style engraving {flags}"));
        let number = |name: &str| values(&page, &format!(" {name}"))[0].to_string();
        let size = [number("width"), number("height")].join(" by ");
        let size_px = number("viewBox");
        let size_px = size_px.split(' ').skip(2);
        let size_px: Vec<f32> = size_px
            .map(|side| side.parse::<f32>().unwrap() / 10.0)
            .collect();
        (size, size_px, points(&page))
    };
    // 480 x 360 pixels. On A4, 12 mm around: 273 mm across, 186 down: 360 pixels in 186 mm, so 297 mm are 574.8 pixels
    // and the drawing begins (574.8 - 480) / 2 = 47.4 from the left, 12 mm or 23.2 pixels from above.
    let (size, size_px, points) = written("--page A4");
    assert_eq!(size, "297.000mm by 210.000mm");
    let is_near = |found: f32, expected: f32| (found - expected).abs() < 0.2;
    assert!(
        is_near(size_px[0], 574.8) && is_near(size_px[1], 406.5),
        "{size_px:?}"
    );
    for [x, y] in points {
        assert!(
            (474..=5275).contains(&x) && (232..=3833).contains(&y),
            "{x} {y}"
        );
    }
    // 480 pixels in 297 - 40 mm.
    let (size, size_px, _) = written("--page A3 --margin 20mm --landscape off --pens 1");
    assert_eq!(size, "297.000mm by 420.000mm");
    assert!(is_near(size_px[0], 480.0 * 297.0 / 257.0), "{size_px:?}");
    let (size, ..) = written("--page 100x80mm --margin 0 --landscape on");
    assert_eq!(size, "100.000mm by 80.000mm");
    // Dots of a millimetre: 480 pixels in 100 mm, a radius of 2.4.
    let page = page(
        &desk,
        "--style stipple --stroke-scale 1mm --page 100x80mm --margin 0",
    );
    let radii = values(&page, " r").into_iter();
    let radii: Vec<f32> = radii.map(|text| text.parse().unwrap()).collect();
    let mean = radii.iter().sum::<f32>() / radii.len() as f32;
    assert!((mean - 24.0).abs() < 2.4, "{mean}");
}

#[test]
fn a_print_has_its_size_and_black_and_white_alone() {
    let desk = Desk::new();
    // 480 x 360 pixels: 65 mm at 300 to the inch are 767.7 pixels across, and 575.8 down, three quarters of that.
    let flags = "--size 65x90mm --dpi 300";
    let grey = desk.picture(format!("{BUST} {flags}"));
    assert_eq!(size(&grey), [767, 575]);
    let printed = desk.picture(format!("{BUST} {flags} --ink bilevel"));
    assert_eq!(size(&printed), [767, 575]);
    let values = printed.channels[0].samples();
    assert!(values.iter().all(|&v| v == 0.0 || v == 1.0));
    // The share of white is the light of the drawing.
    let [of_grey, of_printed] = [light(&grey), light(&printed)];
    assert!(
        (of_grey - of_printed).abs() < 0.005,
        "{of_grey} {of_printed}"
    );
    // 767 of 300 to the inch.
    let page = page(&desk, &format!("{flags} --style lines"));
    assert!(page.contains("width=\"64.939mm\""), "{}", &page[..200]);
}

#[test]
fn what_cannot_be_drawn_is_refused_in_one_line() {
    Desk::new().check(
        "hatch fixtures/bust.exr {}",
        "
        --style pencil -o a.svg => 2: --style is a texture, and an SVG holds lines
        --style . -o a.svg => 2: --style is a texture, and an SVG holds lines
        --mix 0.5 -o a.svg => 2: --mix takes a share of ink
        --pens 2 --plotter off -o a.svg => 2: --pens counts the pens of a plotter
        --page A4 -o a.png => 2: write a .svg or leave it out
        --page A4 --size 65x90mm -o a.svg => 2: cannot be used with
        --page A4 --dpi 300 -o a.svg => 2: leave one out
        --page A4 --margin 105mm -o a.svg => 2: --margin is 105 mm
        --page letter -o a.svg => 2: expected A3, A4
        --size 30x30mm -o a.png => 2: give --dpi 407 or more
        --size 65x90mm --enlarge 2 -o a.png => 2: cannot be used with
        --ink bilevel -o a.jpg => 2: write a .png or .tif
        --ink bilevel --style pencil -o a.png => 2: give --style pen or lines
    ",
    );
}

#[test]
fn tone_comes_from_new_light_where_there_is_any() {
    let desk = Desk::new();
    let lit = |lamp: &str| {
        let flags = "--style pen --tone relight --albedo-from white --contours off";
        light(&desk.picture(format!("{BUST} {flags} --light {lamp}")))
    };
    assert!(lit("90,80") > lit("0,2") + 0.03);
    // Shape is shown in any light. Without a picture there is a lamp.
    let rows = "
        --light 90,80 => 0: light-sum:  ... ran   shape-tone
        --tone relight => 0: light-sum:
        --tone picture => 0: -     diffusion  ... -     trace  ... -     radiance-scaling  ... -     light-sum
    ";
    desk.check(
        "hatch fixtures/bust.exr --style pen --explain -v -o a.png {}",
        rows,
    );
}

#[test]
fn layers_of_a_drawing_lie_beside_the_input_and_strokes_cover_what_is_asked() {
    let desk = Desk::new();
    for style in ["pen", "pencil"] {
        desk.make(format!("{BUST} --style {style} -o drawing.exr"));
        desk.channel("drawing.exr", "relievo.R");
        let covered = |name: &str| mean(&desk.channel("drawing.exr", name));
        let [strokes, asked] = ["strokes.hatching", "strokes.tone"].map(covered);
        assert!((strokes / asked - 1.0).abs() < 0.02, "{strokes} of {asked}");
        assert!(covered("strokes.contours") > 0.0 && covered("strokes.interior") > 0.0);
    }
}

#[test]
fn a_folder_of_pictures_draws_and_one_without_is_refused() {
    let desk = Desk::new();
    fs::create_dir(desk.at("dots")).unwrap();
    let dots = "hatch fixtures/bust.exr --style dots -o a.png {}";
    desk.check(dots, "=> 1: holds 0 pictures");
    for (name, size) in [("light.png", 2), ("dark.png", 6)] {
        let dots = image::GrayImage::from_fn(64, 64, |x, y| {
            image::Luma([if x % 8 < size && y % 8 < size { 0 } else { 255 }])
        });
        dots.save(desk.at("dots").join(name)).unwrap();
    }
    desk.write("dots/notes.txt", "not a picture");
    let dotted = desk.picture(format!("{BUST} --style dots"));
    assert!((0.2..0.98).contains(&light(&dotted)));
    desk.check(dots, "--stroke-scale 0.3mm => 2: --stroke-scale");
    let odd = image::GrayImage::new(32, 64);
    odd.save(desk.at("dots/odd.png")).unwrap();
    desk.check(dots, "=> 1: odd.png");
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
    let desk = Desk::new();
    dome(&desk.at("in.exr"), |x, _| if x < 3 { 0.0 } else { 1.0 });
    let mask = Plane::from_fn(40, 32, |x, _| x as f32 / 39.0);
    desk.write_exr("mask.exr", &[("mask.Y", &mask)]);
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
        let [width, height] = [40 * times, 32 * times];
        let words = format!("hatch in.exr --style {style} --wrap {wrap}{more}");
        desk.make(format!("{words} -q -o out.exr"));
        let strokes = desk.channel("out.exr", "strokes.hatching");
        assert_eq!(
            [strokes.width(), strokes.height()],
            [width, height],
            "{words}"
        );
        let picture = desk.picture(&words);
        assert_eq!(size(&picture), [width, height], "{words}");
        assert!((0.02..1.0).contains(&light(&picture)), "{words}");
        if style != "pencil" && !more.contains("mask") {
            desk.make(format!("{words} -q -o out.svg"));
            let page = desk.text("out.svg");
            assert!(page.contains(&format!("viewBox=\"0 0 {width}0 {height}0\"")));
        }
    }
}

/// Coverage is read as a share: beyond 0 and 1 it draws what 0 and 1 draw.
#[test]
fn coverage_beyond_its_range_is_brought_into_it() {
    let desk = Desk::new();
    let wild = [1e10, f32::NEG_INFINITY, 1e38, f32::NAN, 0.5, -1e30, 65504.0];
    let stored = |x: usize, y: usize| match (x * y) % 5 {
        0 => wild[(x + 3 * y) % 7],
        _ => f32::from(u8::from(x > 5)),
    };
    dome(&desk.at("wild.exr"), stored);
    dome(&desk.at("sane.exr"), |x, y| {
        let share = stored(x, y);
        if share > 0.0 { share.min(1.0) } else { 0.0 }
    });
    for style in ["pen", "lines", "engraving", "stipple"] {
        let [wild, sane] = ["wild", "sane"].map(|name| {
            let drawn = desk.picture(format!("hatch {name}.exr --style {style}"));
            drawn.channels
        });
        assert!(wild == sane, "{style}");
    }
}
