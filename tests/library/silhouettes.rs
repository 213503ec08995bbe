//! Silhouettes: gaps between surfaces, and nothing else.

use crate::common::curved::deep;
use crate::prelude::*;

const SIDE: usize = 200;

/// The weights drawn in a frame, and its conductance.
fn silhouettes(frame: &Frame) -> [Plane; 2] {
    let shape = cpu::described(frame, ShapeParams::default()).shape;
    [shape.silhouette.unwrap(), shape.conductance.unwrap()]
}

/// A frame of `SIDE` columns and rows, of the normal and the depth at the middle of each pixel; nothing at depth 0.
fn frame(projection: Option<Projection>, at: impl Fn(f64, f64) -> (DVec3, f64)) -> Frame {
    let here = |x: usize, y: usize| at(x as f64 + 0.5, y as f64 + 0.5);
    let normal = Vector3Planes::from_fn(SIDE, SIDE, |x, y| here(x, y).0);
    let depth = Plane::from_fn(SIDE, SIDE, |x, y| here(x, y).1 as f32);
    let mut frame = Frame::of_normals(normal, Mask::new(depth.map(|depth| depth != 0.0)));
    frame.depth = Some(depth);
    frame.camera = projection.map(|projection| Camera {
        view_from_world: DAffine3::IDENTITY,
        projection,
    });
    frame
}

const CENTER: f64 = SIDE as f64 / 2.0;

fn perspective(focal: f64) -> Projection {
    let (fx, fy, cx, cy) = (focal, focal, CENTER, CENTER);
    Projection::Perspective { fx, fy, cx, cy }
}

fn parallel(scale: f64) -> Projection {
    let (sx, sy, cx, cy) = (scale, scale, CENTER, CENTER);
    Projection::Orthographic { sx, sy, cx, cy }
}

/// A ball of radius 60 at the middle, at `distance`, before a wall 40 behind it: in pixels at the ball.
fn ball(in_perspective: bool, distance: f64) -> Frame {
    let mut scene = ExactScene::orthographic(Surface::ball(60.0), CENTER, CENTER);
    let wall = Surface::plane(DVec3::Z).moved(DVec3::new(0.0, 0.0, -100.0));
    scene.surfaces.push(wall);
    scene = scene.at_distance(distance);
    if in_perspective {
        // With pixels of that size at the ball: a focal length of the distance.
        scene = deep(&scene, distance / 3.0);
    }
    scene.frame(SIDE, SIDE)
}

#[test]
fn a_floor_has_none_however_grazing_and_bumpy() {
    // The floor n . P = -1 with its horizon in row 20, seen with these focal lengths: at depth -1 / (n . line).
    let floor = |focal: f64, projection| {
        let upright = DVec3::new(0.0, focal, 80.0).normalize();
        let ahead = DVec3::new(0.0, -upright.z, upright.y);
        frame(projection, |x, y| {
            let line = DVec3::new((x - 100.0) / focal, (100.0 - y) / focal, -1.0);
            let below = -upright.dot(line);
            let (sine, cosine) = (0.9 * x + 0.7 * y).sin_cos();
            // 11 degrees from upright.
            let normal = upright + 0.2 * (sine * DVec3::X + cosine * ahead);
            let depth = if below > 1e-6 { 1.0 / below } else { 0.0 };
            (normal.normalize(), depth)
        })
    };
    // An unknown lens is taken for one of 250 pixels here.
    let known = Some(perspective(250.0));
    for (focal, projection) in [(250.0, known), (250.0, None), (325.0, None)] {
        let [weights, _] = silhouettes(&floor(focal, projection));
        for y in 22..SIDE - 1 {
            let row = &weights.row(y)[1..SIDE - 1];
            assert!(row.iter().all(|&weight| weight == 0.0), "{focal}, row {y}");
        }
    }
}

#[test]
fn a_ball_before_a_wall_has_its_outline_at_any_distance_in_one_pixel() {
    for distance in [300.0, 1000.0, 5000.0, 30_000.0] {
        for in_perspective in [true, false] {
            let frame = ball(in_perspective, distance);
            let depth = frame.depth.as_ref().unwrap();
            let is_wall = |x: usize, y: usize| f64::from(depth.at(x, y)) > distance + 99.0;
            let [weights, conductance] = silhouettes(&frame);
            let (mut outline, mut drawn) = (0, 0);
            for (x, y) in places(SIDE - 2, SIDE - 2).map(|(x, y)| (x + 1, y + 1)) {
                let beside = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
                let differs = beside.iter().any(|&(i, j)| is_wall(i, j) != is_wall(x, y));
                let is_front = differs && !is_wall(x, y);
                let is_drawn = !is_front || weights.at(x, y) == 1.0;
                let is_cut = !differs || conductance.at(x, y) == 0.0;
                assert!(
                    is_drawn && is_cut,
                    "{distance}, {in_perspective} at {x}, {y}"
                );
                outline += usize::from(is_front);
                drawn += usize::from(weights.at(x, y) > 0.0);
            }
            let is_whole = outline > 300 && drawn == outline;
            assert!(
                is_whole,
                "{distance}, {in_perspective}: {drawn} of {outline}"
            );
        }
    }
}

