//! Contours in scenes with known edges: their positions and widths, one for each edge, and their junctions.

use crate::prelude::*;
use relievo::line::contours::{Contour, ContourKind};
use std::f32::consts::{PI, TAU};

fn drawn_with(frame: &Frame, contours: ContourParams) -> Drawing {
    let line = default_but(|line: &mut LineParams| {
        (line.contours, line.strokes.scale) = (Some(contours), StrokeScale::Factor(1.0));
    });
    cpu::drawn(frame, Tone::Picture, line)
}

fn drawn(frame: &Frame) -> Drawing {
    drawn_with(frame, ContourParams::default())
}

fn ink(drawing: &Drawing) -> &Plane {
    drawing.contours.as_ref().expect("contours were asked for")
}

/// Number of ink runs along a straight line, sampled every tenth of a pixel.
fn runs_of_ink(ink: &Plane, from: Vec2, to: Vec2) -> usize {
    let steps = (10.0 * from.distance(to)) as usize;
    let is_inked = |i: usize| {
        let p = from.lerp(to, i as f32 / steps as f32) - 0.5;
        between(ink, p.x.into(), p.y.into()) > 0.1
    };
    let starts = (1..=steps).filter(|&i| is_inked(i) && !is_inked(i - 1));
    starts.count() + usize::from(is_inked(0))
}

fn length(contour: &Contour) -> f32 {
    let pairs = contour.points.windows(2);
    pairs.map(|pair| pair[0].distance(pair[1])).sum()
}

/// The points every `step` pixels along a line.
fn evenly(contour: &Contour, step: f32) -> Vec<Vec2> {
    let (mut left, mut points) = (0.0, Vec::new());
    for pair in contour.points.windows(2) {
        let length = pair[0].distance(pair[1]);
        while left < length {
            points.push(pair[0].lerp(pair[1], left / length));
            left += step;
        }
        left -= length;
    }
    points
}

/// The least distance of a point from a line.
fn gap(line: &Contour, from: Vec2) -> f32 {
    let distances = line.points.iter().map(|p| p.distance(from));
    distances.fold(f32::INFINITY, f32::min)
}

/// A scene with this surface at a place of the picture.
fn at(place: Vec2, surface: Surface) -> ExactScene {
    ExactScene::orthographic(surface, place.x.into(), place.y.into())
}

const RADIUS: f32 = 60.0;
const CENTER: Vec2 = Vec2::new(80.3, 79.6);

fn disc() -> Frame {
    at(CENTER, Surface::ball(RADIUS.into())).frame(160, 160)
}

/// The coverage of pixels by a disc, of 16 x 16 samples each.
fn coverage_of_disc() -> Plane {
    Plane::from_fn(160, 160, |x, y| {
        let sample = |i: usize| {
            let offset = Vec2::new((i % 16) as f32 + 0.5, (i / 16) as f32 + 0.5) / 16.0;
            (Vec2::new(x as f32, y as f32) + offset).distance(CENTER) < RADIUS
        };
        (0..256).filter(|&i| sample(i)).count() as f32 / 256.0
    })
}

fn farthest_from_circle(contour: &Contour) -> f32 {
    let off = |p: &Vec2| (p.distance(CENTER) - RADIUS).abs();
    contour.points.iter().map(off).fold(0.0, f32::max)
}

#[test]
fn a_disc_is_one_smooth_closed_line() {
    let drawing = drawn(&disc());
    assert_eq!(drawing.contour_lines.len(), 1);
    let line = &drawing.contour_lines[0];
    assert!(line.is_closed() && line.kind == ContourKind::Silhouette);
    // A crack is within half a pixel of the edge between its pixels.
    let off = farthest_from_circle(line);
    assert!(off < 0.5, "{off}");
    // Over s pixels a circle turns by s/R: over 12 pixels by 0.2 rad. With the steps between pixels left in, single
    // turns would be 0 or 0.8 rad.
    let points = evenly(line, 12.0);
    for three in points.windows(3) {
        let turn = (three[1] - three[0]).angle_to(three[2] - three[1]);
        assert!((turn.abs() - 12.0 / RADIUS).abs() < 0.1, "turns by {turn}");
    }
    // Before the background, and almost at one depth: a rim pixel is up to 1 px inside, where the surface is sqrt(R^2 -
    // (R-1)^2) = 11 px nearer than the rim, 2.7 % of the distance of 400. Over 0.4 in the logarithm 40 % of the width
    // are lost: here up to 2.7 %.
    let width = ContourParams::default().width_px;
    assert!(line.widths.iter().all(|&w| w <= width && w > 0.97 * width));
    let sum: f32 = ink(&drawing).samples().iter().sum();
    let expected = TAU * RADIUS * width;
    let is_near = (sum - expected).abs() < 0.03 * expected;
    assert!(is_near, "{sum} of {expected}");
    assert!((length(line) - TAU * RADIUS).abs() < 0.02 * TAU * RADIUS);
}

