//! The pairs.

use super::super::kernels::Kernel;
use super::domains::*;
use super::words::{Namesake, UNSPECIFIED};
use crate::backend::cpu::{key_of, luminance, premultiplied, value_of};
use crate::backend::stroke_field::FieldSetting;
use crate::fast_math::circular::{ATAN, TAN};
use crate::fast_math::exponential::{EXP, LN, split_exp};
use crate::fast_math::{self, polynomial, power_of_two};
use crate::frame::{Projection, SightLines};
use crate::light::batch::BATCH;
use crate::light::brdf::{self, AshikhminShirley, Cosines, fifth_power, passed};
use crate::light::environment::equirectangular_position;
use crate::light::layers::{TermScaling, changed, limited};
use crate::light::light_warping::{
    MOST_BRIGHTENED, Warp, bounded_entry, contrast, half_vector, scale_factor,
};
use crate::light::radiance_scaling::{ScalingCurve, scaled, scaling};
use crate::light::sum::Power;
use crate::light::sum::terms::{self, at_most_1, positive, scalar_product};
use crate::light::texels::mixed;
use crate::light::tones::tone_factor;
use crate::line::contours::crack;
use crate::line::contours::round_stroke::RoundStroke;
use crate::line::direction::{clear_direction, fixed_direction, fixed_second_direction};
use crate::line::direction_field::{Form, calm, doubled, halved};
use crate::line::hatching::share;
use crate::line::normal_rays::{Difference, Local, NormalRay, Slopes, upright_tangents};
use crate::line::paper::{grain, graphite, unit};
use crate::line::slice_texture::{mix, within};
use crate::line::stroke_texture::{ramp_between, ramp_of};
use crate::line::texture_coordinates::{
    in_texture, is_joined, is_one_depth, is_one_motion, jacobian, slope,
};
use crate::params::{Quantisation, ShapeParams, SoftThreshold};
use crate::shape::conductance::face_conductance;
use crate::shape::crease::{CreaseDetector, angle_within};
use crate::shape::curvature::{
    mapped_curvature, mapped_curvature_toward, principal_curvatures, principal_direction,
};
use crate::shape::diffusion::{Update, flux};
use crate::shape::gradient::{depth_gradient, facing};
use crate::shape::hessian::{fitted, in_the_open, plane_fit};
use crate::shape::silhouette::jump_weight;
use crate::shape::sobel;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// A scalar function of WGSL with its namesake.
pub(super) struct Twin {
    pub(super) name: &'static str,
    /// A kernel that has it.
    pub(super) kernel: Kernel,
    /// The namesake, from words to words.
    pub(super) rust: Box<dyn Fn(&[u32], &mut Vec<u32>) + Send + Sync>,
    /// Fields of the uniform block and switches that follow after the arguments.
    pub(super) with: &'static [&'static str],
    /// Brings inputs to where the function is asked.
    pub(super) domain: fn(&mut [u32]),
    pub(super) tolerance: Tolerance,
}

/// How far twins may differ.
#[derive(Clone, Copy)]
pub(super) enum Tolerance {
    /// Not at all: both do the same operations of f32 in the same order.
    Exact,
    /// As many f32 lie between them at the most.
    Ulps(u32),
    Absolute(f32),
}

impl Twin {
    fn new<A>(
        name: &'static str,
        path: &str,
        kernel: Kernel,
        rust: impl Namesake<A> + Send + Sync + 'static,
    ) -> Self {
        assert!(is_namesake(name, path), "{name} is no name for {path}");
        Self {
            name,
            kernel,
            rust: Box::new(move |words, out| rust.run(&mut words.iter().copied(), out)),
            with: &[],
            domain: |_| {},
            tolerance: Tolerance::Exact,
        }
    }

    fn with(mut self, names: &'static [&'static str]) -> Self {
        self.with = names;
        self
    }

    fn on(mut self, domain: fn(&mut [u32])) -> Self {
        self.domain = domain;
        self
    }

    fn within(mut self, tolerance: Tolerance) -> Self {
        self.tolerance = tolerance;
        self
    }
}

/// Functions of which WGSL has its own, which a device computes as it likes: the twin's name ends in `_of`.
const BUILT_IN: [&str; 5] = ["exp", "tanh", "atan", "atan2", "mix"];

