//! Environments filtered by a glossy lobe: one look-up replaces a sum over lights.
//!
//! The normalised Phong lobe, (eta + 1) / (2 pi) (r.l)^eta, over all directions l with r.l > 0. Its weights depend only
//! on two latitudes and a difference of longitudes, so they are computed once per pair of rows, and each row is a sum
//! of shifted rows. Map and source are sampled at the resolution the lobe needs: a wide lobe costs no more than a
//! narrow one.

use super::brdf::entering;
use super::environment::Environment;
use crate::frame::{ColorPlanes, Plane, parallel_rows};
use rayon::prelude::*;

/// Columns per turn per square root of eta: four pixels per standard deviation of the lobe, 1/sqrt(eta).
const COLUMNS_PER_ROOT: f64 = 24.0;

/// Minimum number of columns of a filtered map, if the request allows: bilinear look-ups in a cosine then err by 3e-4
/// of its peak, and by 1.2e-2 at its edge.
const MIN_COLUMNS: usize = 128;

/// Weights below this share of a lobe's peak are dropped.
const CUT: f64 = 1e-5;

/// Red, green, blue, and a weight that is 1 in a white map: the divisor of a filter.
type WeighedColor = [f32; 4];

/// The filtering of one environment by one lobe, row by row: rows may be filled in any order.
#[derive(Debug, Clone)]
pub(crate) struct GlossyFilter {
    width: usize,
    height: usize,
    lobe: GlossyLobe,
    source: GlossySource,
    turned_like: Environment,
}

/// What reflects light, by the cosine it is seen under.
#[derive(Debug, Clone, Copy)]
enum GlossyLobe {
    /// The cosine to a power.
    Phong(f64),
    /// The base under a coat.
    Base,
}

#[derive(Debug, Clone)]
enum GlossySource {
    /// The lobe is narrower than a pixel: the result is this map.
    Unfiltered(Environment),
    /// Power and solid angle of every pixel, each row stored twice in succession, so that no shift wraps.
    Rows(Vec<WeighedColor>),
}

impl GlossyFilter {
    /// Prepares filtering `environment` with the exponent `shininess` (eta, 0 and up) to a map of at most `max_width`
    /// columns (at least 4), fewer if the lobe resolves no more.
    pub(crate) fn new(environment: &Environment, shininess: f32, max_width: usize) -> Self {
        let shininess = f64::from(shininess.max(0.0)).min(1e12);
        let max_width = max_width.max(4) & !1;
        let deviation = 1.0 / shininess.sqrt();
        let needed = (COLUMNS_PER_ROOT / deviation).ceil() as usize;
        let width = needed.next_multiple_of(2).max(MIN_COLUMNS).min(max_width);
        // A lobe narrower than half a pixel, of the result or of the environment, filters nothing.
        let finest = width.min(environment.width().max(MIN_COLUMNS)) & !1;
        let pixel = std::f64::consts::TAU / finest as f64;
        if deviation < pixel / 2.0 {
            return Self::unfiltered(environment.resized(max_width), environment);
        }
        Self {
            width: finest,
            height: finest / 2,
            lobe: GlossyLobe::Phong(shininess),
            source: GlossySource::Rows(source_rows(environment, finest, finest / 2)),
            turned_like: corner(environment),
        }
    }

    /// Prepares filtering `environment` by the base of a coated surface.
    pub(crate) fn base(environment: &Environment) -> Self {
        Self {
            lobe: GlossyLobe::Base,
            ..Self::new(environment, 1.0, MIN_COLUMNS)
        }
    }

    fn unfiltered(map: Environment, environment: &Environment) -> Self {
        Self {
            width: map.width(),
            height: map.height(),
            lobe: GlossyLobe::Phong(f64::INFINITY),
            source: GlossySource::Unfiltered(map),
            turned_like: corner(environment),
        }
    }

