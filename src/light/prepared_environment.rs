//! An environment prepared for relighting: as lights, as maps prefiltered by the lobes, or unchanged; or a lit sphere
//! in its place. Shared by all backends.

use crate::frame::luminance;
use crate::frame::memory::Memory;
use crate::light::brdf::{MIRROR_PEAK, mirrored, seen_in_glass};
use crate::light::environment::Environment;
use crate::light::glossy::GlossyFilter;
use crate::light::intensity::{Intensity, Map, White, ball, median};
use crate::light::irradiance::irradiance_filter;
use crate::light::light_samples::uniform_directions;
use crate::light::lights::{DirectionalLight, Illumination, LightChoice, brightened};
use crate::light::lit_sphere::LitSphere;
use crate::light::median_cut::median_cut;
use crate::light::relight::pilot::{Base, SampledLights, StandIn, chosen};
use crate::light::relight::setting::{EnvironmentUse, Relighting};
use crate::params::{Adaptive, Material, MaterialParams};
use glam::Vec3;
use std::f32::consts::PI;
use std::sync::{Arc, Mutex, PoisonError};

/// Exponent of Phong's lobe about the mirrored view that is as wide as [`MIRROR_PEAK`]'s: a quarter of that about the normal,
/// 2 over it.
const MIRROR_SHININESS: f32 = 0.5 / MIRROR_PEAK;

/// Columns of a map prefiltered by a highlight, which bounds the sharpness of highlights.
const GLOSSY_WIDTH: usize = 512;

/// The surroundings as one plan uses them.
pub(crate) struct Illuminants<'a> {
    pub(crate) ready: Arc<PreparedEnvironment>,
    pub(crate) spheres: &'a [LitSphere],
}

/// Products of an environment, prepared once and shared by all frames it lights.
#[derive(Debug)]
pub(crate) struct PreparedEnvironment {
    /// Gain of its radiance; `None` without an environment.
    gain: Option<f32>,
    /// The luminance of the brightest white surface that faces the viewer; the largest number where it is not known.
    brightest: f32,
    choice: Option<LightChoice>,
    pub(crate) used: Used,
    /// Filtered as surfaces with gloss of their own mirror it.
    pub(crate) gloss: Option<Map>,
}

/// The prepared form of an environment.
#[derive(Debug)]
pub(crate) enum Used {
    Nothing,
    Lights(Vec<DirectionalLight>),
    /// Even directions, and the environment at their resolution.
    Lookups(Vec<Vec3>, Environment),
    Prefiltered {
        diffuse: Map,
        specular: Option<Map>,
    },
    Mirrored(Map),
    Sampled(SampledLights),
    /// Lit spheres, and the intensity of their light.
    LitSpheres(Intensity),
}

/// The parameters that a prepared environment depends on; those of the material that it does not are the default.
#[derive(Debug, Clone, PartialEq)]
struct Purpose {
    used: EnvironmentUse,
    gain: Adaptive,
    material: MaterialParams,
    mirrors: bool,
    white: White,
    weights: [f32; 3],
}

/// The prepared environment of the last run.
#[derive(Debug, Default)]
pub(crate) struct EnvironmentCache(Mutex<Option<LastEnvironment>>);

#[derive(Debug)]
struct LastEnvironment {
    environment: Arc<Environment>,
    purpose: Purpose,
    ready: Arc<PreparedEnvironment>,
}

impl EnvironmentCache {
    /// Drops the cached environment.
    pub(crate) fn forget(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// The cached environment, if it was prepared for this `purpose` from the same environment.
    fn ready(
        &self,
        environment: &Arc<Environment>,
        purpose: &Purpose,
    ) -> Option<Arc<PreparedEnvironment>> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = kept.as_ref()?;
        let same = Arc::ptr_eq(&kept.environment, environment) && kept.purpose == *purpose;
        same.then(|| kept.ready.clone())
    }

    fn keep(
        &self,
        environment: &Arc<Environment>,
        purpose: &Purpose,
        ready: &Arc<PreparedEnvironment>,
    ) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(LastEnvironment {
            environment: environment.clone(),
            purpose: purpose.clone(),
            ready: ready.clone(),
        });
    }
}

impl<'a> Illuminants<'a> {
    /// No environment, but possibly a lit sphere.
    fn nothing(illumination: &'a Illumination, white: White, weights: [f32; 3]) -> Self {
        let spheres = &illumination.lit_spheres;
        let used = match spheres.is_empty() {
            true => Used::Nothing,
            false => Used::LitSpheres(white.of_spheres(spheres, weights)),
        };
        let largest = spheres.iter().map(|s| s.largest_luminance(weights));
        let ready = Arc::new(PreparedEnvironment {
            gain: None,
            brightest: largest.fold(0.0, f32::max),
            choice: None,
            used,
            gloss: None,
        });
        Self { ready, spheres }
    }

