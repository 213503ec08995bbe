//! Sheets of sprites: every cell is a picture of its own, and all are made by what is chosen once.

use super::inputs::grey;
use crate::common::program::{Desk, tells};
use glam::DVec3;
use relievo::frame::{Plane, Window};
use relievo::io::picture::ViewTransform;
use std::f64::consts::TAU;

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

/// A desk with a sheet that has a row of frames of each sprite: `sheet.png` in grey light and `sheet_n.png`, of 8 bits.
fn desk_with(sprites: &[Sprite], frames: usize) -> Desk {
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
    let (desk, none) = (Desk::new(), ViewTransform::None);
    desk.write_planes("sheet_n.png", [0, 1, 2].map(code), Some(&alpha), 8, none);
    let light =
        |share: f64| plane(&move |n| share * (0.3 + 0.5 * n.dot(DVec3::new(-0.4, 0.5, 0.7))));
    desk.write_planes(
        "sheet.png",
        [0.9, 0.7, 0.5].map(light),
        Some(&alpha),
        8,
        none,
    );
    desk
}

/// All channels of a part of a picture, its alpha last; 1 where it has none.
fn part(desk: &Desk, name: &str, part: Window) -> Vec<Plane> {
    let photo = desk.photo(name);
    let whole = Window::from_size(photo.width, photo.height);
    let opaque = || Plane::filled(photo.width, photo.height, 1.0);
    let alpha = photo.alpha.clone().unwrap_or_else(opaque);
    let planes = photo.channels.iter().chain([&alpha]);
    planes.map(|plane| plane.crop(whole, part)).collect()
}

fn cell(x: usize, y: usize) -> Window {
    Window::at((x * SIDE) as i32, (y * SIDE) as i32, SIDE, SIDE)
}

/// With the choices of the sheet, a cell alone gives the same codes: nothing of its neighbours shows. Waves and the ball's
/// rims are as different as can be at borders.
#[test]
fn every_cell_is_what_it_gives_alone() {
    let desk = desk_with(&[ball, waves, nothing, pyramid], 3);
    let own = Window::from_size(SIDE, SIDE);
    for command in [
        "enhance sheet.png --normal sheet_n.png -o made.png",
        "enhance sheet.png --normal sheet_n.png --scale 2,6 -o made.png",
        "relight sheet.png --normal sheet_n.png --light 150,30 --albedo-from picture -o made.png",
        "hatch sheet.png --normal sheet_n.png -o made.png",
        "hatch sheet.png --normal sheet_n.png --style pencil --tone picture -o made.png",
        "shape sheet.png --normal sheet_n.png -o made.png",
        "map sheet_n.png --wrap none -o made.png",
        "map sheet_n.png --map edges,residual --wrap x -o {map}.png",
        "normals sheet_n.png -o made.png",
    ] {
        let output = if command.contains("edges") {
            "edges.png"
        } else {
            "made.png"
        };
        let words = format!("{command} --grid 32x32 --save-recipe look.toml --force");
        tells(&desk.make(&words).stderr, "!warning");
        let size = desk.photo(output);
        assert_eq!([size.width, size.height], [3 * SIDE, 4 * SIDE], "{words}");
        let inputs = ["sheet.png --normal one_sheet_n.png", "sheet_n.png"];
        let inputs = inputs[usize::from(!command.contains("--normal"))];
        let to = command.rsplit_once(' ').unwrap().1;
        for (x, y) in [(0, 0), (2, 0), (0, 1), (1, 1), (1, 2), (2, 3)] {
            if inputs == "sheet_n.png" && y == 2 {
                // Alone, nothing tells that it is a map.
                continue;
            }
            let expected = part(&desk, output, cell(x, y));
            for name in ["sheet.png", "sheet_n.png"] {
                let [r, g, b, alpha] = part(&desk, name, cell(x, y)).try_into().unwrap();
                let (name, none) = (format!("one_{name}"), ViewTransform::None);
                desk.write_planes(&name, [r, g, b], Some(&alpha), 8, none);
            }
            desk.make(format!(
                "run look.toml one_{inputs} --keep-levels -q -o one_{to}"
            ));
            let found = part(&desk, &format!("one_{output}"), own);
            assert!(found == expected, "{command}: cell {x}, {y}");
        }
    }
}

/// A flat cell beside waves is left as it is, to the bit; as one picture the change at the border reaches into it.
#[test]
fn a_flat_cell_stays_flat_beside_waves() {
    let desk = desk_with(&[waves], 2);
    let waves = part(&desk, "sheet_n.png", cell(1, 0));
    let codes = [128.0, 128.0, 255.0].into_iter().zip(&waves);
    let both = codes.map(|(flat, waves)| {
        Plane::from_fn(2 * SIDE, SIDE, |x, y| match x < SIDE {
            true => flat / 255.0,
            false => waves.at(x - SIDE, y),
        })
    });
    desk.write_codes(
        "sheet_n.png",
        both.collect::<Vec<_>>().try_into().unwrap(),
        8,
    );
    let before = part(&desk, "sheet.png", cell(0, 0));
    let words = "enhance sheet.png --normal sheet_n.png --normal-flip none -q -o";
    desk.make(format!("{words} apart.png --grid 32x32"));
    desk.make(format!("{words} one.png"));
    assert!(part(&desk, "apart.png", cell(0, 0)) == before);
    assert!(part(&desk, "one.png", cell(0, 0)) != before);
}