    /// Fills row `y` of the filtered map's red, green and blue, each `width` samples.
    ///
    /// # Panics
    /// If there is no such row, or a slice is shorter than a row.
    fn row(&self, y: usize, [r, g, b]: [&mut [f32]; 3]) {
        let mut put = |x: usize, color: [f32; 3]| {
            [r[x], g[x], b[x]] = color;
        };
        match &self.source {
            GlossySource::Unfiltered(map) => (0..self.width).for_each(|x| put(x, map.pixel(x, y))),
            GlossySource::Rows(rows) => {
                for (x, [r, g, b, weight]) in self.filtered_row(rows, y).into_iter().enumerate() {
                    put(x, [r / weight, g / weight, b / weight].map(|v| v as f32));
                }
            }
        }
    }

    /// The filtered map; black rows where `goes_on` says no.
    pub(crate) fn filtered(&self, goes_on: impl Fn() -> bool + Sync) -> Environment {
        let [mut r, mut g, mut b] = [(); 3].map(|()| Plane::filled(self.width, self.height, 0.0));
        parallel_rows([&mut r, &mut g, &mut b])
            .filter(|_| goes_on())
            .for_each(|(y, rows)| self.row(y, rows));
        Environment::new(ColorPlanes { r, g, b }).turned_like(&self.turned_like)
    }

    /// Weighted sums of power and of solid angle for each pixel of row `y`.
    fn filtered_row(&self, rows: &[WeighedColor], y: usize) -> Vec<[f64; 4]> {
        let (width, stride) = (self.width, 2 * self.width);
        let mut sums = vec![[0.0_f64; 4]; width];
        let mut in_row = vec![[0.0_f32; 4]; width];
        for source_y in 0..self.height {
            let weights = self.weights(y, source_y);
            if weights.is_empty() {
                continue;
            }
            let source = &rows[source_y * stride..(source_y + 1) * stride];
            in_row.fill([0.0; 4]);
            for (shift, &weight) in weights.iter().enumerate() {
                let right = &source[shift..shift + width];
                let left = &source[width - shift..stride - shift];
                // A shift of 0 or half a turn has only one position, not two.
                match shift == 0 || 2 * shift == width {
                    true => add(&mut in_row, right, weight),
                    false => add_both(&mut in_row, right, left, weight),
                }
            }
            for (sum, row) in sums.iter_mut().zip(&in_row) {
                *sum = std::array::from_fn(|i| sum[i] + f64::from(row[i]));
            }
        }
        sums
    }

    /// Weights of the lobe at row `y` for the pixels of row `source_y`, by distance in columns; further ones are
    /// negligible.
    fn weights(&self, y: usize, source_y: usize) -> Vec<f32> {
        use std::f64::consts::{PI, TAU};
        let elevation = |y: usize| (0.5 - (y as f64 + 0.5) / self.height as f64) * PI;
        let (sin, cos) = elevation(y).sin_cos();
        let (source_sin, source_cos) = elevation(source_y).sin_cos();
        let least = match self.lobe {
            GlossyLobe::Phong(shininess) => CUT.powf(1.0 / shininess),
            GlossyLobe::Base => 0.0,
        };
        let cosines = (0..=self.width / 2).map(|shift| {
            let turn = (shift as f64 / self.width as f64 * TAU).cos();
            (sin * source_sin + cos * source_cos * turn).min(1.0)
        });
        cosines
            .take_while(|&cosine| cosine > 0.0 && cosine >= least)
            .map(|cosine| match self.lobe {
                GlossyLobe::Phong(shininess) => cosine.powf(shininess) as f32,
                GlossyLobe::Base => entering(cosine as f32),
            })
            .collect()
    }
}

/// A single pixel that keeps the rotation of `environment`.
fn corner(environment: &Environment) -> Environment {
    Environment::from_fn(1, 1, |_, _| [0.0; 3]).turned_like(environment)
}

fn add(sums: &mut [WeighedColor], row: &[WeighedColor], weight: f32) {
    for (sum, v) in sums.iter_mut().zip(row) {
        *sum = std::array::from_fn(|i| sum[i] + weight * v[i]);
    }
}

