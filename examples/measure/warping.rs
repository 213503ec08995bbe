//! Error against time of both equations of light warping, by number of samples, as one table.
//!
//! Equation 1 of [LW] looks the environment up in evenly spread directions, each warped; equation 2 sums lights taken
//! by median cut, each with the Jacobian of the warp. Both are compared with many evenly spread lights, summed in
//! double precision at some pixels of waves.

use super::{Outcomes, hessian, luminance, ms, quartiles, some_covered};
use rayon::prelude::*;
use relievo::engine::{Engine, Outcome, PlanInputs, Run};
use relievo::frame::{ColorPlanes, Frame};
use relievo::light::light_samples::uniform_lights;
use relievo::light::lights::{DirectionalLight, Illumination};
use relievo::params::{
    Material, Method, RelightParams, SampleCount, ScalingParams, ShapeParams, WarpBy,
};
use relievo::plan::{Available, Goal, Plan};
use relievo::scenes::light_reference::{Pixel, Settings, lit, white};
use relievo::scenes::{Scene, environment};

const COUNTS: [u32; 5] = [16, 64, 256, 1024, 4096];
/// Lights of the reference. With a quarter as many the sun is off by so much that highlights err by 0.015.
const LIGHTS: usize = 65_536;
/// Pixels that are compared, less those with a light so close to the horizon that rounding decides its side: a third.
const CHECKED: usize = 1000;
const ROUNDS: usize = 3;

/// A pixel and its colour.
type Known = ([usize; 2], [f64; 3]);

pub(super) fn print() -> Outcomes<()> {
    let environment = environment();
    let lights = uniform_lights(&environment, LIGHTS);
    let waves = Waves {
        frame: Scene::waves(480, 270).frame,
        light: Illumination {
            environment: Some(environment.into()),
            ..Illumination::default()
        },
        engine: Engine::cpu(),
    };
    println!("| light | samples | look-ups: error | ms | lights: error | ms |");
    println!("|---|---|---|---|---|---|");
    let materials = [Material::Lambert, Material::Phong];
    for (name, material) in ["diffuse", "highlights"].into_iter().zip(materials) {
        let params = params(material);
        let known = waves.exact(&lights, &params)?;
        for count in COUNTS {
            let by = [WarpBy::Lookups, WarpBy::Lights].map(|warp_by| RelightParams {
                warp_by,
                samples: SampleCount::Fixed(count),
                ..params
            });
            let [by_lookups, by_lights] = waves.measured(&by, &known)?;
            println!("| {name} | {count} | {by_lookups} | {by_lights} |");
        }
    }
    Ok(())
}

/// White: diffuse, or glossy alone, by a lobe that shows a constant environment unchanged.
fn params(material: Material) -> RelightParams {
    let mut params = white(material, Method::Warp, SampleCount::Auto);
    if material == Material::Phong {
        params.material.diffuse_gain = 0.0;
        params.material.specular_gain = Some(0.5 * (params.material.shininess + 1.0));
    }
    params
}

struct Waves {
    frame: Frame,
    light: Illumination,
    engine: Engine,
}

impl Waves {
    fn lit(&self, params: &RelightParams) -> Outcomes<Outcome> {
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let available = Available::in_frame(&self.frame).lit_by(&self.light);
        let plan = Plan::new(Goal::Relight(*params), available, shape, scaling)?;
        let (inputs, run) = (PlanInputs::lit_by(&self.light), Run::new());
        Ok(self.engine.execute(&plan, &self.frame, inputs, &run)?)
    }

    /// Some pixels under `lights`, summed in double precision.
    fn exact(&self, lights: &[DirectionalLight], params: &RelightParams) -> Outcomes<Vec<Known>> {
        let gain = self.lit(params)?.gain.ok_or("warped light has a gain")?;
        let hessian = hessian(&self.frame, ShapeParams::default())?;
        let settings = Settings {
            method: params.method,
            alpha: f64::from(params.warping.warp * gain),
            gain: gain.into(),
            scaling: &ScalingParams::default(),
            material: &params.material,
        };
        let pixels: Vec<_> = some_covered(&self.frame.mask, CHECKED).collect();
        let known = pixels.into_par_iter().filter_map(|at| {
            let pixel = Pixel::of(&self.frame, &hessian, at, 0.0);
            Some((at, lit(&pixel, lights, &settings)?))
        });
        Ok(known.collect())
    }

    /// Of each setting the error of 99 of 100 pixels, relative to the luminance that 98 of 100 stay below, and the
    /// median time of lighting; all run in turn.
    fn measured(&self, settings: &[RelightParams; 2], known: &[Known]) -> Outcomes<[String; 2]> {
        let mut seconds = [Vec::new(), Vec::new()];
        let mut errors = [0.0; 2];
        for _ in 0..ROUNDS {
            for (i, params) in settings.iter().enumerate() {
                let outcome = self.lit(params)?;
                let took = outcome
                    .timings
                    .iter()
                    .find(|(stage, _)| *stage == "relight");
                seconds[i].push(took.ok_or("light is a stage")?.1.as_secs_f64());
                errors[i] = error(
                    outcome.color.as_ref().ok_or("light makes a picture")?,
                    known,
                );
                self.engine.recycle(outcome);
            }
        }
        Ok([0, 1].map(|i| format!("{:.1e} | {}", errors[i], ms(quartiles(&seconds[i])[1]))))
    }
}

fn error(found: &ColorPlanes, known: &[Known]) -> f64 {
    let off = |([x, y], exact): &Known| {
        let found = [&found.r, &found.g, &found.b].map(|plane| f64::from(plane.at(*x, *y)));
        (0..3)
            .map(|c| (found[c] - exact[c]).abs())
            .fold(0.0, f64::max)
    };
    let white = quantile(known.iter().map(|(_, exact)| luminance(*exact)), 0.98);
    quantile(known.iter().map(off), 0.99) / white
}

fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[(share * (values.len() - 1) as f64) as usize]
}
