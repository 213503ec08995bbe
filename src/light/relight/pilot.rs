//! An environment to a stated error: what stands for it, chosen by trying it on a ball.
//!
//! Diffuse light is looked up in a map where its lights need not be told apart, and is that of lights cut by spread
//! otherwise. Of a highlight, what is brighter than ten times the mean is lights, and the rest filtered samples. How many
//! of each is decided by a pilot: pixels all over a ball, bent as the surface may be, in the light of every texel of the map
//! and in that of each candidate. The ball is always the same, and so is the choice, in tiles, strips and all frames.

use crate::frame::luminance;
use crate::kernel::quantile::quantile;
use crate::kernel::simd::wide;
use crate::light::batch::{BATCH, Lanes, LitPixels};
use crate::light::brdf::mirrored;
use crate::light::cosines::{at_most_1, positive};
use crate::light::environment::Environment;
use crate::light::glossy::GlossyFilter;
use crate::light::intensity::{Intensity, Map, ball};
use crate::light::irradiance::irradiance_filter;
use crate::light::lights::{DirectionalLight, LightChoice, brightened};
use crate::light::median_cut::cut_by_spread;
use crate::light::octahedral::OctahedralMaps;
use crate::light::relight::samples::FilteredSamples;
use crate::light::relight::setting::ToError;
use crate::light::sum::lobes::Lobes;
use crate::light::sum::{Directed, LightSum, LightSums, Shading};
use crate::params::{Material, MaterialParams};
use crate::srgb;
use std::f64::consts::PI;
use std::sync::Arc;

/// Columns of the map that highlights are made of: a sun of half a degree is a pixel.
const WIDTH: usize = 512;

/// Columns of the map whose every texel is a light of the truth, and which diffuse light is cut from.
const TRUTH_WIDTH: usize = 256;

/// What is brighter than this many times the mean is lights.
const BRIGHT: f64 = 10.0;

/// Lights of diffuse light, lights of highlights, and samples, that are tried.
const BASE_LIGHTS: [usize; 5] = [96, 128, 192, 256, 384];
const LIGHTS: [usize; 2] = [32, 64];
const SAMPLES: [usize; 3] = [16, 32, 64];

/// What a light and a sample cost.
const COSTS: [usize; 2] = [3, 4];

/// Share of the error allowed that the base may have where a highlight errs too.
const OF_BASE: f32 = 0.75;

/// Albedo of the ball.
const ALBEDO: f32 = 0.5;

/// What stands for an environment.
pub(crate) enum StandIn {
    Lights(Vec<DirectionalLight>),
    Sampled(SampledLights),
}

/// What stands for an environment on a glossy surface.
#[derive(Debug)]
pub(crate) struct SampledLights {
    /// What is bright, for highlights alone.
    pub(crate) lights: Vec<DirectionalLight>,
    /// The rest, for highlights alone.
    pub(crate) samples: FilteredSamples,
    pub(crate) base: Base,
}

/// All of an environment, for diffuse light alone.
#[derive(Debug)]
pub(crate) enum Base {
    Lights(Vec<DirectionalLight>),
    Map(Map),
}

impl Base {
    pub(crate) fn lights(&self) -> &[DirectionalLight] {
        match self {
            Self::Lights(lights) => lights,
            Self::Map(_) => &[],
        }
    }
}

