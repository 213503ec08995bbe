//! Which space normals are in: of a ball whose camera is known, of real renders, of photographs.

use super::planes::mapped;
use super::renders::{Render, pictures};
use crate::common::real_files::real;
use glam::{DAffine3, DMat3, DVec3};
use relievo::frame::{Camera, Mask, NormalSpace, Plane, Projection, Vector3Planes, Window};
use relievo::io::inputs::Flip;
use relievo::io::normal_space::{
    NormalReading, NormalSpaceConclusion, NormalSpaceVerdict, judge_normal_space,
};

const SIDE: usize = 96;

const WORLD: NormalSpaceConclusion = certain(NormalSpace::World, false);
const VIEW: NormalSpaceConclusion = certain(NormalSpace::View, false);
const VIEW_FLIPPED: NormalSpaceConclusion = certain(NormalSpace::View, true);

const fn certain(space: NormalSpace, flip_z: bool) -> NormalSpaceConclusion {
    let mut flip = Flip::NONE;
    flip.z = flip_z;
    NormalSpaceConclusion::Certain(NormalReading { space, flip })
}

/// Normals in world space, with other evidence for their space.
struct Surface {
    normal: Vector3Planes,
    mask: Mask,
    position: Option<Vector3Planes>,
    depth: Option<Plane>,
    camera: Camera,
    window: Window,
}

/// Evidence for a judgement besides the normals.
#[derive(Debug, Clone, Copy, PartialEq)]
enum By {
    Position,
    Depth,
    Camera,
}

impl Surface {
    /// The normals turned to the view, z toward the viewer (1) or away from it (-1).
    fn in_view(&self, sign: f64) -> Vector3Planes {
        let turn = self.camera.view_from_world.matrix3;
        mapped(&self.normal, |n| turn * n * DVec3::new(1.0, 1.0, sign))
    }

    /// Judges `normal` as the normals of this surface by some of its clues.
    fn judge(&self, normal: &Vector3Planes, clues: &[By]) -> NormalSpaceVerdict {
        let given = |clue| clues.contains(&clue);
        let verdict = judge_normal_space(
            normal,
            &self.mask,
            self.position.as_ref().filter(|_| given(By::Position)),
            self.depth.as_ref().filter(|_| given(By::Depth)),
            given(By::Camera).then_some(&self.camera),
            self.window,
        );
        assert!(!verdict.reason.contains('\n'));
        verdict
    }

    fn concluded(&self, normal: &Vector3Planes, clues: &[By]) -> NormalSpaceConclusion {
        self.judge(normal, clues).conclusion
    }
}

fn field(at: impl Fn(usize, usize) -> DVec3) -> Vector3Planes {
    Vector3Planes::from_fn(SIDE, SIDE, at)
}

/// A ball under a camera whose tilt of 90 looks along the world's +y with z up, 0 straight down.
fn ball(tilt_deg: f64) -> Surface {
    let turn = DMat3::from_rotation_x(-tilt_deg.to_radians());
    let [sx, sy, cx, cy] = [40.0, 40.0, 48.0, 48.0];
    let camera = Camera {
        view_from_world: DAffine3::from_mat3_translation(turn, DVec3::new(0.0, 0.0, -5.0)),
        projection: Projection::Orthographic { sx, sy, cx, cy },
    };
    let view = |x: usize, y: usize| {
        let (u, v) = ((x as f64 - 47.5) / 40.0, (47.5 - y as f64) / 40.0);
        let square = 1.0 - u * u - v * v;
        (square > 0.0).then(|| DVec3::new(u, v, square.sqrt()))
    };
    let world = |x: usize, y: usize| view(x, y).map_or(DVec3::ZERO, |n| turn.transpose() * n);
    let depth = |x: usize, y: usize| 5.0 - view(x, y).map_or(0.0, |n| n.z as f32);
    Surface {
        normal: field(world),
        mask: Mask::new(Plane::from_fn(SIDE, SIDE, |x, y| view(x, y).is_some())),
        position: Some(field(world)),
        depth: Some(Plane::from_fn(SIDE, SIDE, depth)),
        camera,
        window: Window::from_size(SIDE, SIDE),
    }
}