/// Whether a WGSL function has the name of the Rust function of a path.
fn is_namesake(wgsl: &str, path: &str) -> bool {
    let path = path.replace(' ', "").replace("::<", "<");
    let mut parts = path.rsplit("::");
    let name = parts.next().unwrap_or_default();
    if let Some((name, _)) = name.split_once('<') {
        // Generic over coefficients, which the name ends with.
        return wgsl
            .strip_prefix(name)
            .is_some_and(|rest| rest.starts_with('_'));
    }
    if BUILT_IN.contains(&name) {
        return wgsl.strip_suffix("_of") == Some(name);
    }
    let mut with_type = String::new();
    for c in parts.next().unwrap_or_default().chars() {
        if c.is_uppercase() && !with_type.is_empty() {
            with_type.push('_');
        }
        with_type.extend(c.to_lowercase());
    }
    wgsl == name || wgsl == format!("{with_type}_{name}")
}

/// A pair: the name in WGSL, the path of the Rust function, which the compiler has to know, and a kernel that has the other.
macro_rules! twin {
    ($name:ident, $path:path, $kernel:ident, $rust:expr) => {{
        let _ = $path;
        Twin::new(stringify!($name), stringify!($path), Kernel::$kernel, $rust)
    }};
}

/// All pairs.
pub(super) fn twins() -> Vec<Twin> {
    let rooms = [
        elementary(),
        edges(),
        curvature(),
        scaling_of_light(),
        reflectance(),
        warping(),
        lights(),
        contours(),
        directions(),
        rays(),
        strokes(),
    ];
    rooms.into_iter().flatten().collect()
}

fn elementary() -> Vec<Twin> {
    vec![
        twin!(
            polynomial_exp,
            fast_math::polynomial::<5>,
            Relight,
            |x: f32| polynomial(x, EXP)
        ),
        twin!(
            polynomial_ln,
            fast_math::polynomial::<8>,
            Relight,
            |x: f32| polynomial(x, LN)
        ),
        twin!(
            polynomial_atan,
            fast_math::polynomial::<5>,
            Relight,
            |x: f32| polynomial(x, ATAN)
        ),
        twin!(
            polynomial_tan,
            fast_math::polynomial::<7>,
            Relight,
            |x: f32| polynomial(x, TAN)
        ),
        twin!(power_of_two, power_of_two, Relight, |n: i32| power_of_two(
            n
        )),
        twin!(is_finite, f32::is_finite, Relight, |x: f32| x.is_finite()),
        twin!(is_nan, f32::is_nan, Relight, |x: f32| x.is_nan()),
        twin!(copysign, f32::copysign, Relight, |size: f32, sign: f32| {
            size.copysign(sign)
        }),
        twin!(split_exp, split_exp, Relight, |x: f32| split_exp(x))
            .on(|words| within_range(words, -104.0, 89.0)),
        twin!(exp_of, fast_math::exp, Relight, |x: f32| fast_math::exp(x)).on(no_nan),
        // WGSL's is for positive, finite and normal numbers.
        twin!(ln, fast_math::ln, Relight, |x: f32| fast_math::ln(x))
            .on(|words| within_range(words, f32::MIN_POSITIVE, f32::MAX)),
        twin!(tanh_of, fast_math::tanh, Relight, |x: f32| fast_math::tanh(
            x
        ))
        .on(no_nan),
        twin!(atan_of, fast_math::atan, Relight, |x: f32| fast_math::atan(
            x
        )),
        twin!(atan2_of, fast_math::atan2, Relight, |y: f32, x: f32| {
            fast_math::atan2(y, x)
        }),
        twin!(
            tan_to_eighth_turn,
            fast_math::tan_to_eighth_turn,
            Relight,
            |x: f32| { fast_math::tan_to_eighth_turn(x) }
        ),
        // The library's is within an ulp; this one rounds a ratio, a square, a root and a product.
        twin!(hypot, f32::hypot, Curvatures, |a: f32, b: f32| a.hypot(b))
            .on(bounded)
            .within(Tolerance::Ulps(3)),
        twin!(key_of, key_of, Count, |value: f32| key_of(value))
            .on(|words| within_range(words, f32::MIN, f32::MAX)),
        twin!(value_of, value_of, Narrow, |key: u32| value_of(key)),
    ]
}

