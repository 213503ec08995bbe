//! Median cut: an environment as a number of lights.
//!
//! Theory: [MC] halves regions of the map at the median of their energy along their longer side, and puts a light at
//! the centroid of each region's energy. Changes: the region with most energy is halved next, so that any number of
//! lights is possible, and energy is the sum of red, green and blue, which needs no primaries and ignores no colour.

use super::environment::Environment;
use super::lights::DirectionalLight;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// Widest map that is cut: finer maps are averaged first.
const MAX_WIDTH: usize = 1024;

/// Share of the total energy below which a region is dropped: the rounding of the sums.
const NEGLIGIBLE: f64 = 1e-12;

/// At most `count` lights that represent `environment`, brightest first.
///
/// Their intensities add up to its power over pi. There are fewer lights if fewer pixels shine; a black map has none.
pub fn median_cut(environment: &Environment, count: usize) -> Vec<DirectionalLight> {
    cut(environment, count, false)
}

/// [`median_cut`] where the region of the largest energy times squared diameter is halved next: what its light errs by
/// on a smooth lobe. A sun stays one light, and wide regions become small.
pub(crate) fn cut_by_spread(environment: &Environment, count: usize) -> Vec<DirectionalLight> {
    cut(environment, count, true)
}

fn cut(environment: &Environment, count: usize, by_spread: bool) -> Vec<DirectionalLight> {
    let environment = environment.resized(MAX_WIDTH);
    let energy = EnergySums::of(&environment, by_spread);
    let columns: Vec<_> = (0..environment.width())
        .map(|x| environment.azimuth(x).sin_cos())
        .collect();
    let regions = regions(&energy, count);
    regions
        .iter()
        .map(|region| region.light(&environment, &columns))
        .collect()
}

/// Summed-area table of energy from the map's corner.
struct EnergySums {
    width: usize,
    height: usize,
    /// `(width + 1) * (height + 1)` sums; the first row and column are 0.
    sums: Vec<f64>,
    by_spread: bool,
}

impl EnergySums {
    fn of(environment: &Environment, by_spread: bool) -> Self {
        let (width, height) = (environment.width(), environment.height());
        let stride = width + 1;
        let mut sums = vec![0.0; stride * (height + 1)];
        for y in 0..height {
            let solid_angle = environment.solid_angle(y);
            let mut in_row = 0.0;
            for x in 0..width {
                in_row += solid_angle * energy_of(environment.pixel(x, y));
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + in_row;
            }
        }
        Self {
            width,
            height,
            sums,
            by_spread,
        }
    }

    fn of_rectangle(&self, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2]) -> f64 {
        let at = |x: usize, y: usize| self.sums[y * (self.width + 1) + x];
        (at(x1, y1) - at(x0, y1)) - (at(x1, y0) - at(x0, y0))
    }

    fn region(&self, columns: [usize; 2], rows: [usize; 2]) -> Region {
        let energy = self.of_rectangle(columns, rows);
        let [across, down] = self.sides(columns, rows);
        let spread = across * across + down * down;
        Region {
            weight: energy * if self.by_spread { spread } else { 1.0 },
            energy,
            columns,
            rows,
        }
    }

    /// Both sides of a rectangle as angles; columns converge with latitude.
    fn sides(&self, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2]) -> [f64; 2] {
        let latitude = (0.5 - (y0 + y1) as f64 / 2.0 / self.height as f64) * PI;
        let across = (x1 - x0) as f64 / self.width as f64 * 2.0 * PI * latitude.cos();
        [across, (y1 - y0) as f64 / self.height as f64 * PI]
    }
}

fn energy_of(radiance: [f32; 3]) -> f64 {
    radiance.iter().map(|&v| f64::from(v)).sum()
}

/// A rectangle of pixels, half-open, ordered by weight.
struct Region {
    /// Its energy, times its squared diameter if the cut is by spread.
    weight: f64,
    energy: f64,
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Ord for Region {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_weight = self.weight.total_cmp(&other.weight);
        // Ties are broken by position, so that the order never depends on the heap.
        by_weight.then_with(|| (other.rows, other.columns).cmp(&(self.rows, self.columns)))
    }
}

