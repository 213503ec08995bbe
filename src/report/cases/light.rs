//! Cases of light and lines: radiance scaling, warping, materials, environments, drawings.

use super::{Case, apart, correlation, pixels, table, worst};
use crate::engine::{Engine, Outcome, Request, Run};
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::kernel::quantile::quantile;
use crate::light::environment::Environment;
use crate::light::lights::{DirectionalLight, Illumination, direction_of};
use crate::light::radiance_scaling::scaling;
use crate::params::{
    Adaptive, LineParams, Material, Method, Params, RelightParams, SampleCount, Scale,
    ScalingParams, ShapeParams, Solver, StrokeDirections, ToneParams,
};
use crate::plan::{Goal, Tone};
use crate::scenes::frames::{grey, masked};
use crate::scenes::light_reference::{Pixel, Settings, irradiance, lit, sigma, white};
use crate::scenes::{Scene, environment};
use crate::srgb::encoded;

fn run(request: &Request, frame: &Frame) -> Result<Outcome> {
    Engine::cpu().run(request, frame, &Run::new())
}

fn relit(frame: &Frame, params: RelightParams, light: &Illumination) -> Result<Outcome> {
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    run(
        &Request::relight(
            Params {
                relight: params,
                ..Params::of(shape, scaling)
            },
            light,
        ),
        frame,
    )
}

fn lamp(azimuth: f32, elevation: f32) -> Illumination {
    Illumination {
        directional: vec![DirectionalLight {
            to_light: direction_of(azimuth, elevation),
            intensity: [1.0, 0.8, 0.6],
        }],
        ..Illumination::default()
    }
}

fn under(map: Environment) -> Illumination {
    Illumination {
        environment: Some(map.into()),
        ..Illumination::default()
    }
}

/// The largest error of a material in the light of three lamps, in relation to the brightest pixel.
fn material(material: Material, method: Method) -> Result<f64> {
    let frame = Scene::waves(128, 96).frame;
    let params = white(material, method, SampleCount::Auto);
    let directions = [(135.0, 40.0), (20.0, 65.0), (250.0, 25.0)];
    let light = Illumination {
        directional: directions.map(|(a, e)| lamp(a, e).directional[0]).into(),
        ..Illumination::default()
    };
    let outcome = relit(&frame, params, &light)?;
    let gain = outcome.gain.unwrap_or(0.0);
    let scaling = ScalingParams::default();
    let settings = Settings {
        method,
        alpha: f64::from(params.warping.warp * gain),
        gain: gain.into(),
        scaling: &scaling,
        material: &params.material,
    };
    let layers = Request::new(Goal::LAYERS, Params::default());
    let layers = Engine::cpu().run(&layers, &frame, &Run::new())?;
    let hessian = layers.shape.hessian.expect("layers hold it");
    let color = picture(&outcome);
    let mut largest = 0.0_f64;
    let mut off = 0.0_f64;
    for (x, y) in pixels(128, 96) {
        let pixel = Pixel::of(&frame, &hessian, [x, y], 0.0);
        if let Some(exact) = lit(&pixel, &light.directional, &settings) {
            for (plane, exact) in [&color.r, &color.g, &color.b].into_iter().zip(exact) {
                largest = largest.max(exact);
                off = off.max((f64::from(plane.at(x, y)) - exact).abs());
            }
        }
    }
    Ok(off / largest)
}

fn picture(outcome: &Outcome) -> &ColorPlanes {
    outcome.color.as_ref().expect("it makes a picture")
}

fn painted(frame: Frame) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let tone = |hue: f32| {
        Plane::from_fn(width, height, |x, y| {
            hue * (0.3 + 0.2 * ((x + 2 * y) as f32 / 9.0).sin())
        })
    };
    Frame {
        color: Some(ColorPlanes {
            r: tone(1.0),
            g: tone(0.7),
            b: tone(0.4),
        }),
        ..frame
    }
}

/// How far `enhance` changes a picture.
fn changed(frame: &Frame, shape: ShapeParams, scaling: ScalingParams) -> Result<f64> {
    let outcome = run(&Request::enhance(Params::of(shape, scaling)), frame)?;
    let before = frame.color.as_ref().expect("the frame has a picture");
    let Some(after) = &outcome.color else {
        return Ok(0.0);
    };
    Ok(apart(&before.r, &after.r)
        .max(apart(&before.g, &after.g))
        .max(apart(&before.b, &after.b)))
}

