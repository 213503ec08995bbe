//! Sheets of sprites: every cell is a picture of its own, and all are made by what is chosen once.

use super::inputs::write_planes;
use crate::common::exr::channel;
use crate::common::program::{fixture, names, relievo};
use glam::DVec3;
use relievo::frame::{Plane, Window};
use relievo::io::photo::Photo;
use relievo::io::picture::ViewTransform;
use std::f64::consts::TAU;
use std::path::Path;

const SIDE: usize = 32;

/// Normals of a cell, at -1..1 from left to right and from bottom to top; `None` where nothing is.
type Sprite = fn(turn: f64, x: f64, y: f64) -> Option<DVec3>;

/// A ball with ridges that turn.
fn ball(turn: f64, x: f64, y: f64) -> Option<DVec3> {
    let (x, y) = (1.1 * x, 1.1 * y);
    let z = (1.0 - x * x - y * y).sqrt();
    let around = 0.3 * (5.0 * (y.atan2(x) - turn)).cos();
    (z > 0.05).then(|| DVec3::new(x - around * y, y + around * x, z))
}

/// A pyramid of four sides that turns.
fn pyramid(turn: f64, x: f64, y: f64) -> Option<DVec3> {
    let quarter = TAU / 4.0;
    let side = ((y.atan2(x) - turn) / quarter).round() * quarter + turn;
    let up = x * side.cos() + y * side.sin();
    (up < 0.7).then(|| DVec3::new(side.cos(), side.sin(), 1.2))
}

/// Waves that fill the cell and move on.
fn waves(turn: f64, x: f64, y: f64) -> Option<DVec3> {
    let slope = |v: f64| 0.8 * (TAU * v + turn).sin();
    Some(DVec3::new(slope(x), slope(y), 1.0))
}

fn nothing(_: f64, _: f64, _: f64) -> Option<DVec3> {
    None
}

/// Writes a sheet with a row of frames of each sprite, as `sheet.png` in grey light and `sheet_n.png`, of 8 bits.
fn write_sheet(directory: &Path, sprites: &[Sprite], frames: usize) {
    let (width, height) = (frames * SIDE, sprites.len() * SIDE);
    let at = |x: usize, y: usize| {
        let [u, v] = [x, y].map(|at| ((at % SIDE) as f64 + 0.5) / (SIDE as f64 / 2.0) - 1.0);
        sprites[y / SIDE](0.2 * (x / SIDE) as f64, u, -v).map(DVec3::normalize)
    };
    let plane = |value: &dyn Fn(DVec3) -> f64| {
        let value = |x, y| at(x, y).map_or(0.0, |n| value(n) as f32);
        Plane::from_fn(width, height, value)
    };
    let alpha = plane(&|_| 1.0);
    let code = |axis: usize| plane(&move |n| 0.5 * n[axis] + 0.5);
    let none = ViewTransform::None;
    let path = directory.join("sheet_n.png");
    write_planes(&path, [0, 1, 2].map(code), Some(&alpha), 8, none);
    let light =
        |share: f64| plane(&move |n| share * (0.3 + 0.5 * n.dot(DVec3::new(-0.4, 0.5, 0.7))));
    let path = directory.join("sheet.png");
    write_planes(&path, [0.9, 0.7, 0.5].map(light), Some(&alpha), 8, none);
}

/// All channels of a part of a picture, its alpha last; 1 where it has none.
fn part(path: &Path, part: Window) -> Vec<Plane> {
    let photo = Photo::read(path).unwrap();
    let whole = Window::from_size(photo.width, photo.height);
    let alpha = photo
        .alpha
        .unwrap_or_else(|| Plane::filled(photo.width, photo.height, 1.0));
    let planes = photo.channels.iter().chain([&alpha]);
    planes.map(|plane| plane.crop(whole, part)).collect()
}

/// Copies a cell to a file of its own.
fn copy_cell(from: &Path, to: &Path, cell: Window) {
    let [r, g, b, alpha] = part(from, cell).try_into().unwrap();
    write_planes(to, [r, g, b], Some(&alpha), 8, ViewTransform::None);
}

fn cell(x: usize, y: usize) -> Window {
    Window::at((x * SIDE) as i32, (y * SIDE) as i32, SIDE, SIDE)
}