impl PartialOrd for Region {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Region {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Region {}

/// At most `count` regions with all the energy, heaviest first.
fn regions(energy: &EnergySums, count: usize) -> Vec<Region> {
    let whole = energy.region([0, energy.width], [0, energy.height]);
    if count == 0 || whole.energy <= 0.0 {
        return Vec::new();
    }
    let negligible = NEGLIGIBLE * whole.energy;
    let mut to_halve = BinaryHeap::from([whole]);
    let mut whole_pixels = Vec::new();
    while to_halve.len() + whole_pixels.len() < count {
        let Some(region) = to_halve.pop() else {
            break;
        };
        match region.halves(energy) {
            Some(halves) => to_halve.extend(halves.into_iter().filter(|h| h.energy > negligible)),
            None => whole_pixels.push(region),
        }
    }
    let mut regions: Vec<_> = to_halve.into_iter().chain(whole_pixels).collect();
    regions.sort_unstable_by(|a, b| b.cmp(a));
    regions
}

impl Region {
    /// The two parts on either side of the median of energy; `None` for a single pixel.
    fn halves(&self, energy: &EnergySums) -> Option<[Region; 2]> {
        let ([x0, x1], [y0, y1]) = (self.columns, self.rows);
        let [across, down] = energy.sides(self.columns, self.rows);
        let halves = match (x1 - x0, y1 - y0) {
            (1, 1) => return None,
            (1, _) => self.cut_rows(energy),
            (_, 1) => self.cut_columns(energy),
            _ if across >= down => self.cut_columns(energy),
            _ => self.cut_rows(energy),
        };
        Some(halves)
    }

    fn cut_columns(&self, energy: &EnergySums) -> [Region; 2] {
        let [start, end] = self.columns;
        let before = |x: usize| energy.of_rectangle([start, x], self.rows);
        let cut = median(start, end, self.energy, before);
        [[start, cut], [cut, end]].map(|columns| energy.region(columns, self.rows))
    }

    fn cut_rows(&self, energy: &EnergySums) -> [Region; 2] {
        let [start, end] = self.rows;
        let before = |y: usize| energy.of_rectangle(self.columns, [start, y]);
        let cut = median(start, end, self.energy, before);
        [[start, cut], [cut, end]].map(|rows| energy.region(self.columns, rows))
    }

