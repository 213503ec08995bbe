//! Twins of light.

use super::*;

pub(super) fn twins() -> Vec<Twin> {
    [
        scaling_of_light(),
        terms_of_light(),
        reflectance(),
        warping(),
        lights(),
        look_ups(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn scaling_of_light() -> Vec<Twin> {
    vec![
        twin!(scaling_curve_of, ScalingCurve::of, RELIGHT, |x: f32| {
            let curve = ScalingCurve::of(x);
            [curve.dark, curve.bright]
        }),
        twin!(
            scaling_curve_at,
            ScalingCurve::at,
            RELIGHT,
            |curve: [f32; 2], d: f32, alpha: f32| {
                let [dark, bright] = curve;
                ScalingCurve { dark, bright }.at(d, alpha)
            }
        )
        .on(no_nan),
        twin!(scaling, scaling, RELIGHT, |d: f32, x: f32, alpha: f32| {
            scaling(d, x, alpha)
        })
        .on(no_nan),
        // A scaling is positive and finite.
        twin!(scaled, scaled, RELIGHT, |c: f32, sigma: f32| scaled(
            c, sigma
        ))
        .on(|words| within_range(&mut words[1..], 1e-27, 1e27)),
    ]
}

fn terms_of_light() -> Vec<Twin> {
    vec![
        twin!(
            luminance,
            luminance,
            RELIGHT,
            |rgb: [f32; 3], weights: [f32; 3]| { luminance(rgb, weights) }
        )
        .with(&["weight_r", "weight_g", "weight_b"]),
        // The device receives the bits of a NaN, which WGSL cannot express.
        twin!(
            premultiplied,
            premultiplied,
            RELIGHT,
            |shown: f32, coverage: f32, _: u32| { premultiplied(shown, coverage) }
        )
        .with(&["nan_bits"])
        .on(|words| words[2] = f32::NAN.to_bits()),
        // Within parameter ranges: whole levels from 1 on, and softness as a share.
        twin!(
            tone_factor,
            tone_factor,
            RELIGHT,
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

fn coat(coat: [f32; 2], reflectance: f32) -> AshikhminShirley {
    AshikhminShirley {
        coat,
        reflectance,
        normalisation: 0.0,
    }
}

fn reflectance() -> Vec<Twin> {
    vec![
        twin!(fifth_power, fifth_power, RELIGHT, |x: f32| fifth_power(x)),
        twin!(passed, passed, RELIGHT, |cosine: f32| passed(cosine)),
        twin!(entering, entering, RELIGHT, |nl: f32| entering(nl)),
        twin!(
            share_seen,
            share_seen,
            RELIGHT,
            |nl: f32, per_ne: f32, per_he: f32| { share_seen(nl, per_ne, per_he) }
        )
        .on(no_nan),
        twin!(
            ashikhmin_shirley_leaving,
            AshikhminShirley::leaving,
            RELIGHT,
            |cosine: f32, reflectance: f32| coat([0.0; 2], reflectance).leaving(cosine)
        )
        .with(&["lobe_3"]),
        twin!(
            ashikhmin_shirley_reflected,
            AshikhminShirley::reflected,
            RELIGHT,
            |he: f32, reflectance: f32| coat([0.0; 2], reflectance).reflected(he)
        )
        .with(&["lobe_3"]),
        // Squares of cosines, and exponents within the ranges of a coat, half of them of a round one.
        twin!(
            ashikhmin_shirley_exponent,
            AshikhminShirley::exponent,
            RELIGHT,
            |squares: [f32; 2], exponents: [f32; 2]| {
                let [uu, vv] = squares;
                coat(exponents, 0.0).exponent(uu, vv)
            }
        )
        .with(&["lobe_0", "lobe_1"])
        .on(|words| {
            within_range(&mut words[..2], 0.0, 4.0);
            within_range(&mut words[2..], 0.0, 1e6);
            if words[0] & 1 == 0 {
                words[3] = words[2];
            }
        }),
        twin!(
            ashikhmin_shirley_log_lobe,
            AshikhminShirley::log_lobe,
            RELIGHT,
            |nh_squared: f32, exponent: f32| AshikhminShirley::log_lobe(nh_squared, exponent)
        )
        .on(|words| {
            within_range(&mut words[..1], -4.0, 2.0);
            within_range(&mut words[1..], 0.0, 1e6);
        }),
        twin!(
            ashikhmin_shirley_diffuse,
            AshikhminShirley::diffuse,
            RELIGHT,
            |nl: f32, ne: f32, reflectance: f32| coat([0.0; 2], reflectance).diffuse(nl, ne)
        )
        .with(&["lobe_3"]),
        // Cosines slightly beyond 1, by more than rounding; exponents and other values within the ranges of a coat.
        twin!(
            ashikhmin_shirley_specular,
            AshikhminShirley::specular,
            RELIGHT,
            |cosines: [f32; 5], coat: [f32; 2], reflectance: f32, normalisation: f32| {
                let [nl, ne, he, hu, hv] = cosines;
                let model = AshikhminShirley {
                    normalisation,
                    ..self::coat(coat, reflectance)
                };
                model.specular(Cosines { nl, ne, he, hu, hv })
            }
        )
        .with(&["lobe_0", "lobe_1", "lobe_3", "lobe_2"])
        .on(|words| {
            within_range(&mut words[..5], -2.0, 2.0);
            within_range(&mut words[5..], 0.0, 1e6);
        }),
        twin!(fresnel, brdf::fresnel, RELIGHT, |cosine: f32, ior: f32| {
            brdf::fresnel(cosine, ior)
        })
        .on(no_nan),
        twin!(
            mirrored,
            brdf::mirrored,
            RELIGHT,
            |n: [f32; 3], eye: [f32; 3]| { brdf::mirrored(n, eye) }
        ),
        twin!(thin_sheet, brdf::thin_sheet, RELIGHT, |r: f32| {
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
        twin!(scale_factor, scale_factor, RELIGHT, |k: f32, alpha: f32| {
            scale_factor(k, alpha)
        }),
        twin!(bounded_entry, bounded_entry, RELIGHT, |h: f32| {
            bounded_entry(h)
        }),
        // The gain times the requested strength.
        twin!(warp_of, Warp::of, RELIGHT, |h: [f32; 3], alpha: f32| {
            entries(Warp::of(h, alpha))
        })
        .on(|words| within_range(&mut words[3..], -10.0, 10.0)),
        twin!(
            warp_determinant,
            Warp::determinant,
            RELIGHT,
            |w: [f32; 3]| warp(w).determinant()
        ),
        twin!(warp_inverse, Warp::inverse, RELIGHT, |w: [f32; 3]| entries(
            warp(w).inverse()
        )),
        twin!(
            warp_apply,
            Warp::apply,
            RELIGHT,
            |w: [f32; 3], half: [f32; 3]| warp(w).apply(half)
        ),
        twin!(
            warp_direction,
            Warp::direction,
            RELIGHT,
            |w: [f32; 3], half: [f32; 3]| { warp(w).direction(half) }
        ),
        twin!(half_vector, half_vector, RELIGHT, |direction: [f32; 3]| {
            half_vector(direction)
        }),
        twin!(contrast, contrast, RELIGHT, |w: [f32; 3], gamma: f32| {
            contrast(warp(w), gamma)
        })
        .on(|words| {
            // The determinant of a warp is 1/3 to 3.
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
            RELIGHT,
            |a: [f32; 3], b: [f32; 3]| { scalar_product(a, b) }
        ),
        twin!(positive, positive, RELIGHT, |x: f32| positive(x)),
        twin!(at_most_1, at_most_1, RELIGHT, |x: f32| at_most_1(x)),
        twin!(
            arrive_unwarped,
            terms::arrive_unwarped::<false>,
            RELIGHT,
            |direction: [f32; 3],
             half: [f32; 3],
             share: f32,
             axis: ([f32; 3], [f32; 2]),
             squared: [f32; 3]| {
                let most = MOST_BRIGHTENED * scalar_product(axis.0, direction);
                let half = terms::HalfVector::of(half);
                let arrived = terms::arrive_unwarped::<false>(&half, share, axis, squared, most);
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
            RELIGHT,
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
            half_vector_lobe,
            terms::half_vector_lobe,
            RELIGHT,
            |normal: [f32; 3], half: [f32; 3]| terms::half_vector_lobe(normal, half)
        ),
        twin!(
            unwarped_xy,
            terms::unwarped_xy,
            RELIGHT,
            |unwarp: [f32; 3], half: [f32; 3], inverse: f32| {
                terms::unwarped_xy(unwarp, half, inverse)
            }
        ),
        twin!(
            half_way,
            terms::half_way,
            RELIGHT,
            |le: f32, ln: f32, ne: f32| { terms::half_way(le, ln, ne) }
        ),
        // A cosine clamped to 0..1; integer powers up to the largest computed by multiplication, real ones up to the
        // largest exponent.
        twin!(
            exponent_raise,
            Exponent::raise,
            RELIGHT,
            |x: f32, whole: u32, power: f32| {
                let mut lanes = [x; BATCH];
                let power = match whole {
                    0 => Exponent::Real(power),
                    whole => Exponent::Integer(whole),
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
    ]
}

fn look_ups() -> Vec<Twin> {
    vec![
        // A map has at least one pixel and at most 16384 per side.
        twin!(
            equirectangular_position,
            equirectangular_position,
            RELIGHT,
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
        twin!(mixed, mixed, RELIGHT, |a: [f32; 3], b: [f32; 3], t: f32| {
            let texel = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
            let [x, y, z, _] = mixed(texel(a), texel(b), t);
            [x, y, z]
        }),
    ]
}
