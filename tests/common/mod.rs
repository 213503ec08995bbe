//! Shared by the tests: inputs, runs of the program, and rotated and mirrored frames.

#![allow(dead_code, reason = "each test binary uses its own part")]
#![allow(unreachable_pub, reason = "each test binary is its own crate")]

pub mod cpu;
pub mod curved;
pub mod damage;
pub mod exr;
pub mod files;
pub mod lobes;
pub mod planes;
pub mod program;
pub mod real_files;
pub mod relit;

use exr::{Part, Stored};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use relievo::engine::Drawing;
use relievo::frame::{
    Camera, ColorPlanes, Frame, Mask, NormalSpace, Plane, Projection, Vector2Planes, Vector3Planes,
    Window,
};
use relievo::io::Loaded;
use relievo::light::lights::{DirectionalLight, Illumination};
use relievo::params::{Adaptive, ScalingParams};
use relievo::scenes::angle_deg;
use std::fmt::Display;

/// The defaults, with this change.
pub fn default_but<T: Default>(change: impl FnOnce(&mut T)) -> T {
    let mut value = T::default();
    change(&mut value);
    value
}

/// A white light from an azimuth and an elevation in degrees.
pub fn lamp(azimuth: f32, elevation: f32) -> Illumination {
    let lamp = DirectionalLight::white([azimuth, elevation]);
    default_but(|light: &mut Illumination| light.directional.push(lamp))
}

/// Scaling with nothing chosen from the frame.
pub fn given(gain: f32, white: f32) -> ScalingParams {
    default_but(|scaling: &mut ScalingParams| {
        (scaling.curvature_gain, scaling.white_level) =
            (Adaptive::Fixed(gain), Adaptive::Fixed(white));
    })
}

/// Columns and rows of all pixels, row after row.
pub fn places(width: usize, height: usize) -> impl Iterator<Item = (usize, usize)> + Clone {
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// Those that a mask covers.
pub fn covered(mask: &Mask) -> impl Iterator<Item = (usize, usize)> + Clone {
    places(mask.width(), mask.height()).filter(|&(x, y)| mask.at(x, y))
}

/// Layers with view-space normals and a picture, written to a file with samples stored so, and loaded.
pub fn through_a_file(layers: &[(&str, &Plane)], stored: Stored) -> Loaded {
    let mut part = Part::of(layers.iter().copied());
    for channel in &mut part.channels {
        channel.1 = stored;
    }
    files::read(part, |inputs, needs| {
        inputs.normal_space = Some(NormalSpace::View);
        (needs.color, needs.projection) = (true, true);
    })
}

/// The frame as seen in a mirror to its left: columns reversed, x of vectors negated.
///
/// The camera's world is mirrored with it, so that its rotation stays proper.
pub fn mirrored(frame: &Frame) -> Frame {
    let shown = frame.display_window;
    let flip = |x: i32| shown.x0 + shown.x1 - x;
    let data = frame.data_window;
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let sides = f64::from(shown.x0 + shown.x1);
    let turn = Rearranged {
        width: data.width(),
        height: data.height(),
        from: move |x, y| (data.width() - 1 - x, y),
        vector: |v: DVec3| DVec3::new(-v.x, v.y, v.z),
    };
    turn.frame(
        frame,
        Window {
            x0: flip(data.x1),
            x1: flip(data.x0),
            ..data
        },
        shown,
        frame.pixel_aspect,
        |camera| Camera {
            view_from_world: mirror * camera.view_from_world * mirror,
            projection: projected(camera.projection, |[fx, fy, cx, cy]| {
                [fx, fy, sides - cx, cy]
            }),
        },
    )
}

/// The frame rotated a quarter turn counterclockwise: the right side becomes the top.
///
/// The world stays as it is; the camera is rolled.
pub fn quarter_turned(frame: &Frame) -> Frame {
    let shown = frame.display_window;
    let data = frame.data_window;
    // A position (x, y), rows running down, moves to (y, x0 + x1 - x).
    let turned_window = |w: Window| Window {
        x0: w.y0,
        x1: w.y1,
        y0: shown.x0 + shown.x1 - w.x1,
        y1: shown.x0 + shown.x1 - w.x0,
    };
    let roll = DAffine3::from_mat3(DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z));
    let sides = f64::from(shown.x0 + shown.x1);
    let turn = Rearranged {
        width: data.height(),
        height: data.width(),
        from: move |x, y| (data.width() - 1 - y, x),
        vector: |v: DVec3| DVec3::new(-v.y, v.x, v.z),
    };
    turn.frame(
        frame,
        turned_window(data),
        turned_window(shown),
        1.0 / frame.pixel_aspect,
        |camera| Camera {
            view_from_world: roll * camera.view_from_world,
            projection: projected(camera.projection, |[fx, fy, cx, cy]| {
                [fy, fx, cy, sides - cx]
            }),
        },
    )
}