    /// Prepares the surroundings for their use; `making` prepares an environment unless it is cached from an earlier
    /// run.
    pub(crate) fn new(
        illumination: &'a Illumination,
        relighting: &Relighting,
        weights: [f32; 3],
        kept: &EnvironmentCache,
        memory: &Memory,
        making: impl FnOnce(&dyn Fn() -> Self) -> Self,
    ) -> Self {
        if relighting.environment == EnvironmentUse::None {
            return Self::nothing(illumination, relighting.white, weights);
        }
        let environment = illumination
            .environment
            .as_ref()
            .expect("an environment is planned with");
        let params = &relighting.params;
        let purpose = Purpose {
            used: relighting.environment,
            gain: params.environment_gain,
            material: match relighting.environment {
                EnvironmentUse::ToError(_) => params.material,
                _ => MaterialParams {
                    material: params.material.material,
                    shininess: params.material.shininess,
                    ior: params.material.ior,
                    thin: params.material.thin,
                    ..MaterialParams::default()
                },
            },
            mirrors: relighting.gloss,
            white: relighting.white,
            weights,
        };
        let spheres = &illumination.lit_spheres;
        if let Some(ready) = kept.ready(environment, &purpose) {
            return Self { ready, spheres };
        }
        making(&|| {
            let ready = Arc::new(PreparedEnvironment::of(environment, &purpose, memory));
            if !memory.is_cancelled() {
                kept.keep(environment, &purpose, &ready);
            }
            Self { ready, spheres }
        })
    }

    /// Gain of the environment's radiance; `None` without an environment.
    pub(crate) fn gain(&self) -> Option<f32> {
        self.ready.gain
    }

    /// The last tone of a cartoon: that of a white surface which unchanged light meets in full, for light that is warped
    /// and scaled adds none. Near a light at a point, and for other materials, there is no last one.
    pub(crate) fn most_tone(
        &self,
        light: &Illumination,
        relighting: &Relighting,
        weights: [f32; 3],
    ) -> f32 {
        let material = &relighting.params.material;
        let is_changed = relighting.warps || relighting.scales || relighting.aligns;
        let has_last = material.material == Material::Toon && is_changed && light.points.is_empty();
        let Some(tones) = relighting.params.tones().filter(|_| has_last) else {
            return f32::MAX;
        };
        let far = light.directional.iter();
        let far: f32 = far.map(|far| luminance(far.intensity, weights)).sum();
        let around = match self.spheres {
            [] => material.diffuse_gain * self.ready.brightest,
            // They include gains of their own.
            _ => self.ready.brightest,
        };
        let most = material.ambient + material.diffuse_gain * far + around;
        (tones.levels as f32 * most.sqrt())
            .round()
            .clamp(1.0, f32::MAX)
    }

    /// Lights that represent the environment.
    pub(crate) fn lights(&self) -> &[DirectionalLight] {
        match &self.ready.used {
            Used::Lights(lights) => lights,
            Used::Sampled(sampled) => &sampled.lights,
            _ => &[],
        }
    }

    /// Those of them that are for diffuse light alone.
    pub(crate) fn base_lights(&self) -> &[DirectionalLight] {
        self.sampled().map_or(&[], |sampled| sampled.base.lights())
    }

    /// What stands for the environment on a glossy surface, if it was chosen by its error.
    pub(crate) fn sampled(&self) -> Option<&SampledLights> {
        match &self.ready.used {
            Used::Sampled(sampled) => Some(sampled),
            _ => None,
        }
    }

    /// What was chosen by its error.
    pub(crate) fn choice(&self) -> Option<LightChoice> {
        self.ready.choice
    }

    /// Even directions in which every pixel looks the environment up.
    pub(crate) fn even_directions(&self) -> &[Vec3] {
        match &self.ready.used {
            Used::Lookups(directions, _) => directions,
            _ => &[],
        }
    }

    /// Whether there are look-ups made once per pixel.
    pub(crate) fn has_lookups(&self) -> bool {
        matches!(
            self.ready.used,
            Used::Prefiltered { .. }
                | Used::Mirrored(_)
                | Used::LitSpheres(_)
                | Used::Sampled(SampledLights {
                    base: Base::Map(_),
                    ..
                })
        )
    }

    /// Whether the environment is looked up in the mirrored view direction.
    pub(crate) fn is_mirrored(&self) -> bool {
        self.ready.gloss.is_some()
            || matches!(
                self.ready.used,
                Used::Mirrored(_)
                    | Used::Prefiltered {
                        specular: Some(_),
                        ..
                    }
            )
    }

