//! Light turned to the form.

use super::{Asked, bits, difference, facing, lights, sky, torus_in_perspective};
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
    facing(120, 100, |x, y| {
        let slope = [(0.5 * x as f32).cos(), (0.4 * y as f32).cos()].map(|v| height * v);
        Vec3::new(-slope[0], -slope[1], 1.0)
    })
}

#[test]
fn strength_0_and_flat_surfaces_show_plain_light() {
    let frame = torus_in_perspective();
    use Material::{AshikhminShirley, Lambert, Phong};
    for material in [Lambert, Phong, AshikhminShirley] {
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
    use Material::{AshikhminShirley, BlinnPhong, Phong};
    for material in [Phong, BlinnPhong, AshikhminShirley] {
        let lamp = aligned(material);
        let around = lamp.clone().in_environment(sky(), SampleCount::Fixed(20));
        for mut asked in [lamp, around] {
            asked.relight.material.diffuse_gain = 0.0;
            let found = difference(&asked.color(&frame), &plain(&asked).color(&frame));
            assert!(found < 1e-5, "{material:?}: {found}");
        }
    }
}
