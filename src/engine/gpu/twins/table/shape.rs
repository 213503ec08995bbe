//! Elementary functions, and shape.

use super::{Twin, coarse, each, twin, unit_vector};
use crate::frame::facing;
use crate::frame::gap::pair::{Gap, GapUnit, Side};
use crate::kernel::fast_math::circular::SIXTH;
use crate::kernel::fast_math::circular::{ATAN, rest_of_tangent};
use crate::kernel::fast_math::exponential::{EXP, LN, split_exp};
use crate::kernel::fast_math::{atan, atan2, exp, ln, polynomial, power_of_two, tanh};
use crate::light::relight::gpu::RELIGHT;
use crate::params::{ShapeParams, SoftThreshold};
use crate::shape::conductance::face_conductance;
use crate::shape::crease::{CreaseDetector, angle_within};
use crate::shape::curvature::gpu::{CURVATURES, HESSIAN};
use crate::shape::curvature::{
    mapped_curvature, mapped_curvature_toward, principal_curvatures, principal_direction,
};
use crate::shape::diffusion::gpu::DIFFUSION;
use crate::shape::diffusion::{Update, flux, through};
use crate::shape::edges::gpu::{EDGES, GAPS};
use crate::shape::gradient::depth_gradient;
use crate::shape::hessian::{fitted, in_the_open, plane_fit};
use crate::shape::silhouette::{along_gaps, drawn, jump_weight, silhouettes_of_gaps};
use crate::shape::sobel;
use glam::{Vec2, Vec3};

pub(super) fn twins() -> Vec<Twin> {
    let mut twins = elementary();
    twins.extend(edges());
    twins.extend(curvature());
    twins
}

fn elementary() -> Vec<Twin> {
    vec![
        twin("polynomial_exp", &RELIGHT, |x: f32| polynomial(x, EXP)),
        twin("polynomial_ln", &RELIGHT, |x: f32| polynomial(x, LN)),
        twin("polynomial_atan", &RELIGHT, |x: f32| polynomial(x, ATAN)),
        twin("polynomial_sixth", &RELIGHT, |x: f32| polynomial(x, SIXTH)),
        twin("power_of_two", &RELIGHT, power_of_two),
        twin("is_finite", &RELIGHT, f32::is_finite).on(any_float),
        twin("is_nan", &RELIGHT, f32::is_nan).on(any_float),
        twin("copysign", &RELIGHT, f32::copysign),
        twin("split_exp", &RELIGHT, split_exp),
        twin("exp_of", &RELIGHT, exp)
            .ulps(1)
            .within(&[(1, -120.0, 100.0)]),
        twin("ln", &RELIGHT, ln).within(&[(1, 1e-30, 1e30)]),
        twin("tanh_of", &RELIGHT, tanh),
        twin("rest_of_tangent", &RELIGHT, rest_of_tangent),
        twin("atan_of", &RELIGHT, atan),
        twin("atan2_of", &RELIGHT, atan2),
        twin("hypot", &CURVATURES, f32::hypot).ulps(2),
    ]
}

/// Infinities and NaN among others.
fn any_float(words: &mut [u32]) {
    each(words, |v| match (v.to_bits() % 16, v) {
        (0, v) => v / 0.0,
        (1, _) => f32::NAN,
        (_, v) => v,
    });
}

fn edges() -> Vec<Twin> {
    vec![
        twin(
            "soft_threshold_weight",
            &EDGES,
            |v: f32, lo: f32, hi: f32| SoftThreshold { lo, hi }.weight(v),
        ),
        twin("sobel", &EDGES, sobel),
        twin(
            "jump_weight",
            &EDGES,
            |rows: [[f32; 3]; 3], lo: f32, hi: f32| jump_weight(rows, SoftThreshold { lo, hi }),
        )
        .with(&["silhouette_lo", "silhouette_hi"]),
        // Differences of depths, magnified to pixels; a threshold turns what they round to into up to all of a weight.
        twin("gap_strength", &GAPS, gap)
            .absolute(1e-3)
            .with(&["rounding", "silhouette_lo", "silhouette_hi"])
            .within(&[
                (1, 1.0, 2.0),
                (2, 0.5, 1.0),
                (2, -1.0, 1.0),
                (1, 0.0, 1.0),
                (1, 1.0, 2.0),
                (2, 0.5, 1.0),
                (2, -1.0, 1.0),
                (1, 0.0, 1.0),
                (1, 1.0, 20.0),
                (1, 0.0, 0.1),
                (1, 0.0, 1.0),
                (2, 0.0, 1e-3),
                (1, 1.0, 2.0),
                (1, 5.0, 9.0),
            ]),
        twin("drawn", &EDGES, drawn),
        twin("along_gaps", &EDGES, along_gaps),
        twin("silhouettes_of_gaps", &EDGES, silhouettes_of_gaps),
        twin("angle_within", &EDGES, angle_within).ulps(2),
        twin("crease_detector_weight", &EDGES, crease)
            .absolute(2.2e-6)
            .with(&["crease_lo", "crease_hi", "flat_length"])
            .within(&[
                (15, -4.0, 4.0),
                (1, 0.0, 2.0),
                (4, 0.0, 1.0),
                (1, 0.0, 1.0),
                (1, 1.1, 2.0),
                (1, 0.0, 1.0),
            ])
            .on(|words| (0..5).for_each(|i| unit_vector(&mut words[3 * i..3 * i + 3]))),
        // A sum that cancels.
        twin("facing", &EDGES, facing)
            .within(&[(5, -1.0, 1.0)])
            .absolute(2.4e-7),
        // A power of a sum that cancels.
        twin(
            "depth_gradient",
            &EDGES,
            |n: Vec3, to_eye: Vec2, min_nz: f32, foreshortening: f32| {
                let params = ShapeParams {
                    min_nz,
                    foreshortening,
                    ..ShapeParams::default()
                };
                depth_gradient(n, to_eye, &params)
            },
        )
        .ulps(85)
        .with(&["min_nz", "foreshortening"])
        .within(&[(5, -100.0, 100.0), (1, 1e-3, 1.0), (1, 0.0, 4.0)]),
    ]
}