#[test]
fn each_reading_is_told_with_every_kind_of_evidence() {
    let ball = ball(90.0);
    let (view, flipped) = (ball.in_view(1.0), ball.in_view(-1.0));
    for clues in [&[By::Position, By::Camera][..], &[By::Camera]] {
        assert_eq!(ball.concluded(&ball.normal, clues), WORLD);
        assert_eq!(ball.concluded(&view, clues), VIEW);
        assert_eq!(ball.concluded(&flipped, clues), VIEW_FLIPPED);
    }
    assert_eq!(ball.concluded(&view, &[]), VIEW);
    assert_eq!(ball.concluded(&flipped, &[]), VIEW_FLIPPED);
    let alone = ball.concluded(&ball.normal, &[]);
    assert_eq!(alone, NormalSpaceConclusion::WorldWithoutCamera);
    assert_eq!(ball.concluded(&ball.normal, &[By::Position]), WORLD);
}

#[test]
fn the_reason_holds_the_numbers() {
    let ball = ball(90.0);
    let verdict = ball.judge(&ball.normal, &[By::Position, By::Camera]);
    let reason = &verdict.reason;
    assert!(reason.starts_with("world: "), "{reason}");
    assert!(reason.contains("100.0 % turned"), "{reason}");
    let evidence = verdict.evidence;
    assert_eq!(evidence.samples, ball.mask.count());
    assert!(evidence.world.shape_deg.is_some_and(|d| d < 1.0));
    assert!(evidence.view.shape_deg.is_some_and(|d| d > 30.0));
}

#[test]
fn a_gentle_tilt_needs_the_positions() {
    // Flat ground from 30 degrees off the vertical faces the viewer in either reading.
    let mut ground = ball(30.0);
    let up = field(|_, _| DVec3::Z);
    let inverse = ground.camera.view_from_world.inverse();
    ground.position = Some(field(|x, y| {
        let seen = DVec3::new(x as f64 / 40.0, -(y as f64) / 40.0, -5.0);
        let from = inverse.transform_point3(seen);
        let along = inverse.transform_vector3(DVec3::NEG_Z);
        from - along * (from.z / along.z)
    }));
    let blind = ground.concluded(&up, &[By::Camera]);
    assert_eq!(blind, NormalSpaceConclusion::Ambiguous);
    assert_eq!(ground.concluded(&up, &[By::Position, By::Camera]), WORLD);
}

#[test]
fn depth_settles_what_facing_leaves_open() {
    let ball = ball(50.0);
    for (sign, expected) in [(1.0, VIEW), (-1.0, VIEW_FLIPPED)] {
        let view = ball.in_view(sign);
        assert_eq!(ball.concluded(&view, &[By::Depth]), expected);
        assert_eq!(ball.concluded(&view, &[By::Depth, By::Camera]), expected);
    }
    let by_both = ball.concluded(&ball.normal, &[By::Depth, By::Camera]);
    assert_eq!(by_both, WORLD);
    // As stored, ground normals all face the viewer, but depth shows that the ground recedes.
    let up = field(|_, _| DVec3::Z);
    let alone = ball.concluded(&up, &[By::Depth]);
    assert_eq!(alone, NormalSpaceConclusion::WorldWithoutCamera);
}

#[test]
fn equal_readings_are_no_riddle() {
    // Straight down with z up, world and view axes are the same.
    let above = ball(0.0);
    let verdict = above.judge(&above.normal, &[By::Position, By::Camera]);
    assert_eq!(verdict.conclusion, VIEW);
    let differ = verdict.evidence.readings_differ_deg;
    assert!(differ.is_some_and(|d| d < 1e-3));
    assert_eq!(above.concluded(&above.normal, &[]), VIEW);
}

#[test]
fn a_flat_normal_map_is_view_space() {
    let flat = field(|_, _| DVec3::Z);
    let (mask, window) = (Mask::full(SIDE, SIDE), Window::from_size(SIDE, SIDE));
    let verdict = judge_normal_space(&flat, &mask, None, None, None, window);
    assert_eq!(verdict.conclusion, VIEW);
}

#[test]
fn normals_that_face_away_keep_their_space() {
    let ball = ball(90.0);
    let away = mapped(&ball.normal, |n| -n);
    assert_eq!(ball.concluded(&away, &[By::Position, By::Camera]), WORLD);
    let blind = ball.concluded(&away, &[By::Camera]);
    assert_eq!(blind, NormalSpaceConclusion::Ambiguous);
}

