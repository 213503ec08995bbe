//! What is around the surface: an environment as lights, as maps prefiltered by the lobes, or as it is;
//! or a lit sphere in its place.

use super::Scene;
use super::batch::Batch;
use super::shade::TERMS;
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::light::batch::{Lanes, Pixels};
use crate::light::brdf::{fresnel, refracted, thin_sheet};
use crate::light::environment::Environment;
use crate::light::glossy::GlossyFilter;
use crate::light::irradiance::irradiance_filter;
use crate::light::light_samples::uniform_directions;
use crate::light::lights::{DirectionalLight, Illumination};
use crate::light::lit_sphere::LitSphere;
use crate::light::median_cut::median_cut;
use crate::params::{Adaptive, Material};
use crate::plan::{EnvironmentUse, Relighting};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Columns of a map prefiltered by a highlight; narrower highlights are looked up as if they were as wide.
const GLOSSY_WIDTH: usize = 512;

/// The surroundings as one plan uses them.
pub(in super::super) struct Around<'a> {
    /// Factor of radiance.
    gain: Option<f32>,
    used: Used<'a>,
}

enum Used<'a> {
    Nothing,
    Lights(Vec<DirectionalLight>),
    /// Even directions, and the environment no finer than they are.
    Lookups(Vec<Vec3>, Environment),
    Prefiltered {
        diffuse: Map,
        specular: Option<Map>,
    },
    Mirrored(Map),
    LitSpheres(&'a [LitSphere], f32),
}

/// A map to be looked up, and the luminance that counts as intensity 1.
struct Map {
    environment: Environment,
    largest: f32,
}

impl<'a> Around<'a> {
    /// No environment; a lit sphere perhaps.
    pub(super) fn nothing(illumination: &'a Illumination) -> Self {
        let spheres = &illumination.lit_spheres;
        let used = if spheres.is_empty() {
            Used::Nothing
        } else {
            let weights = super::light::REC709_LUMINANCE;
            let largest = spheres.iter().map(|s| s.largest_luminance(weights));
            Used::LitSpheres(spheres, largest.fold(f32::MIN_POSITIVE, f32::max))
        };
        Self { gain: None, used }
    }

    /// The environment, made ready for its use.
    pub(super) fn new(
        illumination: &'a Illumination,
        relighting: &Relighting,
        weights: [f32; 3],
    ) -> Self {
        let environment = illumination
            .environment
            .as_ref()
            .expect("an environment is planned with");
        let params = &relighting.params;
        let prefiltered = relighting.environment == EnvironmentUse::Prefiltered;
        let needs_irradiance = prefiltered || params.environment_gain == Adaptive::Auto;
        let irradiance = needs_irradiance
            .then(|| Map::of_normals(filtered(&irradiance_filter(environment)), weights));
        let gain = match params.environment_gain {
            Adaptive::Fixed(gain) => gain,
            Adaptive::Auto => {
                let largest = irradiance.as_ref().map_or(1.0, |map| map.largest);
                if largest > f32::MIN_POSITIVE {
                    1.0 / largest
                } else {
                    1.0
                }
            }
        };
        let used = match relighting.environment {
            EnvironmentUse::None => Used::Nothing,
            EnvironmentUse::Lights(count) => {
                let lights = median_cut(environment, count as usize).into_iter();
                Used::Lights(lights.map(|light| brightened(light, gain)).collect())
            }
            EnvironmentUse::Lookups(count) => {
                // A pixel on the horizon, (2 pi / width)^2, then has the solid angle of a direction.
                let width = (PI * count as f32).sqrt().ceil() as usize;
                let coarse = environment.resized(width);
                Used::Lookups(uniform_directions(count as usize), coarse)
            }
            EnvironmentUse::Prefiltered => Used::Prefiltered {
                diffuse: irradiance.expect("made above"),
                specular: (params.material.material == Material::Phong).then(|| {
                    let filter =
                        GlossyFilter::new(environment, params.material.shininess, GLOSSY_WIDTH);
                    Map::new(filtered(&filter), weights)
                }),
            },
            EnvironmentUse::Mirrored => Used::Mirrored(Map::new(environment.clone(), weights)),
        };
        Self {
            gain: Some(gain),
            used,
        }
    }

    /// Factor of the environment's radiance; `None` without one.
    pub(super) fn gain(&self) -> Option<f32> {
        self.gain
    }