#[test]
fn alpha_tells_where_between_pixels_the_edge_is() {
    let smooth = Frame {
        alpha: Some(coverage_of_disc()),
        ..disc()
    };
    let line = &drawn(&smooth).contour_lines[0];
    // Sums of coverage along rows or columns miss a slanted edge of slope m by up to m/8 where it leaves the four
    // pixels considered, here never: 1/16 pixel of sampling, plus smoothing.
    let off = farthest_from_circle(line);
    assert!(off < 0.2, "{off}");
}

#[test]
fn one_run_of_ink_on_every_way_across_an_edge() {
    let drawing = drawn(&disc());
    for i in 0..720 {
        let way = Vec2::from_angle(i as f32 * TAU / 720.0);
        let runs = runs_of_ink(ink(&drawing), CENTER + 2.0 * way, CENTER + 75.0 * way);
        assert_eq!(runs, 1, "toward {way}");
    }
}

/// Image positions of the balls of `two_balls(40, 50)`: near and far, with their radii.
fn balls() -> (Frame, [(Vec2, f32); 2]) {
    let (near, far, cx, cy) = (40.0, 50.0, 90.2, 100.4);
    let frame = ExactScene::two_balls(near, far, cx, cy).frame(200, 200);
    let seen = |x: f64, y: f64| Vec2::new((cx + x) as f32, (cy - y) as f32);
    let near_at = seen(-0.7 * near, -0.4 * near);
    let far_at = seen(0.6 * far, 0.4 * far);
    (frame, [(near_at, near as f32), (far_at, far as f32)])
}

#[test]
fn the_nearer_ball_is_outlined_whole_and_the_farther_joins_it() {
    let (frame, [(near, near_radius), (far, far_radius)]) = balls();
    let drawing = drawn(&frame);
    let ink = ink(&drawing);
    for i in 0..360 {
        let way = Vec2::from_angle(i as f32 * PI / 180.0);
        let runs = |edge: Vec2| runs_of_ink(ink, edge - 6.0 * way, edge + 6.0 * way);
        let edge = near + near_radius * way;
        // Near the farther ball's own outline both are crossed.
        if (edge.distance(far) - far_radius).abs() > 9.0 {
            assert_eq!(runs(edge), 1, "near ball, {i} degrees");
        }
        let edge = far + far_radius * way;
        if edge.distance(near) > near_radius + 9.0 {
            assert_eq!(runs(edge), 1, "far ball, {i} degrees");
        } else if edge.distance(near) < near_radius - 9.0 {
            assert_eq!(runs(edge), 0, "hidden, {i} degrees");
        }
    }
    // Two lines: around the near ball, closed; around the far one, both ends on the near one's edge.
    let lines = drawing.contour_lines.iter();
    let (whole, part): (Vec<_>, Vec<_>) = lines.partition(|line| line.is_closed());
    assert_eq!((whole.len(), part.len()), (1, 1));
    for point in &whole[0].points {
        assert!((point.distance(near) - near_radius).abs() < 0.7, "{point}");
    }
    let ends = [part[0].points[0], part[0].points[part[0].points.len() - 1]];
    for end in ends {
        let gap = gap(whole[0], end);
        assert!(gap < 0.8, "an end {gap} px off the near ball's line");
    }
    // The near ball's line is the heavier one.
    let mean = |line: &Contour| line.widths.iter().sum::<f32>() / line.widths.len() as f32;
    assert!(mean(whole[0]) > 1.05 * mean(part[0]));
}

/// Unit directions, in rows that run down, of the edges that meet in a corner.
fn edges(block: bool, roll: f32) -> [Vec2; 3] {
    // Faces lean toward roll + 90 degrees and thirds of a turn from there; edges of a block run opposite to
    // the faces, those of a room along them.
    let first = roll + if block { -PI / 2.0 } else { PI / 2.0 };
    [0.0, 1.0, 2.0].map(|i| {
        let (sin, cos) = (first + i * TAU / 3.0).sin_cos();
        Vec2::new(cos, -sin)
    })
}

