//! The list of cases, continued: everything that could break light.

use super::case::{case, cases};
use super::frames::{ball, cylinder, random, through_a_file, with_normals};
use super::lit::{Asked, judged, judged_picture};
use super::{Case, Expected};
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::light::environment::Environment;
use crate::light::light_samples::uniform_directions;
use crate::light::lights::{DirectionalLight, Illumination};
use crate::params::{
    Adaptive, Material, Method, Samples, ScalingParams, ShapeParams, Tangent, WarpBy,
};
use crate::report::scenes::frames::{gentle, masked, relief};
use glam::Vec3;

/// All cases of light.
pub(super) fn all() -> Vec<Case> {
    let groups = [
        light_cases(),
        material_cases(),
        environment_cases(),
        curvature_cases(),
        scaling_cases(),
        size_cases(),
    ];
    groups.into_iter().flatten().collect()
}

fn lit(
    name: &'static str,
    done: &'static str,
    frame: impl Fn() -> Frame + 'static,
    asked: Asked,
) -> Case {
    case(name, done, Expected::Lit, move || judged(&frame(), &asked))
}

/// Light of intensity 1 from the upper left.
fn usual() -> Illumination {
    from(Vec3::new(-0.6, 0.6, 0.53))
}

fn from(direction: Vec3) -> Illumination {
    Illumination {
        directional: vec![DirectionalLight {
            to_light: direction.normalize(),
            intensity: [1.0; 3],
        }],
        ..Illumination::default()
    }
}

fn of(material: Material, method: Method) -> Asked {
    Asked::of(material, method, usual())
}

fn under(light: Illumination) -> Asked {
    Asked::of(Material::BlinnPhong, Method::Both, light)
}

fn rolling() -> Frame {
    relief(29, 23)
}

fn light_cases() -> Vec<Case> {
    let flat = || with_normals(|_, _| Vec3::Z);
    let many = Illumination {
        directional: uniform_directions(100_000)
            .into_iter()
            .map(|to_light| DirectionalLight {
                to_light,
                intensity: [1e-5; 3],
            })
            .collect(),
        ..Illumination::default()
    };
    cases! {
        lit("light at -z", "straight behind a surface that faces the viewer: black", rolling,
            Asked { dark: true, ..under(from(Vec3::NEG_Z)) });
        lit("light at -z, far sides too", "random unit normals", random(29, 23), under(from(Vec3::NEG_Z)));
        lit("light beside -z", "where the printed warp has lost its digits", random(29, 23),
            under(from(Vec3::new(1e-4, -1e-5, -1.0))));
        lit("light below the surface", "30 degrees under a plane: black", flat,
            Asked { dark: true, ..under(from(Vec3::new(0.75_f32.sqrt(), 0.0, -0.5))) });
        case("no lights", "and nothing else that shines", Expected::Refused,
            || judged(&rolling(), &under(Illumination::default())));
        lit("1e5 lights", "in even directions, together 1", rolling, under(many));
    }
}

fn material_cases() -> Vec<Case> {
    let shiny = |material, shininess| {
        let mut asked = of(material, Method::Both);
        asked.relight.material.shininess = shininess;
        asked
    };
    let coated = |coat, tangent| {
        let mut asked = of(Material::AshikhminShirley, Method::Both);
        asked.relight.material.coat = coat;
        asked.relight.material.tangent = tangent;
        asked
    };
    let [along, grain] = [Tangent::Degrees(20.0), Tangent::Curvature];
    cases! {
        lit("eta 0", "Phong's lobe is a hemisphere", rolling, shiny(Material::Phong, 0.0));
        lit("eta 1e6", "Phong's lobe is a point", rolling, shiny(Material::Phong, 1e6));
        lit("eta 0, Blinn", "the same of Blinn's", rolling, shiny(Material::BlinnPhong, 0.0));
        lit("eta 1e6, Blinn", "the same of Blinn's", rolling, shiny(Material::BlinnPhong, 1e6));
        lit("n_u, n_v 0", "no coat to speak of", rolling, coated([0.0; 2], along));
        lit("n_u, n_v 1e5", "a mirror of a coat", rolling, coated([1e5; 2], along));
        lit("n_u 0, n_v 1e5", "as brushed as can be, along the curvature", rolling, coated([0.0, 1e5], grain));
    }
}

/// A dim sky with one pixel of value `spot`.
fn spotted(spot: f32) -> Illumination {
    let map = Environment::from_fn(64, 32, |x, y| match (x, y) {
        (50, 9) => [spot; 3],
        _ => [0.2, 0.3, 0.4],
    });
    Illumination {
        environment: Some(map.into()),
        ..Illumination::default()
    }
}