fn add_both(sums: &mut [WeighedColor], right: &[WeighedColor], left: &[WeighedColor], weight: f32) {
    for ((sum, a), b) in sums.iter_mut().zip(right).zip(left) {
        *sum = std::array::from_fn(|i| sum[i] + weight * (a[i] + b[i]));
    }
}

/// The environment on `width` by `height` pixels, each row twice.
fn source_rows(environment: &Environment, width: usize, height: usize) -> Vec<WeighedColor> {
    let finer = environment.width() > width && environment.height() > height;
    let map = match finer {
        true => gathered(environment, width, height),
        false => interpolated(environment, width, height),
    };
    map.chunks_exact(width)
        .flat_map(|row| row.iter().chain(row).map(|v| v.map(|v| v as f32)))
        .collect()
}

/// A coarser map: the power of each pixel is distributed to the four nearest new ones, preserving its centroid.
/// Averaging would move a small sun by up to half a pixel.
fn gathered(environment: &Environment, width: usize, height: usize) -> Vec<[f64; 4]> {
    let (from_width, from_height) = (environment.width(), environment.height());
    let mut map = vec![[0.0_f64; 4]; width * height];
    for y in 0..from_height {
        let solid_angle = environment.solid_angle(y);
        let row = (y as f64 + 0.5) * height as f64 / from_height as f64 - 0.5;
        for x in 0..from_width {
            let [r, g, b] = environment.pixel(x, y).map(|v| f64::from(v) * solid_angle);
            let column = (x as f64 + 0.5) * width as f64 / from_width as f64 - 0.5;
            for (near_y, down) in neighbours(row) {
                // Beyond a pole the same row continues, half a turn away.
                let beyond = near_y < 0 || near_y >= height as isize;
                let to_y = near_y.clamp(0, height as isize - 1) as usize;
                for (near_x, across) in neighbours(column) {
                    let half_turn = if beyond { width as isize / 2 } else { 0 };
                    let to_x = (near_x + half_turn).rem_euclid(width as isize) as usize;
                    let to = &mut map[to_y * width + to_x];
                    for (sum, v) in to.iter_mut().zip([r, g, b, solid_angle]) {
                        *sum += across * down * v;
                    }
                }
            }
        }
    }
    map
}

/// The two integer positions around a position, each with its weight.
fn neighbours(position: f64) -> [(isize, f64); 2] {
    let whole = position.floor();
    let share = position - whole;
    [(whole as isize, 1.0 - share), (whole as isize + 1, share)]
}