    /// Lights that stand for the environment.
    pub(super) fn lights(&self) -> &[DirectionalLight] {
        match &self.used {
            Used::Lights(lights) => lights,
            _ => &[],
        }
    }

    /// Even directions in which the environment is looked up at every pixel.
    pub(super) fn even_directions(&self) -> &[Vec3] {
        match &self.used {
            Used::Lookups(directions, _) => directions,
            _ => &[],
        }
    }

    /// Whether something is looked up once per pixel.
    pub(super) fn has_lookups(&self) -> bool {
        matches!(
            self.used,
            Used::Prefiltered { .. } | Used::Mirrored(_) | Used::LitSpheres(..)
        )
    }

    /// Whether the mirrored view is looked up.
    pub(super) fn is_mirrored(&self) -> bool {
        matches!(
            self.used,
            Used::Mirrored(_)
                | Used::Prefiltered {
                    specular: Some(_),
                    ..
                }
        )
    }

    /// Ambient occlusion, which dims prefiltered and ambient light.
    pub(super) fn occlusion<'f>(&self, frame: &'f Frame) -> Option<&'f Plane> {
        let even = matches!(self.used, Used::Nothing | Used::Prefiltered { .. });
        frame.light.occlusion.as_ref().filter(|_| even)
    }

    /// Intensities of one of the even directions, looked up where `warped` says; dark where that is below
    /// the surface.
    #[inline(always)]
    pub(super) fn look_up(
        &self,
        out: &mut [Lanes; 3],
        pixels: &Pixels,
        warped: impl Fn(usize) -> [f32; 3],
    ) {
        let Used::Lookups(directions, environment) = &self.used else {
            return;
        };
        // Each stands for 4 pi / n; intensities are over pi.
        let share = self.gain.unwrap_or(1.0) * 4.0 / directions.len() as f32;
        let [r, g, b] = out;
        for i in 0..pixels.count {
            let (n, direction) = (pixels.normal.at(i), warped(i));
            let above = n[0] * direction[0] + n[1] * direction[1] + n[2] * direction[2] > 0.0;
            let share = if above { share } else { 0.0 };
            let radiance = environment.radiance(direction);
            (r[i], g[i], b[i]) = (
                share * radiance[0],
                share * radiance[1],
                share * radiance[2],
            );
        }
    }
}

impl Map {
    /// A map by normal, of which only those that face the viewer are looked up.
    fn of_normals(environment: Environment, weights: [f32; 3]) -> Self {
        let pixels =
            (0..environment.height()).flat_map(|y| (0..environment.width()).map(move |x| (x, y)));
        let seen = pixels.filter(|&(x, y)| environment.direction(x, y).z >= 0.0);
        let largest = seen
            .map(|(x, y)| super::super::light::luminance(environment.pixel(x, y), weights))
            .fold(f32::MIN_POSITIVE, f32::max);
        Self {
            environment,
            largest,
        }
    }

    fn new(environment: Environment, weights: [f32; 3]) -> Self {
        let largest = environment
            .largest_luminance(weights)
            .max(f32::MIN_POSITIVE);
        Self {
            environment,
            largest,
        }
    }
}

fn brightened(light: DirectionalLight, gain: f32) -> DirectionalLight {
    DirectionalLight {
        intensity: light.intensity.map(|channel| gain * channel),
        ..light
    }
}

/// The filtered map, its rows in parallel.
fn filtered(filter: &GlossyFilter) -> Environment {
    let (width, height) = (filter.width(), filter.height());
    let mut planes = [(); 3].map(|()| Plane::filled(width, height, 0.0));
    let [r, g, b] = planes
        .each_mut()
        .map(|plane| plane.samples_mut().par_chunks_mut(width));
    r.zip(g)
        .zip(b)
        .enumerate()
        .for_each(|(y, ((r, g), b))| filter.row(y, [r, g, b]));
    let [r, g, b] = planes;
    filter.finish(ColorPlanes { r, g, b })
}

