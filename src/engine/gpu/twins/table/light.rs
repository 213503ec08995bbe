//! Light.

use super::{Twin, each, twin};
use crate::frame::luminance;
use crate::light::batch::BATCH;
use crate::light::brdf::{
    AshikhminShirley, Cosines, entering, fifth_power, fresnel, mirrored, passed, share_seen,
    thin_sheet,
};
use crate::light::cosines::{at_most_1, positive, scalar_product};
use crate::light::environment::equirectangular_position;
use crate::light::intensity::Intensity;
use crate::light::light_warping::{
    MOST_BRIGHTENED, Warp, bounded_entry, contrast, half_vector, scale_factor,
};
use crate::light::radiance_scaling::{ScalingCurve, scaled, scaling};
use crate::light::relight::gpu::RELIGHT;
use crate::light::relight::shade::premultiplied;
use crate::light::sum::exponent::Exponent;
use crate::light::sum::terms;
use crate::light::texels::mixed;
use crate::light::tones::tone_factor;
use crate::params::{Magnitude, Quantisation};

pub(super) fn twins() -> Vec<Twin> {
    let mut twins = scaling_of_light();
    twins.extend(reflectance());
    twins.extend(warping());
    twins.extend(lights());
    twins
}

fn scaling_of_light() -> Vec<Twin> {
    vec![
        twin("scaling_curve_of", &RELIGHT, |x: f32| {
            let ScalingCurve { dark, bright } = ScalingCurve::of(x);
            [dark, bright]
        })
        .ulps(1),
        twin(
            "scaling_curve_at",
            &RELIGHT,
            |[dark, bright]: [f32; 2], d: f32, alpha: f32| {
                ScalingCurve { dark, bright }.at(d, alpha)
            },
        )
        // Weights of a curve.
        .within(&[(2, 1e-26, 1.0)]),
        // Luminances that samples can have, over a level or against a median.
        twin("intensity_of", &RELIGHT, |l: f32, bend: f32, level: f32| {
            Intensity { bend, level }.of(l)
        })
        .ulps(3)
        .within(&[(1, 0.0, 1e30), (1, 0.0, 1.0), (1, f32::MIN_POSITIVE, 1e30)]),
        twin("scaling", &RELIGHT, scaling).ulps(3),
        twin("scaled", &RELIGHT, scaled),
        twin(
            "exponents_of",
            &RELIGHT,
            |kappa: f32, concave: [f32; 3], convex: [f32; 3]| -> [f32; 3] {
                std::array::from_fn(|i| {
                    let (convex, concave) = (convex[i], concave[i]);
                    Magnitude { convex, concave }.exponent(kappa)
                })
            },
        )
        .with(&["concave_magnitudes", "magnitudes"]),
        twin("luminance", &RELIGHT, luminance).with(&["weights"]),
        twin("premultiplied", &RELIGHT, premultiplied),
        twin(
            "tone_factor",
            &RELIGHT,
            |y: f32, levels: f32, softness: f32, most: f32| {
                tone_factor(
                    y,
                    Quantisation {
                        levels: levels as u32,
                        softness,
                    },
                    most,
                )
            },
        )
        .with(&["tone_levels", "tone_softness", "tone_most"])
        .within(&[(1, 0.0, 2.0), (1, 1.0, 64.0), (1, 0.0, 1.0), (1, 1.0, 64.0)])
        .on(|words| each(&mut words[1..2], f32::floor)),
    ]
}

fn coat(coat: [f32; 2], reflectance: f32) -> AshikhminShirley {
    AshikhminShirley {
        coat,
        reflectance,
        normalisation: 0.0,
    }
}