fn edges() -> Vec<Twin> {
    vec![
        twin!(
            soft_threshold_weight,
            SoftThreshold::weight,
            Edges,
            |value: f32, lo: f32, hi: f32| { SoftThreshold { lo, hi }.weight(value) }
        ),
        twin!(sobel, sobel, Edges, |rows: [[f32; 3]; 3]| sobel(rows)),
        twin!(
            jump_weight,
            jump_weight,
            Edges,
            |rows: [[f32; 3]; 3], lo: f32, hi: f32| { jump_weight(rows, SoftThreshold { lo, hi }) }
        )
        .with(&["silhouette_lo", "silhouette_hi"]),
        // The CPU takes the library's atan2.
        twin!(angle_within, angle_within, Edges, |length: f32| {
            angle_within(length)
        })
        .on(no_nan)
        .within(Tolerance::Absolute(1e-6)),
        // The CPU takes the angle from the cross product, this from the chord, which loses digits toward half a turn alone:
        // far past every threshold.
        twin!(
            crease_detector_weight,
            CreaseDetector::weight,
            Edges,
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
        twin!(facing, facing, Edges, |n: [f32; 3], to_eye: [f32; 2]| {
            facing(n.into(), to_eye.into())
        }),
        twin!(
            depth_gradient,
            depth_gradient,
            Edges,
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
            Faces,
            |a: f32, b: f32| face_conductance(a, b)
        ),
        twin!(
            flux,
            flux,
            Sweep,
            |g: [f32; 2], sides: [[f32; 2]; 4], joined: [f32; 4]| {
                [0, 1].map(|k| flux(g[k], sides.map(|side| side[k]), joined))
            }
        ),
        twin!(
            updated,
            Update::updated,
            Sweep,
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

/// A row of three pixels as WGSL has it: gradients left, here and right, and their conductances.
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
        twin!(in_the_open, in_the_open, Hessian, |rows: [Row; 3]| {
            let [gx, gy, _] = planes(rows);
            in_the_open(gx, gy)
        }),
        twin!(plane_fit, plane_fit, Hessian, |rows: [Row; 3]| {
            let [gx, gy, open] = planes(rows);
            plane_fit(gx, gy, open)
        })
        .on(conductances),
        twin!(fitted, fitted, Hessian, |rows: [Row; 3]| {
            let [gx, gy, open] = planes(rows);
            fitted(gx, gy, open)
        })
        .on(conductances),
        // The CPU takes the library's hypot, and a rounding of it is one of the sum.
        twin!(
            principal_curvatures,
            principal_curvatures,
            Curvatures,
            |h: [f32; 3]| { principal_curvatures(h) }
        )
        .on(|words| coarse(words, 100.0))
        .within(Tolerance::Absolute(5e-5)),
        // The CPU takes the library's atan2, sine and cosine.
        twin!(
            principal_direction,
            principal_direction,
            Curvatures,
            |h: [f32; 3]| { principal_direction(h) }
        )
        .on(|words| coarse(words, 100.0))
        .within(Tolerance::Absolute(1e-6)),
        twin!(
            mapped_curvature,
            mapped_curvature,
            Relight,
            |trace: f32, gain: f32| { mapped_curvature(trace, gain) }
        )
        .on(bounded),
        twin!(
            mapped_curvature_toward,
            mapped_curvature_toward,
            Relight,
            |h: [f32; 3], l: [f32; 2], gain: f32, anisotropy: f32| {
                mapped_curvature_toward(h, l, gain, anisotropy)
            }
        )
        .on(bounded),
    ]
}

fn scaling_of_light() -> Vec<Twin> {
    vec![
        twin!(scaling_curve_of, ScalingCurve::of, Relight, |x: f32| {
            let curve = ScalingCurve::of(x);
            [curve.dark, curve.bright]
        }),
        twin!(
            scaling_curve_at,
            ScalingCurve::at,
            Relight,
            |curve: [f32; 2], d: f32, alpha: f32| {
                let [dark, bright] = curve;
                ScalingCurve { dark, bright }.at(d, alpha)
            }
        )
        .on(no_nan),
        twin!(scaling, scaling, Relight, |d: f32, x: f32, alpha: f32| {
            scaling(d, x, alpha)
        })
        .on(no_nan),
        // A scaling is positive and finite.
        twin!(scaled, scaled, Occlude, |c: f32, sigma: f32| scaled(
            c, sigma
        ))
        .on(|words| within_range(&mut words[1..], 1e-27, 1e27)),
        twin!(limited, limited, Occlude, |value: f32, most: f32| limited(
            value, most
        )),
        twin!(
            term_scaling_sigma,
            TermScaling::sigma,
            Occlude,
            |luminance: f32, white: f32, kappa: f32, magnitude: f32, invariant_point: f32| {
                let scaling = TermScaling {
                    magnitude,
                    invariant_point,
                    white,
                    weights: [0.0; 3],
                };
                scaling.sigma(luminance, kappa)
            }
        )
        .with(&["magnitude", "invariant_point"])
        .on(no_nan),
        // What terms change and hold is finite.
        twin!(
            changed,
            changed,
            ChangePicture,
            |c: f32, change: f32, told: f32| { changed(c, change, told) }
        )
        .on(|words| bounded(&mut words[1..])),
        twin!(
            luminance,
            luminance,
            Relight,
            |rgb: [f32; 3], weights: [f32; 3]| { luminance(rgb, weights) }
        )
        .with(&["weight_r", "weight_g", "weight_b"]),
        twin!(
            premultiplied,
            premultiplied,
            Relight,
            |shown: f32, coverage: f32, _: u32| { premultiplied(shown, coverage) }
        )
        .with(&["nan_bits"])
        .on(|words| words[2] = f32::NAN.to_bits()),
        twin!(
            tone_factor,
            tone_factor,
            Relight,
            |y: f32, levels: f32, softness: f32| {
                let levels = levels as u32;
                tone_factor(y, Quantisation { levels, softness })
            }
        )
        .with(&["tone_levels", "tone_softness"])
        .on(|words| {
            within_range(&mut words[1..2], 1.0, 64.0);
            each(&mut words[1..2], f32::floor);
            within_range(&mut words[2..3], 0.0, 1.0);
        }),
    ]
}

fn reflectance() -> Vec<Twin> {
    vec![
        twin!(fifth_power, fifth_power, Relight, |x: f32| fifth_power(x)),
        twin!(passed, passed, Relight, |cosine: f32| passed(cosine)),
        twin!(
            ashikhmin_shirley_diffuse,
            AshikhminShirley::diffuse,
            Relight,
            |nl: f32, ne: f32, reflectance: f32| {
                let model = AshikhminShirley {
                    coat: [0.0; 2],
                    reflectance,
                    normalisation: 0.0,
                };
                model.diffuse(nl, ne)
            }
        )
        .with(&["reflectance"]),
        twin!(
            ashikhmin_shirley_specular,
            AshikhminShirley::specular,
            Relight,
            |cosines: [f32; 5], coat: [f32; 2], reflectance: f32, normalisation: f32| {
                let [nl, ne, he, hu, hv] = cosines;
                let model = AshikhminShirley {
                    coat,
                    reflectance,
                    normalisation,
                };
                model.specular(Cosines { nl, ne, he, hu, hv })
            }
        )
        .with(&[
            "coat_along",
            "coat_across",
            "reflectance",
            "coat_normalisation",
        ])
        .on(|words| {
            within_range(&mut words[..5], -2.0, 2.0);
            within_range(&mut words[5..], 0.0, 1e6);
        }),
        twin!(fresnel, brdf::fresnel, Relight, |cosine: f32, ior: f32| {
            brdf::fresnel(cosine, ior)
        })
        .on(no_nan),
        twin!(
            mirrored,
            brdf::mirrored,
            Relight,
            |n: [f32; 3], eye: [f32; 3]| { brdf::mirrored(n, eye) }
        ),
        twin!(thin_sheet, brdf::thin_sheet, Relight, |r: f32| {
            brdf::thin_sheet(r)
        }),
    ]
}

fn warp([xx, xy, yy]: [f32; 3]) -> Warp {
    Warp { xx, xy, yy }
}

fn entries(warp: Warp) -> [f32; 3] {
    [warp.xx, warp.xy, warp.yy]
}

fn warping() -> Vec<Twin> {
    vec![
        twin!(scale_factor, scale_factor, Relight, |k: f32, alpha: f32| {
            scale_factor(k, alpha)
        }),
        twin!(bounded_entry, bounded_entry, Relight, |h: f32| {
            bounded_entry(h)
        }),
        // The gain times the strength asked for.
        twin!(warp_of, Warp::of, Relight, |h: [f32; 3], alpha: f32| {
            entries(Warp::of(h, alpha))
        })
        .on(|words| within_range(&mut words[3..], -10.0, 10.0)),
        twin!(
            warp_determinant,
            Warp::determinant,
            Relight,
            |w: [f32; 3]| warp(w).determinant()
        ),
        twin!(warp_inverse, Warp::inverse, Relight, |w: [f32; 3]| entries(
            warp(w).inverse()
        )),
        twin!(
            warp_apply,
            Warp::apply,
            Relight,
            |w: [f32; 3], half: [f32; 3]| warp(w).apply(half)
        ),
        twin!(
            warp_direction,
            Warp::direction,
            Relight,
            |w: [f32; 3], half: [f32; 3]| { warp(w).direction(half) }
        ),
        twin!(half_vector, half_vector, Relight, |direction: [f32; 3]| {
            half_vector(direction)
        }),
        twin!(contrast, contrast, Relight, |w: [f32; 3], gamma: f32| {
            contrast(warp(w), gamma)
        })
        .on(|words| {
            // A warp's determinant is 1/3 to 3.
            for (i, (from, to)) in [(0.5, 2.0), (-0.4, 0.4), (0.5, 2.0)]
                .into_iter()
                .enumerate()
            {
                within_range(&mut words[i..=i], from, to);
            }
            bounded(&mut words[3..]);
        }),
    ]
}

fn lights() -> Vec<Twin> {
    vec![
        twin!(
            scalar_product,
            scalar_product,
            Relight,
            |a: [f32; 3], b: [f32; 3]| { scalar_product(a, b) }
        ),
        twin!(positive, positive, Relight, |x: f32| positive(x)),
        twin!(at_most_1, at_most_1, Relight, |x: f32| at_most_1(x)),
        twin!(
            arrive_unwarped,
            terms::arrive_unwarped,
            Relight,
            |direction: [f32; 3],
             half: [f32; 3],
             share: f32,
             axis: ([f32; 3], [f32; 2]),
             squared: [f32; 3]| {
                let most = MOST_BRIGHTENED * scalar_product(axis.0, direction);
                let arrived = terms::arrive_unwarped(half, share, axis, squared, most);
                [
                    arrived.weight,
                    arrived.cosine,
                    arrived.inverse,
                    arrived.lobe,
                ]
            }
        ),
        twin!(
            product,
            terms::product,
            Relight,
            |direction: [f32; 3],
             half: [f32; 3],
             _: f32,
             inverse: f32,
             axis: ([f32; 3], [f32; 2]),
             is_warped: bool| {
                terms::product(direction, is_warped.then_some(half), inverse, axis)
            }
        )
        .with(&["HAS_JACOBIAN"]),
        twin!(
            half_way,
            terms::half_way,
            Relight,
            |le: f32, ln: f32, ne: f32| { terms::half_way(le, ln, ne) }
        ),
        twin!(
            power_raise,
            Power::raise,
            Relight,
            |x: f32, whole: u32, power: f32| {
                let mut lanes = [x; BATCH];
                let power = match whole {
                    0 => Power::Any(power),
                    whole => Power::Whole(whole),
                };
                power.raise(&mut lanes);
                lanes[0]
            }
        )
        .with(&["whole_power", "power"])
        .on(|words| {
            within_range(&mut words[..1], 0.0, 1.0);
            words[1] %= 1025;
            within_range(&mut words[2..], 0.0, 1e6);
        }),
        twin!(
            equirectangular_position,
            equirectangular_position,
            Relight,
            |_: u32, size: [u32; 2], turn: f32, _: f32, direction: [f32; 3]| {
                equirectangular_position(size.map(|v| v as usize), turn, direction)
            }
        )
        .on(|words| {
            words[1..3]
                .iter_mut()
                .for_each(|size| *size = *size % 16384 + 1);
            within_range(&mut words[3..4], -2.0, 2.0);
        }),
        twin!(mixed, mixed, Relight, |a: [f32; 3], b: [f32; 3], t: f32| {
            let texel = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
            let [x, y, z, _] = mixed(texel(a), texel(b), t);
            [x, y, z]
        }),
    ]
}

fn contours() -> Vec<Twin> {
    vec![
        twin!(
            difference,
            crack::difference,
            Cracks,
            |a: Option<f32>, b: Option<f32>| { crack::difference(a, b) }
        ),
        twin!(
            beyond_slopes,
            crack::beyond_slopes,
            Cracks,
            |jump: f32, times: f32, slopes: [Option<f32>; 2]| crack::beyond_slopes(
                jump, times, slopes
            )
        ),
        twin!(steepness, crack::steepness, Cracks, |slope: Option<f32>| {
            crack::steepness(slope)
        }),
        twin!(
            unexplained_jump,
            crack::unexplained_jump,
            Cracks,
            |across: [Option<f32>; 6]| { crack::unexplained_jump(&across) }
        ),
        twin!(
            spread_offset,
            crack::spread_offset,
            Cracks,
            |raw: [f32; 2], sharp: [f32; 2]| { crack::spread_offset(raw, sharp) }
        ),
        twin!(
            nearer_extreme,
            crack::nearer_extreme,
            Cracks,
            |value: f32, least: f32, greatest: f32| crack::nearer_extreme(value, least, greatest)
        ),
        twin!(
            round_stroke_coverage,
            RoundStroke::coverage,
            LineCoverage,
            |numbers: [f32; 8], p: [f32; 2]| RoundStroke::of_numbers(numbers).coverage(p.into())
        )
        .on(|words| {
            within_range(words, -1e6, 1e6);
            within_range(&mut words[7..8], 0.1, 1.0);
        }),
        twin!(unit, unit, LineCoverage, |high: u32| unit(
            u64::from(high) << 32
        )),
        twin!(
            grain,
            grain,
            LineCoverage,
            |x: i32, y: i32, low: u32, high: u32| {
                // The device is given the seed spread over all bits: multiplied by an odd number, of which this is the inverse.
                let spread = u64::from(high) << 32 | u64::from(low);
                grain(x, y, spread.wrapping_mul(0xf1de_83e1_9937_733d))
            }
        )
        .with(&["seed_low", "seed_high"]),
        twin!(
            graphite,
            graphite,
            LineCoverage,
            |coverage: f32, grain: f32| { graphite(coverage, grain) }
        )
        .on(bounded),
    ]
}

/// Sight lines whose line through the point below has the direction `line`.
fn sight([x, y, _]: [f32; 3], pixel_shape: f32) -> (SightLines, [f64; 2]) {
    let fy = f64::from(pixel_shape);
    let sight = SightLines::new(Projection::Perspective {
        fx: 1.0,
        fy,
        cx: 0.0,
        cy: 0.0,
    });
    (sight, [f64::from(x), -f64::from(y) * fy])
}

fn dvec([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into())
}

/// A sight line, a unit vector and the shape of a pixel.
fn seen_vector(words: &mut [u32]) {
    sight_line(words);
    unit_vector(&mut words[3..6]);
}

fn form([x, y, mean, _]: [f32; 4]) -> Form {
    Form {
        deviator: DVec2::new(x.into(), y.into()),
        mean: mean.into(),
    }
}

fn directions() -> Vec<Twin> {
    // The CPU takes f64 for what follows, the device f32.
    const SINGLE: Tolerance = Tolerance::Absolute(2e-6);
    vec![
        twin!(doubled, doubled, SpreadDirections, |t: [f32; 2]| doubled(
            t.into()
        )
        .to_array()),
        twin!(halved, halved, SpreadDirections, |z: [f32; 2]| halved(z)),
        twin!(
            clear_direction,
            clear_direction,
            SpreadDirections,
            |sum: [f32; 2], weight: f32| {
                clear_direction(sum.into(), weight)
                    .unwrap_or_default()
                    .to_array()
            }
        ),
        twin!(
            calm,
            calm,
            SettlePatches,
            |own: [f32; 4], around: [f32; 4]| calm(own, around)
        )
        .on(bounded),
        twin!(form_larger, Form::larger, PatchDirections, |f: [f32; 4]| {
            form(f).larger().unwrap_or_default().as_vec2().to_array()
        })
        .on(|words| coarse(words, 4.0))
        .within(SINGLE),
        twin!(
            form_confidence,
            Form::confidence,
            PatchDirections,
            |f: [f32; 4], doubt: f32| { form(f).confidence(doubt.into()) as f32 }
        )
        .with(&["doubt"])
        .on(|words| {
            coarse(&mut words[..4], 4.0);
            within_range(&mut words[4..], 1e-3, 1.0);
        })
        .within(SINGLE),
        twin!(
            form_flatness,
            Form::flatness,
            PatchDirections,
            |f: [f32; 4], doubt: f32| { form(f).flatness(doubt.into()) as f32 }
        )
        .with(&["doubt"])
        .on(|words| {
            coarse(&mut words[..4], 4.0);
            within_range(&mut words[4..], 0.0, 1.0);
            each(&mut words[4..], |v| if v < 1e-3 { 0.0 } else { v });
        })
        .within(SINGLE),
        twin!(
            fallback,
            FieldSetting::fallback,
            PatchDirections,
            |line: [f32; 3],
             normal: [f32; 3],
             shape: f32,
             order: u32,
             is_fixed: u32,
             fixed: [f32; 2]| {
                let (sight, [x, y]) = sight(line, shape);
                let setting = FieldSetting {
                    fixed: (is_fixed == 1).then_some([Vec2::from(fixed); 2]),
                    sight,
                    pixels: 1.0,
                    cells: 1.0,
                    doubt: 1.0,
                    is_by_depth: false,
                };
                setting
                    .fallback(x, y, dvec(normal), order as usize)
                    .to_array()
            }
        )
        .with(&["pixel_shape", "order", "is_fixed", "fixed_x", "fixed_y"])
        .on(|words| {
            seen_vector(words);
            within_range(&mut words[6..7], 0.5, 2.0);
            words[7] &= 1;
        })
        .within(Tolerance::Absolute(5e-5)),
        twin!(
            fixed_direction,
            fixed_direction,
            PatchDirections,
            |line: [f32; 3], normal: [f32; 3], order: u32, shape: f32| {
                let (sight, [x, y]) = sight(line, shape);
                let direction = match order {
                    0 => fixed_direction(dvec(normal), &sight, x, y),
                    _ => fixed_second_direction(dvec(normal), &sight, x, y),
                };
                direction.to_array()
            }
        )
        .with(&["pixel_shape"])
        .on(|words| {
            seen_vector(words);
            words[6] &= 1;
            within_range(&mut words[7..], 0.5, 2.0);
        })
        .within(Tolerance::Absolute(5e-5)),
    ]
}

fn rays() -> Vec<Twin> {
    // The CPU takes f64 for what follows, the device f32.
    const SINGLE: Tolerance = Tolerance::Absolute(1e-4);
    vec![
        twin!(
            line,
            SightLines::line,
            PatchDirections,
            |place: [f32; 2], line: [f32; 2], step: [f32; 2]| {
                let [[line_x, line_y], [step_x, step_y]] =
                    [line, step].map(|pair| pair.map(f64::from));
                let [fx, fy] = [1.0 / step_x, -1.0 / step_y];
                let sight = SightLines::new(Projection::Perspective {
                    fx,
                    fy,
                    cx: 0.5 - line_x * fx,
                    cy: 0.5 + line_y * fy,
                });
                let (_, direction) = sight.line(place[0].into(), place[1].into());
                direction.as_vec3().to_array()
            }
        )
        .with(&["line_x", "line_y", "line_x_step", "line_y_step"])
        .on(|words| {
            within_range(&mut words[..2], 0.0, 4000.0);
            within_range(&mut words[2..4], -2.0, 2.0);
            within_range(&mut words[4..], 1e-4, 1e-2);
        })
        .within(SINGLE),
        twin!(
            sight_lines_facing,
            SightLines::facing,
            PatchDirections,
            |line: [f32; 3], normal: [f32; 3]| {
                let (sight, [x, y]) = sight(line, 1.0);
                sight.facing(x, y, dvec(normal)) as f32
            }
        )
        .on(seen_vector)
        .within(Tolerance::Absolute(1e-6)),
        twin!(
            picture_direction,
            SightLines::picture_direction,
            PatchDirections,
            |line: [f32; 3], tangent: [f32; 3], shape: f32| {
                let (sight, [x, y]) = sight(line, shape);
                let seen = sight.picture_direction(x, y, dvec(tangent));
                seen.unwrap_or_default().as_vec2().to_array()
            }
        )
        .with(&["pixel_shape"])
        .on(|words| {
            seen_vector(words);
            within_range(&mut words[6..], 0.5, 2.0);
        })
        .within(Tolerance::Absolute(5e-5)),
        twin!(
            sight_lines_step,
            SightLines::step,
            PatchForms,
            |normals: [f32; 3], line: [f32; 3], there: [f32; 3], _: [f32; 3]| {
                let (sight, from) = sight(line, 1.0);
                let (_, to) = self::sight(there, 1.0);
                let step = sight.step(from.into(), dvec(normals), to.into(), DVec3::ZERO);
                let offset = step.map_or([UNSPECIFIED; 3], |step| step.as_vec3().to_array());
                (step.is_some(), offset)
            }
        )
        .on(|words| {
            coarse(&mut words[..3], 2.0);
            sight_line(&mut words[3..6]);
            sight_line(&mut words[6..9]);
            let [normal, line, there] = [0, 3, 6].map(|at| Vec3::from(vector(&words[at..])));
            if normal.dot(there).abs() < 0.25 {
                set(words, &[0.0, 0.0, 1.0]);
            }
            set(&mut words[9..], &(there - line).to_array());
        })
        .within(SINGLE),
        twin!(
            local_ray,
            Local::ray,
            PatchForms,
            |step: (bool, [f32; 3]),
             there: [f32; 3],
             _: [f32; 3],
             normal: [f32; 3],
             tangents: [[f32; 3]; 2]| {
                let local = Local {
                    tangents: tangents.map(dvec),
                    normal: dvec(normal),
                };
                let ray = local.ray(&NormalRay {
                    offset: dvec(step.1),
                    normal: dvec(there),
                });
                match ray.filter(|_| step.0) {
                    Some((foot, slope)) => (true, [foot, slope].map(|v| v.as_vec2().to_array())),
                    None => (false, [[0.0; 2]; 2]),
                }
            }
        )
        .on(|words| {
            coarse(&mut words[1..4], 4.0);
            unit_vector(&mut words[4..7]);
            unit_vector(&mut words[10..13]);
            let [there, normal] = [4, 10].map(|at| Vec3::from(vector(&words[at..])));
            set(&mut words[7..10], &(there - normal).to_array());
            let (a, b) = normal.any_orthonormal_pair();
            set(&mut words[13..16], &a.to_array());
            set(&mut words[16..19], &b.to_array());
        })
        .within(SINGLE),
        twin!(
            slopes_of,
            Slopes::of,
            PatchForms,
            |rays: [(bool, [f32; 2], [f32; 2]); 4]| {
                let between = |before: usize, after: usize| {
                    let (a, b) = (&rays[before], &rays[after]);
                    let difference = |a: [f32; 2], b: [f32; 2]| {
                        DVec2::new(b[0].into(), b[1].into()) - DVec2::new(a[0].into(), a[1].into())
                    };
                    (a.0 || b.0).then(|| Difference {
                        foot: difference(a.1, b.1),
                        slope: difference(a.2, b.2),
                        samples: 1.0,
                    })
                };
                let found = between(0, 1).zip(between(2, 3));
                match found.and_then(|(x, y)| Slopes::of(&x, &y)) {
                    Some(s) => {
                        let all = [s.mean, s.half_difference, s.off, s.area, s.spread];
                        (true, all.map(|v| v as f32))
                    }
                    None => (false, [UNSPECIFIED; 5]),
                }
            }
        )
        .on(|words| {
            for ray in words.chunks_mut(5) {
                coarse(&mut ray[1..], 2.0);
                if ray[0] == 0 {
                    ray.fill(0);
                }
            }
        })
        .within(Tolerance::Absolute(1e-3)),
        twin!(
            any_orthonormal_pair,
            Vec3::any_orthonormal_pair,
            NormalRays,
            |normal: [f32; 3]| {
                let (a, b) = Vec3::from(normal).any_orthonormal_pair();
                [a.to_array(), b.to_array()]
            }
        )
        .on(bounded),
        twin!(
            upright_tangents,
            upright_tangents,
            PatchForms,
            |normal: [f32; 3]| {
                match upright_tangents(dvec(normal)) {
                    Some(tangents) => (true, tangents.map(|t| t.as_vec3().to_array())),
                    None => (false, [[UNSPECIFIED; 3]; 2]),
                }
            }
        )
        .on(|words| {
            unit_vector(words);
            let [x, y, z] = vector(words);
            if z < -0.9 {
                let up = if x + y > 0.0 { 1.0 } else { -1.0 };
                set(words, &[0.0, 0.0, up]);
            }
        })
        .within(SINGLE),
    ]
}

fn strokes() -> Vec<Twin> {
    vec![
        twin!(
            share,
            share,
            Strokes,
            |wanted: f32, family: u32, families: u32| {
                share(wanted, family as usize, families as usize)
            }
        )
        .with(&["family", "families"]),
        twin!(within, within, PictureStrokes, |at: f32, size: u32| {
            let (first, next, share) = within(at, size as usize);
            (first as u32, next as u32, share)
        })
        .on(|words| {
            within_range(&mut words[..1], -4096.0, 4096.0);
            words[1] = words[1] % 4096 + 1;
        }),
        twin!(mix_of, mix, PictureStrokes, |a: f32, b: f32, share: f32| {
            mix(a, b, share)
        }),
        twin!(ramp_of, ramp_of, Strokes, |word: u32| ramp_of(word)),
        twin!(
            ramp_between,
            ramp_between,
            Strokes,
            |word: u32, across: f32| { ramp_between(word, across) }
        ),
        twin!(is_joined, is_joined, Strokes, |a: [f32; 2], b: [f32; 2]| {
            is_joined(a, b)
        }),
        twin!(
            slope,
            slope,
            Strokes,
            |here: [f32; 2], beside: [Option<[f32; 2]>; 2]| { slope(here, beside) }
        ),
        twin!(
            jacobian,
            jacobian,
            Strokes,
            |here: [f32; 2], beside: [Option<[f32; 2]>; 2], over: [Option<[f32; 2]>; 2]| {
                jacobian(here, beside, over)
            }
        ),
        twin!(
            in_texture,
            in_texture,
            Strokes,
            |by: [[f32; 2]; 2], t: [f32; 2]| in_texture(&by, t)
        ),
        twin!(is_one_depth, is_one_depth, Strokes, |a: f32, b: f32| {
            is_one_depth(a, b)
        }),
        twin!(
            is_one_motion,
            is_one_motion,
            Strokes,
            |a: [f32; 2], b: [f32; 2]| { is_one_motion(a, b) }
        ),
    ]
}
