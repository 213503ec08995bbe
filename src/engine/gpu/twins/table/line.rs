//! Lines and strokes.

use super::{Twin, coarse, each, set, sight_line, twin, unit_vector, vector};
use crate::frame::{Projection, SightLines};
use crate::line::contours::crack;
use crate::line::contours::gpu::CRACKS;
use crate::line::contours::gpu_coverage::LINE_COVERAGE;
use crate::line::contours::round_stroke::RoundStroke;
use crate::line::direction::gpu::SPREAD_DIRECTIONS;
use crate::line::direction::{clear_direction, fixed_direction, fixed_second_direction};
use crate::line::direction_field::gpu_kernels::{PATCH_DIRECTIONS, PATCH_FORMS, SETTLE_PATCHES};
use crate::line::direction_field::setting::FieldSetting;
use crate::line::direction_field::{CurvatureTensor, calm, doubled, halved};
use crate::line::hatching::gpu::{PICTURE_STROKES, STROKES};
use crate::line::hatching::share;
use crate::line::normal_rays::gpu::NORMAL_RAYS;
use crate::line::normal_rays::{Difference, Local, NormalRay, Slopes, upright_tangents};
use crate::line::paper::{grain, graphite, unit};
use crate::line::slice_texture::{mix, within};
use crate::line::stroke_texture::{ramp_between, ramp_of};
use crate::line::texture_coordinates::{
    in_texture, is_joined, is_one_depth, is_one_motion, jacobian, slope,
};
use glam::{DVec2, DVec3, Vec2, Vec3};

pub(super) fn twins() -> Vec<Twin> {
    let mut twins = contours();
    twins.extend(directions());
    twins.extend(sight_lines());
    twins.extend(normal_rays());
    twins.extend(strokes());
    twins
}

fn contours() -> Vec<Twin> {
    vec![
        twin("difference", &CRACKS, crack::difference),
        twin("beyond_slopes", &CRACKS, crack::beyond_slopes),
        twin("steepness", &CRACKS, crack::steepness),
        twin("unexplained_jump", &CRACKS, |across: [Option<f32>; 6]| {
            crack::unexplained_jump(&across)
        }),
        twin("spread_offset", &CRACKS, crack::spread_offset),
        twin("nearer_extreme", &CRACKS, crack::nearer_extreme),
        twin(
            "round_stroke_coverage",
            &LINE_COVERAGE,
            |numbers: [f32; 8], p: Vec2| RoundStroke::of_numbers(numbers).coverage(p),
        )
        .within(&[(7, -100.0, 100.0), (1, 0.1, 1.0)]),
        twin("unit", &LINE_COVERAGE, |high: u32| {
            unit(u64::from(high) << 32)
        }),
        // Heights next to 0 are differences.
        twin(
            "grain",
            &LINE_COVERAGE,
            |x: i32, y: i32, low: u32, high: u32| {
                // The device receives the seed multiplied by an odd number; this is its inverse.
                let spread = u64::from(high) << 32 | u64::from(low);
                grain(x, y, spread.wrapping_mul(0xf1de_83e1_9937_733d))
            },
        )
        .absolute(1.2e-7)
        .with(&["seed_low", "seed_high"]),
        twin("graphite", &LINE_COVERAGE, graphite),
    ]
}

fn form([x, y, mean, _]: [f64; 4]) -> CurvatureTensor {
    CurvatureTensor {
        deviator: DVec2::new(x, y),
        mean,
    }
}

