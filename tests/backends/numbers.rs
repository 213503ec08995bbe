//! Numbers at the limits of single precision: invalid ones are dropped on reading, and both backends treat the rest
//! alike.

use super::{GOALS, assert_same, on_gpu, waves, with_shape};
use crate::common::exr::Stored;
use crate::common::through_a_file;
use relievo::frame::{Frame, Plane, Vector3Planes};
use relievo::params::{Params, Scale};
use relievo::plan::Goal;

/// Every so-manieth pixel of a plane in turn made one of `values`.
fn scattered(plane: &Plane, every: usize, values: &[f32]) -> Plane {
    let (width, height) = (plane.width(), plane.height());
    Plane::from_fn(width, height, |x, y| {
        let i = y * width + x;
        match i % every {
            0 => values[i / every % values.len()],
            _ => plane.at(x, y),
        }
    })
}

/// The vectors renormalised down to their smallest components; zero ones face the eye.
fn unit(vectors: &Vector3Planes) -> Vector3Planes {
    let (width, height) = (vectors.x.width(), vectors.x.height());
    let at = |x: usize, y: usize| {
        let [x, y, z] = [&vectors.x, &vectors.y, &vectors.z].map(|plane| plane.at(x, y));
        let length = x.hypot(y).hypot(z);
        match length > 0.1 {
            true => [x, y, z].map(|v| v / length),
            false => [x, y, 1.0],
        }
    };
    let [x, y, z] = [0, 1, 2].map(|axis| Plane::from_fn(width, height, |x, y| at(x, y)[axis]));
    Vector3Planes { x, y, z }
}

/// The frame after being written to a file and read back.
fn as_read(frame: &Frame) -> Frame {
    let color = frame.color.as_ref().unwrap();
    let layers = [
        ("R", &color.r),
        ("G", &color.g),
        ("B", &color.b),
        ("N.x", &frame.normal.x),
        ("N.y", &frame.normal.y),
        ("N.z", &frame.normal.z),
        ("Z", frame.depth.as_ref().unwrap()),
    ];
    through_a_file(&layers, Stored::Float).frame
}

#[test]
fn what_is_no_number_in_a_file() {
    let hostile = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        -0.0,
        0.0,
        1e-40,
        -2.0,
    ];
    let whole = waves(90, 70);
    let mut frame = whole.clone();
    frame.normal.x = scattered(&whole.normal.x, 67, &hostile);
    frame.normal.y = scattered(&whole.normal.y, 71, &hostile);
    frame.normal.z = scattered(&whole.normal.z, 73, &hostile);
    frame.depth = Some(scattered(whole.depth.as_ref().unwrap(), 79, &hostile));
    let color = frame.color.as_mut().unwrap();
    // Beside the largest number others are indistinguishable.
    color.g = scattered(&color.g, 83, &hostile[..3]);
    let read = as_read(&frame);
    let covered = read.mask.count();
    assert!(covered < 90 * 70 && covered > 80 * 70, "{covered}");
    on_gpu(|runner| assert_same("from a file", runner, &GOALS, &read, &Params::default()));
}

/// Devices may flush numbers below the least normal one, 1.2e-38, to 0. For normals and occlusion the difference is no
/// larger than that; such a small depth makes an edge either way.
#[test]
fn zeros_of_both_signs_and_numbers_next_to_them() {
    let tiny = [0.0, -0.0, 1e-40, -1e-40, f32::MIN_POSITIVE, 1e-30];
    on_gpu(|runner| {
        for scale in [Scale::Iterations(0), Scale::Iterations(12)] {
            let mut frame = waves(80, 60);
            frame.normal.x = scattered(&frame.normal.x, 61, &tiny);
            frame.normal.y = scattered(&frame.normal.y, 67, &tiny);
            // Seen edge-on, and from behind.
            frame.normal.z = scattered(&frame.normal.z, 241, &[-0.0, 0.0, 1e-40, -0.3]);
            frame.normal = unit(&frame.normal);
            frame.normal_length = Some(Plane::from_fn(80, 60, |x, y| {
                [1.0, 0.99, 1e-40, 0.0, -0.0][usize::from(x % 37 == 0) * (1 + y % 4)]
            }));
            let params = with_shape(|shape| {
                (shape.scale, shape.foreshortening) = (scale, 1.0);
            });
            assert_same(&format!("{scale:?}"), runner, &GOALS, &frame, &params);
            frame.depth = None;
            frame.occlusion = Some(Plane::from_fn(80, 60, |x, y| {
                [0.5, 0.0, -0.0, 1e-40, 1.0][usize::from(y % 17 == 0) * (1 + x % 4)]
            }));
            let name = format!("{scale:?}, occlusion");
            assert_same(&name, runner, &[Goal::LAYERS], &frame, &params);
        }
    });
}

#[test]
fn the_nearest_and_the_farthest_depth() {
    let ends = [
        f32::MIN_POSITIVE,
        1e-30,
        1e-3,
        1e30,
        f32::MAX,
        f32::from_bits(1),
        1e-40,
    ];
    on_gpu(|runner| {
        // The last two are no normal numbers: alone among their neighbours they are edges.
        for count in [5, 7] {
            let mut frame = waves(80, 60);
            let depth = frame.depth.as_ref().unwrap();
            frame.depth = Some(scattered(depth, 59, &ends[..count]));
            let name = format!("{count} depths");
            assert_same(&name, runner, &GOALS, &frame, &Params::default());
        }
    });
}