#[test]
fn three_straight_creases_meet_in_a_corner() {
    let corner = Vec2::new(80.3, 78.9);
    for (block, roll) in [(true, 0.0_f32), (true, 0.3), (false, 0.0), (false, 0.45)] {
        let [x, y] = corner.as_dvec2().to_array();
        let scene = ExactScene::box_corner(block, roll.into(), x, y);
        let drawing = drawn(&scene.frame(160, 160));
        let lines = &drawing.contour_lines;
        let lengths: Vec<f32> = lines.iter().map(length).collect();
        assert_eq!(lines.len(), 3, "{block} {roll}: {lengths:?}");
        let edges = edges(block, roll);
        for line in lines {
            assert_eq!(line.kind, ContourKind::Crease);
            // The point farthest out shows which edge it is.
            let points = line.points.iter();
            let out = points.max_by(|a, b| a.distance(corner).total_cmp(&b.distance(corner)));
            let way = (*out.unwrap() - corner).normalize();
            let edges = edges.iter();
            let edge = edges.max_by(|a, b| a.dot(way).total_cmp(&b.dot(way)));
            let edge = edge.unwrap();
            for &point in &line.points {
                let off = (point - corner).perp_dot(*edge).abs();
                assert!(off < 0.5, "{block} {roll}: {point} is {off} off");
            }
            let gap = gap(line, corner);
            assert!(gap < 0.7, "{block} {roll}: ends {gap} px from the corner");
        }
        for edge in edges {
            for along in 10..70 {
                let (at, across) = (corner + along as f32 * edge, 5.0 * edge.perp());
                let runs = runs_of_ink(ink(&drawing), at - across, at + across);
                assert_eq!(runs, 1, "{block} {roll}: {along} px along {edge}");
            }
        }
    }
}

/// This frame with the other one's surface where that is nearer.
fn before(far: Frame, near: &Frame) -> Frame {
    let [depths, nearer] = [&far, near].map(|frame| frame.depth.clone().unwrap());
    let hides = |x, y| near.mask.at(x, y) && nearer.at(x, y) < depths.at(x, y);
    let of = |a: &Plane, b: &Plane| {
        let at = |x, y| if hides(x, y) { b.at(x, y) } else { a.at(x, y) };
        Plane::from_fn(a.width(), a.height(), at)
    };
    let (a, b) = (&far.normal, &near.normal);
    let [x, y, z] = [(&a.x, &b.x), (&a.y, &b.y), (&a.z, &b.z)].map(|(a, b)| of(a, b));
    Frame {
        normal: Vector3Planes { x, y, z },
        depth: Some(of(&depths, &nearer)),
        ..far
    }
}

#[test]
fn an_edge_goes_on_behind_a_ball() {
    // A ball of 14 pixels hides the edge of a block from 40 to 68 pixels away from its corner. The edge leaves the picture 81.3 pixels away: the part beyond the ball has a length of 13, too
    // short for a crease of its own.
    let (corner, radius) = (Vec2::new(80.3, 78.7), 14.0);
    let edge = Vec2::Y;
    let block = ExactScene::box_corner(true, 0.0, corner.x.into(), corner.y.into());
    let middle = corner + 54.0 * edge;
    let ball = at(middle, Surface::ball(radius.into()));
    let ball = ball
        .at_distance(0.9 * Surface::DISTANCE - 120.0)
        .frame(160, 160);
    let drawing = drawn(&before(block.frame(160, 160), &ball));
    let is_on_edge = |line: &&Contour| {
        let along = |p: &Vec2| (*p - corner).dot(edge) > -1.0 && (p.x - corner.x).abs() < 0.6;
        line.kind == ContourKind::Crease && line.points.iter().all(along)
    };
    let parts: Vec<&Contour> = drawing.contour_lines.iter().filter(is_on_edge).collect();
    assert_eq!(parts.len(), 2);
    for part in parts {
        // No point is behind the ball, and the nearest is on its outline.
        let distances: Vec<f32> = part.points.iter().map(|p| p.distance(middle)).collect();
        let nearest = gap(part, middle);
        assert!((nearest - radius).abs() < 0.6, "{nearest}");
        // The end there is as heavy as the rest: an open one has a quarter of the width.
        let end = distances.iter().position(|&distance| distance == nearest);
        let end = end.unwrap();
        assert!(end == 0 || end + 1 == distances.len());
        let (width, usual) = (part.widths[end], part.widths[part.widths.len() / 2]);
        assert!(width > 0.9 * usual, "{width} of {usual}");
    }
}

