//! Twins of elementary functions and of shape.

use super::*;
use crate::frame::sampling::ENOUGH;

pub(super) fn twins() -> Vec<Twin> {
    [elementary(), edges(), gradient(), curvature()]
        .into_iter()
        .flatten()
        .collect()
}

fn elementary() -> Vec<Twin> {
    vec![
        twin!(
            polynomial_exp,
            fast_math::polynomial::<5>,
            RELIGHT,
            |x: f32| polynomial(x, EXP)
        ),
        twin!(
            polynomial_ln,
            fast_math::polynomial::<8>,
            RELIGHT,
            |x: f32| polynomial(x, LN)
        ),
        twin!(
            polynomial_atan,
            fast_math::polynomial::<5>,
            RELIGHT,
            |x: f32| polynomial(x, ATAN)
        ),
        twin!(
            polynomial_sixth,
            fast_math::polynomial::<5>,
            RELIGHT,
            |x: f32| polynomial(x, SIXTH)
        ),
        twin!(power_of_two, power_of_two, RELIGHT, |n: i32| power_of_two(
            n
        )),
        twin!(is_finite, f32::is_finite, RELIGHT, |x: f32| x.is_finite()),
        twin!(is_nan, f32::is_nan, RELIGHT, |x: f32| x.is_nan()),
        twin!(copysign, f32::copysign, RELIGHT, |size: f32, sign: f32| {
            size.copysign(sign)
        }),
        twin!(split_exp, split_exp, RELIGHT, |x: f32| split_exp(x))
            .on(|words| within_range(words, -104.0, 89.0)),
        twin!(exp_of, fast_math::exp, RELIGHT, |x: f32| fast_math::exp(x)).on(no_nan),
        // WGSL's version is for positive, finite, normal numbers.
        twin!(ln, fast_math::ln, RELIGHT, |x: f32| fast_math::ln(x))
            .on(|words| within_range(words, f32::MIN_POSITIVE, f32::MAX)),
        twin!(tanh_of, fast_math::tanh, RELIGHT, |x: f32| fast_math::tanh(
            x
        ))
        .on(no_nan),
        twin!(rest_of_tangent, rest_of_tangent, RELIGHT, |size: f32| {
            rest_of_tangent(size)
        }),
        twin!(atan_of, fast_math::atan, RELIGHT, |x: f32| fast_math::atan(
            x
        )),
        twin!(atan2_of, fast_math::atan2, RELIGHT, |y: f32, x: f32| {
            fast_math::atan2(y, x)
        }),
        // The library's version is within one ulp; this one rounds a ratio, a square, a root and a product.
        twin!(hypot, f32::hypot, CURVATURES, |a: f32, b: f32| a.hypot(b))
            .on(bounded)
            .within(Tolerance::Ulps(3)),
        // The kernels ignore non-finite values.
        twin!(key_of, key_of, COUNT, |value: f32| key_of(value))
            .on(|words| within_range(words, f32::MIN, f32::MAX)),
        twin!(value_of, value_of, NARROW, |key: u32| value_of(key)),
        twin!(scattered, scattered, COUNT, |i: u32, j: u32| scattered(
            i, j
        )),
        twin!(
            lattice_place,
            lattice_place,
            COUNT,
            |i: u32, side: u32, length: u32, random: u32| {
                lattice_place(i, side, length, random)
            }
        )
        .on(|words| {
            words[1] = words[1] % 100 + 1;
            words[2] = words[2] % 60_000 + 1;
            words[0] %= words[2].div_ceil(words[1]);
        }),
        twin!(finer_side, finer_side, NARROW, |side: u32, counted: u32| {
            finer_side(side, counted)
        })
        .on(|words| {
            words[0] = words[0] % 200 + 1;
            words[1] %= 2 * ENOUGH;
        }),
    ]
}

fn edges() -> Vec<Twin> {
    vec![
        twin!(
            soft_threshold_weight,
            SoftThreshold::weight,
            EDGES,
            |value: f32, lo: f32, hi: f32| { SoftThreshold { lo, hi }.weight(value) }
        ),
        twin!(sobel, sobel, EDGES, |rows: [[f32; 3]; 3]| sobel(rows)),
        twin!(
            jump_weight,
            jump_weight,
            EDGES,
            |rows: [[f32; 3]; 3], lo: f32, hi: f32| { jump_weight(rows, SoftThreshold { lo, hi }) }
        )
        .with(&["silhouette_lo", "silhouette_hi"]),
        // The CPU uses the library's atan2.
        twin!(angle_within, angle_within, EDGES, |length: f32| {
            angle_within(length)
        })
        .on(no_nan)
        .within(Tolerance::Absolute(1e-6)),
        // The CPU takes the angle from the cross product, the device from the chord, which loses digits only near half
        // a turn, far past every threshold.
        twin!(
            crease_detector_weight,
            CreaseDetector::weight,
            EDGES,
            |normals: [[f32; 3]; 5],
             length: f32,
             there: [bool; 4],
             threshold: [f32; 2],
             flat_length: f32| {
                let [own, beside @ ..] = normals.map(Vec3::from);
                let beside = std::array::from_fn(|i| there[i].then_some(beside[i]));
                let [lo, hi] = threshold;
                let detector = CreaseDetector {
                    threshold_rad: SoftThreshold { lo, hi },
                    flat_cosine: 2.0,
                    flat_length,
                };
                detector.weight(own, length, beside)
            }
        )
        .with(&["crease_lo", "crease_hi", "flat_length"])
        .on(|words| {
            (0..5).for_each(|i| unit_vector(&mut words[3 * i..3 * i + 3]));
            within_range(&mut words[15..16], 0.0, 2.0);
            within_range(&mut words[20..21], 0.0, 1.0);
            within_range(&mut words[21..22], 1.1, 2.0);
            within_range(&mut words[22..23], 0.0, 1.0);
        })
        .within(Tolerance::Absolute(2e-5)),
        twin!(facing, facing, EDGES, |n: [f32; 3], to_eye: [f32; 2]| {
            facing(n.into(), to_eye.into())
        }),
    ]
}