/// A projection of the same kind with its numbers changed: of pixels per unit, and of the principal point.
fn projected(projection: Projection, change: impl Fn([f64; 4]) -> [f64; 4]) -> Projection {
    match projection {
        Projection::Perspective { fx, fy, cx, cy } => {
            let [fx, fy, cx, cy] = change([fx, fy, cx, cy]);
            Projection::Perspective { fx, fy, cx, cy }
        }
        Projection::Orthographic { sx, sy, cx, cy } => {
            let [sx, sy, cx, cy] = change([sx, sy, cx, cy]);
            Projection::Orthographic { sx, sy, cx, cy }
        }
    }
}

/// The frame with every sample outside the mask, of every plane but the picture's own, replaced by
/// `poison`: nothing computed may change.
pub fn poisoned(frame: &Frame, poison: f32) -> Frame {
    let spoil = |p: &Plane| {
        let at = |x, y| {
            if frame.mask.at(x, y) {
                p.at(x, y)
            } else {
                poison
            }
        };
        Plane::from_fn(p.width(), p.height(), at)
    };
    let [x, y, z] = [&frame.normal.x, &frame.normal.y, &frame.normal.z].map(spoil);
    Frame {
        normal: Vector3Planes { x, y, z },
        normal_length: frame.normal_length.as_ref().map(spoil),
        confidence: frame.confidence.clone(),
        depth: frame.depth.as_ref().map(spoil),
        ..frame.clone()
    }
}

/// The frame with its normals passed through `round`, and normalised as loading does.
pub fn rounded(mut frame: Frame, rounding: f32, round: impl Fn(f32) -> f32) -> Frame {
    let n = &mut frame.normal;
    let xy = n.x.samples_mut().iter_mut().zip(n.y.samples_mut());
    for ((x, y), z) in xy.zip(n.z.samples_mut()) {
        let v = Vec3::new(round(*x), round(*y), round(*z)).normalize_or_zero();
        (*x, *y, *z) = v.into();
    }
    frame.source.normal_rounding = rounding;
    frame
}

/// The frame with its normals as 8 bits over -1..1 store them.
pub fn in_8_bits(frame: Frame) -> Frame {
    rounded(frame, 1.0 / 255.0, |v| {
        ((v * 0.5 + 0.5) * 255.0).round() / 255.0 * 2.0 - 1.0
    })
}

/// The result of `work` on so many threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(work)
}

pub fn without_depth(frame: Frame) -> Frame {
    Frame {
        depth: None,
        ..frame
    }
}

/// Sets the normal of a pixel.
pub fn set_normal(planes: &mut Vector3Planes, x: usize, y: usize, n: Vec3) {
    let planes = [&mut planes.x, &mut planes.y, &mut planes.z];
    let components = planes.into_iter().zip(n.to_array());
    components.for_each(|(plane, v)| plane.row_mut(y)[x] = v);
}

/// The direction at a pixel.
pub fn direction_at(found: &Vector2Planes, x: usize, y: usize) -> DVec2 {
    DVec2::new(found.x.at(x, y).into(), found.y.at(x, y).into())
}

/// The largest angle between the directions of covered neighbours.
pub fn largest_turn_deg(found: &Vector2Planes, frame: &Frame) -> f64 {
    let beside = |(x, y)| [(x - 1, y, x, y), (x, y - 1, x, y)];
    let places = covered(&frame.mask).filter(|&(x, y)| x > 0 && y > 0);
    let pairs = places
        .flat_map(beside)
        .filter(|&(x, y, ..)| frame.mask.at(x, y));
    let at = |x, y| direction_at(found, x, y);
    let turns = pairs.map(|(px, py, x, y)| angle_deg(at(x, y), at(px, py)));
    turns.fold(0.0, f64::max)
}

/// The quantile of the sorted values for this share.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

pub fn mean(plane: &Plane) -> f64 {
    let sum: f64 = plane.samples().iter().copied().map(f64::from).sum();
    sum / plane.samples().len() as f64
}

/// The largest difference of two planes.
pub fn apart(a: &Plane, b: &Plane) -> f32 {
    assert_eq!((a.width(), a.height()), (b.width(), b.height()));
    let pairs = a.samples().iter().zip(b.samples());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Whether every sample of all layers is a share.
pub fn is_a_drawing(drawn: &Drawing) -> bool {
    let layers = std::iter::once(&drawn.hatching).chain(&drawn.contours);
    layers
        .flat_map(|plane| plane.samples())
        .all(|v| (0.0..=1.0).contains(v))
}

/// Expects a number within a bound of what it should be.
#[track_caller]
pub fn near(found: impl Into<f64>, expected: impl Into<f64>, bound: f64, what: impl Display) {
    let [found, expected] = [found.into(), expected.into()];
    let is_near = (found - expected).abs() < bound;
    assert!(is_near, "{what}: {found}, not {expected}");
}

/// Numbers in their order.
pub fn sorted(numbers: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut numbers: Vec<f64> = numbers.into_iter().collect();
    numbers.sort_by(f64::total_cmp);
    numbers
}

/// The largest of numbers that are not negative.
pub fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(0.0, f64::max)
}