/// With the choices of the sheet, a cell alone gives the same codes: nothing of its neighbours shows. Waves and the ball's
/// rims are as different as can be at borders.
#[test]
fn every_cell_is_what_it_gives_alone() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_sheet(here, &[ball, waves, nothing, pyramid], 3);
    let own = Window::from_size(SIDE, SIDE);
    let picture = "sheet.png --normal sheet_n.png";
    for (command, inputs) in [
        ("enhance", picture),
        ("enhance --scale 2,6", picture),
        ("relight --light 150,30 --albedo-from picture", picture),
        ("hatch", picture),
        ("hatch --style pencil --tone picture", picture),
        ("shape", picture),
        ("map --wrap none", "sheet_n.png"),
        (
            "map --map edges,residual --wrap x -o {map}.png",
            "sheet_n.png",
        ),
        ("normals", "sheet_n.png"),
    ] {
        let output = match command.contains("edges") {
            true => "edges.png",
            false => "made.png",
        };
        let to = |name: &str| match command.contains(" -o ") {
            true => String::new(),
            false => format!("-o {name}"),
        };
        let words = format!(
            "{command} {inputs} --grid 32x32 --save-recipe look.toml --force {}",
            to("made.png")
        );
        let said = relievo(here, &words).ended(0);
        assert!(!said.contains("warning"), "{words}: {said}");
        let size = Photo::read(&here.join(output)).unwrap();
        assert_eq!([size.width, size.height], [3 * SIDE, 4 * SIDE], "{words}");
        for (x, y) in [(0, 0), (2, 0), (0, 1), (1, 1), (1, 2), (2, 3)] {
            let is_map = !inputs.contains("--normal");
            if is_map && y == 2 {
                // Alone, nothing tells that it is a map.
                continue;
            }
            let expected = part(&here.join(output), cell(x, y));
            for name in ["sheet.png", "sheet_n.png"] {
                copy_cell(
                    &here.join(name),
                    &here.join(format!("one_{name}")),
                    cell(x, y),
                );
            }
            let inputs = inputs.replace("sheet", "one_sheet");
            let to = command.contains(" -o ").then_some("-o one_{map}.png");
            let words = format!(
                "run look.toml {inputs} --keep-levels -q {}",
                to.unwrap_or("-o one_made.png")
            );
            relievo(here, &words).done();
            let found = part(&here.join(format!("one_{output}")), own);
            assert!(found == expected, "{command}: cell {x}, {y}");
        }
    }
}

/// A flat cell beside waves is left as it is, to the bit; as one picture the change at the border reaches into it.
#[test]
fn a_flat_cell_stays_flat_beside_waves() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_sheet(here, &[waves], 2);
    let waves = part(&here.join("sheet_n.png"), cell(1, 0));
    let codes = [128.0, 128.0, 255.0].into_iter().zip(&waves);
    let both = codes.map(|(flat, waves)| {
        Plane::from_fn(2 * SIDE, SIDE, |x, y| match x < SIDE {
            true => flat / 255.0,
            false => waves.at(x - SIDE, y),
        })
    });
    let both = both.collect::<Vec<_>>().try_into().unwrap();
    write_planes(
        &here.join("sheet_n.png"),
        both,
        None,
        8,
        ViewTransform::None,
    );
    let before = part(&here.join("sheet.png"), cell(0, 0));
    let words = "enhance sheet.png --normal sheet_n.png --normal-flip none -q -o";
    relievo(here, &format!("{words} apart.png --grid 32x32")).done();
    relievo(here, &format!("{words} one.png")).done();
    let of = |name: &str| part(&here.join(name), cell(0, 0));
    assert!(of("apart.png") == before);
    assert!(of("one.png") != before);
}

/// Slopes and heights of depth go by the size of a cell, as alone, and so does what is said of them.
#[test]
fn cells_of_depth_and_of_heights_are_as_alone() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let cone = |x: usize, y: usize| {
        let away = |at: usize| (at % SIDE) as f32 + 0.5 - SIDE as f32 / 2.0;
        let steep = 1.0 + (x / SIDE) as f32;
        (1.0 - steep * away(x).hypot(away(y)) / 24.0).max(0.0)
    };
    let cones = Plane::from_fn(3 * SIDE, SIDE, cone);
    let planes = || [cones.clone(), cones.clone(), cones.clone()];
    write_planes(
        &here.join("cones.png"),
        planes(),
        None,
        16,
        ViewTransform::None,
    );
    let third = cones.crop(Window::from_size(3 * SIDE, SIDE), cell(2, 0));
    let planes = [third.clone(), third.clone(), third];
    write_planes(&here.join("one.png"), planes, None, 16, ViewTransform::None);
    let own = Window::from_size(SIDE, SIDE);
    for kind in ["--height", "--depth"] {
        let words =
            format!("relight cones.png {kind} cones.png --albedo-from white --light 150,30");
        let said = relievo(
            here,
            &format!("{words} --grid 32x32 -o made.png --save-recipe look.toml --force"),
        )
        .ended(0);
        if kind == "--height" {
            // A tenth of the side of a cell.
            assert!(said.contains("1 is taken for 3.2 pixels"), "{said}");
        } else {
            assert!(said.contains("white is taken for near"), "{said}");
        }
        let words =
            format!("run look.toml one.png {kind} one.png --keep-levels -q -o alone.png --force");
        relievo(here, &words).done();
        let [found, expected] = [("alone.png", own), ("made.png", cell(2, 0))]
            .map(|(name, cell)| part(&here.join(name), cell));
        assert!(found == expected, "{kind}");
    }
}

