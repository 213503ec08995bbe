//! Normal-ray principal directions against surfaces whose curvatures are known exactly.

use crate::common::curved::*;
use crate::prelude::*;

/// The direction layer of `frame`, and conductance.
fn directions(frame: &Frame, step: Adaptive) -> (Vector2Planes, Plane) {
    let shape = ShapeParams {
        scale: Scale::Iterations(0),
        direction_step: step,
        ..ShapeParams::default()
    };
    let shape = cpu::described(frame, shape).shape;
    (shape.direction.unwrap(), shape.conductance.unwrap())
}

/// The exact direction, in the picture, of the curvature larger in size; `None` where the two differ by
/// less than a twentieth of their sum.
fn expected(exact: &Exact, projection: Projection) -> Option<DVec2> {
    Some(curved_along(exact, projection, 0.05)?[0])
}

/// Whether a pixel and a neighbour along either axis are open: at a corner of edges the direction comes from its
/// neighbours.
fn has_rays(conductance: &Plane, x: usize, y: usize) -> bool {
    let (width, height) = (conductance.width(), conductance.height());
    let open = |x: usize, y: usize| x < width && y < height && conductance.at(x, y) > 0.0;
    let (left, above) = (x.wrapping_sub(1), y.wrapping_sub(1));
    open(x, y) && (open(left, y) || open(x + 1, y)) && (open(x, above) || open(x, y + 1))
}

/// Sorted angles in degrees between found and expected directions, over pixels with rays whose normal faces
/// the viewer with more than 0.35, as measured against the sight line.
fn errors_deg(scene: &ExactScene, frame: &Frame, step: Adaptive) -> Vec<f64> {
    let (found, conductance) = directions(frame, step);
    let mut errors = Vec::new();
    for (x, y) in places(frame.mask.width(), frame.mask.height()) {
        let t = direction_at(&found, x, y);
        assert!(t.is_finite(), "({x}, {y}): {t}");
        let unit = (t.length() - 1.0).abs() < 1e-6;
        assert!(unit == frame.mask.at(x, y), "({x}, {y}): {t}");
        let exact = scene.exact(x, y).filter(|_| has_rays(&conductance, x, y));
        let exact = exact.filter(|exact| facing(scene, exact, x, y) >= 0.35);
        if let Some(e) = exact.and_then(|exact| expected(&exact, scene.projection)) {
            errors.push(t.perp_dot(e).abs().asin().to_degrees());
        }
    }
    sorted(errors)
}

/// Scenes of about `radius` pixels, orthographic, off the pixel grid.
fn scenes(radius: f64) -> Vec<(&'static str, ExactScene)> {
    let axes = DVec3::new(1.0, 0.7, 0.5) * radius;
    let tilted = DVec3::new(0.6, 0.5, 0.45);
    let saddle = Surface::saddle(0.7 / radius, -0.4 / radius, 0.4);
    let surfaces = [
        ("ellipsoid", Surface::ellipsoid(axes, DMat3::IDENTITY)),
        ("turned ellipsoid", ellipsoid(radius)),
        ("torus", torus(radius)),
        (
            "upright cylinder",
            Surface::cylinder(0.8 * radius, DVec3::Y),
        ),
        ("tilted cylinder", Surface::cylinder(0.7 * radius, tilted)),
        ("saddle", saddle),
    ];
    let at = |(name, surface)| (name, in_the_middle(surface, radius, side(radius)));
    surfaces.map(at).into()
}

fn side(radius: f64) -> usize {
    (2.2 * radius) as usize
}

fn framed(scene: &ExactScene, radius: f64) -> Frame {
    scene.frame(side(radius), side(radius))
}

