//! Error against time of both equations of light warping, by number of samples, as one table.
//!
//! Equation 1 of [LW] looks the environment up in evenly spread directions, each warped; equation 2 sums lights taken
//! by median cut, each with the Jacobian of the warp. Both are compared with many evenly spread lights, summed in
//! double precision at some pixels of waves.

use crate::common::light_around;
use crate::{Known, Outcomes, errors_of_colors, exact_colors, luminance, ms, plan, quartiles};
use relievo::engine::{Engine, Outcome, PlanInputs, Run};
use relievo::frame::Frame;
use relievo::light::light_samples::uniform_lights;
use relievo::light::lights::Illumination;
use relievo::params::{Material, Method, RelightParams, SampleCount, WarpBy};
use relievo::plan::Goal;
use relievo::scenes::light_reference::{Pixel, Settings, lit, white};
use relievo::scenes::{Scene, environment};

const COUNTS: [u32; 5] = [16, 64, 256, 1024, 4096];
/// Lights of the reference. With a quarter as many the sun is off by so much that highlights err by 0.015.
const LIGHTS: usize = 65_536;
/// Pixels that are compared, less those with a light so close to the horizon that rounding decides its side: a third.
const CHECKED: usize = 1000;
const ROUNDS: usize = 3;

pub(crate) fn print() -> Outcomes<()> {
    let environment = environment();
    let lights = uniform_lights(&environment, LIGHTS);
    let waves = Waves {
        frame: Scene::waves(480, 270).frame,
        light: light_around(environment),
        engine: Engine::cpu(),
    };
    println!("| light | samples | look-ups: error | ms | lights: error | ms |");
    println!("|---|---|---|---|---|---|");
    let materials = [Material::Lambert, Material::Phong];
    for (name, material) in ["diffuse", "highlights"].into_iter().zip(materials) {
        let params = params(material);
        let gain = waves.lit(&params)?.gain.ok_or("warped light has a gain")?;
        let exact = |pixel: &Pixel, settings: &Settings| lit(pixel, &lights, settings);
        let known = exact_colors(&waves.frame, &params, gain, CHECKED, exact)?;
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
        let plan = plan(Goal::Relight(*params), &self.frame, &self.light)?;
        let (inputs, run) = (PlanInputs::lit_by(&self.light), Run::new());
        Ok(self.engine.execute(&plan, &self.frame, inputs, &run)?)
    }

    /// Of each setting the error of 99 of 100 pixels, relative to the luminance that 98 of 100 stay below, and the
    /// median time of lighting; all run in turn.
    fn measured(&self, settings: &[RelightParams; 2], known: &[Known]) -> Outcomes<[String; 2]> {
        let mut seconds = [Vec::new(), Vec::new()];
        let mut errors = [0.0; 2];
        for _ in 0..ROUNDS {
            for (i, params) in settings.iter().enumerate() {
                let outcome = self.lit(params)?;
                let mut timings = outcome.timings.iter();
                let took = timings.find(|(stage, _)| *stage == "relight");
                seconds[i].push(took.ok_or("light is a stage")?.1.as_secs_f64());
                let white = quantile(known.iter().map(|(_, exact)| luminance(*exact)), 0.98);
                errors[i] = quantile(errors_of_colors(&outcome, known), 0.99) / white;
                self.engine.recycle(outcome);
            }
        }
        Ok([0, 1].map(|i| format!("{:.1e} | {}", errors[i], ms(quartiles(&seconds[i])[1]))))
    }
}

fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[(share * (values.len() - 1) as f64) as usize]
}