#[test]
fn mirrored_and_transposed_frames_have_the_same_to_the_bit() {
    let at = |in_perspective: bool, swap: bool, sign: f64| {
        let own = ball(in_perspective, 300.0);
        let (normal, depth) = (own.normal.clone(), own.depth.clone().unwrap());
        frame(own.camera.map(|camera| camera.projection), move |x, y| {
            let x = if sign < 0.0 { SIDE as f64 - x } else { x };
            let [x, y] = if swap { [y, x] } else { [x, y] };
            let (i, j) = (x as usize, y as usize);
            let [nx, ny, nz] = normal.at(i, j).to_array();
            let (nx, ny) = if swap { (-ny, -nx) } else { (nx, ny) };
            // Noise, which thresholds follow.
            let noise = f64::from((i * 7 + j * 13) as u32 % 11);
            let depth = f64::from(depth.at(i, j)) + noise;
            (DVec3::new(sign * nx, ny, nz), depth)
        })
    };
    for in_perspective in [true, false] {
        let of = |swap, sign| silhouettes(&at(in_perspective, swap, sign));
        let own = of(false, 1.0);
        let mut weights = own[0].samples().iter();
        assert!(weights.any(|&weight| weight > 0.0 && weight < 1.0));
        let (mirrored, transposed) = (of(false, -1.0), of(true, 1.0));
        for k in 0..2 {
            for (x, y) in places(SIDE, SIDE) {
                let here = own[k].at(x, y).to_bits();
                assert_eq!(mirrored[k].at(SIDE - 1 - x, y).to_bits(), here, "{x}, {y}");
                assert_eq!(transposed[k].at(y, x).to_bits(), here, "{x}, {y}");
            }
        }
    }
}

#[test]
fn rounding_of_depth_is_none() {
    // A plane at 80 degrees to the picture, around depth 5000, where half floats are 4 apart.
    let slope = 80.0_f64.to_radians();
    let normal = DVec3::new(-slope.sin(), 0.0, slope.cos());
    let mut frame = frame(Some(parallel(1.0)), |x, _| {
        let depth = 5000.0 - (x - 100.0) * slope.tan();
        (normal, half::f16::from_f64(depth).to_f64())
    });
    let drawn = |frame: &Frame| {
        let [weights, _] = silhouettes(frame);
        let inside = weights.row(100)[1..SIDE - 1].iter();
        inside.filter(|&&weight| weight > 0.0).count()
    };
    // Of an error of 2 in each depth, 4 cos 80 = 0.7 pixels are off the plane: below the least threshold. At ten times
    // the pixels per unit they are above.
    frame.source.depth_rounding = [f32::from(half::f16::EPSILON) / 2.0, 0.0];
    assert_eq!(drawn(&frame), 0);
}

#[test]
fn thresholds_rise_by_the_noise_of_depth() {
    let noise = |x: f64, y: f64| {
        let hash = (x as u64).wrapping_mul(2_654_435_761) ^ (y as u64).wrapping_mul(40_503_917);
        f64::from((hash.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as u32 % 1000) / 1000.0
    };
    let frame = frame(Some(parallel(1.0)), |x, y| {
        let noise = if x < 100.0 { 0.0 } else { 10.0 * noise(x, y) };
        (DVec3::Z, 500.0 + noise)
    });
    let [weights, _] = silhouettes(&frame);
    let marked = (1..SIDE - 1).flat_map(|y| weights.row(y)[120..SIDE - 1].to_vec());
    let [drawn, all] = [
        marked.clone().filter(|&weight| weight > 0.0).count(),
        marked.count(),
    ];
    let share = drawn as f64 / all as f64;
    // Two numbers up to 10 differ by more than d in (1 - d / 10)^2 of all pairs: by 1.6 pixels, where silhouettes begin, in
    // 70 %. Four times the noise, about 1.75 pixels, on top leave 2 % of two pairs to each pixel.
    assert!(share < 0.06, "{share}");
}
