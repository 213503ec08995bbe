//! Lights and look-up maps on the device.

use crate::frame::memory::Memory;
use crate::frame::{ColorPlanes, Frame};
use crate::gpu::device::Device;
use crate::gpu::fault::RunFault;
use crate::kernel::last::Last;
use crate::light::environment::Environment;
use crate::light::intensity::Intensity;
use crate::light::intensity::Map;
use crate::light::light_warping::half_vector;
use crate::light::lights::{DirectionalLight, Illumination, PointLight};
use crate::light::prepared_environment::{
    EnvironmentCache, Illuminants, PreparedEnvironment, Used,
};
use crate::light::relight::albedo;
use crate::light::relight::albedo_search::estimated;
use crate::light::relight::setting::{Albedo, Relighting};
use crate::plan::Plan;
use crate::plan::watch::Watch;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The light of a frame.
pub(crate) struct Light {
    pub(crate) ready: Arc<PreparedEnvironment>,
    /// Number of lit spheres.
    pub(crate) spheres: usize,
    /// The albedo of the frame, if estimated.
    estimate: Option<ColorPlanes>,
    pub(crate) counts: Counts,
    /// Vectors of the lights, in the order given in `relight.wgsl`.
    pub(crate) lights: wgpu::Buffer,
    pub(crate) texels: wgpu::Buffer,
    pub(crate) maps: [PlacedMap; 2],
    pub(crate) most_tone: f32,
    /// Timings of the preparation.
    pub(crate) timings: Vec<(&'static str, Duration)>,
}

/// Number of lights of each kind.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Counts {
    pub(crate) around: u32,
    pub(crate) even: u32,
    pub(crate) directions: u32,
    pub(crate) points: u32,
}

/// The layout of a map whose texels are on the device.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PlacedMap {
    pub(crate) size: [u32; 2],
    /// Rotation, in turns.
    pub(crate) turn: f32,
    /// The intensity of its light.
    pub(crate) intensity: Intensity,
}

/// The cache of the last run's light.
#[derive(Debug, Default)]
pub(crate) struct LightCache {
    environment: EnvironmentCache,
    /// Environment maps.
    maps: Last<PreparedEnvironment, wgpu::Buffer>,
}

impl LightCache {
    /// Drops everything on the device.
    pub(crate) fn forget_maps(&self) {
        self.maps.forget();
    }

    /// Prepares light, and copies it to the device.
    pub(crate) fn light(
        &self,
        device: &Device,
        plan: &Plan,
        frame: &Frame,
        illumination: &Illumination,
        watch: Watch,
    ) -> Result<Light, RunFault> {
        let relighting = relighting(plan);
        let mut timings = Vec::new();
        let weights = frame.luminance_weights();
        let memory = &Memory::default().for_run(watch.token());
        let around = Illuminants::new(
            illumination,
            relighting,
            weights,
            &self.environment,
            memory,
            |make| timed(&mut timings, "environment", make),
        );
        watch.check()?;
        let estimate = (relighting.albedo == Albedo::Estimate).then(|| {
            timed(&mut timings, "albedo-estimate", || {
                let found = estimated(&plan.chosen_from(frame));
                albedo::by_estimate(frame, &found, memory)
            })
        });
        let (vectors, counts) = match relighting.sums {
            true => vectors_of(illumination, &around),
            false => Default::default(),
        };
        let (texels, maps) = self.texels(device, &around)?;
        Ok(Light {
            estimate,
            counts,
            lights: filled(device, &[&vectors])?,
            texels,
            maps,
            most_tone: around.most_tone(illumination, relighting, weights),
            spheres: around.spheres.len(),
            ready: around.ready,
            timings,
        })
    }