fn environment_cases() -> Vec<Case> {
    let around = |material, warp_by, samples, spot| {
        let mut asked = Asked::of(material, Method::Both, spotted(spot));
        asked.relight.warp_by = warp_by;
        asked.relight.samples = samples;
        asked
    };
    let [lights, lookups] = [WarpBy::Lights, WarpBy::Lookups];
    let (some, none) = (Samples::Fixed(54), Samples::Fixed(0));
    let most = Samples::Fixed(crate::params::MAX_LIGHTS);
    let by_lights = around(Material::BlinnPhong, lights, some, 1e6);
    cases! {
        lit("one pixel of 1e6, lights", "54 by median cut", rolling, by_lights);
        lit("one pixel of 1e6, look-ups", "in 54 directions", rolling,
            around(Material::BlinnPhong, lookups, some, 1e6));
        lit("one pixel of 1e6, prefiltered", "both maps", rolling, around(Material::Phong, lookups, none, 1e6));
        lit("one pixel of 1e6, mirrored", "as it is", rolling,
            around(Material::Mirror, lookups, Samples::Auto, 1e6));
        lit("one pixel infinite", "read as 65504", rolling,
            around(Material::BlinnPhong, lights, some, f32::INFINITY));
        lit("one pixel NaN", "read as 0", rolling, around(Material::BlinnPhong, lights, some, f32::NAN));
        lit("more lights than pixels", "1e5 of 2048", rolling, around(Material::Lambert, lights, most, 1.0));
    }
}

fn curvature_cases() -> Vec<Case> {
    // Curvatures are about 0.05: alpha is this gain times the strongest warp.
    let strong = |gain: f32| {
        let mut asked = of(Material::BlinnPhong, Method::Warp);
        asked.relight.warping.warp = 1e6;
        asked.relight.warping.contrast = 1.0;
        asked.scaling.curvature_gain = Adaptive::Fixed(gain);
        asked
    };
    let brushed = || {
        let mut asked = of(Material::AshikhminShirley, Method::Both);
        asked.relight.material.coat = [10.0, 1000.0];
        asked
    };
    cases! {
        lit("alpha k to -1e30", "a ball, warped without end", || ball(0.05), strong(2e25));
        lit("alpha k to 1e30", "a bowl, warped without end", || ball(-0.05), strong(2e25));
        lit("alpha 1e36", "the largest gain of the strongest warp", random(29, 23), strong(1e30));
        lit("light on a ball", "umbilic everywhere: no grain", || ball(0.05), brushed());
        lit("light on a plane", "planar everywhere: no curvature", || with_normals(|_, _| Vec3::new(0.6, 0.0, 0.8)),
            brushed());
        lit("light on a cylinder", "parabolic everywhere", cylinder, brushed());
        lit("light on chaos", "random normals, the far side too", random(29, 23),
            of(Material::Phong, Method::Both));
    }
}

fn scaling_cases() -> Vec<Case> {
    let scaled = |scaling: f32, invariant_point: f32| {
        let mut asked = of(Material::Phong, Method::Both);
        asked.scaling = ScalingParams {
            scaling,
            invariant_point,
            curvature_gain: Adaptive::Fixed(100.0),
            ..ScalingParams::default()
        };
        asked
    };
    let picture = |name, done, expected, spot: f32| {
        case(name, done, expected, move || {
            let loaded = through_a_file(&pictured(spot))?;
            judged_picture(&loaded.frame, &loaded.warnings)
        })
    };
    cases! {
        lit("gamma 0", "nothing is scaled", rolling, scaled(0.0, 0.25));
        lit("gamma 1e3", "the exponent ends at 60", rolling, scaled(1e3, 0.25));
        lit("alpha 0", "an invariant point of 0", rolling, scaled(1.0, 0.0));
        lit("alpha 1", "an invariant point of 1", rolling, scaled(1.0, 1.0));
        lit("gamma 1e3, alpha 0", "both", rolling, scaled(1e3, 0.0));
        picture("delta 50", "a pixel of a picture fifty times white", Expected::Lit, 50.0);
        picture("delta NaN", "a pixel of a picture NaN", Expected::Warned, f32::NAN);
        picture("delta inf", "a pixel of a picture infinite", Expected::Warned, f32::INFINITY);
    }
}

/// A relief with a grey picture and one pixel of value `spot`.
fn pictured(spot: f32) -> Frame {
    let grey = Plane::from_fn(29, 23, |x, y| match (x, y) {
        (14, 11) => spot,
        _ => 0.1 + 0.8 * gentle(x, y).x.abs(),
    });
    Frame {
        color: Some(ColorPlanes {
            r: grey.clone(),
            g: grey.clone(),
            b: grey,
        }),
        ..rolling()
    }
}

fn size_cases() -> Vec<Case> {
    let sampled = || {
        let mut asked = Asked::of(Material::AshikhminShirley, Method::Both, spotted(10.0));
        asked.relight.samples = Samples::Fixed(54);
        asked.shape = ShapeParams::default();
        asked
    };
    let one = || masked(rolling(), |x, y| (x, y) == (14, 11));
    cases! {
        lit("light on nothing", "no pixel covered", || masked(rolling(), |_, _| false), sampled());
        lit("light on one pixel", "of 29x23", one, sampled());
        lit("light on 1x1", "one pixel in all", random(1, 1), sampled());
        lit("light on 1xN", "a column of 300 pixels", random(1, 300), sampled());
        lit("light on Nx1", "a row of 300 pixels", random(300, 1), sampled());
    }
}
