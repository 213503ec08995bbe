//! Mirrors and lenses that show their surroundings: each sight line is bent, warped and traced, and the light at its
//! hit is scaled by its own brightness.

use crate::frame::luminance;
use crate::frame::{Frame, Ray};
use crate::light::batch::BATCH;
use crate::light::brdf::{fresnel, thin_sheet};
use crate::light::light_warping::{Warp, warped};
use crate::light::prepared_environment::Map;
use crate::light::relight::batch::Batch;
use crate::light::relight::mirrors::Mirrors;
use crate::light::relight::scene::{Scene, Term};
use crate::params::{Bend, Material, MaterialParams};
use glam::{DVec3, Vec3};

/// Adds the light that the pixels of a batch mirror and refract.
pub(crate) fn add_traced(
    batch: &mut Batch,
    scene: &Scene,
    mirrors: &Mirrors,
    environment: Option<(&Map, f32)>,
) {
    let material = scene.params().material;
    let largest = environment.map_or(mirrors.largest, |(map, gain)| {
        mirrors.largest.max(gain * map.largest)
    });
    let curves = scene
        .relighting
        .scales
        .then(|| *batch.pixels.curve(Term::Specular as usize));
    let mut places = [[0; 2]; BATCH];
    for (lane, x, y) in batch.places() {
        places[lane] = [x, y];
    }
    for (lane, at) in places.into_iter().enumerate().take(batch.pixels.count) {
        let pixel = Pixel {
            mirrors,
            environment,
            at,
            warp: scene.relighting.warps.then(|| {
                let [xx, xy, yy] = batch.pixels.unwarp.each_ref().map(|lanes| lanes[lane]);
                Warp { xx, xy, yy }.inverse()
            }),
        };
        let (n, eye) = (batch.pixels.normal.at(lane), batch.pixels.to_eye.at(lane));
        let cosine = n[0] * eye[0] + n[1] * eye[1] + n[2] * eye[2];
        let mut sum: Option<([f32; 3], f32)> = None;
        for (share, bend) in shares(cosine, &material) {
            let Some(color) = pixel.shown(bend) else {
                continue;
            };
            let sigma = curves.as_ref().map_or(1.0, |curves| {
                let light = luminance(color, scene.luminance) / largest;
                curves.at(lane).at(light, scene.invariant_point)
            });
            let (sum, shares) = sum.get_or_insert(([0.0; 3], 0.0));
            for (sum, color) in sum.iter_mut().zip(color) {
                *sum += share * sigma * color;
            }
            *shares += share;
        }
        // Rays without a hit count as the mean of the others; without any hit the picture stays.
        let shown = match sum {
            Some((sum, shares)) => sum.map(|channel| channel / shares),
            None => own_color(scene.frame, at),
        };
        for (to, color) in batch.sum.sums.specular.iter_mut().zip(shown) {
            to[lane] += color;
        }
    }
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

/// One pixel and the sources of its light.
struct Pixel<'a> {
    mirrors: &'a Mirrors<'a>,
    environment: Option<(&'a Map, f32)>,
    at: [usize; 2],
    warp: Option<Warp>,
}

impl Pixel<'_> {
    /// The radiance along a ray bent by `bend`, by default that of the tracer.
    fn shown(&self, bend: Option<Bend>) -> Option<[f32; 3]> {
        let tracer = &self.mirrors.tracer;
        let [x, y] = self.at;
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
        let tracer = &self.mirrors.tracer;
        tracer.color(&tracer.hit(ray)?)
    }

    fn far_away(&self, direction: DVec3) -> Option<[f32; 3]> {
        let (map, gain) = self.environment?;
        let seen = map.environment.radiance(direction.as_vec3().to_array());
        Some(seen.map(|channel| gain * channel))
    }
}

/// The picture's colour divided by coverage; black without a picture.
fn own_color(frame: &Frame, [x, y]: [usize; 2]) -> [f32; 3] {
    let alpha = frame.alpha.as_ref().map_or(1.0, |alpha| alpha.at(x, y));
    let cover = if alpha > 0.0 { alpha } else { 1.0 };
    frame.color.as_ref().map_or([0.0; 3], |color| {
        [&color.r, &color.g, &color.b].map(|plane| plane.at(x, y) / cover)
    })
}