/// What makes `environment`, times `gain`, reflect from `material` with the error allowed; with the least that is found
/// where no candidate keeps to it.
pub(crate) fn chosen(
    environment: &Environment,
    material: &MaterialParams,
    allowed: ToError,
    (gain, weights): (f32, [f32; 3]),
    goes_on: impl Fn() -> bool + Sync,
) -> (StandIn, LightChoice) {
    let fine = environment.resized(WIDTH);
    let coarse = fine.resized(TRUTH_WIDTH);
    let mut pilot = Pilot::new(&coarse, material, allowed.warp, gain);
    let lights_of = |map: &Environment, count| brightened(cut_by_spread(map, count), gain);
    let mut base_lights = |most| {
        let (lights, levels) = first_within(most, BASE_LIGHTS, &goes_on, |count| {
            let lights = lights_of(&coarse, count);
            let error = pilot.error_of_base(&lights);
            (lights, error)
        });
        pilot.error_of_base(&lights);
        (lights, levels)
    };
    if !allowed.glossy {
        let (lights, levels) = base_lights(allowed.levels);
        let choice = LightChoice {
            lights: lights.len(),
            samples: 0,
            levels,
        };
        return (StandIn::Lights(lights), choice);
    }
    let base = match allowed.apart {
        true => Base::Lights(base_lights(OF_BASE * allowed.levels).0),
        false => {
            let filter = match material.material {
                Material::AshikhminShirley => GlossyFilter::base(&coarse),
                _ => irradiance_filter(&coarse),
            };
            let map = filter.filtered(&goes_on);
            pilot.look_base_up(&map);
            Base::Map(Map {
                environment: map,
                intensity: Intensity::default(),
            })
        }
    };
    let [bright, rest] = split(&fine, weights);
    let finest = FilteredSamples::finest(material, SAMPLES[SAMPLES.len() - 1]);
    let maps = Arc::new(OctahedralMaps::new(&rest, finest));
    let lights = LIGHTS.map(|count| lights_of(&bright, count));
    let mut pairs = Vec::new();
    for (i, lights) in lights.iter().enumerate() {
        // Fewer bright texels are fewer lights.
        if lights.len() == LIGHTS[i] || i == 0 || lights.len() > LIGHTS[i - 1] {
            pairs.extend(SAMPLES.map(|samples| (lights, samples)));
        }
    }
    pairs.sort_by_key(|(lights, samples)| COSTS[0] * lights.len() + COSTS[1] * samples);
    let found = first_within(allowed.levels, pairs, &goes_on, |(lights, count)| {
        let samples = FilteredSamples::new(material, &maps, count, gain);
        let error = pilot.error(lights, &samples);
        ((lights, samples), error)
    });
    let ((lights, samples), levels) = found;
    let choice = LightChoice {
        lights: lights.len() + base.lights().len(),
        samples: samples.count(),
        levels,
    };
    let sampled = SampledLights {
        lights: lights.clone(),
        base,
        samples,
    };
    (StandIn::Sampled(sampled), choice)
}

/// The first candidate whose error is at most `allowed`, else that of the least; where `goes_on` says no, any.
fn first_within<C, T>(
    allowed: f32,
    candidates: impl IntoIterator<Item = C>,
    goes_on: impl Fn() -> bool,
    mut tried: impl FnMut(C) -> (T, f32),
) -> (T, f32) {
    let mut best: Option<(T, f32)> = None;
    for candidate in candidates {
        let found = tried(candidate);
        let is_enough = found.1 <= allowed || !goes_on();
        if best.as_ref().is_none_or(|best| found.1 < best.1) {
            best = Some(found);
        }
        if is_enough {
            break;
        }
    }
    best.expect("there are candidates")
}

/// What is far brighter than the mean, and the rest.
fn split(environment: &Environment, weights: [f32; 3]) -> [Environment; 2] {
    let power = environment.power().into_iter().zip(weights);
    let mean = power.map(|(power, w)| power * f64::from(w)).sum::<f64>() / (4.0 * PI);
    let most = (BRIGHT * mean) as f32;
    let part = |of: fn(f32) -> f32| {
        let (width, height) = (environment.width(), environment.height());
        let map = Environment::from_fn(width, height, |x, y| {
            let radiance = environment.pixel(x, y);
            let share = (most / luminance(radiance, weights).max(f32::MIN_POSITIVE)).min(1.0);
            radiance.map(|v| of(share) * v)
        });
        map.turned_like(environment)
    };
    [part(|share| 1.0 - share), part(|share| share)]
}

/// A ball in the light of every texel, and the diffuse light of what stands for it.
struct Pilot {
    pixels: Box<LitPixels>,
    sum: Box<LightSum>,
    shading: Shading,
    material: MaterialParams,
    gain: f32,
    truth: LightSums,
    base: [Lanes; 3],
}

