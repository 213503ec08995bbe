//! Light sources, and sampling them.

use super::geometry::Ray;
use glam::Vec3;
use relievo::light::environment::Environment;
use std::f32::consts::{PI, TAU};

/// A rectangle that shines to the side that its sides turn counterclockwise on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AreaLight {
    pub(crate) corner: Vec3,
    pub(crate) sides: [Vec3; 2],
    pub(crate) radiance: Vec3,
}

/// Light from one direction, by chance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightSample {
    pub(crate) to_light: Vec3,
    /// Distance of the source; infinite for the environment.
    pub(crate) distance: f32,
    pub(crate) radiance: Vec3,
    /// Solid-angle density of the direction.
    pub(crate) density: f32,
}

impl AreaLight {
    /// Along the normal, as long as the area.
    fn area(&self) -> Vec3 {
        self.sides[0].cross(self.sides[1])
    }

    fn sample(&self, from: Vec3, [u, v]: [f32; 2]) -> Option<LightSample> {
        let offset = self.corner + u * self.sides[0] + v * self.sides[1] - from;
        let distance = offset.length();
        let to_light = offset / distance;
        let density = self.density(to_light, distance);
        density.is_finite().then_some(LightSample {
            to_light,
            distance,
            radiance: self.radiance,
            density,
        })
    }

    /// Solid-angle density of its points seen `distance` away; infinite from behind.
    pub(crate) fn density(&self, to_light: Vec3, distance: f32) -> f32 {
        let facing = -self.area().dot(to_light);
        if facing > 0.0 {
            distance * distance / facing
        } else {
            f32::INFINITY
        }
    }
}

/// Light from all around that can be sampled by its brightness.
pub(crate) struct Surroundings {
    map: Environment,
    /// Cumulative probability of the pixels, in reading order.
    shares: Vec<f64>,
    share_sum: f64,
}

/// Widest map that is sampled; the light itself is looked up at full size.
const SAMPLED_WIDTH: usize = 512;

impl Surroundings {
    /// `None` where nothing shines.
    pub(crate) fn new(map: Environment) -> Option<Self> {
        let map = map.resized(SAMPLED_WIDTH);
        let (width, height) = (map.width(), map.height());
        let brightness = |x: usize, y: usize| map.pixel(x, y).iter().sum::<f32>();
        // Look-ups interpolate between pixels, so each pixel gets the brightness of the brightest one beside it: no
        // light may be left out. The neighbours beyond a pole are the whole row.
        let around = |x: usize, y: usize| {
            let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
            let beside_pole = y == 0 || y + 1 == height;
            let columns = if beside_pole {
                0..width
            } else {
                x + width - 1..x + width + 2
            };
            let pixels = rows.flat_map(|y| columns.clone().map(move |x| (x % width, y)));
            pixels.map(|(x, y)| brightness(x, y)).fold(0.0, f32::max)
        };
        let mut share_sum = 0.0;
        let mut shares = Vec::with_capacity(width * height);
        for y in 0..height {
            let pole = (y == 0 || y + 1 == height).then(|| around(0, y));
            for x in 0..width {
                share_sum += f64::from(pole.unwrap_or_else(|| around(x, y))) * map.solid_angle(y);
                shares.push(share_sum);
            }
        }
        (share_sum > 0.0).then_some(Self {
            map,
            shares,
            share_sum,
        })
    }

    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        self.map.radiance(direction.to_array()).into()
    }

    fn sample(&self, choice: f32, [u, v]: [f32; 2]) -> LightSample {
        let wanted = f64::from(choice) * self.share_sum;
        let pixel = self.shares.partition_point(|&share| share <= wanted);
        let pixel = pixel.min(self.shares.len() - 1);
        let (x, y) = (pixel % self.map.width(), pixel / self.map.width());
        // Even over the pixel: its columns by angle, its rows by height.
        let [top, bottom] = self.heights(y);
        let height = top + v * (bottom - top);
        let aside = (1.0 - height * height).max(0.0).sqrt();
        let azimuth = ((x as f32 + u) / self.map.width() as f32 - 0.5) * TAU;
        let to_light = Vec3::new(aside * azimuth.sin(), height, -aside * azimuth.cos());
        LightSample {
            to_light,
            distance: f32::INFINITY,
            radiance: self.radiance(to_light),
            density: self.density_of(pixel),
        }
    }

    /// Sines of the elevation at both edges of a row.
    fn heights(&self, row: usize) -> [f32; 2] {
        [row, row + 1].map(|edge| (PI * edge as f32 / self.map.height() as f32).cos())
    }

    fn density_of(&self, pixel: usize) -> f32 {
        let before = if pixel == 0 {
            0.0
        } else {
            self.shares[pixel - 1]
        };
        let share = (self.shares[pixel] - before) / self.share_sum;
        (share / self.map.solid_angle(pixel / self.map.width())) as f32
    }

    /// Solid-angle density of the samples around a direction.
    pub(crate) fn density(&self, direction: Vec3) -> f32 {
        let [column, row] = self.map.position(direction.to_array());
        let (width, height) = (self.map.width(), self.map.height());
        let whole = |at: f32, count: usize| ((at + 0.5).max(0.0) as usize).min(count - 1);
        self.density_of(whole(row, height) * width + whole(column, width))
    }
}

/// All lights that can be sampled.
#[derive(Default)]
pub(crate) struct Lights {
    pub(crate) areas: Vec<AreaLight>,
    pub(crate) surroundings: Option<Surroundings>,
}

impl Lights {
    fn count(&self) -> usize {
        self.areas.len() + usize::from(self.surroundings.is_some())
    }

    /// Probability of choosing one particular light for a sample.
    pub(crate) fn share(&self) -> f32 {
        1.0 / self.count().max(1) as f32
    }

    /// Light that comes from one of them, each as likely as the others.
    pub(crate) fn sample(&self, from: Vec3, choice: f32, at: [f32; 2]) -> Option<LightSample> {
        let scaled = choice * self.count() as f32;
        let which = (scaled as usize).min(self.count().checked_sub(1)?);
        let sample = match self.areas.get(which) {
            Some(area) => area.sample(from, at)?,
            // The fractional rest of the choice is as uniform as the choice was.
            None => self.surroundings.as_ref()?.sample(scaled.fract(), at),
        };
        Some(LightSample {
            density: sample.density * self.share(),
            ..sample
        })
    }

    /// Light along a ray that hits nothing.
    pub(crate) fn beyond(&self, ray: &Ray) -> Vec3 {
        let around = self.surroundings.as_ref();
        around.map_or(Vec3::ZERO, |around| around.radiance(ray.direction))
    }
}