/// Slopes and heights of depth go by the size of a cell, as alone, and so does what is said of them.
#[test]
fn cells_of_depth_and_of_heights_are_as_alone() {
    let desk = Desk::new();
    let cone = |x: usize, y: usize| {
        let away = |at: usize| (at % SIDE) as f32 + 0.5 - SIDE as f32 / 2.0;
        let steep = 1.0 + (x / SIDE) as f32;
        (1.0 - steep * away(x).hypot(away(y)) / 24.0).max(0.0)
    };
    let cones = Plane::from_fn(3 * SIDE, SIDE, cone);
    let third = cones.crop(Window::from_size(3 * SIDE, SIDE), cell(2, 0));
    desk.write_codes("cones.png", grey(cones), 16);
    desk.write_codes("one.png", grey(third), 16);
    // A tenth of the side of a cell.
    let rows = "
        --height cones.png => 0: 1 is taken for 3.2 pixels
        --depth cones.png => 0: white is taken for near
    ";
    for (row, kind) in rows.trim().lines().zip(["--height", "--depth"]) {
        let relight = "relight cones.png --albedo-from white --light 150,30 {}";
        let output = "--grid 32x32 -o made.png --save-recipe look.toml --force";
        desk.check(&format!("{relight} {output}"), row);
        let alone = format!("one.png {kind} one.png --keep-levels -q -o alone.png --force");
        desk.make(format!("run look.toml {alone}"));
        let found = part(&desk, "alone.png", Window::from_size(SIDE, SIDE));
        assert!(found == part(&desk, "made.png", cell(2, 0)), "{kind}");
    }
}

/// Frames of an animation get one exposure, and one estimate of what the surface's colour is: as cells of one sheet, those that
/// hold the same are the same, whatever is beside them.
#[test]
fn equal_cells_are_made_equal() {
    let desk = desk_with(&[ball, waves, ball], 2);
    let sheet = "sheet.png --normal sheet_n.png --grid 32x32 -q";
    desk.make(format!("relight {sheet} --light 150,30 -o made.png"));
    let of = |x, y| part(&desk, "made.png", cell(x, y));
    assert!(of(0, 0) == of(0, 2) && of(1, 0) == of(1, 2));
    assert!(of(0, 0) != of(1, 0));
    // Layers as numbers too.
    desk.make(format!("shape {sheet} -o layers.exr"));
    let mean = desk.channel("layers.exr", "curvature.mean");
    let whole = Window::from_size(2 * SIDE, 3 * SIDE);
    assert!(mean.crop(whole, cell(1, 0)) == mean.crop(whole, cell(1, 2)));
    desk.make("map sheet_n.png --map height --grid 32x32 --wrap none -q -o height.tif");
    let heights = |y| part(&desk, "height.tif", cell(1, y));
    assert!(heights(0) == heights(2));
}

/// Every cell leans its own way, so that the normals jump at all borders: that is no noise.
#[test]
fn borders_of_cells_are_no_noise() {
    let desk = desk_with(&[waves as Sprite; 8], 8);
    let side = 8 * SIDE;
    let map = part(&desk, "sheet_n.png", Window::from_size(side, side));
    let lean = |i: usize, x: usize, y: usize| {
        let cell = x / SIDE + 8 * (y / SIDE);
        0.3 * ((7 * cell + 3 * i) as f64).sin() as f32
    };
    let planes = [0, 1, 2].map(|i| {
        Plane::from_fn(side, side, |x, y| match i {
            2 => 0.9,
            _ => 0.5 + 0.3 * (map[i].at(x, y) - 0.5) + lean(i, x, y),
        })
    });
    desk.write_codes("tiles_n.png", planes, 8);
    let words = "shape tiles_n.png --normal tiles_n.png --normal-flip none -o made.png --force";
    desk.check(&format!("{words} --grid 32x32"), "=> 0: !noise");
}

#[test]
fn what_cannot_be_cut_is_refused() {
    let desk = desk_with(&[ball, waves], 3);
    let rows = "
        enhance sheet.png --normal sheet_n.png -o x.png --grid 36x20 => 2: --grid 36x20 does not fit a sheet of 96x64; give 32x16, or crop the sheet to 72x60
        enhance fixtures/bust.exr -o x.png --grid 48x40 => 1: is an EXR
        hatch sheet.png --normal sheet_n.png -o x.svg --grid 32x32 => 2: an SVG holds lines
        hatch sheet.png --normal sheet_n.png -o x.png --grid 32x32 --enlarge 2 => 2: --enlarge makes cells larger than those of the sheet
        enhance s.####.png -o x.####.png --grid 32x32 --frames 1-2 => 2: cannot be used with '--frames
        map sheet_n.png -o x.png --map height --grid 32x32 => 2: --map height runs from black to white in each picture
        map sheet_n.png -o x_{map}.png --scale 1,4 --grid 32x32 => 2: --scale takes a gain for each scale
        normals sheet_n.png -o x.png --flatten --grid 32x32 => 2: --flatten is of a whole picture
        enhance sheet.png --normal sheet_n.png -o x.png --grid 32x32 --max-memory 1M => 1: needs the picture whole
    ";
    desk.check("{}", rows);
    // Of several sheets each makes its own choices.
    desk.copy("sheet.png", "other.png");
    desk.make("enhance sheet.png other.png --normal sheet_n.png --grid 32x32 -q -o made/");
    assert_eq!(desk.at("made").read_dir().unwrap().count(), 2);
}
