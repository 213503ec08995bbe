//! `relievo hatch` on sequences, as a user runs it.

use crate::common::exr::Part;
use crate::common::program::Desk;
use relievo::frame::Plane;

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

fn write_frame(desk: &Desk, number: i32, luminance: f32, with: With) {
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
            desk.write(&format!("cam.{number}.json"), camera);
        }
        With::Nothing => {}
    }
    let channels = channels.iter().map(|(name, plane)| (name, plane));
    Part::of(channels).write(&desk.at(&format!("in.{number:04}.exr")));
}

const HATCH: &str = "hatch --contours off --normal-space view";

/// Draws, and gives back the frames of these numbers, and what is said.
fn drawn<const N: usize>(desk: &Desk, words: &str, numbers: [u32; N]) -> ([Plane; N], String) {
    let said = desk.make(format!("{HATCH} {words} -o out.####.png")).stderr;
    let mut frames = numbers.map(|n| desk.photo(&format!("out.{n:04}.png")).channels);
    (frames.each_mut().map(|channels| channels.remove(0)), said)
}

/// Whether `now` is `before` shifted by 3 pixels to the right and 2 up.
fn is_moved(now: &Plane, before: &Plane) -> bool {
    let mut pixels = (0..SIZE[1] - 2).flat_map(|y| (3..SIZE[0]).map(move |x| (x, y)));
    pixels.all(|(x, y)| (now.at(x, y) - before.at(x - 3, y + 2)).abs() < 0.02)
}

#[test]
fn strokes_of_a_sequence_move_by_its_motion() {
    let desk = Desk::new();
    for number in 1..=3 {
        // Twice as bright from the second frame on.
        let luminance = if number == 1 { 0.4 } else { 0.8 };
        write_frame(&desk, number, luminance, With::Motion);
    }
    let sequence = "in.####.exr --frames 1-3 --tone picture";
    let ([first, second, third], said) = drawn(&desk, sequence, [1, 2, 3]);
    // Each has its 98th percentile as white point; their median applies to all: no frame is made as bright as another.
    assert!(said.contains("for all frames:"), "{said}");
    assert!(said.contains("white point 0.8000"), "{said}");
    assert!(second.samples().iter().all(|&white| white == 1.0));
    assert!(first.samples().iter().any(|&white| white < 0.5));
    assert!(is_moved(&third, &second));

    // A tone for each: the second and third are alike, and move with the surface.
    let drawn = |flags: &str| {
        drawn(
            &desk,
            &format!("{sequence} --white-point 1.5 {flags}"),
            [2, 3],
        )
        .0
    };
    let [second, third] = drawn("");
    assert!(is_moved(&third, &second));
    assert!(!is_moved(&second, &second));

    // Fixed strokes stay, as in single pictures.
    let [second, third] = drawn("--motion none");
    let alone = desk.picture(format!(
        "{HATCH} in.0003.exr --tone picture --white-point 1.5"
    ));
    assert_eq!(second, third);
    assert_eq!(third, alone.channels[0]);

    // A flag overrules what the frames show and the name says: they go the other way.
    let [second, third] = drawn("--motion ViewLayer.Vector --motion-convention forward");
    assert!(is_moved(&second, &third));

    // Enlarged, lines move twice as far: 6 pixels to the right and 4 up, but where new ones come in at the border.
    let [second, third] = drawn("--style engraving --enlarge 2");
    assert_eq!(second.width(), 2 * SIZE[0]);
    let difference = |[right, up]: [usize; 2]| {
        let pixels = (40..90).flat_map(|y| (40..150).map(move |x| (x, y)));
        let off = pixels.map(|(x, y)| (third.at(x, y) - second.at(x - right, y + up)).abs());
        off.sum::<f32>() / (110.0 * 50.0)
    };
    let [moved, still] = [difference([6, 4]), difference([0, 0])];
    assert!(5.0 * moved < still, "{moved} {still}");

    // Named by layer; a skipped frame means twice the motion, reported once.
    let gap = "in.####.exr --frames 1-3x2 --tone picture --motion ViewLayer.Vector -o gap.####.png";
    let said = desk.make(format!("{HATCH} {gap}")).stderr;
    assert!(
        said.contains("where frames are left out motion is taken"),
        "{said}"
    );
    assert_eq!(desk.names("gap"), ["gap.0001.png", "gap.0003.png"]);
}

#[test]
fn cameras_tell_the_motion_of_what_stands_still() {
    let desk = Desk::new();
    for number in 1..=3 {
        write_frame(&desk, number, 0.4, With::Camera);
    }
    let tone = "--tone picture --white-point 0.8";
    let sequence = format!("in.####.exr --frames 1-3 --camera cam.#.json {tone}");
    let ([first, second, third], said) = drawn(&desk, &sequence, [1, 2, 3]);
    assert!(said.contains("taken from depth and cameras"), "{said}");
    assert!(is_moved(&second, &first) && is_moved(&third, &second));
    // Without them there is no evidence.
    for number in 1..=2 {
        write_frame(&desk, number, 0.4, With::Nothing);
    }
    let ([first, second], said) = drawn(&desk, &format!("in.####.exr --frames 1-2 {tone}"), [1, 2]);
    assert!(said.contains("strokes lie still in the picture"), "{said}");
    assert_eq!(first, second);
}

#[test]
fn what_is_no_sequence_is_refused_in_one_line() {
    let desk = Desk::new();
    write_frame(&desk, 1, 0.4, With::Motion);
    let rows = "
        in.####.exr -o a.png => 2: give them, as in --frames 1-12
        in.0001.exr -o a.####.png => 2: give them, as in --frames 1-12
        in.0001.exr --frames 1-2 -o a.####.png => 2: IN in.0001.exr has no place
        in.####.exr --frames 1-2 -o a.png => 2: -o a.png has no place
        in.####.exr --frames 2-1 -o a.%d.png => 2: backward
        in.####.exr --frames all -o a.%d.png => 2: no list of frames
        in.0001.exr --motion none -o a.png => 2: --frames
        in.####.exr --frames 1-2 --motion v --motion-convention world -o a.%d.png => 2: render it in pixels
        in.####.exr --frames 1 -o in.####.exr => 2: is the input
        in.####.exr --frames 1 --timings t.json -o a.####.png => 2: one file for all frames
    ";
    desk.check(&format!("{HATCH} {{}}"), rows);
    // A missing frame, and missing motion: earlier frames are done.
    let sequence = format!("{HATCH} in.####.exr --frames 1-2 -o a.####.png");
    let said = desk.run(&sequence).ended(1);
    assert!(said.contains("in.0002.exr: cannot read"), "{said}");
    assert!(desk.has("a.0001.png"));
    write_frame(&desk, 2, 0.4, With::Camera);
    let said = desk.run(format!("{sequence} --motion speed")).ended(1);
    assert!(said.contains("no motion called speed"), "{said}");
}
