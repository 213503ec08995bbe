//! `relievo hatch` on sequences, as a user runs it.

use crate::common::exr::Part;
use crate::common::program::{Ran, relievo};
use relievo::frame::Plane;
use relievo::io::photo::Photo;
use std::fs;
use std::path::Path;

const SIZE: [usize; 2] = [96, 64];

/// Content of a frame beside normals and a picture.
#[derive(Clone, Copy)]
enum With {
    /// Motion of 3 pixels to the right and 2 up, as Blender stores it.
    Motion,
    /// Depth, and a camera in a file of its own: the same motion of a wall.
    Camera,
    /// Neither, and no depth.
    Nothing,
}

fn write_frame(directory: &Path, number: i32, luminance: f32, with: With) {
    let flat = |value| Plane::filled(SIZE[0], SIZE[1], value);
    let mut channels: Vec<(&str, Plane)> = vec![
        ("R", flat(luminance)),
        ("G", flat(luminance)),
        ("B", flat(luminance)),
        ("N.X", flat(0.0)),
        ("N.Y", flat(0.0)),
        ("N.Z", flat(1.0)),
    ];
    if !matches!(with, With::Nothing) {
        channels.push(("Z", flat(5.0)));
    }
    match with {
        // Previous minus current, y up.
        With::Motion => channels.extend([
            ("ViewLayer.Vector.X", flat(-3.0)),
            ("ViewLayer.Vector.Y", flat(-2.0)),
            ("ViewLayer.Vector.Z", flat(-50.0)),
            ("ViewLayer.Vector.W", flat(90.0)),
        ]),
        // An eye that goes left and down: 100 px * 0.15 / 5 = 3 px, 100 px * 0.1 / 5 = 2 px a frame.
        With::Camera => {
            let (x, y) = (0.15 * number as f32, 0.1 * number as f32);
            let camera = format!(
                r#"{{"world_to_camera": [[1,0,0,{x}],[0,1,0,{y}],[0,0,1,0],[0,0,0,1]], "focal_px": 100}}"#
            );
            fs::write(directory.join(format!("cam.{number}.json")), camera).unwrap();
        }
        With::Nothing => {}
    }
    let channels = channels.iter().map(|(name, plane)| (name, plane));
    Part::of(channels).write(&directory.join(format!("in.{number:04}.exr")));
}

fn hatch(directory: &Path, words: &str) -> Ran {
    relievo(
        directory,
        &format!("hatch --contours off --normal-space view {words}"),
    )
}

fn drawing(directory: &Path, name: &str) -> Plane {
    let photo = Photo::read(&directory.join(name)).unwrap();
    photo.channels[0].clone()
}

/// Whether `now` is `before` shifted by 3 pixels to the right and 2 up.
fn is_moved(now: &Plane, before: &Plane) -> bool {
    let mut pixels = (0..SIZE[1] - 2).flat_map(|y| (3..SIZE[0]).map(move |x| (x, y)));
    pixels.all(|(x, y)| (now.at(x, y) - before.at(x - 3, y + 2)).abs() < 0.02)
}

#[test]
fn strokes_of_a_sequence_move_by_its_motion() {
    let desk = tempfile::tempdir().unwrap();
    for number in 1..=3 {
        // Twice as bright from the second frame on.
        let luminance = if number == 1 { 0.4 } else { 0.8 };
        write_frame(desk.path(), number, luminance, With::Motion);
    }
    let sequence = "in.####.exr --frames 1-3 --tone picture";
    let said = hatch(desk.path(), &format!("{sequence} -o out.%04d.png")).ended(0);
    // Each has its 98th percentile as white point; their median applies to all: no frame is made as bright as another.
    assert!(said.contains("for all frames:"), "{said}");
    assert!(said.contains("white point 0.8000"), "{said}");
    let [second, third] = ["out.0002.png", "out.0003.png"].map(|n| drawing(desk.path(), n));
    assert!(second.samples().iter().all(|&white| white == 1.0));
    let first = drawing(desk.path(), "out.0001.png");
    assert!(first.samples().iter().any(|&white| white < 0.5));
    assert!(is_moved(&third, &second));

    // A tone for each: the second and third are alike, and move with the surface.
    let tone = "--white-point 1.5";
    let outputs = "-o out.%04d.png";
    hatch(desk.path(), &format!("{sequence} {tone} {outputs}")).ended(0);
    let [second, third] = ["out.0002.png", "out.0003.png"].map(|n| drawing(desk.path(), n));
    assert!(is_moved(&third, &second));
    assert!(!is_moved(&second, &second));

    // Fixed strokes stay, as in single pictures.
    let still = "--motion none -o still.####.png";
    hatch(desk.path(), &format!("{sequence} {tone} {still}")).ended(0);
    let alone = "in.0003.exr --tone picture -o alone.png";
    hatch(desk.path(), &format!("{alone} {tone}")).ended(0);
    let [second, third, alone] =
        ["still.0002.png", "still.0003.png", "alone.png"].map(|n| drawing(desk.path(), n));
    assert_eq!(second, third);
    assert_eq!(third, alone);

    // A flag overrules what the frames show and the name says: they go the other way.
    let forward = "--motion ViewLayer.Vector --motion-convention forward -o forward.%04d.png";
    hatch(desk.path(), &format!("{sequence} {tone} {forward}")).ended(0);
    let [second, third] = ["forward.0002.png", "forward.0003.png"].map(|n| drawing(desk.path(), n));
    assert!(is_moved(&second, &third));

    // Enlarged, lines move twice as far: 6 pixels to the right and 4 up, but where new ones come in at the border.
    let large = "--style engraving --enlarge 2 -o large.%04d.png";
    hatch(desk.path(), &format!("{sequence} {tone} {large}")).ended(0);
    let [second, third] = ["large.0002.png", "large.0003.png"].map(|n| drawing(desk.path(), n));
    assert_eq!(second.width(), 2 * SIZE[0]);
    let difference = |[right, up]: [usize; 2]| {
        let pixels = (40..90).flat_map(|y| (40..150).map(move |x| (x, y)));
        let off = pixels.map(|(x, y)| (third.at(x, y) - second.at(x - right, y + up)).abs());
        off.sum::<f32>() / (110.0 * 50.0)
    };
    let [moved, still] = [difference([6, 4]), difference([0, 0])];
    assert!(5.0 * moved < still, "{moved} {still}");

    // Named by layer; a skipped frame means twice the motion, reported once.
    let gap = "in.####.exr --frames 1-3x2 --tone picture";
    let named = "--motion ViewLayer.Vector -o gap.####.png";
    let said = hatch(desk.path(), &format!("{gap} {tone} {named}")).ended(0);
    assert!(
        said.contains("where frames are left out motion is taken"),
        "{said}"
    );
    assert!(desk.path().join("gap.0003.png").exists());
    assert!(!desk.path().join("gap.0002.png").exists());
}