/// Most of these are in f64 on the CPU.
fn directions() -> Vec<Twin> {
    const DOUBT: [(usize, f32, f32); 2] = [(4, -4.0, 4.0), (1, 1e-3, 1.0)];
    vec![
        twin("doubled", &SPREAD_DIRECTIONS, doubled),
        twin("halved", &SPREAD_DIRECTIONS, halved),
        twin(
            "clear_direction",
            &SPREAD_DIRECTIONS,
            |sum: Vec2, weight: f32| clear_direction(sum, weight).unwrap_or_default(),
        ),
        twin("calm", &SETTLE_PATCHES, calm),
        twin(
            "curvature_tensor_larger",
            &PATCH_DIRECTIONS,
            |f: [f64; 4]| form(f).larger().unwrap_or_default(),
        )
        .ulps(2)
        .on(|words| coarse(words, 4.0)),
        twin(
            "curvature_tensor_confidence",
            &PATCH_DIRECTIONS,
            |f: [f64; 4], doubt: f64| form(f).confidence(doubt),
        )
        .absolute(2.4e-7)
        .with(&["doubt"])
        .within(&DOUBT)
        .on(|words| coarse(&mut words[..4], 4.0)),
        twin(
            "curvature_tensor_flatness",
            &PATCH_DIRECTIONS,
            |f: [f64; 4], doubt: f64| form(f).flatness(doubt),
        )
        .absolute(1.2e-7)
        .with(&["doubt"])
        .within(&DOUBT)
        .on(|words| {
            coarse(&mut words[..4], 4.0);
            // Without any doubt is a case of its own.
            each(&mut words[4..], |v| if v < 0.01 { 0.0 } else { v });
        }),
    ]
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
        twin(
            "fallback",
            &PATCH_DIRECTIONS,
            |line: [f64; 3],
             normal: DVec3,
             shape: f64,
             order: usize,
             is_fixed: bool,
             fixed: Vec2| {
                let (sight, [x, y]) = sight(line, shape);
                let setting = FieldSetting {
                    fixed: is_fixed.then_some([fixed; 2]),
                    sight,
                    pixels: 1.0,
                    cells: 1.0,
                    doubt: 1.0,
                    is_by_depth: false,
                };
                setting.fallback(x, y, normal, order)
            },
        )
        .absolute(8.4e-7)
        .with(&["pixel_shape", "order", "is_fixed", "fixed_x", "fixed_y"])
        .within(&[SEEN, SHAPE, (2, 0.0, 1.0)])
        .on(seen_vector),
        twin(
            "fixed_direction",
            &PATCH_DIRECTIONS,
            |line: [f64; 3], normal: DVec3, order: u32, shape: f64| {
                let (sight, [x, y]) = sight(line, shape);
                match order {
                    0 => fixed_direction(normal, &sight, x, y),
                    _ => fixed_second_direction(normal, &sight, x, y),
                }
            },
        )
        .absolute(1.5e-6)
        .with(&["pixel_shape"])
        .within(&[SEEN, (1, 0.0, 1.0), SHAPE])
        .on(seen_vector),
        // Positions in a picture, and focal lengths of 100 to 10,000 pixels.
        twin(
            "line",
            &PATCH_DIRECTIONS,
            |place: [f64; 2], line: [f64; 2], step: [f64; 2]| {
                let [fx, fy] = [1.0 / step[0], -1.0 / step[1]];
                let (cx, cy) = (0.5 - line[0] * fx, 0.5 + line[1] * fy);
                let sight = SightLines::new(Projection::Perspective { fx, fy, cx, cy });
                sight.line(place[0], place[1]).1
            },
        )
        .absolute(3.9e-6)
        .with(&["line_x", "line_y", "line_x_step", "line_y_step"])
        .within(&[(2, 0.0, 4000.0), (2, -2.0, 2.0), (2, 1e-4, 1e-2)]),
        twin(
            "sight_lines_facing",
            &PATCH_DIRECTIONS,
            |line: [f64; 3], normal: DVec3| {
                let (sight, [x, y]) = sight(line, 1.0);
                sight.facing(x, y, normal)
            },
        )
        .absolute(1.2e-7)
        .within(&[SEEN])
        .on(seen_vector),
        twin(
            "picture_direction",
            &PATCH_DIRECTIONS,
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
            &PATCH_FORMS,
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
        // Directly behind the viewer a rounding turns the tangents.
        twin("upright_tangents", &PATCH_FORMS, |normal: DVec3| {
            let tangents = upright_tangents(normal);
            (tangents.is_some(), tangents.unwrap_or([DVec3::NAN; 2]))
        })
        .absolute(1.5e-7)
        .on(|words| {
            unit_vector(words);
            let Vec3 { x, y, z } = vector(words);
            if z < -0.9 {
                set(words, &[0.0, 0.0, if x + y > 0.0 { 1.0 } else { -1.0 }]);
            }
        }),
        twin(
            "local_ray",
            &PATCH_FORMS,
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
        twin("slopes_of", &PATCH_FORMS, slopes_of)
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
    let s = Slopes::of(&between(rays[0], rays[1]), &between(rays[2], rays[3]));
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