impl Pilot {
    fn new(map: &Environment, material: &MaterialParams, warp: f32, gain: f32) -> Self {
        let lobes = Lobes::of(material, true).expect("mirrors have no lights");
        let mut pixels = Box::new(LitPixels::new());
        let stride = ball().count() / BATCH;
        for (i, n) in ball().step_by(stride).take(BATCH).enumerate() {
            pixels.normal.set(i, n);
            pixels.mirrored.set(i, mirrored(n, [0.0, 0.0, 1.0]));
            // Curvatures of both signs and all directions, half of them past the one that bends half as much as any.
            let at = |turn: f32| (turn * i as f32).fract() - 0.5;
            let [mean, difference, cross] = [0.618, 0.755, 0.570].map(at);
            pixels.hessian[0][i] = mean + 0.5 * difference;
            pixels.hessian[1][i] = 0.5 * cross;
            pixels.hessian[2][i] = mean - 0.5 * difference;
        }
        pixels.count = BATCH;
        let is_phong = material.material.glows_about_mirrored_view();
        pixels.set_tangents(is_phong, |_| [1.0, 0.0]);
        lobes.see(&mut pixels);
        pixels.warp_by(warp);
        lobes.unwarp_axes(&mut pixels);
        let mut pilot = Self {
            pixels,
            sum: Box::new(LightSum::new()),
            shading: Shading {
                warped: warp > 0.0,
                scaled: None,
                lobes,
            },
            material: *material,
            gain,
            truth: LightSums::NONE,
            base: LightSums::NONE.diffuse,
        };
        let texels = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
        let lights = texels.map(|(x, y)| {
            let share = (map.solid_angle(y) / PI) as f32;
            DirectionalLight {
                to_light: map.direction(x, y),
                intensity: map.pixel(x, y).map(|radiance| share * radiance),
            }
        });
        let lights = brightened(lights.collect(), gain);
        pilot.truth = pilot.lit(&pilot.shading.clone(), &lights, None);
        pilot
    }

    fn lit(
        &mut self,
        shading: &Shading,
        lights: &[DirectionalLight],
        samples: Option<&FilteredSamples>,
    ) -> LightSums {
        let lights = Directed::all(lights);
        let (pixels, sum) = (&self.pixels, &mut self.sum);
        wide!(|fma| light_ball(fma, pixels, sum, shading, &lights, samples));
        self.sum.sums.clone()
    }

    /// Takes the diffuse light of `lights`, and finds its error.
    fn error_of_base(&mut self, lights: &[DirectionalLight]) -> f32 {
        self.base = self.lit(&self.shading.diffuse(), lights, None).diffuse;
        self.error_of(&self.truth.specular)
    }

    /// Takes the diffuse light that `map` tells.
    fn look_base_up(&mut self, map: &Environment) {
        let shares = self.shading.lobes.base_share(&self.pixels);
        for i in 0..BATCH {
            let found = map.radiance(self.pixels.normal.at(i));
            for (base, found) in self.base.iter_mut().zip(found) {
                base[i] = self.gain * shares[i] * found;
            }
        }
    }

    /// The error with this highlight.
    fn error(&mut self, lights: &[DirectionalLight], samples: &FilteredSamples) -> f32 {
        let found = self.lit(&self.shading.clone(), lights, Some(samples));
        self.error_of(&found.specular)
    }

    /// The 99th percentile of the difference from the truth, in grey levels.
    fn error_of(&self, specular: &[Lanes; 3]) -> f32 {
        let MaterialParams {
            ambient,
            diffuse_gain,
            ..
        } = self.material;
        let shown = |diffuse: f32, specular: f32| {
            let diffuse = ALBEDO * (ambient + diffuse_gain * diffuse);
            let shown = diffuse + self.material.specular() * specular;
            255.0 * srgb::encoded(f64::from(at_most_1(positive(shown))))
        };
        let LightSums {
            diffuse: truth,
            specular: glossy,
        } = &self.truth;
        let places = (0..3).flat_map(|k| (0..BATCH).map(move |i| (k, i)));
        let each = places.map(|(k, i)| {
            let found = shown(self.base[k][i], specular[k][i]);
            (found - shown(truth[k][i], glossy[k][i])).abs()
        });
        let mut each: Vec<f64> = each.collect();
        quantile(&mut each, 0.99, f64::total_cmp).unwrap_or(0.0) as f32
    }
}

/// Lights the ball.
#[inline(always)]
fn light_ball(
    fma: bool,
    pixels: &LitPixels,
    sum: &mut LightSum,
    shading: &Shading,
    lights: &[Directed],
    samples: Option<&FilteredSamples>,
) {
    sum.clear();
    sum.add_directed(fma, pixels, shading, lights);
    sum.finish(pixels, shading);
    if let Some(samples) = samples {
        samples.add(pixels, sum, shading, None);
    }
}
