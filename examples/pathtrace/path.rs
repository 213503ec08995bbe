//! Light along a path: direct light, sampled and hit by chance, and all light it hits afterwards.
//!
//! [LW] section 6.1: a sampled direction l' to a light is unwarped to l, and weighted by the Jacobian (equation 2); for
//! a direction l sampled from the material, the path continues along its warped one l' (equation 1). Both sample one
//! integral over l', the second with the density of l times the same Jacobian; so they are combined as usual (E. Veach,
//! L. Guibas: Optimally Combining Sampling Techniques, 1995).

use super::enhancement::{Altered, Enhancement};
use super::geometry::Ray;
use super::material::{Directions, Material, PerLobe};
use super::sampler::Sampler;
use super::scene::{Point, Scene};
use glam::Vec3;
use relievo::light::brdf::mirrored;
use relievo::light::light_warping::counted_cosine;

/// Sampling of direct light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Direct {
    /// Both ways, weighed against each other.
    Both,
    /// By sampling lights ([LW] equation 2).
    Lights,
    /// By directions sampled from the material ([LW] equation 1).
    Lookups,
}

/// Settings of path tracing.
#[derive(Debug, Clone)]
pub(crate) struct Tracing {
    pub(crate) enhancement: Enhancement,
    pub(crate) direct: Direct,
    /// Surfaces that a path may meet.
    pub(crate) max_bounces: usize,
}

impl Default for Tracing {
    fn default() -> Self {
        Self {
            enhancement: Enhancement::default(),
            direct: Direct::Both,
            max_bounces: 12,
        }
    }
}

/// Bounces that no path is ended before.
const CERTAIN_BOUNCES: usize = 3;

/// A vertex of a path, with everything needed to weight the light there.
pub(crate) struct Vertex<'a> {
    pub(crate) point: Point<'a>,
    pub(crate) to_eye: Vec3,
    pub(crate) altered: Altered,
}

/// Light looked for and found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    /// Reflected light per lobe, over the density of the sample, without the Jacobian.
    pub(crate) light: PerLobe<Vec3>,
    /// Jacobian of the inverse warp at the light.
    pub(crate) jacobian: f32,
    /// Its sampling density, and its density under [`Vertex::bounce`].
    pub(crate) densities: [f32; 2],
}

/// Continuation of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounce {
    /// Direction of the incoming light, already warped.
    pub(crate) direction: Vec3,
    /// Reflectance per lobe, over the density of the sample.
    pub(crate) weight: PerLobe<Vec3>,
    /// Density of `direction`; `None` for the only possible one.
    pub(crate) density: Option<f32>,
}

impl<'a> Vertex<'a> {
    pub(crate) fn new(point: Point<'a>, ray: &Ray, before: usize, by: &Enhancement) -> Self {
        let to_eye = -ray.direction;
        Self {
            point,
            to_eye,
            altered: by.at(before, to_eye, point.normal, point.turn),
        }
    }

    fn directions(&self, to_light: Vec3) -> Directions {
        Directions {
            normal: self.point.normal,
            to_eye: self.to_eye,
            to_light,
        }
    }

    /// Solid-angle density of that direction under [`Vertex::bounce`], without a warp.
    fn density(&self, to_light: Vec3) -> f32 {
        let material = &self.point.object.material;
        material.density(&self.directions(to_light))
    }

    /// Whether light from there can reach the outer side of the triangle.
    fn is_above(&self, to_light: Vec3) -> bool {
        self.point.face_normal.dot(to_light) > 0.0
    }

    /// Reflected share of the light that comes from `source` and is assigned to `to_light`.
    fn reflected(&self, to_light: Vec3, source: Vec3) -> PerLobe<Vec3> {
        let d = self.directions(to_light);
        let mut lobes = self.point.object.material.reflected(&d);
        if self.altered.warp.is_some() {
            // BRDF times cosine is given; the cosine that counts may be less.
            let cosine = d.normal.dot(to_light).max(f32::MIN_POSITIVE);
            let share = counted_cosine(cosine, d.normal.dot(source)) / cosine;
            lobes = lobes.map(|lobe| lobe * share);
        }
        if let Some(scale) = &self.altered.scale {
            let [diffuse, specular] = scale.factors(Material::intensities(&d));
            lobes = [lobes[0] * diffuse, lobes[1] * specular];
        }
        lobes
    }