fn reflectance() -> Vec<Twin> {
    vec![
        twin("fifth_power", &RELIGHT, fifth_power),
        twin("passed", &RELIGHT, passed),
        twin("entering", &RELIGHT, entering),
        twin("share_seen", &RELIGHT, share_seen),
        twin(
            "ashikhmin_shirley_leaving",
            &RELIGHT,
            |cosine: f32, reflectance: f32| coat([0.0; 2], reflectance).leaving(cosine),
        )
        .with(&["lobe_3"]),
        twin(
            "ashikhmin_shirley_reflected",
            &RELIGHT,
            |he: f32, reflectance: f32| coat([0.0; 2], reflectance).reflected(he),
        )
        .with(&["lobe_3"]),
        // Squares of cosines, and exponents of a coat, half of them of a round one.
        twin(
            "ashikhmin_shirley_exponent",
            &RELIGHT,
            |[uu, vv]: [f32; 2], exponents: [f32; 2]| coat(exponents, 0.0).exponent(uu, vv),
        )
        .with(&["lobe_0", "lobe_1"])
        .within(&[(2, 0.0, 4.0), (2, 0.0, 1e6)])
        .on(|words| words[3] = words[2 + words[0] as usize % 2]),
        twin(
            "ashikhmin_shirley_log_lobe",
            &RELIGHT,
            AshikhminShirley::log_lobe,
        )
        .within(&[(1, -4.0, 2.0), (1, 0.0, 1e6)]),
        twin(
            "ashikhmin_shirley_diffuse",
            &RELIGHT,
            |nl: f32, ne: f32, reflectance: f32| coat([0.0; 2], reflectance).diffuse(nl, ne),
        )
        .with(&["lobe_3"]),
        // Cosines beyond 1 by more than rounding.
        twin(
            "ashikhmin_shirley_specular",
            &RELIGHT,
            |[nl, ne, he, hu, hv]: [f32; 5],
             exponents: [f32; 2],
             reflectance: f32,
             normalisation: f32| {
                let model = AshikhminShirley {
                    normalisation,
                    ..coat(exponents, reflectance)
                };
                model.specular(Cosines { nl, ne, he, hu, hv })
            },
        )
        .ulps(3)
        .with(&["lobe_0", "lobe_1", "lobe_3", "lobe_2"])
        .within(&[(5, -2.0, 2.0), (2, 0.0, 1e3), (1, 0.0, 1.0), (1, 0.0, 1e3)]),
        twin("fresnel", &RELIGHT, fresnel),
        twin("mirrored", &RELIGHT, mirrored),
        twin("thin_sheet", &RELIGHT, thin_sheet),
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
        twin("scale_factor", &RELIGHT, scale_factor),
        twin("bounded_entry", &RELIGHT, bounded_entry),
        twin("warp_of", &RELIGHT, |h: [f32; 3], alpha: f32| {
            entries(Warp::of(h, alpha))
        })
        .within(&[(3, -100.0, 100.0), (1, -10.0, 10.0)]),
        twin("warp_determinant", &RELIGHT, |w: [f32; 3]| {
            warp(w).determinant()
        }),
        twin("warp_inverse", &RELIGHT, |w: [f32; 3]| {
            entries(warp(w).inverse())
        }),
        twin("warp_apply", &RELIGHT, |w: [f32; 3], half: [f32; 3]| {
            warp(w).apply(half)
        }),
        twin("warp_direction", &RELIGHT, |w: [f32; 3], half: [f32; 3]| {
            warp(w).direction(half)
        }),
        twin("half_vector", &RELIGHT, half_vector),
        // The determinant of a warp is 1/3 to 3.
        twin("contrast", &RELIGHT, |w: [f32; 3], gamma: f32| {
            contrast(warp(w), gamma)
        })
        .ulps(1)
        .within(&[(1, 0.5, 2.0), (1, -0.4, 0.4), (1, 0.5, 2.0)]),
    ]
}

fn lights() -> Vec<Twin> {
    vec![
        twin("scalar_product", &RELIGHT, scalar_product),
        twin("positive", &RELIGHT, positive),
        twin("at_most_1", &RELIGHT, at_most_1),
        twin("arrive_unwarped", &RELIGHT, arrive_unwarped),
        twin(
            "product",
            &RELIGHT,
            |direction: [f32; 3],
             half: [f32; 3],
             _: f32,
             inverse: f32,
             axis: ([f32; 3], [f32; 2]),
             is_warped: bool| {
                terms::product(direction, is_warped.then_some(half), inverse, axis)
            },
        )
        .with(&["HAS_JACOBIAN"]),
        twin("half_vector_lobe", &RELIGHT, terms::half_vector_lobe),
        twin("unwarped_xy", &RELIGHT, terms::unwarped_xy),
        twin("half_way", &RELIGHT, terms::half_way),
        // Integer powers up to the largest computed by multiplication, real ones up to the largest exponent.
        twin(
            "exponent_raise",
            &RELIGHT,
            |x: f32, whole: u32, power: f32| {
                let mut lanes = [x; BATCH];
                let power = match whole {
                    0 => Exponent::Real(power),
                    whole => Exponent::Integer(whole),
                };
                power.raise(&mut lanes);
                lanes[0]
            },
        )
        .ulps(1)
        .with(&["whole_power", "power"])
        .within(&[(1, 0.0, 1.0), (1, 0.0, 1024.0), (1, 0.0, 1e6)])
        .on(|words| words[1] *= words[0] % 2),
        twin(
            "equirectangular_position",
            &RELIGHT,
            |_: u32, size: [usize; 2], turn: f32, _: [f32; 2], direction: [f32; 3]| {
                equirectangular_position(size, turn, direction)
            },
        )
        .within(&[(3, 1.0, 16384.0), (1, -2.0, 2.0)]),
        twin("mixed", &RELIGHT, |a: [f32; 3], b: [f32; 3], t: f32| {
            let texel = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
            let [x, y, z, _] = mixed(texel(a), texel(b), t);
            [x, y, z]
        }),
    ]
}

fn arrive_unwarped(
    direction: [f32; 3],
    half: [f32; 3],
    share: f32,
    axis: ([f32; 3], [f32; 2]),
    squared: [f32; 3],
) -> [f32; 4] {
    let most = MOST_BRIGHTENED * scalar_product(axis.0, direction);
    let half = terms::HalfVector::of(half);
    let arrived = terms::arrive_unwarped(false, &half, share, axis, squared, most);
    [
        arrived.weight,
        arrived.cosine,
        arrived.inverse,
        arrived.lobe,
    ]
}