/// The scaling of intensity in single precision against double, relative.
fn formula() -> f64 {
    let mut off = 0.0_f64;
    for (i, j) in (0..=200).flat_map(|i| (-60..=60).map(move |j| (i, j))) {
        for alpha in [0.01, 0.25, 0.5, 0.9_f32] {
            let (d, x) = (i as f32 / 200.0, j as f32 / 20.0);
            let exact = sigma(d.into(), x.into(), alpha.into());
            off = off.max((f64::from(scaling(d, x, alpha)) / exact - 1.0).abs());
        }
    }
    off
}

/// One less the correlation of curvature with the logarithm of what brings it out.
fn sign(frame: &Frame, plain: &Plane, scaled: &Plane) -> Result<f64> {
    let layers = Request::layers(Params::default());
    let layers = run(&layers, frame)?;
    let kappa = layers.shape.kappa.as_ref().expect("layers hold it");
    let mut pairs = Vec::new();
    for (x, y) in pixels(frame.mask.width(), frame.mask.height()) {
        let (before, after) = (f64::from(plain.at(x, y)), f64::from(scaled.at(x, y)));
        if frame.mask.at(x, y) && before > 1e-6 && after > 1e-6 {
            pairs.push([(after / before).ln(), kappa.at(x, y).into()]);
        }
    }
    Ok(1.0 - correlation(&pairs))
}

/// A mirror in the even light of a room with one texel of this radiance.
fn mirror(texel: f32) -> Result<f64> {
    let frame = Scene::waves(160, 120).frame;
    let map = Environment::from_fn(64, 32, |x, y| match (x, y) {
        (20, 9) => [texel; 3],
        _ => [0.4 + 0.2 * (y as f32 / 32.0), 0.5, 0.6],
    });
    let light = under(map);
    let params = |method| white(Material::Mirror, method, SampleCount::Auto);
    let of = |method| relit(&frame, params(method), &light);
    let (plain, scaled) = (of(Method::Plain)?, of(Method::Scale)?);
    sign(&frame, &picture(&plain).g, &picture(&scaled).g)
}

/// Light chosen by its error against many lights, for 99 of 100 pixels, in levels of albedo one half.
fn chosen_light(material: Material) -> Result<f64> {
    let frame = Scene::ball(96, 96).frame;
    let light = under(environment());
    let of = |samples| {
        let mut params = white(material, Method::Plain, samples);
        params.environment_gain = Adaptive::Auto;
        relit(&frame, params, &light)
    };
    let (truth, found) = (of(SampleCount::Fixed(4096))?, of(SampleCount::Auto)?);
    let level = |v: f32| 255.0 * encoded(f64::from(0.5 * v).clamp(0.0, 1.0));
    let mut off = Vec::new();
    for (x, y) in pixels(96, 96) {
        if frame.mask.at(x, y) && frame.normal.z.at(x, y) > 0.1 {
            let [a, b] = [&truth, &found].map(|outcome| level(picture(outcome).g.at(x, y)));
            off.push((a - b).abs());
        }
    }
    Ok(quantile(&mut off, 0.99, f64::total_cmp).unwrap_or(f64::NAN))
}

/// The mean ink of a drawing of a tone of one half, against it.
fn ink(directions: StrokeDirections) -> Result<f64> {
    let frame = grey(Scene::waves(480, 360).frame, 0.5);
    let line = LineParams {
        tone: ToneParams {
            white_point: Adaptive::Fixed(1.0),
            black_point: 0.0,
            gamma: 1.0,
            ..ToneParams::default()
        },
        directions,
        interior: None,
        contours: None,
        ..LineParams::default()
    };
    let request = Request::new(Goal::Hatch(Tone::Picture, line), Params::default());
    let outcome = run(&request, &frame)?;
    let ink = &outcome.drawing.as_ref().expect("it draws").hatching;
    let mean =
        ink.samples().iter().map(|v| f64::from(*v)).sum::<f64>() / ink.samples().len() as f64;
    Ok((mean - 0.5).abs())
}

/// How far `enhance` of this strength changes a picture.
fn enhanced(frame: Frame, scaling: f32) -> Result<f64> {
    let scaling = ScalingParams {
        scaling,
        ..ScalingParams::default()
    };
    changed(&painted(frame), ShapeParams::default(), scaling)
}