    fn light(&self, environment: &Environment, columns: &[(f64, f64)]) -> DirectionalLight {
        let ([x0, x1], [y0, y1]) = (self.columns, self.rows);
        let (mut power, mut moment) = ([0.0_f64; 3], DVec3::ZERO);
        for y in y0..y1 {
            let (sin, cos) = environment.elevation(y).sin_cos();
            let mut in_row = DVec3::ZERO;
            let mut colors = [0.0_f64; 3];
            for (x, (sin_a, cos_a)) in (x0..x1).zip(&columns[x0..x1]) {
                let radiance = environment.pixel(x, y);
                in_row += energy_of(radiance) * DVec3::new(cos * sin_a, sin, -cos * cos_a);
                for (sum, v) in colors.iter_mut().zip(radiance) {
                    *sum += f64::from(v);
                }
            }
            let solid_angle = environment.solid_angle(y);
            moment += solid_angle * in_row;
            for (power, sum) in power.iter_mut().zip(colors) {
                *power += solid_angle * sum;
            }
        }
        // Uniform light from all sides has no centroid: use the centre of the region.
        let centre = match moment.length() > 1e-9 * self.energy {
            true => moment.normalize().as_vec3(),
            false => environment.direction((x0 + x1) / 2, (y0 + y1) / 2),
        };
        DirectionalLight {
            to_light: centre,
            intensity: power.map(|power| (power / PI) as f32),
        }
    }
}

/// The position between `start` and `end`, both excluded, at which `before(place)`, a non-decreasing function, comes
/// closest to half of `energy`.
fn median(start: usize, end: usize, energy: f64, before: impl Fn(usize) -> f64) -> usize {
    let (mut low, mut high) = (start + 1, end - 1);
    while low < high {
        let middle = (low + high) / 2;
        match 2.0 * before(middle) >= energy {
            true => high = middle,
            false => low = middle + 1,
        }
    }
    let misses = |place: usize| (before(place) - energy / 2.0).abs();
    match low > start + 1 && misses(low - 1) <= misses(low) {
        true => low - 1,
        false => low,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(lights: &[DirectionalLight]) -> [f64; 3] {
        [0, 1, 2].map(|c| lights.iter().map(|l| f64::from(l.intensity[c])).sum())
    }

    /// A sky with a sun, in many colours.
    fn sky() -> Environment {
        Environment::from_fn(128, 64, |x, y| {
            let sun = if (x, y) == (40, 20) { 5e4 } else { 0.0 };
            [
                sun + 1.0 + x as f32 / 128.0,
                sun + 2.0,
                3.0 - y as f32 / 64.0,
            ]
        })
    }

    #[test]
    fn power_is_kept() {
        for map in [sky(), sky().rotated_deg(77.0)] {
            for count in [1, 2, 7, 64, 1000, 100_000] {
                let lights = median_cut(&map, count);
                assert_eq!(lights.len(), count.min(128 * 64));
                for (sum, power) in total(&lights).into_iter().zip(map.power()) {
                    assert!((sum * PI / power - 1.0).abs() < 1e-6, "{count}: {sum}");
                }
                assert!(
                    lights
                        .iter()
                        .all(|l| (l.to_light.length() - 1.0).abs() < 1e-5)
                );
                assert_eq!(lights, median_cut(&map, count));
            }
        }
    }

    #[test]
    fn the_sun_is_the_first_light() {
        let lights = median_cut(&sky(), 64);
        let sun = sky().direction(40, 20);
        assert!(
            (lights[0].to_light - sun).length() < 1e-3,
            "{}",
            lights[0].to_light
        );
    }

    #[test]
    fn by_spread_a_sun_takes_one_light() {
        // One pixel of 5e4 has 17 times the energy of the rest: of 16 lights by energy alone the rest has few.
        let lights = cut_by_spread(&sky(), 16);
        let sun = sky().direction(40, 20);
        let near = |l: &&DirectionalLight| l.to_light.dot(sun) > 0.95;
        assert!(lights.iter().filter(near).count() <= 3, "{lights:?}");
        for (sum, power) in total(&lights).into_iter().zip(sky().power()) {
            assert!((sum * PI / power - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_rotation_of_the_map_turns_the_lights() {
        let (plain, turned) = (
            median_cut(&sky(), 16),
            median_cut(&sky().rotated_deg(90.0), 16),
        );
        for (a, b) in plain.iter().zip(&turned) {
            // The direction -z, previously ahead, is now +x, to the right.
            let expected = glam::Vec3::new(-a.to_light.z, a.to_light.y, a.to_light.x);
            assert!((b.to_light - expected).length() < 1e-5);
            assert_eq!(a.intensity, b.intensity);
        }
    }

    #[test]
    fn a_constant_map_gives_lights_of_like_power() {
        let map = Environment::from_fn(256, 128, |_, _| [1.0; 3]);
        let lights = median_cut(&map, 256);
        // For a power of two every region is halved equally often, to within a row or column.
        for light in &lights {
            assert!(
                (light.intensity[0] * 256.0 / 4.0 - 1.0).abs() < 0.35,
                "{light:?}"
            );
        }
        let mean = lights
            .iter()
            .map(|l| l.intensity[0] * l.to_light)
            .sum::<glam::Vec3>();
        assert!(mean.length() < 0.02, "{mean}");
    }

    #[test]
    fn strange_maps_are_cut() {
        let black = Environment::from_fn(8, 4, |_, _| [f32::NAN, -1.0, 0.0]);
        assert!(median_cut(&black, 16).is_empty());
        let one =
            Environment::from_fn(64, 32, |x, y| [if (x, y) == (9, 9) { 1e6 } else { 0.0 }; 3]);
        let lights = median_cut(&one, 16);
        assert_eq!(lights.len(), 1);
        assert!((lights[0].to_light - one.direction(9, 9)).length() < 1e-6);
        for (width, height) in [(1, 1), (1, 5), (5, 1), (2, 1)] {
            let map = Environment::from_fn(width, height, |_, _| [f32::INFINITY, 1.0, 1e30]);
            for count in [0, 1, 3, 50] {
                let lights = median_cut(&map, count);
                assert_eq!(lights.len(), count.min(width * height));
                for light in lights {
                    assert!(light.to_light.is_normalized());
                    assert!(light.intensity.iter().all(|v| v.is_finite()));
                }
            }
        }
    }
}
