//! New light: every material, method and kind of light.

use super::common::poisoned;
use super::common::scenes::{Scene, Surface};
use super::{assert_alike, on_gpu, with_color};
use glam::{DVec3, Vec3};
use relievo::backend::gpu::{Choice, Device, Runner};
use relievo::backend::{cpu, relit_tolerance};
use relievo::frame::{ColorPlanes, DepthKind, Frame, Mask, Plane, SightLines};
use relievo::light::environment::Environment;
use relievo::light::lights::{DirectionalLight, Illumination, PointLight};
use relievo::light::lit_sphere::LitSphere;
use relievo::params::{
    Adaptive, AlbedoSource, Material, Method, Quantisation, RelightParams, Samples, Scale,
    ScalingParams, ShapeParams, Tangent, WarpBy,
};
use relievo::plan::{Available, LightKinds, Plan};

/// What a test asks for; the rest is as it comes.
#[derive(Clone)]
struct Asked {
    shape: ShapeParams,
    scaling: ScalingParams,
    relight: RelightParams,
    light: Illumination,
}

impl Asked {
    /// Lights from six sides on white.
    fn of(material: Material, method: Method) -> Self {
        let mut relight = RelightParams {
            method,
            albedo: AlbedoSource::White,
            ..RelightParams::default()
        };
        relight.material.material = material;
        relight.material.tangent = Tangent::Degrees(25.0);
        relight.material.coat = [30.0, 90.0];
        Self {
            shape: ShapeParams {
                scale: Scale::Iterations(4),
                ..ShapeParams::default()
            },
            scaling: ScalingParams {
                scaling_diffuse: Some(1.5),
                scaling_specular: Some(0.7),
                ..ScalingParams::default()
            },
            relight,
            light: six_lights(),
        }
    }

    fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    fn around(self, environment: Environment, samples: Samples) -> Self {
        self.with(|asked| {
            asked.light = Illumination {
                environment: Some(environment.into()),
                ..Illumination::default()
            };
            asked.relight.samples = samples;
        })
    }

    fn plan(&self, frame: &Frame) -> Plan {
        Plan::relight(
            Available::in_frame(frame),
            self.shape,
            self.scaling,
            self.relight,
            LightKinds::in_light(&self.light),
        )
        .unwrap()
    }

    #[track_caller]
    fn assert_same(&self, name: &str, runner: &Runner, frame: &Frame) {
        let plan = self.plan(frame);
        assert!(Runner::can_run(&plan), "{name}");
        let expected = cpu::Runner::default().relight(&plan, frame, &self.light);
        let found = runner.relight(&plan, frame, &self.light).unwrap();
        let allowed = relit_tolerance(plan.relighting.as_ref().unwrap(), &self.light);
        assert_alike(name, &plan, &found, &expected, |_| allowed);
    }
}

const LIT: [Material; 6] = [
    Material::Lambert,
    Material::Phong,
    Material::BlinnPhong,
    Material::Toon,
    Material::Sublambert,
    Material::AshikhminShirley,
];

const METHODS: [Method; 4] = [Method::Plain, Method::Warp, Method::Scale, Method::Both];

fn six_lights() -> Illumination {
    let from = [
        [-0.6, 0.6, 0.53],
        [0.9, 0.1, 0.2],
        [0.0, 0.0, 1.0],
        [0.3, -0.8, -0.3],
        [0.1, 0.2, -0.97],
        [-0.4, -0.5, 0.7],
    ];
    let lights = from.into_iter().enumerate();
    let lights = lights.map(|(i, direction)| DirectionalLight {
        to_light: Vec3::from_array(direction).normalize(),
        intensity: [0.4, 0.3 + 0.1 * i as f32, 0.9 - 0.1 * i as f32],
    });
    Illumination {
        directional: lights.collect(),
        ..Illumination::default()
    }
}

/// An environment with a bright side, a dark one, and some colour.
fn sky() -> Environment {
    let blank = Environment::from_fn(64, 32, |_, _| [0.0; 3]);
    let sky = Environment::from_fn(64, 32, |x, y| {
        let [x, y, z] = blank.direction(x, y).to_array();
        let glow = (0.5 + 0.5 * (0.6 * x + 0.5 * y + 0.62 * z)).max(0.0);
        let glow = glow * glow * glow;
        [
            0.1 + 2.0 * glow,
            0.15 + 1.5 * glow,
            0.3 + glow + 0.2 * y.abs(),
        ]
    });
    sky.rotated_deg(33.0)
}