    /// Looks for light ([LW] equation 2).
    pub(crate) fn find_light(&self, scene: &Scene, sampler: &mut Sampler) -> Option<Found> {
        let (choice, at) = (sampler.one(), sampler.pair());
        let light = scene.lights.sample(self.point.position, choice, at)?;
        let source = light.to_light;
        let (to_light, jacobian) = match &self.altered.warp {
            Some(warp) => warp.unwarped(source),
            None => (source, 1.0),
        };
        let lobes = self.reflected(to_light, source);
        let reflects = self.is_above(source) && (lobes[0] + lobes[1]).max_element() > 0.0;
        let open = reflects && scene.is_open(&self.point.leaving(source), light.distance);
        open.then(|| Found {
            light: lobes.map(|lobe| lobe * light.radiance / light.density),
            jacobian,
            densities: [light.density, jacobian * self.density(to_light)],
        })
    }

    /// Continues by sampling the material ([LW] equation 1); `None` if nothing is reflected that way.
    pub(crate) fn bounce(&self, sampler: &mut Sampler) -> Option<Bounce> {
        let material = &self.point.object.material;
        let (lobe, at) = (sampler.one(), sampler.pair());
        if let Material::Mirror(tint) = material {
            return Some(self.mirrored(*tint));
        }
        let to_light = material.sampled(self.point.normal, self.to_eye, lobe, at);
        let (source, jacobian) = match &self.altered.warp {
            // The Jacobian is evaluated at the light's direction, as for sampled lights.
            Some(warp) => {
                let source = warp.warped(to_light);
                (source, warp.unwarped(source).1)
            }
            None => (to_light, 1.0),
        };
        let density = self.density(to_light);
        let goes_on = self.is_above(source) && density > 0.0;
        let weight = self.reflected(to_light, source).map(|lobe| lobe / density);
        (goes_on && (weight[0] + weight[1]).max_element() > 0.0).then_some(Bounce {
            direction: source,
            weight,
            density: Some(density * jacobian),
        })
    }

    /// Mirrors: one direction. The half vector is the normal, so that [RS] section 5.2 scales by the full intensity;
    /// directions are not warped.
    fn mirrored(&self, tint: Vec3) -> Bounce {
        let direction = mirrored(self.point.normal.to_array(), self.to_eye.to_array());
        let scale = self.altered.scale.as_ref();
        let factor = scale.map_or(1.0, |scale| scale.factors([1.0; 2])[1]);
        Bounce {
            direction: Vec3::from(direction).normalize(),
            weight: [Vec3::ZERO, factor * tint],
            density: None,
        }
    }
}

/// The light that comes back along a ray.
pub(crate) fn light_along(
    scene: &Scene,
    mut ray: Ray,
    tracing: &Tracing,
    sampler: &mut Sampler,
) -> Vec3 {
    let (mut light, mut through) = (Vec3::ZERO, Vec3::ONE);
    let mut density: Option<f32> = None;
    for bounces in 0..=tracing.max_bounces {
        let met = scene.met(&ray);
        // Light met by chance.
        let radiance = match &met {
            Some((point, _)) => scene.emitted(point),
            None => scene.lights.beyond(&ray),
        };
        if radiance != Vec3::ZERO {
            let place = met.as_ref().map(|(point, distance)| (point, *distance));
            let other = scene.light_density(place, ray.direction);
            let weight = match (density, other) {
                (Some(own), Some(other)) => weight(tracing.direct, Direct::Lookups, own, other),
                _ => 1.0,
            };
            light += weight * through * radiance;
        }
        let Some((point, _)) = met else { break };
        if bounces == tracing.max_bounces {
            break;
        }
        let vertex = Vertex::new(point, &ray, bounces, &tracing.enhancement);
        // Light looked for.
        let is_looked_for = tracing.direct != Direct::Lookups && !point.object.material.is_clear();
        if is_looked_for && let Some(found) = vertex.find_light(scene, sampler) {
            let [own, other] = found.densities;
            let weight = weight(tracing.direct, Direct::Lights, own, other);
            light += found.jacobian * weight * through * (found.light[0] + found.light[1]);
        }
        // On to the next surface.
        let Some(bounce) = vertex.bounce(sampler) else {
            break;
        };
        through *= bounce.weight[0] + bounce.weight[1];
        density = bounce.density;
        if bounces >= CERTAIN_BOUNCES {
            let survival = point.object.material.survival();
            if sampler.one() >= survival {
                break;
            }
            through /= survival;
        }
        ray = point.leaving(bounce.direction);
    }
    light
}

/// The power heuristic: weight of a sample drawn by `way` with the density `own`, which the other way draws with the
/// density `other`.
fn weight(direct: Direct, way: Direct, own: f32, other: f32) -> f32 {
    match direct {
        Direct::Both => {
            let ratio = other / own;
            1.0 / (1.0 + ratio * ratio)
        }
        only => f32::from(u8::from(only == way)),
    }
}
