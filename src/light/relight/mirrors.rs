//! The mirrors and lenses of a frame: what their sight lines meet, and the intensity of its light.

use crate::frame::{Frame, Mask, Ray, SightLines, SpecularScene};
use crate::light::brdf::{fresnel, thin_sheet};
use crate::light::intensity::Map;
use crate::light::intensity::{Intensity, median};
use crate::light::light_warping::{Warp, warped};
use crate::light::prepared_environment::Illuminants;
use crate::light::relight::setting::Relighting;
use crate::params::{Bend, Material, MaterialParams, SpecularParams};
use crate::trace::Tracer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Sight lines that the median of their light is taken over.
const SIGHT_LINES: usize = 4_000;

/// The mirrors and lenses of a frame.
pub(crate) struct Mirrors<'a> {
    pub(super) tracer: Tracer<'a>,
    pub(super) intensity: Intensity,
}

impl<'a> Mirrors<'a> {
    /// The mirrors at the pixels of `mask` in a scene; `None` if nothing can be traced. The median of light is that of what
    /// their sight lines meet.
    pub(crate) fn new(
        (frame, mask): (&'a Frame, &Mask),
        scene: &'a SpecularScene,
        params: &SpecularParams,
        (relighting, around): (&Relighting, &Illuminants),
    ) -> Option<Self> {
        let tracer = Tracer::new(frame, scene, params)?;
        let intensity = relighting.white.unlimited(|| {
            let pixels: Vec<_> = mask.sample(SIGHT_LINES).collect();
            let met = pixels.into_par_iter().filter_map(|(x, y)| {
                let sight = BentSight {
                    tracer: &tracer,
                    environment: around.mirrored(),
                    at: [x, y],
                    warp: None,
                };
                sight.light(cosine(frame, [x, y]), &relighting.params.material, |_| 1.0)
            });
            let met: Vec<_> = met.collect();
            median(met.into_iter(), frame.luminance_weights()).unwrap_or(0.0)
        });
        Some(Self { tracer, intensity })
    }
}

/// The cosine between normal and sight line of a pixel.
fn cosine(frame: &Frame, [x, y]: [usize; 2]) -> f32 {
    let (data, normal) = (frame.data_window, &frame.normal);
    let centre = |first: i32, i: usize| f64::from(first) + i as f64 + 0.5;
    let (_, line) = SightLines::of(frame).line(centre(data.x0, x), centre(data.y0, y));
    let n = [&normal.x, &normal.y, &normal.z].map(|plane| plane.at(x, y));
    -Vec3::from(n).dot(line.as_vec3().normalize())
}

/// The shares of light seen at this cosine that are mirrored and transmitted.
fn shares(cosine: f32, material: &MaterialParams) -> impl Iterator<Item = (f32, Option<Bend>)> {
    let mirror = Some(Bend::Mirror);
    let both = match material.material {
        Material::Glass => {
            let one_surface = fresnel(cosine, material.ior);
            let mirrored = match material.thin {
                true => thin_sheet(one_surface),
                false => one_surface,
            };
            [(1.0 - mirrored, None), (mirrored, mirror)]
        }
        _ => [(1.0, mirror), (0.0, mirror)],
    };
    both.into_iter().filter(|(share, _)| *share > 0.0)
}

/// A sight line and the sources of its light.
pub(super) struct BentSight<'a> {
    pub(super) tracer: &'a Tracer<'a>,
    pub(super) environment: Option<(&'a Map, f32)>,
    pub(super) at: [usize; 2],
    pub(super) warp: Option<Warp>,
}

impl BentSight<'_> {
    /// The light along the sight line, each share times the `sigma` of its colour. Rays without a hit count as the mean
    /// of the others; `None` without any hit.
    pub(super) fn light(
        &self,
        cosine: f32,
        material: &MaterialParams,
        sigma: impl Fn([f32; 3]) -> f32,
    ) -> Option<[f32; 3]> {
        let mut sum: Option<([f32; 3], f32)> = None;
        for (share, bend) in shares(cosine, material) {
            let Some(color) = self.shown(bend) else {
                continue;
            };
            let sigma = sigma(color);
            let (sum, shares) = sum.get_or_insert(([0.0; 3], 0.0));
            for (sum, color) in sum.iter_mut().zip(color) {
                *sum += share * sigma * color;
            }
            *shares += share;
        }
        sum.map(|(sum, shares)| sum.map(|channel| channel / shares))
    }

    /// The radiance along a ray bent by `bend`, by default that of the tracer.
    fn shown(&self, bend: Option<Bend>) -> Option<[f32; 3]> {
        let (tracer, [x, y]) = (self.tracer, self.at);
        let path = match bend {
            Some(bend) => tracer.path_bent(x, y, bend),
            None => tracer.path(x, y),
        }?;
        let leaving = path.leaving();
        let direction = match self.warp {
            Some(warp) => {
                Vec3::from(warped(leaving.direction.as_vec3().to_array(), warp)).as_dvec3()
            }
            None => leaving.direction,
        };
        self.met(&Ray {
            direction,
            ..leaving
        })
        .or_else(|| self.far_away(direction))
    }

    fn met(&self, ray: &Ray) -> Option<[f32; 3]> {
        self.tracer.color(&self.tracer.hit(ray)?)
    }

    fn far_away(&self, direction: DVec3) -> Option<[f32; 3]> {
        let (map, gain) = self.environment?;
        let seen = map.environment.radiance(direction.as_vec3().to_array());
        Some(seen.map(|channel| gain * channel))
    }
}
