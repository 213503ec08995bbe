//! Every kind of light.

use super::super::on_gpu;
use super::{Asked, METHODS, ball, six_lights, sky, torus, torus_from_near, with_layers};
use glam::Vec3;
use relievo::engine::PlanInputs;
use relievo::frame::{DepthKind, SightLines};
use relievo::light::lights::{Illumination, PointLight};
use relievo::params::{Material, Method, SampleCount, WarpBy};

#[test]
fn lights_at_a_point() {
    on_gpu(|runner| {
        for (scene, mut frame) in [("far", torus()), ("near", torus_from_near())] {
            let sight = SightLines::new(frame.camera.unwrap().projection);
            let depth = frame.depth.clone().unwrap();
            let kind = frame.source.depth_kind;
            let covered = (0..97).find(|&x| frame.mask.at(x, 47)).unwrap();
            let away = depth.at(covered, 47).into();
            let near = sight.point(covered as f64 + 0.5, 47.5, away, kind);
            for kind in [DepthKind::Planar, DepthKind::Ray] {
                frame.source.depth_kind = kind;
                for method in METHODS {
                    let asked = Asked::of(Material::BlinnPhong, method).with(|asked| {
                        let at = |offset: [f32; 3], intensity| PointLight {
                            position: near.as_vec3() + Vec3::from(offset),
                            intensity,
                        };
                        asked.light.points = vec![
                            at([-20.0, 30.0, 60.0], [5000.0, 3000.0, 4000.0]),
                            at([40.0, -10.0, 90.0], [1000.0, 3000.0, 2000.0]),
                        ];
                    });
                    asked.assert_same(&format!("{scene}, {kind:?}, {method:?}"), runner, &frame);
                }
            }
        }
    });
}

#[test]
fn environments() {
    on_gpu(|runner| {
        use Material::{BlinnPhong, Glass, Lambert, Mirror, Phong, Toon};
        use SampleCount::{Auto, Fixed};
        let frame = with_layers(torus_from_near());
        for (name, material, samples, warp_by) in [
            ("prefiltered", Lambert, Fixed(0), WarpBy::Auto),
            ("prefiltered by a highlight", Phong, Fixed(0), WarpBy::Auto),
            ("a cartoon", Toon, Fixed(0), WarpBy::Auto),
            ("as lights", BlinnPhong, Fixed(54), WarpBy::Lights),
            ("looked up", BlinnPhong, Fixed(64), WarpBy::Lookups),
            ("mirrored", Mirror, Auto, WarpBy::Auto),
            ("refracted", Glass, Auto, WarpBy::Auto),
        ] {
            for method in METHODS {
                let asked = Asked::of(material, method).in_environment(sky(), samples);
                let asked = asked.with(|asked| {
                    asked.relight.warp_by = warp_by;
                    if material == Glass {
                        asked.relight.material.thin = method == Method::Scale;
                    } else if material != Mirror {
                        asked.light.directional = six_lights().directional;
                    }
                });
                asked.assert_same(&format!("{name}, {method:?}"), runner, &frame);
            }
        }
    });
}

#[test]
fn an_environment_is_made_ready_once() {
    on_gpu(|runner| {
        let frame = torus();
        let mut asked = Asked::of(Material::Phong, Method::Scale);
        for turn in [0.0, 90.0] {
            asked = asked.in_environment(sky().rotated_deg(turn), SampleCount::Fixed(0));
            let plan = asked.plan(&frame).unwrap();
            for is_first in [true, false] {
                asked.assert_same("again", runner, &frame);
                let again = runner.execute(&plan, &frame, PlanInputs::lit_by(&asked.light));
                let mut stages = again.unwrap().timings.into_iter().map(|(stage, _)| stage);
                assert!(!stages.any(|stage| stage == "environment"), "{is_first}");
            }
        }
    });
}

#[test]
fn lit_spheres() {
    on_gpu(|runner| {
        for (scene, frame) in [
            ("bare", torus()),
            ("layers", with_layers(torus_from_near())),
        ] {
            for count in [1, 2] {
                for method in METHODS {
                    let asked = Asked::of(Material::Lambert, method).with(|asked| {
                        asked.light = Illumination::default();
                        asked.light.lit_spheres = [ball(0.5), ball(0.8)][..count].to_vec();
                    });
                    asked.assert_same(&format!("{scene}, {count}, {method:?}"), runner, &frame);
                }
            }
        }
    });
}