fn ball(bright: f32) -> LitSphere {
    let plane = |k: f32| {
        Plane::from_fn(61, 47, |x, y| {
            bright * (1.0 + (0.09 * k * x as f32).sin() * (0.08 * y as f32).cos())
        })
    };
    LitSphere::new(ColorPlanes {
        r: plane(1.0),
        g: plane(1.4),
        b: plane(0.7),
    })
}

/// Convex, concave and saddle pixels, silhouettes, uncovered corners; with a picture.
fn torus() -> Frame {
    with_color(torus_scene().frame(97, 94))
}

/// The same seen by an eye close by.
fn torus_from_near() -> Frame {
    with_color(torus_scene().in_perspective().frame(97, 94))
}

fn torus_scene() -> Scene {
    let axis = DVec3::new(0.3, 0.2, 0.9);
    Scene::orthographic(Surface::torus(30.0, 14.0, axis), 48.2, 47.1)
}

/// Partly covered pixels, albedo, and light that does not reach every corner.
fn with_layers(mut frame: Frame) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let plane = |k: f32| {
        Plane::from_fn(width, height, |x, y| {
            0.5 + 0.4 * (0.3 * k * x as f32).sin() * (0.2 * y as f32).cos()
        })
    };
    frame.alpha = Some(Plane::from_fn(width, height, |x, y| {
        match (frame.mask.at(x, y), (x + y) % 5) {
            (true, 0) => 0.0,
            (true, k) => 0.2 * k as f32,
            (false, 1) => 0.25,
            (false, _) => 0.0,
        }
    }));
    frame.albedo = Some(ColorPlanes {
        r: plane(1.0),
        g: plane(1.3),
        b: plane(0.6),
    });
    frame.light.occlusion = Some(plane(0.8));
    frame
}

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
        use Material::{AshikhminShirley, BlinnPhong, Lambert, Phong, Sublambert, Toon};
        let table: [(&str, Material, Method, Change); 12] = [
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
                a.relight.warping.warp = 1e9
            }),
            ("a given gain", Lambert, Method::Both, |a| {
                a.scaling.curvature_gain = Adaptive::Fixed(12.0);
            }),
            ("soft tones", BlinnPhong, Method::Both, |a| {
                a.relight.quantisation = Some(Quantisation {
                    levels: 3,
                    softness: 1.0,
                });
            }),
            ("soft tones of a cartoon", Toon, Method::Both, |a| {
                a.relight.quantisation = Some(Quantisation {
                    levels: 5,
                    softness: 1.0,
                });
                a.relight.warping.contrast = 0.7;
            }),
            ("a reference", Lambert, Method::Both, |a| {
                a.shape.scale = Scale::Sigma(3.0);
                a.shape.reference_height = Some(60);
            }),
        ];
        let table = table.into_iter().chain(steep());
        let frame = torus();
        for (name, material, method, change) in table {
            let asked = Asked::of(material, method).with(change);
            asked.assert_same(name, runner, &frame);
        }
    });
}

type Change = fn(&mut Asked);

/// Light that turns roundings into more.
fn steep() -> [(&'static str, Material, Method, Change); 5] {
    use Material::{AshikhminShirley, BlinnPhong, Mirror, Sublambert};
    [
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
            a.relight.quantisation = Some(Quantisation {
                levels: 6,
                softness: 0.02,
            });
        }),
        ("a mirrored check", Mirror, Method::Both, |a| {
            let check = Environment::from_fn(2048, 1024, |x, y| [((x + y) % 2) as f32; 3]);
            a.light = Illumination {
                environment: Some(check.into()),
                ..Illumination::default()
            };
        }),
    ]
}

#[test]
fn hard_tones_are_the_same_but_for_a_pixel_on_the_edge() {
    on_gpu(|runner| {
        let frame = torus();
        for method in METHODS {
            let asked = Asked::of(Material::Toon, method).with(|asked| {
                asked.relight.quantisation = Some(Quantisation {
                    levels: 5,
                    softness: 0.0,
                });
            });
            let plan = asked.plan(&frame);
            let expected = cpu::Runner::default().relight(&plan, &frame, &asked.light);
            let found = runner.relight(&plan, &frame, &asked.light).unwrap();
            let [expected, found] = [expected, found].map(|outcome| outcome.color.unwrap().g);
            let pairs = found.samples().iter().zip(expected.samples());
            let apart = pairs.filter(|(f, e)| (**f - **e).abs() > 1e-5 * e.abs());
            assert!(apart.count() <= 3, "{method:?}");
        }
    });
}