#[test]
fn depth_that_a_filter_spread_gives_the_same_single_line() {
    // A disc one quarter of the distance before a wall, its border pixels mixed by coverage.
    let (near, far) = (Surface::DISTANCE, 1.25 * Surface::DISTANCE);
    let wall = at(Vec2::splat(80.0), Surface::plane(DVec3::Z)).frame(160, 160);
    let coverage = coverage_of_disc();
    for spread in [false, true] {
        let share = |c: f32| if spread { c } else { c.round() };
        let depth = coverage.map(|c| far as f32 + share(c) * (near - far) as f32);
        let frame = Frame {
            depth: Some(depth),
            camera: None,
            ..wall.clone()
        };
        let drawing = drawn(&frame);
        assert_eq!(drawing.contour_lines.len(), 1, "spread: {spread}");
        let line = &drawing.contour_lines[0];
        assert!(line.is_closed());
        let off = farthest_from_circle(line);
        assert!(off < 0.6, "spread: {spread}, {off} off");
    }
}

#[test]
fn mirrored_and_turned_frames_give_mirrored_and_turned_drawings() {
    let corner = ExactScene::box_corner(true, 0.3, 80.3, 78.9).frame(160, 150);
    for (name, frame) in [("disc", disc()), ("balls", balls().0), ("corner", corner)] {
        let drawing = drawn(&frame);
        let mirror = drawn(&mirrored(&frame));
        let turned = drawn(&quarter_turned(&frame));
        // Silhouettes are equal to rounding, but are divided into pieces from another end, each within 0.03 px of the
        // line. Bands two pixels wide are thinned to one of the two, whose neighbours differ: a crease moves by up to a
        // tenth of a pixel. A line moved by d changes 2 d of ink per pixel of length.
        let all: f32 = drawing.contour_lines.iter().map(length).sum();
        for (case, other) in [
            (mirrored_plane(ink(&drawing)), mirror),
            (quarter_turned_plane(ink(&drawing)), turned),
        ] {
            let pairs = case.samples().iter().zip(ink(&other).samples());
            let apart: Vec<f32> = pairs.map(|(a, b)| (a - b).abs()).collect();
            let sum: f32 = apart.iter().sum();
            // The share of pixels that differ by more than a fifth.
            let far = apart.iter().filter(|&&d| d > 0.2).count() as f32 / apart.len() as f32;
            let is_near = sum < 2.0 * 0.1 * all && far < 2e-4;
            assert!(is_near, "{name}: {sum} over {all} px, {far} far apart");
        }
    }
}

#[test]
fn specks_are_left_out_unless_asked_for() {
    let ball = disc();
    let is_seen = |x, y| ball.mask.at(x, y) && (x, y) != (80, 80);
    let speckled = masked(ball.clone(), is_seen);
    assert_eq!(drawn(&speckled).contour_lines.len(), 1);
    let params = default_but(|params: &mut ContourParams| params.shortest_px = 0.0);
    assert_eq!(drawn_with(&speckled, params).contour_lines.len(), 2);
}

#[test]
fn lines_run_off_the_picture() {
    // The upper half is covered: one line from border to border, of full width to the last pixel.
    let wall = at(Vec2::splat(20.0), Surface::plane(DVec3::Z)).frame(60, 40);
    let drawing = drawn(&masked(wall.clone(), |_, y| y < 20));
    assert_eq!(drawing.contour_lines.len(), 1);
    for x in [0, 30, 59] {
        // Two pixels wide, on the crack between rows 19 and 20.
        for (y, expected) in [(18, 0.0), (19, 1.0), (20, 1.0), (21, 0.0)] {
            let c = ink(&drawing).at(x, y);
            assert!((c - expected).abs() < 1e-3, "({x}, {y}): {c}");
        }
    }
}

/// A grey wall of 200 by 120 pixels, at these depths.
fn wall(depth: impl Fn(usize, usize) -> f32) -> Frame {
    let normal = Vector3Planes::from_fn(200, 120, |_, _| DVec3::Z);
    Frame {
        depth: Some(Plane::from_fn(200, 120, depth)),
        color: Some(ColorPlanes::grey(Plane::filled(200, 120, 0.5))),
        ..Frame::of_normals(normal, Mask::full(200, 120))
    }
}