#[test]
fn nothing_to_judge_is_undecided() {
    for value in [0.0, f64::NAN, f64::INFINITY] {
        let bad = field(|_, _| DVec3::splat(value));
        let conclusion = ball(90.0).concluded(&bad, &[By::Position, By::Camera]);
        assert_eq!(conclusion, NormalSpaceConclusion::Ambiguous);
    }
    let empty = Mask::new(Plane::filled(SIDE, SIDE, false));
    let window = Window::from_size(SIDE, SIDE);
    let up = field(|_, _| DVec3::Z);
    let verdict = judge_normal_space(&up, &empty, None, None, None, window);
    assert_eq!(verdict.conclusion, NormalSpaceConclusion::Ambiguous);
    let single = Vector3Planes::from_fn(1, 1, |_, _| DVec3::ONE);
    let (mask, window) = (Mask::full(1, 1), Window::from_size(1, 1));
    judge_normal_space(&single, &mask, Some(&single), Some(&single.x), None, window);
}

/// One normal layer of a render judged with every selection of clues; the wrong conclusions.
fn misjudged(
    render: &Surface,
    normal: &Vector3Planes,
    truth: NormalSpaceConclusion,
) -> Vec<String> {
    let blind = match truth == WORLD {
        true => NormalSpaceConclusion::WorldWithoutCamera,
        false => truth,
    };
    // Facing alone may leave a view-space guess open, but must not be confidently wrong.
    let judgements = [
        (&[By::Camera][..], truth, false),
        (&[By::Camera, By::Depth], truth, false),
        (&[By::Camera, By::Position], truth, false),
        (&[By::Depth], blind, false),
        (&[], blind, true),
    ];
    let mut wrong = Vec::new();
    for (clues, expected, may_be_open) in judgements {
        let verdict = render.judge(normal, clues);
        let judged = format!("{clues:?}: {}", verdict.reason);
        println!("  {judged}");
        let open = may_be_open && verdict.conclusion == NormalSpaceConclusion::Ambiguous;
        if verdict.conclusion != expected && !open {
            wrong.push(judged);
        }
    }
    wrong
}

/// The normals of a render with their evidence, if it has any.
fn surface(render: &Render) -> Option<Surface> {
    let normal = render.vector("ViewLayer.Normal")?;
    Some(Surface {
        mask: render.mask(&normal),
        normal,
        position: render.vector("Position"),
        depth: render.depth(),
        camera: render.camera().expect("a camera beside the render"),
        window: render.data_window(),
    })
}

#[test]
fn normals_of_renders_are_judged_right() {
    let mut wrong = Vec::new();
    for render in pictures() {
        let Some(surface) = surface(&render) else {
            continue;
        };
        let readings = [
            ("world", surface.normal.clone(), WORLD),
            ("view", surface.in_view(1.0), VIEW),
            ("flipped", surface.in_view(-1.0), VIEW_FLIPPED),
        ];
        for (kind, normal, truth) in readings {
            let reading = format!("{} as {kind}", render.path.display());
            println!("{reading}");
            let of_this = misjudged(&surface, &normal, truth);
            wrong.extend(of_this.into_iter().map(|w| format!("{reading}, {w}")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn photographed_normal_maps_are_view_space() {
    for name in ["Bricks102_1K-JPG", "rock058_1k"] {
        let Some(path) = real(&format!("rgbn/{name}_NormalGL.jpg")) else {
            continue;
        };
        let picture = image::open(&path).expect("a readable picture").to_rgb8();
        let (w, h) = (picture.width() as usize, picture.height() as usize);
        let normal = Vector3Planes::from_fn(w, h, |x, y| {
            let rgb = picture.get_pixel(x as u32, y as u32).0;
            DVec3::from(rgb.map(|c| f64::from(c) / 127.5 - 1.0))
        });
        let (mask, window) = (Mask::full(w, h), Window::from_size(w, h));
        let verdict = judge_normal_space(&normal, &mask, None, None, None, window);
        println!("{}: {}", path.display(), verdict.reason);
        assert_eq!(verdict.conclusion, VIEW);
    }
}