/// Three planes of colours.
pub fn colors([width, height]: [usize; 2], at: impl Fn(usize, usize, usize) -> f32) -> ColorPlanes {
    let [r, g, b] = [0, 1, 2].map(|i| Plane::from_fn(width, height, |x, y| at(i, x, y)));
    ColorPlanes { r, g, b }
}

/// The three planes of colours.
pub fn channels(color: &ColorPlanes) -> [&Plane; 3] {
    [&color.r, &color.g, &color.b]
}

/// The value of a plane at a place, 0 in the middle of the first pixel, linear between pixels; outside, its border is repeated.
pub fn between(plane: &Plane, x: f64, y: f64) -> f64 {
    let inside = |at: f64, length: usize| at.clamp(0.0, length as f64 - 1.0);
    let (x, y) = (inside(x, plane.width()), inside(y, plane.height()));
    let (left, top) = (x.floor(), y.floor());
    let at = |dx: usize, dy: usize| {
        let column = (left as usize + dx).min(plane.width() - 1);
        let row = (top as usize + dy).min(plane.height() - 1);
        f64::from(plane.at(column, row))
    };
    let along = |dy| at(0, dy) + (x - left) * (at(1, dy) - at(0, dy));
    along(0) + (y - top) * (along(1) - along(0))
}

/// The bits of all samples.
pub fn bits(plane: &Plane) -> Vec<u32> {
    plane.samples().iter().map(|s| s.to_bits()).collect()
}

/// A plane rotated like a frame by `quarter_turned`.
pub fn quarter_turned_plane<T: Copy>(plane: &Plane<T>) -> Plane<T> {
    Plane::from_fn(plane.height(), plane.width(), |x, y| {
        plane.at(plane.width() - 1 - y, x)
    })
}

/// A plane mirrored like a frame by `mirrored`.
pub fn mirrored_plane<T: Copy>(plane: &Plane<T>) -> Plane<T> {
    Plane::from_fn(plane.width(), plane.height(), |x, y| {
        plane.at(plane.width() - 1 - x, y)
    })
}

/// Rearrangement of samples and vectors: the sample at (x, y) comes from `from(x, y)`.
struct Rearranged<P, V> {
    width: usize,
    height: usize,
    from: P,
    vector: V,
}

impl<P: Fn(usize, usize) -> (usize, usize), V: Fn(DVec3) -> DVec3> Rearranged<P, V> {
    fn plane<T: Copy>(&self, plane: &Plane<T>) -> Plane<T> {
        Plane::from_fn(self.width, self.height, |x, y| {
            let (x, y) = (self.from)(x, y);
            plane.at(x, y)
        })
    }

    fn vectors(&self, planes: &Vector3Planes) -> Vector3Planes {
        Vector3Planes::from_fn(self.width, self.height, |x, y| {
            let (x, y) = (self.from)(x, y);
            (self.vector)(planes.at(x, y))
        })
    }

    fn frame(
        &self,
        frame: &Frame,
        data_window: Window,
        display_window: Window,
        pixel_aspect: f32,
        camera: impl Fn(Camera) -> Camera,
    ) -> Frame {
        let plane = |p: &Plane| self.plane(p);
        let colors = |c: &ColorPlanes| {
            let [r, g, b] = [&c.r, &c.g, &c.b].map(plane);
            ColorPlanes { r, g, b }
        };
        Frame {
            data_window,
            display_window,
            pixel_aspect,
            mask: Mask::new(self.plane(frame.mask.plane())),
            normal: self.vectors(&frame.normal),
            normal_length: frame.normal_length.as_ref().map(plane),
            confidence: frame.confidence.as_ref().map(plane),
            depth: frame.depth.as_ref().map(plane),
            occlusion: frame.occlusion.as_ref().map(plane),
            importance: frame.importance.as_ref().map(plane),
            strength: frame.strength.as_ref().map(plane),
            // No test scene has objects, with directions of their own or without.
            objects: None,
            stroke_fallback: None,
            color: frame.color.as_ref().map(colors),
            albedo: frame.albedo.as_ref().map(colors),
            alpha: frame.alpha.as_ref().map(plane),
            light: frame.light.map(plane),
            camera: frame.camera.map(camera),
            wraps: frame.wraps,
            source: frame.source.clone(),
        }
    }
}