/// A wall of two objects that touch along a slanted line, with a shelf before its lower half, which is a third object.
fn objects_in_a_plane() -> Frame {
    let object = |x: usize, y: usize| match slanted(y as f32 + 0.5) {
        _ if y >= 60 => 3.0,
        border if x as f32 + 0.5 < border => 1.0,
        _ => 2.0,
    };
    Frame {
        objects: Some(Plane::from_fn(200, 120, object)),
        ..wall(|_, y| if y < 60 { 400.0 } else { 300.0 })
    }
}

fn slanted(y: f32) -> f32 {
    80.0 + 0.3 * y
}

#[test]
fn objects_in_one_plane_have_a_line_between_them_and_none_beside_a_silhouette() {
    let frame = objects_in_a_plane();
    for times in [1.0, 3.0] {
        let params = ContourParams::default().enlarged(times);
        let enlarged = frame.enlarged(f64::from(times));
        let drawing = drawn_with(&enlarged, params);
        let kinds: Vec<ContourKind> = drawing.contour_lines.iter().map(|line| line.kind).collect();
        assert_eq!(kinds, [ContourKind::Silhouette, ContourKind::Object]);
        let line = &drawing.contour_lines[1];
        // Steps between pixels of the frame are half a pixel off at most, and a little more by smoothing at the ends.
        let off = |p: &Vec2| (p.x / times - slanted(p.y / times)).abs();
        let farthest = line.points.iter().map(off).fold(0.0, f32::max);
        assert!(farthest < 0.8, "{farthest}");
        // From the border of the picture, beyond which it goes on, to the silhouette along row 60.
        let ends = line.points.iter().map(|p| p.y / times);
        let least = ends.clone().fold(f32::INFINITY, f32::min);
        let most = ends.fold(f32::NEG_INFINITY, f32::max);
        let are_there = least < 0.0 && (59.0..61.0).contains(&most);
        assert!(are_there, "{least} {most}");
        // As wide as the line of a middling jump at the depth of the wall: depths from 300 to 400 are .2877 of the .4 over
        // which lines lose most.
        let far = 1.0 - params.depth_emphasis * (400.0_f32 / 300.0).ln() / 0.4;
        let expected = params.width_px * far * (1.0 - 0.5 * params.jump_emphasis);
        let middle = line.widths[line.widths.len() / 2];
        assert!((middle - expected).abs() < 0.02, "{middle} of {expected}");
        let off = ContourParams {
            object_lines: ObjectLines::Off,
            ..params
        };
        let without = drawn_with(&enlarged, off);
        assert_eq!(without.contour_lines, drawing.contour_lines[..1]);
    }
    let none = Frame {
        objects: None,
        ..objects_in_a_plane()
    };
    assert_eq!(drawn(&none).contour_lines.len(), 1);
}

/// Radius of the holes of [`plate`] in pixels, and their centres.
const HOLE: f32 = 13.0;
const HOLES: [Vec2; 3] = [
    Vec2::new(40.3, 45.7),
    Vec2::new(100.0, 80.0),
    Vec2::new(160.6, 38.2),
];

/// A plate with holes through which a wall just behind it is seen: 2 % farther, a gap of 5 pixels where the likely focal
/// length is 250.
fn plate() -> Frame {
    let is_hole = |x: usize, y: usize| {
        let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        HOLES.iter().any(|hole| hole.distance(at) < HOLE)
    };
    wall(|x, y| if is_hole(x, y) { 102.0 } else { 100.0 })
}

#[test]
fn rims_of_holes_are_whole_however_large_the_drawing() {
    for times in [1.0, 4.0] {
        let params = ContourParams::default().enlarged(times);
        let enlarged = plate().enlarged(f64::from(times));
        let drawing = drawn_with(&enlarged, params);
        assert_eq!(drawing.contour_lines.len(), HOLES.len(), "{times}");
        for hole in HOLES {
            let on_rim = |i: u32| hole + HOLE * Vec2::from_angle(TAU * i as f32 / 360.0);
            let points = || drawing.contour_lines.iter().flat_map(|line| &line.points);
            let is_drawn = |at: Vec2| points().any(|p| (*p / times).distance(at) < 1.0);
            let share = (0..360).filter(|&i| is_drawn(on_rim(i))).count() as f32 / 360.0;
            assert!(share >= 0.95, "{times}: {share} of the rim at {hole}");
        }
    }
}
