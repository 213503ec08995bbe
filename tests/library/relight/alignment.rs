//! Light turned to the form.

use super::{Asked, bits, covered, difference, lights, sky, torus_in_perspective};
use crate::prelude::*;

fn aligned(material: Material) -> Asked {
    Asked::of(material, Method::Align)
}

fn plain(asked: &Asked) -> Asked {
    asked
        .clone()
        .with(|asked| asked.relight.method = Method::Plain)
}

/// Ground with small bumps, under which it is flat.
fn ground(height: f32) -> Frame {
    let normals = places(120, 100).flat_map(|(x, y)| {
        let slope = [
            height * (0.5 * x as f32).cos(),
            height * (0.4 * y as f32).cos(),
        ];
        Vec3::new(-slope[0], -slope[1], 1.0).normalize().to_array()
    });
    let normals: Vec<f32> = normals.collect();
    let frame = Frame::builder(120, 100).normals(Normals::view(&normals));
    frame.build().unwrap()
}

#[test]
fn strength_0_and_flat_surfaces_show_plain_light() {
    let frame = torus_in_perspective();
    for material in [
        Material::Lambert,
        Material::Phong,
        Material::AshikhminShirley,
    ] {
        let mut idle = aligned(material);
        assert!(bits(&idle.color(&frame)) != bits(&plain(&idle).color(&frame)));
        idle.relight.align = 0.0;
        assert!(bits(&idle.color(&frame)) == bits(&plain(&idle).color(&frame)));
        let asked = aligned(material);
        let flat = ground(0.0);
        let found = difference(&asked.color(&flat), &plain(&asked).color(&flat));
        assert!(found < 1e-6, "{material:?}: {found}");
    }
}

/// Raking light shows bumps with more contrast, in the same mean.
#[test]
fn detail_stands_out_and_the_mean_stays() {
    let frame = ground(0.3);
    for light in [Vec3::new(0.6, 0.5, 0.4), Vec3::new(-0.3, 0.1, 0.9)] {
        let asked = aligned(Material::Lambert).with(|asked| asked.light = lights(&[light]));
        let [turned, plain] = [asked.color(&frame), plain(&asked).color(&frame)];
        let of = |color: &ColorPlanes| {
            let all = covered(&frame.mask).map(|(x, y)| f64::from(color.g.at(x, y)));
            let all: Vec<f64> = all.collect();
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            let square = all.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            (mean, (square / all.len() as f64).sqrt())
        };
        let ((mean, spread), (expected, before)) = (of(&turned), of(&plain));
        assert!((mean / expected - 1.0).abs() < 0.01, "{mean} {expected}");
        assert!(spread > 1.15 * before, "{spread} {before}");
    }
}

/// The highlight is that of the light as it is: with no diffuse light nothing changes.
#[test]
fn highlights_stay() {
    let frame = torus_in_perspective();
    for material in [
        Material::Phong,
        Material::BlinnPhong,
        Material::AshikhminShirley,
    ] {
        let lamp = aligned(material);
        let around = lamp.clone().in_environment(sky(), SampleCount::Fixed(20));
        for mut asked in [lamp, around] {
            asked.relight.material.diffuse_gain = 0.0;
            let found = difference(&asked.color(&frame), &plain(&asked).color(&frame));
            assert!(found < 1e-5, "{material:?}: {found}");
        }
    }
}

#[test]
fn what_cannot_be_turned_is_refused() {
    let frame = torus_in_perspective();
    let refused = |asked: &Asked| asked.plan(&frame).unwrap_err().to_string();
    let looked_up = aligned(Material::Lambert).in_environment(sky(), SampleCount::Fixed(0));
    assert!(refused(&looked_up).starts_with("--samples"));
    let mirror = aligned(Material::Mirror).in_environment(sky(), SampleCount::Auto);
    assert!(refused(&mirror).starts_with("--method"));
    let even = aligned(Material::Lambert).with(|asked| {
        asked.light = Illumination::default();
        asked.relight.material.ambient = 0.5;
    });
    assert!(refused(&even).starts_with("--method"));
    let around = aligned(Material::Lambert).in_environment(sky(), SampleCount::Auto);
    let plan = around.plan(&frame).unwrap();
    assert!(plan.runs("alignment") && !plan.runs("environment-prefilter"));
}