fn gradient() -> Vec<Twin> {
    vec![
        // Slightly beyond parameter ranges.
        twin!(
            depth_gradient,
            depth_gradient,
            EDGES,
            |n: [f32; 3], to_eye: [f32; 2], min_nz: f32, foreshortening: f32| {
                let params = ShapeParams {
                    min_nz,
                    foreshortening,
                    ..ShapeParams::default()
                };
                depth_gradient(n.into(), to_eye.into(), &params).to_array()
            }
        )
        .with(&["min_nz", "foreshortening"])
        .on(|words| {
            bounded(&mut words[..5]);
            within_range(&mut words[5..6], 1e-6, 1.0);
            within_range(&mut words[6..7], 0.0, 4.0);
        }),
        twin!(
            face_conductance,
            face_conductance,
            DIFFUSION,
            |a: f32, b: f32| face_conductance(a, b)
        ),
        twin!(
            flux,
            flux,
            DIFFUSION,
            |g: [f32; 2], sides: [[f32; 2]; 4], joined: [f32; 4]| {
                [0, 1].map(|k| {
                    let side = |i: usize| through(joined[i], sides[i][k], g[k]);
                    flux([0, 1, 2, 3].map(side))
                })
            }
        ),
        twin!(
            updated,
            Update::updated,
            DIFFUSION,
            |g: [f32; 2],
             lg: [f32; 2],
             earlier: [f32; 2],
             term: u32,
             time_step: f32,
             expands: bool| {
                let update = match (expands, term) {
                    (false, _) => Update::Step(time_step),
                    (true, 1) => Update::First,
                    (true, _) => Update::Next,
                };
                [0, 1].map(|k| update.updated(g[k], lg[k], earlier[k]))
            }
        )
        .with(&["time_step", "IS_EXPANSION"]),
    ]
}

/// A row of three pixels as in WGSL: gradients left, here and right, and their conductances.
type Row = [f32; 9];

/// Both components of the gradients of three rows, and their conductances.
fn planes(rows: [Row; 3]) -> [[[f32; 3]; 3]; 3] {
    let of = |places: [usize; 3]| rows.map(|row| places.map(|at| row[at]));
    [of([0, 2, 4]), of([1, 3, 5]), of([6, 7, 8])]
}

/// Conductances are 0..1.
fn conductances(words: &mut [u32]) {
    for row in words.chunks_mut(9) {
        within_range(&mut row[6..], 0.0, 1.0);
    }
}

fn curvature() -> Vec<Twin> {
    vec![
        twin!(in_the_open, in_the_open, HESSIAN, |rows: [Row; 3]| {
            let [gx, gy, _] = planes(rows);
            in_the_open(gx, gy)
        }),
        twin!(plane_fit, plane_fit, HESSIAN, |rows: [Row; 3]| {
            let [gx, gy, open] = planes(rows);
            plane_fit(gx, gy, open)
        })
        .on(conductances),
        twin!(fitted, fitted, HESSIAN, |rows: [Row; 3]| {
            let [gx, gy, open] = planes(rows);
            fitted(gx, gy, open)
        })
        .on(conductances),
        // The CPU uses the library's hypot, whose rounding carries over to the sum.
        twin!(
            principal_curvatures,
            principal_curvatures,
            CURVATURES,
            |h: [f32; 3]| { principal_curvatures(h) }
        )
        .on(|words| coarse(words, 100.0))
        .within(Tolerance::Absolute(5e-5)),
        // The CPU uses the library's atan2, sine and cosine.
        twin!(
            principal_direction,
            principal_direction,
            CURVATURES,
            |h: [f32; 3]| { principal_direction(h) }
        )
        .on(|words| coarse(words, 100.0))
        .within(Tolerance::Absolute(1e-6)),
        twin!(
            mapped_curvature,
            mapped_curvature,
            RELIGHT,
            |trace: f32, gain: f32| { mapped_curvature(trace, gain) }
        )
        .on(bounded),
        twin!(
            mapped_curvature_toward,
            mapped_curvature_toward,
            RELIGHT,
            |h: [f32; 3], l: [f32; 2], gain: f32, anisotropy: f32| {
                mapped_curvature_toward(h, l, gain, anisotropy)
            }
        )
        .on(bounded),
    ]
}