/// A map of the same or higher resolution: look-ups at its pixel centres.
fn interpolated(environment: &Environment, width: usize, height: usize) -> Vec<[f64; 4]> {
    let from = environment.resized(width);
    let grid = Environment::from_fn(1, height, |_, _| [0.0; 3]);
    let scale = |i: usize, from: usize, to: usize| {
        ((i as f64 + 0.5) * from as f64 / to as f64 - 0.5) as f32
    };
    let mut map = Vec::with_capacity(width * height);
    for y in 0..height {
        let solid_angle = grid.solid_angle(y) / width as f64;
        map.extend((0..width).map(|x| {
            let column = scale(x, from.width(), width);
            let [r, g, b] = from
                .at_position(column, scale(y, from.height(), height))
                .map(|v| f64::from(v) * solid_angle);
            [r, g, b, solid_angle]
        }));
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// The reflection of `environment` by a lobe with exponent `shininess` (eta, 0 and up), indexed by the mirror direction
    /// r: a map of at most `max_width` columns. A constant environment stays constant.
    fn glossy(environment: &Environment, shininess: f32, max_width: usize) -> Environment {
        GlossyFilter::new(environment, shininess, max_width).filtered(|| true)
    }

    fn constant(width: usize, height: usize) -> Environment {
        Environment::from_fn(width, height, |_, _| [0.3, 1.0, 700.0])
    }

    #[test]
    fn a_constant_stays_that_constant() {
        for (width, height) in [(512, 256), (300, 100), (2, 1), (1, 1), (1000, 3)] {
            for shininess in [0.0, 0.5, 1.0, 30.0, 1e3, 1e6, f32::INFINITY, f32::NAN, -5.0] {
                let map = glossy(&constant(width, height), shininess, 256);
                for (x, y) in (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)))
                {
                    for (v, c) in map.pixel(x, y).into_iter().zip([0.3, 1.0, 700.0]) {
                        assert!(
                            (v / c - 1.0).abs() < 2e-6,
                            "{width}x{height}, {shininess}: {v}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_small_sun_takes_the_shape_of_the_lobe() {
        let (x, y) = (150, 47);
        let map = Environment::from_fn(512, 256, |i, j| {
            [if (i, j) == (x, y) { 1e3 } else { 0.0 }; 3]
        });
        let map = map.rotated_deg(25.0);
        let (sun, power) = (map.direction(x, y), map.power()[0]);
        for (shininess, allowed) in [
            (0.5, 0.02),
            (2.0, 0.01),
            (10.0, 0.01),
            (100.0, 0.03),
            (400.0, 0.05),
        ] {
            let filtered = glossy(&map, shininess, 512);
            let lobe = |cosine: f64| {
                let eta = f64::from(shininess);
                (eta + 1.0) / std::f64::consts::TAU * cosine.max(0.0).powf(eta) * power
            };
            let peak = lobe(1.0);
            for d in crate::light::light_samples::uniform_directions(5000) {
                let cosine = f64::from(d.dot(sun));
                // The lobe's edge, at right angles, falls between pixels.
                if cosine.abs() > 0.1 {
                    let read = f64::from(filtered.radiance(d.into())[0]);
                    let error = (read - lobe(cosine)).abs() / peak;
                    assert!(error < allowed, "{shininess} at {cosine}: {error}");
                }
            }
            let at_peak = f64::from(filtered.radiance(sun.into())[0]) / peak;
            assert!((at_peak - 1.0).abs() < allowed, "{shininess}: {at_peak}");
        }
    }

    #[test]
    fn a_lobe_without_width_leaves_the_map() {
        let map = Environment::from_fn(64, 32, |x, y| [x as f32, y as f32, 1.0]).rotated_deg(10.0);
        assert_eq!(glossy(&map, 1e6, 64), map);
        assert_eq!(glossy(&map, 1e6, 32), map.resized(32));
    }

    #[test]
    fn power_is_kept() {
        // Over all r, a normalised lobe gives every direction the weight 1.
        let map = Environment::from_fn(256, 128, |x, y| {
            [1.0, y as f32, if (x, y) == (30, 90) { 1e4 } else { 0.0 }]
        });
        for shininess in [1.0, 20.0, 300.0] {
            let filtered = glossy(&map, shininess, 256);
            for (a, b) in filtered.power().into_iter().zip(map.power()) {
                assert!((a / b - 1.0).abs() < 5e-3, "{shininess}: {a}, not {b}");
            }
        }
    }

    #[test]
    fn the_middle_stays_in_the_middle() {
        let ahead = Environment::from_fn(64, 32, |x, y| {
            [if (30..34).contains(&x) && (14..18).contains(&y) {
                1.0
            } else {
                0.0
            }; 3]
        });
        let filtered = glossy(&ahead, 50.0, 256);
        let seen = |d: Vec3| filtered.radiance(d.normalize().into())[0];
        let peak = seen(Vec3::NEG_Z);
        for d in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
            let beside = seen(Vec3::NEG_Z + 0.2 * d);
            let other = seen(Vec3::NEG_Z - 0.2 * d);
            assert!(
                beside < peak && (beside / other - 1.0).abs() < 1e-3,
                "{beside}, {other}"
            );
        }
    }
}
