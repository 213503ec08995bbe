//! Every material and method, and the numbers they are tuned by.

use super::super::on_gpu;
use super::{Asked, LIT, METHODS, torus, torus_from_near};
use relievo::light::environment::Environment;
use relievo::light::lights::Illumination;
use relievo::params::{Adaptive, Material, Method, Scale};

#[test]
fn materials_and_methods() {
    on_gpu(|runner| {
        for (scene, frame) in [("far", torus()), ("near", torus_from_near())] {
            for material in LIT {
                for method in METHODS {
                    let name = format!("{scene}, {material:?}, {method:?}");
                    Asked::of(material, method).assert_same(&name, runner, &frame);
                }
            }
        }
    });
}

#[test]
fn numbers_of_materials_and_methods() {
    on_gpu(|runner| {
        use Material::{AshikhminShirley, BlinnPhong, Lambert, Mirror, Phong, Sublambert, Toon};
        let table: [(&str, Material, Method, Change); 17] = [
            ("a power that is not whole", Phong, Method::Both, |a| {
                a.relight.material.shininess = 12.7
            }),
            ("no power", BlinnPhong, Method::Both, |a| {
                a.relight.material.shininess = 0.0
            }),
            ("flatter", Sublambert, Method::Warp, |a| {
                a.relight.material.flatness = 0.8
            }),
            ("a round coat", AshikhminShirley, Method::Both, |a| {
                a.relight.material.coat = [20.0; 2];
                a.relight.material.reflectance = 0.4;
            }),
            ("contrast", BlinnPhong, Method::Both, |a| {
                a.relight.warping.contrast = -0.7
            }),
            ("toward the light", BlinnPhong, Method::Both, |a| {
                a.scaling.anisotropy = 0.6
            }),
            ("across the light", Lambert, Method::Scale, |a| {
                a.scaling.anisotropy = -1.0
            }),
            ("a strong warp", Phong, Method::Warp, |a| {
                a.relight.warping.warp = 1e6
            }),
            ("a given gain", Lambert, Method::Both, |a| {
                a.scaling.curvature_gain = Adaptive::Fixed(12.0);
            }),
            ("soft tones", BlinnPhong, Method::Both, |a| {
                a.relight.toon_levels = Some(3);
                a.relight.toon_softness = 1.0;
            }),
            ("soft tones of a cartoon", Toon, Method::Both, |a| {
                a.relight.toon_levels = Some(5);
                a.relight.toon_softness = 1.0;
                a.relight.warping.contrast = 0.7;
            }),
            ("a reference", Lambert, Method::Both, |a| {
                a.shape.scale = Scale::Sigma(3.0);
                a.shape.reference_height = Some(60);
            }),
            // Light that amplifies rounding.
            ("a small highlight", BlinnPhong, Method::Both, |a| {
                a.relight.material.shininess = 3000.5;
            }),
            ("a brushed coat", AshikhminShirley, Method::Both, |a| {
                a.relight.material.coat = [5.0, 1000.0];
            }),
            ("almost flat", Sublambert, Method::Warp, |a| {
                a.relight.material.flatness = 0.2;
            }),
            ("nearly hard tones", BlinnPhong, Method::Scale, |a| {
                a.relight.toon_levels = Some(6);
                a.relight.toon_softness = 0.02;
            }),
            ("a mirrored check", Mirror, Method::Both, |a| {
                let check = Environment::from_fn(2048, 1024, |x, y| [((x + y) % 2) as f32; 3]);
                a.light = Illumination {
                    environment: Some(check.into()),
                    ..Illumination::default()
                };
            }),
        ];
        let frame = torus();
        for (name, material, method, change) in table {
            let asked = Asked::of(material, method).with(change);
            asked.assert_same(name, runner, &frame);
        }
    });
}

type Change = fn(&mut Asked);

#[test]
fn hard_tones_are_the_same_but_for_a_pixel_on_the_edge() {
    on_gpu(|runner| {
        let frame = torus();
        for method in METHODS {
            let asked = Asked::of(Material::Toon, method).with(|asked| {
                asked.relight.toon_levels = Some(5);
                asked.relight.toon_softness = 0.0;
            });
            let made = asked.outcomes(runner, &frame);
            let [found, expected] = made.map(|outcome| outcome.color.unwrap().g);
            let pairs = found.samples().iter().zip(expected.samples());
            let apart = pairs.filter(|(f, e)| (**f - **e).abs() > 1e-5 * e.abs());
            assert!(apart.count() <= 3, "{method:?}");
        }
    });
}
