//! Strength 0 is the plain picture, bit for bit; inputs without light are refused.

use super::raking::{ground, raking};
use super::{Asked, LIT, bits, lights, sky, torus_in_perspective};
use crate::prelude::*;
use relievo::light::lit_sphere::LitSphere;

/// Every material, in light that shines on it.
fn all() -> Vec<(String, Asked)> {
    use Material::{Glass, Lambert, Mirror, Phong};
    let of = |material| Asked::of(material, Method::Plain);
    let mut all = Vec::new();
    for material in LIT {
        all.push((format!("{material:?} by a light"), of(material)));
        let sampled = of(material).in_environment(sky(), SampleCount::Fixed(20));
        all.push((format!("{material:?} by an environment"), sampled));
    }
    let (looked_up, auto) = (SampleCount::Fixed(0), SampleCount::Auto);
    for (material, samples) in [
        (Lambert, looked_up),
        (Phong, looked_up),
        (Mirror, auto),
        (Glass, auto),
    ] {
        let asked = of(material).in_environment(sky(), samples);
        all.push((format!("{material:?} by look-ups"), asked));
    }
    let plane = Plane::from_fn(32, 32, |x, y| (x + y) as f32 / 64.0);
    let sphere = LitSphere::new(ColorPlanes::grey(plane));
    let by_sphere = of(Lambert).with(|asked| {
        asked.light = Illumination::default();
        asked.light.lit_spheres.push(sphere);
    });
    all.push(("lit sphere".into(), by_sphere));
    all
}

#[test]
fn strength_0_reproduces_plain_bit_for_bit() {
    let frame = torus_in_perspective();
    for (name, plain) in all() {
        let expected = bits(&plain.color(&frame));
        for method in [Method::Warp, Method::Scale, Method::Both] {
            let mut idle = plain.clone();
            idle.relight.method = method;
            idle.relight.warping.warp = 0.0;
            idle.scaling.scaling = 0.0;
            let idle = bits(&idle.color(&frame));
            assert!(idle == expected, "{name}, {method:?} of 0");
            // Strengths other than 0 have an effect.
            let mut active = plain.clone();
            active.relight.method = method;
            let active = bits(&active.color(&frame));
            assert!(active != expected, "{name}, {method:?}");
        }
    }
}

#[test]
fn a_term_of_magnitude_0_stays_while_another_is_scaled() {
    let frame = torus_in_perspective();
    let mut scaled = Asked::of(Material::Phong, Method::Scale);
    scaled.relight.material.specular_gain = Some(0.0);
    let plain = scaled
        .clone()
        .with(|asked| asked.relight.method = Method::Plain);
    scaled.scaling.scaling_diffuse = Some(0.0);
    scaled.scaling.scaling_specular = Some(2.0);
    assert!(bits(&scaled.color(&frame)) == bits(&plain.color(&frame)));
}

#[test]
fn a_plan_pays_only_for_what_it_needs() {
    let frame = torus_in_perspective();
    let has = |asked: &Asked, step| asked.plan(&frame).unwrap().runs(step);
    let plain = Asked::of(Material::Phong, Method::Plain);
    assert!(!has(&plain, "conductance") && !has(&plain, "hessian"));
    let scaled = Asked::of(Material::Phong, Method::Scale);
    assert!(has(&scaled, "trace") && !has(&scaled, "hessian"));
    let mut toward = scaled.clone();
    toward.scaling.anisotropy = 0.5;
    assert!(has(&toward, "hessian") && !has(&toward, "trace"));
    let warped = Asked::of(Material::Phong, Method::Warp);
    assert!(has(&warped, "hessian") && has(&warped, "jacobian"));
    assert!(!has(&warped, "environment-prefilter") && !has(&warped, "directions"));
    let looked_up = warped.in_environment(sky(), SampleCount::Fixed(0));
    assert!(has(&looked_up, "environment-prefilter") && !has(&looked_up, "jacobian"));
    assert!(!has(&looked_up, "light-sum"));
    let mut brushed = Asked::of(Material::AshikhminShirley, Method::Plain);
    brushed.relight.material.coat = [10.0, 100.0];
    assert!(has(&brushed, "normal-rays") && !has(&brushed, "hessian"));
    brushed.relight.material.tangent = Tangent::Degrees(0.0);
    assert!(!has(&brushed, "normal-rays"));
}

#[test]
fn what_cannot_be_lit_is_refused_with_a_way_out() {
    let frame = torus_in_perspective();
    let of = |material, method| Asked::of(material, method);
    let around = |asked: Asked, samples| asked.in_environment(sky(), samples);
    let by =
        |asked: Asked, directions: &[Vec3]| asked.with(|asked| asked.light = lights(directions));
    let (look_up, lambert) = (SampleCount::Fixed(0), Material::Lambert);
    let even =
        by(of(lambert, Method::Align), &[]).with(|asked| asked.relight.material.ambient = 0.5);
    #[rustfmt::skip]
    let rows = [
        (&frame, by(of(lambert, Method::Plain), &[]), "--light"),
        (&frame, by(of(Material::Mirror, Method::Plain), &[Vec3::Z]), "--environment"),
        (&frame, around(of(Material::AshikhminShirley, Method::Plain), look_up), "--samples"),
        // Light that cannot be turned.
        (&frame, around(of(lambert, Method::Align), look_up), "--samples"),
        (&frame, around(of(Material::Mirror, Method::Align), SampleCount::Auto), "--method"),
        (&frame, even, "--method"),
        (&frame, raking(Raking::Best), "--raking is for flat work"),
        (&ground(), around(raking(Raking::Best), SampleCount::Fixed(20)), "--raking turns lamps"),
    ];
    for (frame, asked, what) in rows {
        let said = asked.plan(frame).unwrap_err().to_string();
        assert!(said.contains(what), "{what}: {said}");
    }
    let plan = around(of(lambert, Method::Align), SampleCount::Auto);
    let plan = plan.plan(&frame).unwrap();
    assert!(plan.runs("alignment") && !plan.runs("environment-prefilter"));
}