/// Depth, what is linear here and beyond, both products; and whether there is a pixel beyond.
type SideWords = ([f32; 5], bool);

fn gap(
    first: SideWords,
    second: SideWords,
    pitch: f32,
    noise: f32,
    is_perspective: bool,
    rounding: [f32; 2],
    [lo, hi]: [f32; 2],
) -> f32 {
    let unit = GapUnit {
        is_perspective,
        pitch,
        rounding,
    };
    let side = |([depth, linear, beyond, facing, along], has_beyond): SideWords| Side {
        depth,
        linear,
        beyond: if has_beyond { beyond } else { f32::NAN },
        facing,
        along,
    };
    let gap = Gap::between(side(first), side(second), unit);
    gap.strength(noise, SoftThreshold { lo, hi })
}

/// The CPU takes the angle from the cross product, the device from the chord, which loses digits only near half a turn,
/// far past every threshold.
fn crease(
    normals: [Vec3; 5],
    length: f32,
    there: [bool; 4],
    [lo, hi]: [f32; 2],
    flat_length: f32,
) -> f32 {
    let [own, beside @ ..] = normals;
    let detector = CreaseDetector {
        threshold_rad: SoftThreshold { lo, hi },
        flat_cosine: 2.0,
        flat_length,
    };
    detector.weight(
        own,
        length,
        std::array::from_fn(|i| there[i].then_some(beside[i])),
    )
}

/// Three rows of gradients left, here and right, and their conductances.
type GradientRows = [([[f32; 2]; 3], [f32; 3]); 3];

/// Both components of the gradients of three rows, and their conductances.
fn planes(rows: GradientRows) -> [[[f32; 3]; 3]; 3] {
    let component = |k: usize| rows.map(|(gradients, _)| gradients.map(|g| g[k]));
    [component(0), component(1), rows.map(|(_, open)| open)]
}

const OPEN: [(usize, f32, f32); 6] = {
    let (gradients, open) = ((6, -10.0, 10.0), (3, 0.0, 1.0));
    [gradients, open, gradients, open, gradients, open]
};

fn curvature() -> Vec<Twin> {
    vec![
        twin("face_conductance", &DIFFUSION, face_conductance),
        // A sum that cancels.
        twin(
            "flux",
            &DIFFUSION,
            |g: [f32; 2], sides: [[f32; 2]; 4], joined: [f32; 4]| {
                let side = |i: usize, k: usize| through(joined[i], sides[i][k], g[k]);
                [0, 1].map(|k| flux([0, 1, 2, 3].map(|i| side(i, k))))
            },
        )
        .within(&[(14, -1.0, 1.0)])
        .absolute(4.8e-7),
        twin("updated", &DIFFUSION, updated).with(&["time_step", "IS_EXPANSION"]),
        twin("in_the_open", &HESSIAN, |rows: GradientRows| {
            let [gx, gy, _] = planes(rows);
            in_the_open(gx, gy)
        }),
        twin("plane_fit", &HESSIAN, |rows: GradientRows| {
            let [gx, gy, open] = planes(rows);
            plane_fit(gx, gy, open)
        })
        .within(&OPEN),
        twin("fitted", &HESSIAN, |rows: GradientRows| {
            let [gx, gy, open] = planes(rows);
            fitted(gx, gy, open)
        })
        .within(&OPEN),
        // The lesser is a difference, of numbers up to 100.
        twin("principal_curvatures", &CURVATURES, principal_curvatures)
            .absolute(1.6e-5)
            .on(|words| coarse(words, 100.0)),
        twin("principal_direction", &CURVATURES, principal_direction)
            .ulps(3)
            .on(|words| coarse(words, 100.0)),
        twin("mapped_curvature", &RELIGHT, mapped_curvature),
        twin("mapped_curvature_toward", &RELIGHT, mapped_curvature_toward),
    ]
}

fn updated(
    g: [f32; 2],
    lg: [f32; 2],
    earlier: [f32; 2],
    term: u32,
    time_step: f32,
    expands: bool,
) -> [f32; 2] {
    let update = match (expands, term) {
        (false, _) => Update::Step(time_step),
        (true, 1) => Update::First,
        (true, _) => Update::Next,
    };
    [0, 1].map(|k| update.updated(g[k], lg[k], earlier[k]))
}