/// Whether bumps of waves come out brighter.
fn waves_enhanced() -> Result<f64> {
    let frame = grey(Scene::waves(160, 120).frame, 0.3);
    let request = Request::enhance(Params::default());
    let outcome = run(&request, &frame)?;
    let before = frame.color.as_ref().expect("it has a picture");
    sign(&frame, &before.g, &picture(&outcome).g)
}

/// A prefiltered sky against the sum over its texels.
fn prefiltered() -> Result<f64> {
    let frame = Scene::ball(96, 96).frame;
    let map = environment();
    let params = white(Material::Lambert, Method::Plain, SampleCount::Fixed(0));
    let outcome = relit(&frame, params, &under(map.clone()))?;
    let green = &picture(&outcome).g;
    Ok(worst(&frame, |x, y| {
        let is_one_of_many = x % 5 == 0 && y % 5 == 0;
        let exact = || irradiance(&map, frame.normal.at(x, y))[1];
        is_one_of_many.then(|| f64::from(green.at(x, y)) / exact() - 1.0)
    }))
}

fn lit_from_behind() -> Result<f64> {
    let frame = Scene::plane(32, 32).frame;
    let params = white(Material::Lambert, Method::Both, SampleCount::Auto);
    let outcome = relit(&frame, params, &lamp(90.0, -30.0))?;
    let red = &picture(&outcome).r;
    Ok(worst(&frame, |x, y| Some(red.at(x, y).into())))
}

fn by_both_solvers() -> Result<f64> {
    let frame = painted(Scene::waves(160, 120).frame);
    let of = |solver| {
        let shape = ShapeParams {
            scale: Scale::Iterations(50),
            solver,
            ..ShapeParams::default()
        };
        run(
            &Request::enhance(Params::of(shape, ScalingParams::default())),
            &frame,
        )
    };
    let (a, b) = (of(Solver::Explicit)?, of(Solver::Chebyshev)?);
    Ok(apart(&picture(&a).g, &picture(&b).g))
}

#[rustfmt::skip] // It would break the rows.
pub(super) fn cases() -> Vec<Case> {
    use Material::{AshikhminShirley, BlinnPhong, Lambert, Phong};
    use Method::{Both, Plain, Scale as Scaled, Warp};
    table! {
        "enhance --scaling 0", "the picture, bit for bit", 0.0 => enhanced(Scene::waves(96, 80).frame, 0.0);
        "enhance, a facing plane", "the picture, to rounding", 1e-6 => enhanced(Scene::plane(96, 80).frame, 1.0);
        "enhance, no surface", "the picture, bit for bit", 0.0
            => enhanced(masked(Scene::waves(96, 80).frame, |_, _| false), 1.0);
        "scaling of intensity", "[RS] equation 2, in double precision", 2e-6 => Ok(formula());
        "enhance, waves", "bumps brighter, hollows darker: correlation above 0.7", 0.3 => waves_enhanced();
        "mirror, even room", "bumps brighter: correlation above 0.4", 0.6 => mirror(0.5);
        "mirror, one texel of 1e4", "bumps brighter: correlation above 0.4", 0.6 => mirror(1e4);
        "Lambert, plain", "the sum of three lamps", 1e-5 => material(Lambert, Plain);
        "Phong, warped", "the same, bent by [LW]", 1e-4 => material(Phong, Warp);
        "Blinn-Phong, scaled", "the same, scaled by [RS]", 1e-4 => material(BlinnPhong, Scaled);
        "Ashikhmin-Shirley, both", "the same, bent and scaled", 3e-4 => material(AshikhminShirley, Both);
        "Lambert under a formula's sky, prefiltered", "irradiance, summed over every texel", 1e-2 => prefiltered();
        "Lambert, lights chosen by their error", "4096 lights, in levels, 99 % of pixels", 2.0 => chosen_light(Lambert);
        "Phong, lights chosen by their error", "4096 lights, in levels, 99 % of pixels", 2.0 => chosen_light(Phong);
        "light from behind", "nothing is lit", 0.0 => lit_from_behind();
        "--solver explicit and chebyshev, enhanced", "the same picture, to 1e-3", 1e-3 => by_both_solvers();
        "ink of one direction at tone 0.5", "one half of the paper", 0.02 => ink(StrokeDirections::Max);
        "ink of both directions at tone 0.5", "one half of the paper", 0.02 => ink(StrokeDirections::Both);
    }
}