#[test]
fn cameras_tell_the_motion_of_what_stands_still() {
    let desk = tempfile::tempdir().unwrap();
    for number in 1..=3 {
        write_frame(desk.path(), number, 0.4, With::Camera);
    }
    let sequence = "in.####.exr --frames 1-3 --camera cam.#.json";
    let tone = "--tone picture --white-point 0.8 -o out.####.png";
    let said = hatch(desk.path(), &format!("{sequence} {tone}")).ended(0);
    assert!(said.contains("taken from depth and cameras"), "{said}");
    let drawings = [1, 2, 3].map(|n| drawing(desk.path(), &format!("out.000{n}.png")));
    assert!(is_moved(&drawings[1], &drawings[0]));
    assert!(is_moved(&drawings[2], &drawings[1]));
    // Without them there is no evidence.
    for number in 1..=2 {
        write_frame(desk.path(), number, 0.4, With::Nothing);
    }
    let flags = "in.####.exr --frames 1-2";
    let said = hatch(desk.path(), &format!("{flags} {tone}")).ended(0);
    assert!(said.contains("strokes lie still in the picture"), "{said}");
    let drawings = [1, 2].map(|n| drawing(desk.path(), &format!("out.000{n}.png")));
    assert_eq!(drawings[0], drawings[1]);
}

#[test]
fn what_is_no_sequence_is_refused_in_one_line() {
    let desk = tempfile::tempdir().unwrap();
    write_frame(desk.path(), 1, 0.4, With::Motion);
    for (flags, said) in [
        ("in.####.exr -o a.png", "give them, as in --frames 1-12"),
        (
            "in.0001.exr -o a.####.png",
            "give them, as in --frames 1-12",
        ),
        (
            "in.0001.exr --frames 1-2 -o a.####.png",
            "IN in.0001.exr has no place",
        ),
        ("in.####.exr --frames 1-2 -o a.png", "-o a.png has no place"),
        ("in.####.exr --frames 2-1 -o a.%d.png", "backward"),
        ("in.####.exr --frames all -o a.%d.png", "no list of frames"),
        ("in.0001.exr --motion none -o a.png", "--frames"),
        (
            "in.####.exr --frames 1-2 --motion v --motion-convention world -o a.%d.png",
            "render it in pixels",
        ),
        ("in.####.exr --frames 1 -o in.####.exr", "is the input"),
        (
            "in.####.exr --frames 1 --timings t.json -o a.####.png",
            "one file for all frames",
        ),
    ] {
        let line = hatch(desk.path(), flags).refused(2);
        assert!(line.contains(said), "{flags}: {line}");
    }
    // A missing frame, and missing motion: earlier frames are done.
    let sequence = "in.####.exr --frames 1-2 -o a.####.png";
    let stderr = hatch(desk.path(), sequence).ended(1);
    assert!(stderr.contains("in.0002.exr: cannot read"), "{stderr}");
    assert!(desk.path().join("a.0001.png").exists());
    write_frame(desk.path(), 2, 0.4, With::Camera);
    let ran = hatch(desk.path(), &format!("{sequence} --motion speed"));
    let stderr = ran.ended(1);
    assert!(stderr.contains("no motion called speed"), "{stderr}");
}