/// Adds what is looked up once per pixel to the sums; `warped` tells where a direction is looked up.
#[inline(always)]
pub(super) fn add_lookups(
    batch: &mut Batch,
    scene: &Scene,
    warped: impl Fn(&Pixels, &Scene, usize, [f32; 3]) -> [f32; 3],
) {
    let gain = scene.around.gain.unwrap_or(1.0);
    for i in 0..batch.pixels.count {
        let n = batch.pixels.normal.at(i);
        let toward = |direction| warped(&batch.pixels, scene, i, direction);
        let found = match &scene.around.used {
            Used::Nothing | Used::Lights(_) | Used::Lookups(..) => return,
            Used::Prefiltered { diffuse, specular } => {
                let open = gain * batch.occlusion[i];
                let base = seen(batch, scene, i, 0, diffuse, toward(n), open);
                let coat = specular.as_ref().map_or([0.0; 3], |map| {
                    let r = batch.pixels.mirrored.at(i);
                    seen(batch, scene, i, 1, map, toward(r), gain)
                });
                [base, coat]
            }
            Used::Mirrored(map) => [[0.0; 3], reflected(batch, scene, i, map, toward, gain)],
            Used::LitSpheres(spheres, largest) => {
                let color = sphere_color(batch, i, spheres, toward(n));
                let sigma = sigma(batch, scene, i, 0, luminance(scene, color) / largest);
                // A lit sphere holds its own gains and colours.
                let share = 1.0 / scene.params().material.diffuse_gain.max(f32::MIN_POSITIVE);
                [color.map(|c| c * sigma * share), [0.0; 3]]
            }
        };
        let [base, coat] = found;
        let sums = batch.sum.diffuse.iter_mut().zip(base);
        let sums = sums.chain(batch.sum.specular.iter_mut().zip(coat));
        sums.for_each(|(sum, found)| sum[i] += found);
    }
}

fn luminance(scene: &Scene, rgb: [f32; 3]) -> f32 {
    super::light::luminance(rgb, scene.luminance)
}

/// sigma of a diffuse (0) or specular (1) intensity at lane `i`; 1 where nothing is scaled.
#[inline(always)]
fn sigma(batch: &Batch, scene: &Scene, i: usize, term: usize, intensity: f32) -> f32 {
    if !scene.relighting.scales {
        return 1.0;
    }
    let curves = &batch.pixels.curves[TERMS[term]];
    curves.at(i).at(intensity, scene.invariant_point)
}

/// What a map shows in a direction, scaled by its own brightness ([RS] section 5.3), times `gain`.
#[inline(always)]
fn seen(
    batch: &Batch,
    scene: &Scene,
    i: usize,
    term: usize,
    map: &Map,
    direction: [f32; 3],
    gain: f32,
) -> [f32; 3] {
    let radiance = map.environment.radiance(direction);
    let sigma = sigma(
        batch,
        scene,
        i,
        term,
        luminance(scene, radiance) / map.largest,
    );
    radiance.map(|channel| channel * (gain * sigma))
}

/// What a mirror or clear glass shows.
fn reflected(
    batch: &Batch,
    scene: &Scene,
    i: usize,
    map: &Map,
    toward: impl Fn([f32; 3]) -> [f32; 3],
    gain: f32,
) -> [f32; 3] {
    let r = batch.pixels.mirrored.at(i);
    let material = &scene.params().material;
    if material.material == Material::Mirror {
        return seen(batch, scene, i, 1, map, toward(r), gain);
    }
    let (n, eye) = (batch.pixels.normal.at(i), batch.pixels.to_eye.at(i));
    let cosine = n[0] * eye[0] + n[1] * eye[1] + n[2] * eye[2];
    let one_surface = fresnel(cosine, material.ior);
    let (share, through) = if material.thin {
        (thin_sheet(one_surface), Some(eye.map(|c| -c)))
    } else {
        (one_surface, refracted(n, eye, material.ior))
    };
    let outside = seen(batch, scene, i, 1, map, toward(r), gain * share);
    let inside = through.map_or([0.0; 3], |direction| {
        seen(
            batch,
            scene,
            i,
            1,
            map,
            toward(direction),
            gain * (1.0 - share),
        )
    });
    [0, 1, 2].map(|k| outside[k] + inside[k])
}

/// The colour of the lit sphere, or of both mixed by curvature.
fn sphere_color(batch: &Batch, i: usize, spheres: &[LitSphere], normal: [f32; 3]) -> [f32; 3] {
    let across = [normal[0], normal[1]];
    match spheres {
        [convex, concave] => {
            let share = 0.5 + 0.5 * batch.kappa[i];
            let (convex, concave) = (convex.color(across), concave.color(across));
            [0, 1, 2].map(|k| concave[k] + share * (convex[k] - concave[k]))
        }
        spheres => spheres
            .first()
            .map_or([0.0; 3], |sphere| sphere.color(across)),
    }
}