/// Depth, normals with the camera, normals alone.
fn sources(frame: &Frame) -> [(&'static str, Frame); 3] {
    let from_normals = without_depth(frame.clone());
    let alone = Frame {
        camera: None,
        ..from_normals.clone()
    };
    [
        ("depth", frame.clone()),
        ("normals", from_normals),
        ("normals alone", alone),
    ]
}

#[test]
fn directions_are_exact_to_the_second_order() {
    let names = scenes(1.0).into_iter().map(|(name, _)| name);
    let views = names.flat_map(|name| [(name, true), (name, false)]);
    for (name, flat) in views.filter(|&(name, flat)| flat || name != "saddle") {
        let mut before: [Option<f64>; 3] = [None; 3];
        for radius in [32.0, 64.0, 128.0] {
            let mut scenes = scenes(radius).into_iter();
            let (_, scene) = scenes.find(|(n, _)| *n == name).unwrap();
            let scene = if flat { scene } else { deep(&scene, radius) };
            let frame = framed(&scene, radius);
            for (i, (source, frame)) in sources(&frame).into_iter().enumerate() {
                // Without a camera sight lines are taken for parallel.
                if source == "normals alone" && !flat {
                    continue;
                }
                let errors = errors_deg(&scene, &frame, Adaptive::Auto);
                let count = errors.len();
                assert!(count as f64 > 0.3 * radius * radius, "{name}: {count}");
                let p95 = quantile(&errors, 0.95);
                // A quarter per doubling, down to the rounding of f32: 3e-8 over a turn of 2/128 is
                // 1e-4 degrees, and depth's own rounding at three radii, 3e-5 px of 2, 1e-3.
                let case = format!("{name} from {source} at {radius}, flat {flat}");
                if let Some(coarser) = before[i] {
                    let bound = (coarser / 3.0).max(1.5e-3);
                    assert!(p95 < bound, "{case}: {p95}, after {coarser}");
                }
                before[i] = Some(p95);
                // Of a cylinder no error is larger, at any radius.
                let largest = quantile(&errors, 1.0);
                let is_cylinder = name.contains("cylinder");
                assert!(!is_cylinder || largest < 0.01, "{case}: {largest} degrees");
                assert!(radius < 128.0 || p95 < 0.08, "{case}: {p95} degrees");
            }
        }
    }
}

#[test]
fn coarse_normals_are_compared_farther_away() {
    for radius in [32.0, 64.0, 128.0, 256.0] {
        for (name, scene) in scenes(radius) {
            let frame = without_depth(framed(&scene, radius));
            let in_half = |v| half::f16::from_f32(v).to_f32();
            let half = rounded(frame.clone(), 1.0 / 4096.0, in_half);
            // Measured: p95 of at most 7.1 and 1.9.
            for (stored, frame, bound) in [("8 bits", in_8_bits(frame), 8.0), ("half", half, 2.0)] {
                let errors = errors_deg(&scene, &frame, Adaptive::Auto);
                let p95 = quantile(&errors, 0.95);
                assert!(p95 < bound, "{name} of {radius} px, {stored}: {p95}");
            }
        }
    }
}

#[test]
fn balls_and_planes_take_the_fixed_axis_and_show_no_noise() {
    for radius in [40.0, 150.0, 2000.0] {
        let ball = ExactScene::orthographic(Surface::ball(radius), 80.3, 79.6);
        let deep_ball = deep(&ball.clone().at_distance(3.0 * radius), radius);
        let plane = Surface::plane(DVec3::new(0.5, -0.3, 0.8));
        let plane = ExactScene::orthographic(plane, 80.0, 80.0);
        for scene in [ball, deep_ball, plane.clone(), plane.in_perspective()] {
            let frame = scene.frame(160, 160);
            let flat = without_depth(frame.clone());
            for frame in [flat.clone(), in_8_bits(flat), frame] {
                let (found, _) = directions(&frame, Adaptive::Auto);
                // x crossed with the normal is (0, -n_z, n_y): upright in a parallel projection, and in
                // perspective turned by n_y X / n_z at the most; 1 degree from a pixel to the next
                // but for the last row before the rim, where n_z falls to 0.
                let turn = largest_turn_deg(&found, &frame);
                let parallel = matches!(scene.projection, Projection::Orthographic { .. });
                let bound = if parallel { 1e-3 } else { 12.0 };
                assert!(turn < bound, "{radius}: {turn} degrees");
            }
        }
    }
}

#[test]
fn an_umbilic_takes_its_neighbours_direction() {
    // A capsule: the cylinder of radius 60 around y continues in balls at its ends.
    let frame = {
        let tube = ExactScene::orthographic(Surface::cylinder(60.0, DVec3::X), 100.0, 100.0);
        let mut frame = tube.frame(200, 200);
        let ends = |x: f64| (x - 100.0).abs() - 40.0;
        for (x, y) in places(200, 200) {
            let (px, py) = (x as f64 + 0.5 - 100.0, 100.0 - (y as f64 + 0.5));
            let out = ends(x as f64 + 0.5).max(0.0).copysign(px);
            let square = 3600.0 - py * py - out * out;
            if square > 0.0 {
                let n = DVec3::new(out, py, square.sqrt()) / 60.0;
                set_normal(&mut frame.normal, x, y, n.as_vec3());
            }
        }
        without_depth(frame.clone())
    };
    let (found, _) = directions(&frame, Adaptive::Auto);
    // Across the axis on the tube; on the caps also across, from their neighbours, as far as the waves reach from the
    // seam: along the middle row all the way.
    for x in 45..155 {
        let t = direction_at(&found, x, 100);
        assert!(t.x.abs() < 0.02, "({x}, 100): {t}");
    }
    // Not the fixed direction by chance: rotated by a quarter turn, it is the other axis.
    let turned = quarter_turned(&frame);
    let (found, _) = directions(&turned, Adaptive::Auto);
    for y in 45..155 {
        let t = direction_at(&found, 100, y);
        assert!(t.y.abs() < 0.02, "(100, {y}): {t}");
    }
}

#[test]
fn a_wide_plane_is_no_patchwork_of_its_rims() {
    // A block with its edges rounded at 20 px, 200 px of plane between them, tilted in the picture.
    let profile = |d: f64| ((d.abs() - 100.0).max(0.0) / 20.0).min(0.9).copysign(d);
    let turn = DMat3::from_rotation_z(0.5);
    let normal = |x: usize, y: usize| {
        let p = turn.transpose() * DVec3::new(x as f64 - 150.0, 150.0 - y as f64, 0.0);
        let (a, b) = (profile(p.x), profile(p.y));
        turn * DVec3::new(a, b, (1.0 - a * a - b * b).max(0.05).sqrt()).normalize()
    };
    let plane = ExactScene::orthographic(Surface::plane(DVec3::Z), 150.0, 150.0);
    let mut frame = plane.frame(300, 300);
    frame.normal = Vector3Planes::from_fn(300, 300, normal);
    let (found, _) = directions(&without_depth(frame.clone()), Adaptive::Auto);
    // On the rounding the direction is across the edge; farther than 16 px inside, upright.
    let across = turn * DVec3::X;
    let at_place = |a: f64| {
        let p = DVec3::new(150.0, 150.0, 0.0) + DVec3::new(across.x, -across.y, 0.0) * a;
        direction_at(&found, p.x.round() as usize, p.y.round() as usize)
    };
    assert!(angle_deg(at_place(108.0), across.truncate()) < 3.0);
    assert!(angle_deg(at_place(98.0), across.truncate()) < 20.0);
    for a in [-80.0, -40.0, 0.0, 40.0, 80.0] {
        let t = at_place(a);
        assert!(angle_deg(t, DVec2::Y) < 1e-3, "{a}: {t}");
    }
}

#[test]
fn turned_and_mirrored_pictures_give_turned_and_mirrored_directions() {
    for (name, flat) in scenes(48.0) {
        let in_depth = deep(&flat, 48.0);
        for scene in [flat, in_depth] {
            let frame = framed(&scene, 48.0);
            for frame in [without_depth(frame.clone()), frame] {
                let (plain, open) = directions(&frame, Adaptive::Auto);
                let (flipped, _) = directions(&mirrored(&frame), Adaptive::Auto);
                let (turned, _) = directions(&quarter_turned(&frame), Adaptive::Auto);
                let (width, height) = (frame.mask.width(), frame.mask.height());
                for (x, y) in places(width, height) {
                    // Pixels' own directions; where two curvatures are equal in magnitude either may win.
                    let exact = scene.exact(x, y).filter(|_| open.at(x, y) > 0.0);
                    if exact.and_then(|e| expected(&e, scene.projection)).is_none() {
                        continue;
                    }
                    let t = direction_at(&plain, x, y);
                    let mirror = direction_at(&flipped, width - 1 - x, y);
                    let turn = direction_at(&turned, y, width - 1 - x);
                    for (found, wanted) in [(mirror, DVec2::new(-t.x, t.y)), (turn, t.perp())] {
                        let angle = angle_deg(found, wanted);
                        assert!(angle < 1e-3, "{name} at ({x}, {y}): {angle} degrees");
                    }
                }
            }
        }
    }
}

#[test]
fn nothing_is_taken_across_a_silhouette() {
    // A cylinder before another at right angles: on each the direction is across its own axis, up to
    // the edge between them, with the widest of steps.
    let near = Surface::cylinder(30.0, DVec3::Y).moved(DVec3::new(0.0, 0.0, 100.0));
    let scene = ExactScene {
        surfaces: vec![near, Surface::cylinder(60.0, DVec3::X)],
        ..ExactScene::orthographic(near, 80.0, 80.0)
    };
    let frame = scene.frame(160, 160);
    let (found, open) = directions(&frame, Adaptive::Fixed(8.0));
    let mut tested = [0; 2];
    for (x, y) in places(160, 160) {
        let Some(exact) = scene.exact(x, y).filter(|_| open.at(x, y) > 0.0) else {
            continue;
        };
        let across = [DVec2::X, DVec2::Y][exact.surface];
        let angle = angle_deg(direction_at(&found, x, y), across);
        assert!(angle < 0.01, "({x}, {y}): {angle} degrees");
        tested[exact.surface] += 1;
    }
    assert!(tested.iter().all(|&count| count > 4000), "{tested:?}");
}

#[test]
fn the_unit_of_length_changes_nothing() {
    for (name, scene) in scenes(48.0) {
        let scene = deep(&scene, 48.0);
        let frame = framed(&scene, 48.0);
        let (plain, open) = directions(&frame, Adaptive::Auto);
        for unit in [1e-3_f32, 0.37, 1e3] {
            let scaled = Frame {
                depth: frame.depth.as_ref().map(|depth| depth.map(|d| d * unit)),
                ..frame.clone()
            };
            let (found, _) = directions(&scaled, Adaptive::Auto);
            for (x, y) in places(open.width(), open.height()) {
                let exact = scene.exact(x, y).filter(|_| open.at(x, y) > 0.0);
                if exact.and_then(|e| expected(&e, scene.projection)).is_some() {
                    // Depth is rounded again.
                    let angle = angle_deg(direction_at(&found, x, y), direction_at(&plain, x, y));
                    let case = format!("{name} in units of {unit} at ({x}, {y})");
                    assert!(angle < 0.05, "{case}: {angle}");
                }
            }
        }
    }
}

#[test]
fn depth_may_be_measured_along_the_sight_line() {
    let radius = 128.0;
    for (name, scene) in scenes(radius) {
        let scene = deep(&scene, radius);
        let mut frame = framed(&scene, radius);
        let window = frame.mask.width();
        let along = Plane::from_fn(window, window, |x, y| {
            let depth = scene.exact(x, y).map_or(0.0, |e| e.point.length());
            depth as f32
        });
        frame.depth = Some(along);
        frame.source.depth_kind = DepthKind::Ray;
        let errors = errors_deg(&scene, &frame, Adaptive::Auto);
        let p95 = quantile(&errors, 0.95);
        // As for planar depth: see the table of the second order.
        assert!(p95 < 0.1, "{name}: {p95} degrees");
    }
}
