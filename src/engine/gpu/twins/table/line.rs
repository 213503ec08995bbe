//! Lines and strokes.

use super::{Twin, coarse, set, sight_line, twin, unit_vector, vector};
use crate::frame::{Projection, SightLines};
use crate::line::hatching::gpu::{PICTURE_STROKES, STROKES};
use crate::line::hatching::share;
use crate::line::normal_rays::gpu::NORMAL_RAYS;
use crate::line::normal_rays::{Difference, Local, NormalRay, RaySlopes};
use crate::line::slice_texture::{mix, within};
use crate::line::stroke_texture::{ramp_between, ramp_of};
use crate::line::texture_coordinates::{
    in_texture, is_joined, is_one_depth, is_one_motion, jacobian, slope,
};
use glam::{DVec2, DVec3, Vec3};

pub(super) fn twins() -> Vec<Twin> {
    let mut twins = sight_lines();
    twins.extend(normal_rays());
    twins.extend(strokes());
    twins
}

/// Sight lines whose line through the point below has the direction `line`.
fn sight([x, y, _]: [f64; 3], pixel_shape: f64) -> (SightLines, [f64; 2]) {
    let sight = SightLines::new(Projection::Perspective {
        fx: 1.0,
        fy: pixel_shape,
        cx: 0.0,
        cy: 0.0,
    });
    (sight, [x, -y * pixel_shape])
}

/// A sight line and a unit vector.
fn seen_vector(words: &mut [u32]) {
    sight_line(words);
    unit_vector(&mut words[3..6]);
}

/// In f64 on the CPU. Pixels have aspect ratios of 1/2 to 2.
fn sight_lines() -> Vec<Twin> {
    const SHAPE: (usize, f32, f32) = (1, 0.5, 2.0);
    const SEEN: (usize, f32, f32) = (6, -4.0, 4.0);
    vec![
        // Positions in a picture, and focal lengths of 100 to 10,000 pixels.
        twin(
            "line",
            &NORMAL_RAYS,
            |place: [f64; 2], line: [f64; 2], step: [f64; 2]| {
                let [fx, fy] = [1.0 / step[0], -1.0 / step[1]];
                let (cx, cy) = (0.5 - line[0] * fx, 0.5 + line[1] * fy);
                let sight = SightLines::new(Projection::Perspective { fx, fy, cx, cy });
                sight.line(place[0], place[1]).1
            },
        )
        .absolute(3.9e-6)
        .with(&["line"])
        .within(&[(2, 0.0, 4000.0), (2, -2.0, 2.0), (2, 1e-4, 1e-2)]),
        twin(
            "picture_direction",
            &NORMAL_RAYS,
            |line: [f64; 3], tangent: DVec3, shape: f64| {
                let (sight, [x, y]) = sight(line, shape);
                sight.picture_direction(x, y, tangent).unwrap_or_default()
            },
        )
        .absolute(8.7e-7)
        .with(&["pixel_shape"])
        .within(&[SEEN, SHAPE])
        .on(seen_vector),
        twin(
            "sight_lines_step",
            &NORMAL_RAYS,
            |normals: DVec3, line: [f64; 3], there: [f64; 3], _: [f32; 3]| {
                let (sight, from) = sight(line, 1.0);
                let (_, to) = self::sight(there, 1.0);
                let step = sight.step(from.into(), normals, to.into(), DVec3::ZERO);
                (step.is_some(), step.unwrap_or(DVec3::NAN))
            },
        )
        .absolute(2e-6)
        .on(step),
    ]
}

/// A surface seen edge-on recedes without end: single precision loses its distance.
fn step(words: &mut [u32]) {
    coarse(&mut words[..3], 2.0);
    sight_line(&mut words[3..6]);
    sight_line(&mut words[6..9]);
    let [normal, line, there] = [0, 3, 6].map(|at| vector(&words[at..]));
    if normal.dot(there).abs() < 0.25 {
        set(words, &[0.0, 0.0, 1.0]);
    }
    set(&mut words[9..], &(there - line).to_array());
}

/// In f64 on the CPU, but for the first.
fn normal_rays() -> Vec<Twin> {
    vec![
        twin(
            "any_orthonormal_pair",
            &NORMAL_RAYS,
            |normal: Vec3| -> [Vec3; 2] { normal.any_orthonormal_pair().into() },
        ),
        twin(
            "local_ray",
            &NORMAL_RAYS,
            |step: (bool, DVec3),
             there: DVec3,
             _: [f32; 3],
             normal: DVec3,
             tangents: [DVec3; 2]| {
                let (is_there, offset) = step;
                let ray = Local { tangents, normal }.ray(&NormalRay {
                    is_there,
                    offset,
                    normal: there,
                });
                (ray.is_there, [ray.foot, ray.slope])
            },
        )
        .absolute(2.3e-5)
        .on(tangents_of_normal),
        twin("slopes_of", &NORMAL_RAYS, slopes_of)
            .absolute(1.6e-5)
            .on(|words| {
                for ray in words.chunks_mut(5) {
                    coarse(&mut ray[1..], 2.0);
                    // A missing ray is all 0.
                    let is_there = ray[0];
                    ray[1..].iter_mut().for_each(|word| *word *= is_there);
                }
            }),
    ]
}

/// A normal with its tangents, and the neighbour it is compared with.
fn tangents_of_normal(words: &mut [u32]) {
    coarse(&mut words[1..4], 4.0);
    unit_vector(&mut words[4..7]);
    unit_vector(&mut words[10..13]);
    let [there, normal] = [4, 10].map(|at| vector(&words[at..]));
    set(&mut words[7..10], &(there - normal).to_array());
    let (a, b) = normal.any_orthonormal_pair();
    set(&mut words[13..16], &a.to_array());
    set(&mut words[16..19], &b.to_array());
}

fn slopes_of(rays: [(bool, DVec2, DVec2); 4]) -> (bool, [f64; 5]) {
    let between = |a: (bool, DVec2, DVec2), b: (bool, DVec2, DVec2)| Difference {
        foot: b.1 - a.1,
        slope: b.2 - a.2,
        samples: f64::from(u8::from(a.0 || b.0)),
    };
    let s = RaySlopes::of(&between(rays[0], rays[1]), &between(rays[2], rays[3]));
    match s.is_there {
        true => (true, [s.mean, s.half_difference, s.off, s.area, s.spread]),
        false => (false, [f64::NAN; 5]),
    }
}

fn strokes() -> Vec<Twin> {
    vec![
        twin("share", &STROKES, share).with(&["family", "families"]),
        // A texture has at least one texel, and its positions wrap.
        twin("within", &PICTURE_STROKES, within).within(&[(1, -4096.0, 4096.0), (1, 1.0, 4096.0)]),
        twin("mix_of", &PICTURE_STROKES, mix),
        twin("ramp_of", &STROKES, ramp_of),
        twin("ramp_between", &STROKES, ramp_between),
        twin("is_joined", &STROKES, is_joined),
        twin("slope", &STROKES, slope),
        twin("jacobian", &STROKES, jacobian),
        twin("in_texture", &STROKES, |by: [[f32; 2]; 2], t: [f32; 2]| {
            in_texture(&by, t)
        }),
        twin("is_one_depth", &STROKES, is_one_depth),
        twin("is_one_motion", &STROKES, is_one_motion),
    ]
}