    /// The look-up maps, on the device.
    fn texels(
        &self,
        device: &Device,
        around: &Illuminants,
    ) -> Result<(wgpu::Buffer, [PlacedMap; 2]), RunFault> {
        let map = |map: &Map| PlacedMap::of(&map.environment, map.intensity);
        let nothing = PlacedMap::default();
        let ready = &around.ready;
        let (maps, texels): (_, [&[[f32; 4]]; 2]) = match &ready.used {
            Used::Nothing | Used::Lights(_) | Used::Sampled(_) => {
                return Ok((filled(device, &[])?, [nothing; 2]));
            }
            Used::LitSpheres(intensity) => {
                let spheres = around.spheres;
                let placed = |at: usize| match spheres.get(at) {
                    Some(sphere) => PlacedMap {
                        size: sphere.size().map(|n| n as u32),
                        turn: 0.0,
                        intensity: *intensity,
                    },
                    None => nothing,
                };
                let texels = |at: usize| spheres.get(at).map_or(&[][..], |s| s.texels());
                let texels = filled(device, &[texels(0), texels(1)])?;
                return Ok((texels, [placed(0), placed(1)]));
            }
            Used::Lookups(_, environment) => (
                [PlacedMap::of(environment, Intensity::default()), nothing],
                [environment.texels(), &[]],
            ),
            Used::Prefiltered { diffuse, specular } => (
                [map(diffuse), specular.as_ref().map_or(nothing, map)],
                [
                    diffuse.environment.texels(),
                    specular.as_ref().map_or(&[], |s| s.environment.texels()),
                ],
            ),
            Used::Mirrored(mirrored) => (
                [map(mirrored), nothing],
                [mirrored.environment.texels(), &[]],
            ),
        };
        Ok((self.maps.of(ready, || filled(device, &texels))?, maps))
    }
}

impl PlacedMap {
    fn of(environment: &Environment, intensity: Intensity) -> Self {
        Self {
            size: [environment.width(), environment.height()].map(|n| n as u32),
            turn: environment.turn(),
            intensity,
        }
    }
}

impl Light {
    /// The surroundings, but for lit spheres.
    pub(crate) fn around(&self) -> Illuminants<'static> {
        Illuminants {
            ready: self.ready.clone(),
            spheres: &[],
        }
    }

    /// The albedo of `frame`; `None` for white.
    pub(crate) fn albedo<'f>(&'f self, plan: &Plan, frame: &'f Frame) -> Option<&'f ColorPlanes> {
        let color = match relighting(plan).albedo {
            Albedo::Layer => frame.albedo.as_ref(),
            Albedo::Picture => frame.color.as_ref(),
            Albedo::Estimate => self.estimate.as_ref(),
            Albedo::White => return None,
        };
        Some(color.expect("the plan found it in the frame"))
    }
}

/// The relighting of a plan.
pub(crate) fn relighting(plan: &Plan) -> &Relighting {
    let relighting = plan.relighting();
    relighting.expect("the plan says how to light")
}

fn timed<T>(
    timings: &mut Vec<(&'static str, Duration)>,
    name: &'static str,
    pass: impl FnOnce() -> T,
) -> T {
    let start = Instant::now();
    let result = pass();
    timings.push((name, start.elapsed()));
    result
}

/// The vectors of all lights, in the order given in `relight.wgsl`.
fn vectors_of(illumination: &Illumination, around: &Illuminants) -> (Vec<[f32; 4]>, Counts) {
    let [lights, even] = [around.lights().len(), around.even_directions().len()];
    let counts = Counts {
        around: lights as u32,
        even: even as u32,
        directions: illumination.directional.len() as u32,
        points: illumination.points.len() as u32,
    };
    let mut vectors = Vec::new();
    let wide = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
    let far = |light: &DirectionalLight| {
        let direction = light.to_light.to_array();
        [direction, half_vector(direction), light.intensity].map(wide)
    };
    let near = |light: &PointLight| [light.position.to_array(), light.intensity].map(wide);
    vectors.extend(around.lights().iter().flat_map(far));
    vectors.extend(around.even_directions().iter().map(|d| wide(d.to_array())));
    vectors.extend(illumination.directional.iter().flat_map(far));
    vectors.extend(illumination.points.iter().flat_map(near));
    (vectors, counts)
}

/// A separate buffer with these vectors, consecutively.
fn filled(device: &Device, parts: &[&[[f32; 4]]]) -> Result<wgpu::Buffer, RunFault> {
    let count: usize = parts.iter().map(|part| part.len()).sum();
    let bytes = 16 * count.max(1) as u64;
    if bytes > device.plane_bytes {
        return Err(RunFault::TooLarge(device.error(format_args!(
            "takes {} bytes at a time, and what is around the surface has {bytes}",
            device.plane_bytes
        ))));
    }
    let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut at = 0;
    for part in parts {
        let bytes: &[u8] = bytemuck::cast_slice(part);
        device.queue.write_buffer(&buffer, at, bytes);
        at += bytes.len() as u64;
    }
    Ok(buffer)
}