    /// The map in which bent sight lines are looked up, and the gain of its radiance.
    pub(crate) fn mirrored(&self) -> Option<(&Map, f32)> {
        match &self.ready.used {
            Used::Mirrored(map) => Some((map, self.ready.gain.unwrap_or(1.0))),
            _ => None,
        }
    }

    /// The environment for look-ups in even directions, and the intensity of each direction for a radiance of 1.
    pub(crate) fn looked_up(&self) -> Option<(&Environment, f32)> {
        match &self.ready.used {
            // Each direction represents 4 pi / n steradians; intensities are over pi.
            Used::Lookups(directions, environment) => {
                let share = 4.0 / directions.len() as f32;
                Some((environment, self.ready.gain.unwrap_or(1.0) * share))
            }
            _ => None,
        }
    }
}

impl PreparedEnvironment {
    fn of(environment: &Environment, purpose: &Purpose, memory: &Memory) -> Self {
        let weights = purpose.weights;
        let goes_on = || !memory.is_cancelled();
        let prefiltered = purpose.used == EnvironmentUse::Prefiltered;
        let irradiance = (prefiltered || purpose.gain == Adaptive::Auto)
            .then(|| irradiance_filter(environment).filtered(goes_on));
        let largest = irradiance.as_ref().map(|map| largest_facing(map, weights));
        let gain = match purpose.gain {
            Adaptive::Fixed(gain) => gain,
            Adaptive::Auto => {
                let largest = largest.unwrap_or(1.0);
                if largest > f32::MIN_POSITIVE {
                    1.0 / largest
                } else {
                    1.0
                }
            }
        };
        let glossy = |shininess| {
            let filter = GlossyFilter::new(environment, shininess, GLOSSY_WIDTH);
            Map::of_views(filter.filtered(goes_on), purpose)
        };
        let mut choice = None;
        let used = match purpose.used {
            EnvironmentUse::None => Used::Nothing,
            EnvironmentUse::Lights(count) => {
                Used::Lights(brightened(median_cut(environment, count as usize), gain))
            }
            EnvironmentUse::ToError(allowed) => {
                let material = &purpose.material;
                let (used, chosen) =
                    chosen(environment, material, allowed, (gain, weights), goes_on);
                choice = Some(chosen);
                match used {
                    StandIn::Lights(lights) => Used::Lights(lights),
                    StandIn::Sampled(sampled) => Used::Sampled(sampled),
                }
            }
            EnvironmentUse::Lookups(count) => {
                // A pixel on the horizon, (2 pi / width)^2, then matches the solid angle of a direction.
                let width = (PI * count as f32).sqrt().ceil() as usize;
                let coarse = environment.resized(width);
                Used::Lookups(uniform_directions(count as usize), coarse)
            }
            EnvironmentUse::Prefiltered => Used::Prefiltered {
                diffuse: Map {
                    environment: irradiance.expect("made above"),
                    intensity: match purpose.white {
                        White::Level(level) => Intensity::by_level(level),
                        _ => Intensity::by_level(largest.expect("found above")),
                    },
                },
                specular: (purpose.material.material == Material::Phong)
                    .then(|| glossy(purpose.material.shininess)),
            },
            EnvironmentUse::Mirrored => Used::Mirrored(Map::of_views(environment.clone(), purpose)),
        };
        Self {
            gain: Some(gain),
            brightest: largest.map_or(f32::MAX, |largest| gain * largest),
            choice,
            used,
            gloss: purpose.mirrors.then(|| glossy(MIRROR_SHININESS)),
        }
    }
}

impl Map {
    /// A map in which bent sight lines are looked up.
    fn of_views(environment: Environment, purpose: &Purpose) -> Self {
        let (weights, material) = (purpose.weights, &purpose.material);
        let to_eye = [0.0, 0.0, 1.0];
        let seen = |n| {
            let mirrored = environment.radiance(mirrored(n, to_eye));
            if material.material != Material::Glass {
                return mirrored;
            }
            let (share, through) = seen_in_glass(n, to_eye, material);
            let through = environment.radiance(through);
            std::array::from_fn(|k| through[k] + share * (mirrored[k] - through[k]))
        };
        let intensity = purpose.white.unlimited(|| {
            let found = median(ball().map(seen), weights);
            found.unwrap_or_else(|| environment.largest_luminance(weights))
        });
        Self {
            environment,
            intensity,
        }
    }
}

/// The largest luminance of a map by normals that face the viewer.
fn largest_facing(map: &Environment, weights: [f32; 3]) -> f32 {
    let pixels = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
    let seen = pixels.filter(|&(x, y)| map.direction(x, y).z >= 0.0);
    seen.map(|(x, y)| luminance(map.pixel(x, y), weights))
        .fold(f32::MIN_POSITIVE, f32::max)
}
