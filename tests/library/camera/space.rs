//! Which space normals are in: of a ball whose camera is known, of real renders, of photographs.

use super::planes::mapped;
use super::renders::{Render, pictures};
use crate::prelude::*;
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

/// How the normals of the ball are stored.
#[derive(Debug, Clone, Copy)]
enum As {
    World,
    View,
    Flipped,
    /// Facing away.
    Away,
    /// Those of the ground.
    Up,
    /// This in all components.
    Value(f64),
}

/// A tilt of the camera, the normals as stored, what else is known, and the conclusion.
#[rustfmt::skip]
const JUDGED: [(f64, As, &[By], NormalSpaceConclusion); 24] = [
    (90.0, As::World, &[By::Position, By::Camera], WORLD),
    (90.0, As::View, &[By::Position, By::Camera], VIEW),
    (90.0, As::Flipped, &[By::Position, By::Camera], VIEW_FLIPPED),
    (90.0, As::World, &[By::Camera], WORLD),
    (90.0, As::View, &[By::Camera], VIEW),
    (90.0, As::Flipped, &[By::Camera], VIEW_FLIPPED),
    (90.0, As::View, &[], VIEW),
    (90.0, As::Flipped, &[], VIEW_FLIPPED),
    (90.0, As::World, &[], NormalSpaceConclusion::WorldWithoutCamera),
    (90.0, As::World, &[By::Position], WORLD),
    // Depth settles what facing leaves open. As stored, ground normals all face the viewer, but depth shows that the ground
    // recedes.
    (50.0, As::View, &[By::Depth], VIEW),
    (50.0, As::View, &[By::Depth, By::Camera], VIEW),
    (50.0, As::Flipped, &[By::Depth], VIEW_FLIPPED),
    (50.0, As::Flipped, &[By::Depth, By::Camera], VIEW_FLIPPED),
    (50.0, As::World, &[By::Depth, By::Camera], WORLD),
    (50.0, As::Up, &[By::Depth], NormalSpaceConclusion::WorldWithoutCamera),
    // Straight down with z up, world and view axes are the same.
    (0.0, As::World, &[By::Position, By::Camera], VIEW),
    (0.0, As::World, &[], VIEW),
    (0.0, As::Up, &[], VIEW),
    (90.0, As::Away, &[By::Position, By::Camera], WORLD),
    (90.0, As::Away, &[By::Camera], NormalSpaceConclusion::Ambiguous),
    // Nothing to judge.
    (90.0, As::Value(0.0), &[By::Position, By::Camera], NormalSpaceConclusion::Ambiguous),
    (90.0, As::Value(f64::NAN), &[By::Position, By::Camera], NormalSpaceConclusion::Ambiguous),
    (90.0, As::Value(f64::INFINITY), &[By::Position, By::Camera], NormalSpaceConclusion::Ambiguous),
];

#[test]
fn each_reading_is_told_with_every_kind_of_evidence() {
    for (tilt, stored, clues, expected) in JUDGED {
        let ball = ball(tilt);
        let normal = match stored {
            As::World => ball.normal.clone(),
            As::View => ball.in_view(1.0),
            As::Flipped => ball.in_view(-1.0),
            As::Away => mapped(&ball.normal, |n| -n),
            As::Up => field(|_, _| DVec3::Z),
            As::Value(value) => field(|_, _| DVec3::splat(value)),
        };
        let found = ball.concluded(&normal, clues);
        assert_eq!(found, expected, "{tilt} degrees, {stored:?} by {clues:?}");
    }
}

#[test]
fn the_reason_holds_the_numbers() {
    let judged = |tilt| {
        let ball = ball(tilt);
        let verdict = ball.judge(&ball.normal, &[By::Position, By::Camera]);
        assert_eq!(verdict.evidence.samples, ball.mask.count());
        verdict
    };
    let NormalSpaceVerdict {
        reason, evidence, ..
    } = judged(90.0);
    let is_told = reason.starts_with("world: ") && reason.contains("100.0 % turned");
    assert!(is_told, "{reason}");
    assert!(evidence.world.shape_deg.is_some_and(|d| d < 1.0));
    assert!(evidence.view.shape_deg.is_some_and(|d| d > 30.0));
    let differ = judged(0.0).evidence.readings_differ_deg;
    assert!(differ.is_some_and(|d| d < 1e-3));
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
fn an_empty_mask_and_a_single_pixel_are_undecided() {
    let up = field(|_, _| DVec3::Z);
    let empty = Mask::new(Plane::filled(SIDE, SIDE, false));
    let window = Window::from_size(SIDE, SIDE);
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
        assert_eq!(verdict.conclusion, VIEW, "{name}: {}", verdict.reason);
    }
}