/// Frames of an animation get one exposure, and one estimate of what the surface's colour is: as cells of one sheet, those that
/// hold the same are the same, whatever is beside them.
#[test]
fn equal_cells_are_made_equal() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_sheet(here, &[ball, waves, ball], 2);
    let words = "relight sheet.png --normal sheet_n.png --light 150,30 --grid 32x32 -q -o made.png";
    relievo(here, words).done();
    let of = |x, y| part(&here.join("made.png"), cell(x, y));
    assert!(of(0, 0) == of(0, 2) && of(1, 0) == of(1, 2));
    assert!(of(0, 0) != of(1, 0));
    // Layers as numbers too.
    let words = "shape sheet.png --normal sheet_n.png --grid 32x32 -q -o layers.exr";
    relievo(here, words).done();
    let mean = channel(&here.join("layers.exr"), "curvature.mean");
    let whole = Window::from_size(2 * SIDE, 3 * SIDE);
    assert!(mean.crop(whole, cell(1, 0)) == mean.crop(whole, cell(1, 2)));
    let words = "map sheet_n.png --map height --grid 32x32 --wrap none -q -o height.tif";
    relievo(here, words).done();
    let heights = part(&here.join("height.tif"), cell(1, 0));
    assert!(heights == part(&here.join("height.tif"), cell(1, 2)));
}

/// Every cell leans its own way, so that the normals jump at all borders: that is no noise.
#[test]
fn borders_of_cells_are_no_noise() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_sheet(here, &[waves as Sprite; 8], 8);
    let map = part(
        &here.join("sheet_n.png"),
        Window::from_size(8 * SIDE, 8 * SIDE),
    );
    let lean = |i: usize, x: usize, y: usize| {
        let cell = x / SIDE + 8 * (y / SIDE);
        [0.3 * ((7 * cell + 3 * i) as f64).sin() as f32, 0.0][usize::from(i == 2)]
    };
    let planes = [0, 1, 2].map(|i| {
        Plane::from_fn(8 * SIDE, 8 * SIDE, |x, y| match i {
            2 => 0.9,
            _ => 0.5 + 0.3 * (map[i].at(x, y) - 0.5) + lean(i, x, y),
        })
    });
    write_planes(
        &here.join("tiles_n.png"),
        planes,
        None,
        8,
        ViewTransform::None,
    );
    let words = "shape tiles_n.png --normal tiles_n.png --normal-flip none -o made.png --force";
    let said = relievo(here, &format!("{words} --grid 32x32")).ended(0);
    assert!(!said.contains("noise"), "{said}");
}

#[test]
fn what_cannot_be_cut_is_refused() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_sheet(here, &[ball, waves], 3);
    let picture = "sheet.png --normal sheet_n.png";
    let bust = fixture("bust.exr");
    let bust = bust.display();
    for (words, code, expected) in [
        (
            format!("enhance {picture} -o x.png --grid 36x20"),
            2,
            "--grid 36x20 does not fit a sheet of 96x64; give 32x16, or crop the sheet to 72x60",
        ),
        (
            format!("enhance {bust} -o x.png --grid 48x40"),
            1,
            "is an EXR",
        ),
        (
            format!("hatch {picture} -o x.svg --grid 32x32"),
            2,
            "an SVG holds lines",
        ),
        (
            format!("hatch {picture} -o x.png --grid 32x32 --enlarge 2"),
            2,
            "--enlarge makes cells larger than those of the sheet",
        ),
        (
            "enhance s.####.png -o x.####.png --grid 32x32 --frames 1-2".to_string(),
            2,
            "cannot be used with '--frames",
        ),
        (
            "map sheet_n.png -o x.png --map height --grid 32x32".to_string(),
            2,
            "--map height runs from black to white in each picture",
        ),
        (
            "map sheet_n.png -o x_{map}.png --scale 1,4 --grid 32x32".to_string(),
            2,
            "--scale takes a gain for each scale",
        ),
        (
            "normals sheet_n.png -o x.png --flatten --grid 32x32".to_string(),
            2,
            "--flatten is of a whole picture",
        ),
        (
            format!("enhance {picture} -o x.png --grid 32x32 --max-memory 1M"),
            1,
            "needs the picture whole",
        ),
    ] {
        let said = relievo(here, &words).error(code);
        assert!(said.contains(expected), "{words}: {said}");
        assert!(names(here, "x").is_empty(), "{words}");
    }
    // Of several sheets each makes its own choices.
    std::fs::copy(here.join("sheet.png"), here.join("other.png")).unwrap();
    let words = "enhance sheet.png other.png --normal sheet_n.png --grid 32x32 -q -o made/";
    relievo(here, words).done();
    assert_eq!(names(&here.join("made"), "").len(), 2);
}