#[test]
fn lights_at_a_point() {
    on_gpu(|runner| {
        for (scene, mut frame) in [("far", torus()), ("near", torus_from_near())] {
            let sight = SightLines::new(frame.camera.unwrap().projection);
            let depth = frame.depth.clone().unwrap();
            let kind = frame.source.depth_kind;
            let covered = (0..97).find(|&x| frame.mask.at(x, 47)).unwrap();
            let near = sight.point(
                covered as f64 + 0.5,
                47.5,
                depth.at(covered, 47).into(),
                kind,
            );
            for kind in [DepthKind::Planar, DepthKind::Ray] {
                frame.source.depth_kind = kind;
                for method in METHODS {
                    let asked = Asked::of(Material::BlinnPhong, method).with(|asked| {
                        asked.light.points = vec![
                            PointLight {
                                position: near.as_vec3() + Vec3::new(-20.0, 30.0, 60.0),
                                intensity: [5000.0, 3000.0, 4000.0],
                            },
                            PointLight {
                                position: near.as_vec3() + Vec3::new(40.0, -10.0, 90.0),
                                intensity: [1000.0, 3000.0, 2000.0],
                            },
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
        let frame = with_layers(torus_from_near());
        for (name, material, samples, warp_by) in [
            ("prefiltered", Lambert, Samples::Fixed(0), WarpBy::Auto),
            (
                "prefiltered by a highlight",
                Phong,
                Samples::Fixed(0),
                WarpBy::Auto,
            ),
            ("a cartoon", Toon, Samples::Fixed(0), WarpBy::Auto),
            ("as lights", BlinnPhong, Samples::Fixed(54), WarpBy::Lights),
            ("looked up", BlinnPhong, Samples::Fixed(64), WarpBy::Lookups),
            ("mirrored", Mirror, Samples::Auto, WarpBy::Auto),
            ("refracted", Glass, Samples::Auto, WarpBy::Auto),
        ] {
            for method in METHODS {
                let asked = Asked::of(material, method).around(sky(), samples);
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
            asked = asked.around(sky().rotated_deg(turn), Samples::Fixed(0));
            let plan = asked.plan(&frame);
            for is_first in [true, false] {
                asked.assert_same("again", runner, &frame);
                let again = runner.relight(&plan, &frame, &asked.light).unwrap();
                let made = again
                    .timings
                    .iter()
                    .any(|(stage, _)| *stage == "environment");
                assert!(!made, "{is_first}");
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
                        asked.light = Illumination {
                            lit_spheres: vec![ball(0.5), ball(0.8)],
                            ..Illumination::default()
                        };
                        asked.light.lit_spheres.truncate(count);
                    });
                    asked.assert_same(&format!("{scene}, {count}, {method:?}"), runner, &frame);
                }
            }
        }
    });
}

#[test]
fn albedo_alpha_and_occlusion() {
    on_gpu(|runner| {
        for albedo in [
            AlbedoSource::Layer,
            AlbedoSource::Picture,
            AlbedoSource::Estimate,
            AlbedoSource::White,
        ] {
            let asked = Asked::of(Material::BlinnPhong, Method::Both);
            let asked = asked.with(|asked| asked.relight.albedo = albedo);
            let mut frame = with_layers(torus());
            asked.assert_same(&format!("{albedo:?}"), runner, &frame);
            frame.alpha = None;
            frame.light.occlusion = None;
            asked.assert_same(&format!("{albedo:?}, opaque"), runner, &frame);
        }
    });
}

#[test]
fn colors_that_are_no_numbers() {
    on_gpu(|runner| {
        let hostile = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            -3.0,
            0.0,
            1e-40,
        ];
        let mut frame = torus();
        let spoiled = |plane: &Plane, of: usize| {
            Plane::from_fn(97, 94, |x, y| match (x * 31 + y * 17 + of) % 11 {
                k if k < hostile.len() => hostile[k],
                _ => plane.at(x, y),
            })
        };
        let color = frame.color.as_ref().unwrap();
        let spoiled = ColorPlanes {
            r: spoiled(&color.r, 0),
            g: spoiled(&color.g, 0),
            b: spoiled(&color.b, 3),
        };
        frame.albedo = Some(spoiled.clone());
        frame.color = Some(spoiled);
        for (material, albedo) in [
            (Material::BlinnPhong, AlbedoSource::Layer),
            (Material::Toon, AlbedoSource::Layer),
            (Material::Lambert, AlbedoSource::Picture),
        ] {
            let asked = Asked::of(material, Method::Both).with(|asked| {
                asked.relight.albedo = albedo;
                asked.relight.quantisation = Some(Quantisation {
                    levels: 4,
                    softness: 1.0,
                });
            });
            let plan = asked.plan(&frame);
            let expected = cpu::Runner::default().relight(&plan, &frame, &asked.light);
            let found = runner.relight(&plan, &frame, &asked.light).unwrap();
            let [expected, found] = [expected, found].map(|outcome| outcome.color.unwrap());
            for (found, expected) in [
                (found.r, expected.r),
                (found.g, expected.g),
                (found.b, expected.b),
            ] {
                for (f, e) in found.samples().iter().zip(expected.samples()) {
                    let same = f == e || f.is_nan() && e.is_nan() || (f - e).abs() < 1e-5 * e.abs();
                    // Small numbers are what is left of the light of 1.
                    assert!(same || f.abs().max(e.abs()) < 1e-5, "{f:e}, not {e:e}");
                }
            }
        }
    });
}

#[test]
fn sizes_and_masks() {
    on_gpu(|runner| {
        let asked = Asked::of(Material::BlinnPhong, Method::Both);
        for (width, height) in [(1, 1), (1, 7), (65, 1), (129, 5)] {
            let scene = Scene::orthographic(Surface::sine_relief(3.0, 24.0, 0.4), 30.0, 20.0);
            let frame = scene.frame(width, height);
            asked.assert_same(&format!("{width}x{height}"), runner, &frame);
        }
        let torus = torus();
        for (name, covers) in [
            ("nothing", (|_, _| false) as fn(usize, usize) -> bool),
            ("one pixel", |x, y| x == 20 && y == 40),
            ("speckled", |x, y| !(x * 7 + y * 13).is_multiple_of(5)),
        ] {
            let mut frame = torus.clone();
            frame.mask = Mask::new(Plane::from_fn(97, 94, |x, y| {
                torus.mask.at(x, y) && covers(x, y)
            }));
            asked.assert_same(name, runner, &frame);
            for poison in [f32::NAN, f32::INFINITY] {
                asked.assert_same(name, runner, &poisoned(&frame, poison));
            }
        }
    });
}

#[test]
fn a_device_that_takes_small_planes_lights_strips() {
    let Ok(device) = Device::open(Choice::Any) else {
        return;
    };
    let frame = with_layers(torus_from_near());
    // 97 columns of vectors of two are 776 bytes a row: 46 rows at a time.
    let runner = Runner::new(device.limited_to(36_000));
    for albedo in [AlbedoSource::Layer, AlbedoSource::Estimate] {
        let asked = Asked::of(Material::BlinnPhong, Method::Both).with(|asked| {
            asked.relight.albedo = albedo;
            asked.light.points = vec![PointLight {
                position: Vec3::new(30.0, 10.0, 50.0),
                intensity: [900.0; 3],
            }];
        });
        asked.assert_same(&format!("{albedo:?}"), &runner, &frame);
    }
    let asked = Asked::of(Material::Mirror, Method::Plain).around(sky(), Samples::Auto);
    asked.assert_same("mirrored", &runner, &frame);
    // 64x32 pixels of 16 bytes fit; four times as many do not.
    let blank = Environment::from_fn(128, 64, |_, _| [1.0; 3]);
    let asked = asked.around(blank, Samples::Auto);
    let plan = asked.plan(&frame);
    assert!(runner.relight(&plan, &frame, &asked.light).is_err());
}

#[test]
fn what_takes_double_precision_stays_with_the_cpu() {
    let frame = torus();
    let grain = Asked::of(Material::AshikhminShirley, Method::Plain)
        .with(|asked| asked.relight.material.tangent = Tangent::Curvature);
    assert!(!Runner::can_run(&grain.plan(&frame)));
}
