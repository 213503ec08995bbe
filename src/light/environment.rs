//! Environments: radiance by direction.
//!
//! An environment is attached to the view: the centre of its map lies straight ahead of the viewer, behind the surface.
//! There is no world space here that could orient it otherwise.

use super::texels::{Texels, cell, mixed, rgb};
use crate::frame::ColorPlanes;
use crate::kernel::fast_math::atan2;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Radiance from every direction: a latitude-longitude map, seen from inside.
///
/// The middle column is the direction -z, ahead of the viewer; the top edge is +y; +x, the viewer's right, lies a
/// quarter of the width right of the middle. The left and right edges are +z, behind the viewer. Samples are finite and
/// non-negative.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    texels: Texels,
    /// The rotation, in turns.
    turn: f32,
}

impl Environment {
    /// The environment of a latitude-longitude map of any size, usually 2:1. NaN and negative samples become 0,
    /// infinite ones 65504.
    ///
    /// # Panics
    /// If the planes differ in size or are empty.
    pub fn new(radiance: ColorPlanes) -> Self {
        Self::of_texels(Texels::new(&radiance))
    }

    /// The map whose pixel at column `x` of row `y` is `radiance(x, y)`.
    ///
    /// # Panics
    /// If it has no pixels.
    pub fn from_fn(
        width: usize,
        height: usize,
        radiance: impl FnMut(usize, usize) -> [f32; 3],
    ) -> Self {
        Self::of_texels(Texels::from_fn(width, height, radiance))
    }

    pub(super) fn of_texels(texels: Texels) -> Self {
        Self { texels, turn: 0.0 }
    }

    /// The environment rotated about the vertical axis, in addition to any earlier rotation. Positive degrees move the
    /// direction ahead of the viewer to the viewer's right. Non-finite degrees rotate nothing.
    pub fn rotated_deg(mut self, degrees: f32) -> Self {
        let turn = (f64::from(degrees) / 360.0).rem_euclid(1.0) as f32;
        if turn.is_finite() {
            self.turn = (self.turn + turn).fract();
        }
        self
    }

    /// The environment with the rotation of `other`.
    pub(super) fn turned_like(mut self, other: &Environment) -> Self {
        self.turn = other.turn;
        self
    }

    /// Columns of the map.
    pub fn width(&self) -> usize {
        self.texels.width()
    }

    /// Rows of the map.
    pub fn height(&self) -> usize {
        self.texels.height()
    }

    /// Its pixels row by row: red, green, blue and an unused number, for other backends.
    #[cfg(feature = "gpu")]
    pub(crate) fn texels(&self) -> &[[f32; 4]] {
        self.texels.all()
    }

    /// The rotation, in turns.
    #[cfg(feature = "gpu")]
    pub(crate) fn turn(&self) -> f32 {
        self.turn
    }

    /// The radiance of the pixel at column `x` of row `y`.
    pub fn pixel(&self, x: usize, y: usize) -> [f32; 3] {
        rgb(self.texels.at(x, y))
    }

    /// The radiance from `direction`: bilinear between pixel centres, including across the seam and the poles.
    ///
    /// `direction` points away from the surface, with any length from 1e-15 to 1e15. The result is finite for any
    /// input.
    #[inline]
    pub fn radiance(&self, direction: [f32; 3]) -> [f32; 3] {
        let [column, row] = self.position(direction);
        self.at_position(column, row)
    }

    /// Column and row of the map for `direction`, integers being pixel centres. Branch-free, so that a loop over
    /// directions vectorises.
    #[inline(always)]
    pub fn position(&self, direction: [f32; 3]) -> [f32; 2] {
        equirectangular_position([self.width(), self.height()], self.turn, direction)
    }

    /// The radiance at a position of the map, from -1 to `width` and `height`, integers being pixel centres. NaN reads
    /// some pixel.
    #[inline(always)]
    pub fn at_position(&self, column: f32, row: f32) -> [f32; 3] {
        let (top, down) = cell(row);
        let upper = self.on_row(column, top);
        let lower = self.on_row(column, top + 1);
        rgb(mixed(upper, lower, down))
    }

    /// Linear along row `y`. Beyond a pole the same row continues, half a turn away.
    #[inline(always)]
    fn on_row(&self, column: f32, y: i32) -> [f32; 4] {
        let (width, last) = (self.width(), self.height() as i32 - 1);
        let beyond_pole = y < 0 || y > last;
        let column = column + if beyond_pole { width as f32 / 2.0 } else { 0.0 };
        let (left, across) = cell(column);
        let wrapped = |x: i32| {
            let x = if x < 0 { x + width as i32 } else { x } as usize;
            // A single column is its own neighbour on both sides.
            (if x >= width { x - width } else { x }).min(width - 1)
        };
        let row = self.texels.row(y.clamp(0, last) as usize);
        mixed(row[wrapped(left)], row[wrapped(left + 1)], across)
    }

    /// The unit direction of the centre of the pixel at column `x` of row `y`.
    pub fn direction(&self, x: usize, y: usize) -> Vec3 {
        let ((sin_a, cos_a), (sin_e, cos_e)) =
            (self.azimuth(x).sin_cos(), self.elevation(y).sin_cos());
        DVec3::new(cos_e * sin_a, sin_e, -cos_e * cos_a).as_vec3()
    }

    /// Azimuth of the centres of column `x`, in radians: 0 ahead, increasing to the viewer's right.
    pub(super) fn azimuth(&self, x: usize) -> f64 {
        ((x as f64 + 0.5) / self.width() as f64 - 0.5 + f64::from(self.turn)) * 2.0 * PI
    }

    /// Elevation of the centres of row `y`, in radians: pi/2 at the top edge.
    pub(super) fn elevation(&self, y: usize) -> f64 {
        (0.5 - (y as f64 + 0.5) / self.height() as f64) * PI
    }

    /// The solid angle, in steradians, of each pixel of row `y`.
    pub fn solid_angle(&self, y: usize) -> f64 {
        let rows = self.height() as f64;
        zone(y as f64 / rows, (y + 1) as f64 / rows) * 2.0 * PI / self.width() as f64
    }

    /// Radiance integrated over all directions.
    pub fn power(&self) -> [f64; 3] {
        let mut power = [0.0; 3];
        for y in 0..self.height() {
            let solid_angle = self.solid_angle(y);
            for texel in self.texels.row(y) {
                for (power, &radiance) in power.iter_mut().zip(texel) {
                    *power += solid_angle * f64::from(radiance);
                }
            }
        }
        power
    }

    /// The largest luminance of a pixel; `weights` are those of linear red, green and blue.
    pub fn largest_luminance(&self, weights: [f32; 3]) -> f32 {
        self.texels.largest_luminance(weights, |_, _| true)
    }

    /// The environment on a map of at most `max_width` columns (at least 1): each pixel is the mean over its area,
    /// weighted by solid angle, so that power is preserved.
    pub fn resized(&self, max_width: usize) -> Environment {
        let (width, height) = (self.width(), self.height());
        let max_width = max_width.max(1);
        if width <= max_width {
            return self.clone();
        }
        let rows = (height * max_width + width / 2) / width;
        let rows = rows.clamp(1, height);
        let columns = overlaps(width, max_width, |from, to| to - from);
        let bands = overlaps(height, rows, zone);
        let mut texels = Vec::with_capacity(max_width * rows);
        let mut sums = vec![[0.0_f64; 3]; width];
        for band in &bands {
            sums.fill([0.0; 3]);
            for &(y, weight) in band {
                for (sum, texel) in sums.iter_mut().zip(self.texels.row(y)) {
                    for (sum, &radiance) in sum.iter_mut().zip(texel) {
                        *sum += weight * f64::from(radiance);
                    }
                }
            }
            texels.extend(columns.iter().map(|column| {
                let mean = column.iter().fold([0.0; 3], |mean, &(x, weight)| {
                    std::array::from_fn(|i| mean[i] + weight * sums[x][i])
                });
                mean.map(|v| v as f32)
            }));
        }
        Self::from_fn(max_width, rows, |x, y| texels[y * max_width + x]).turned_like(self)
    }
}

/// Solid angle over 2 pi of the zone between two polar angles, given as shares of the way from zenith to nadir.
fn zone(from: f64, to: f64) -> f64 {
    // The difference of cosines without cancellation.
    2.0 * ((from + to) * PI / 2.0).sin() * ((to - from) * PI / 2.0).sin()
}

/// For each of `to` equal intervals, the overlapping ones of `from` equal intervals, and their shares of its measure.
fn overlaps(from: usize, to: usize, measure: impl Fn(f64, f64) -> f64) -> Vec<Vec<(usize, f64)>> {
    let shares = |i: usize| {
        let (start, end) = (i as f64 / to as f64, (i + 1) as f64 / to as f64);
        let (first, last) = (i * from / to, ((i + 1) * from).div_ceil(to));
        let share = |j: usize| {
            let overlap_start = (j as f64 / from as f64).max(start);
            let overlap_end = ((j + 1) as f64 / from as f64).min(end);
            let overlap = measure(overlap_start, overlap_end.max(overlap_start));
            (j, overlap / measure(start, end))
        };
        (first..last).map(share).collect()
    };
    (0..to).map(shares).collect()
}

/// Column and row, integers being pixel centres, of a direction on a map of this size rotated by `turn` turns.
#[inline(always)]
pub(crate) fn equirectangular_position(
    [width, height]: [usize; 2],
    turn: f32,
    [x, y, z]: [f32; 3],
) -> [f32; 2] {
    use std::f32::consts::{PI, TAU};
    let across = atan2(x, -z) / TAU + 0.5 - turn;
    let across = if across < 0.0 { across + 1.0 } else { across };
    let down = 0.5 - atan2(y, (x * x + z * z).sqrt()) / PI;
    [across * width as f32 - 0.5, down * height as f32 - 0.5]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map of distinct pixels: column, row and 1.
    fn numbered(width: usize, height: usize) -> Environment {
        Environment::from_fn(width, height, |x, y| [x as f32, y as f32, 1.0])
    }

    /// A smooth function of direction, without seams.
    fn smooth(d: Vec3) -> [f32; 3] {
        [2.0 + d.x, 2.0 + d.y + 0.5 * d.x * d.z, 2.0 + d.z]
    }

    fn smooth_map(width: usize, height: usize) -> Environment {
        let grid = numbered(width, height);
        Environment::from_fn(width, height, |x, y| smooth(grid.direction(x, y)))
    }

    #[test]
    fn directions_of_pixels_read_those_pixels() {
        for (width, height, turn) in [(64, 32, 0.0), (17, 9, 33.0), (2, 1, -90.0), (1, 1, 5.0)] {
            let map = numbered(width, height).rotated_deg(turn);
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let read = map.radiance(map.direction(x, y).to_array());
                for (read, stored) in read.into_iter().zip([x as f32, y as f32, 1.0]) {
                    // The angle's error of 4e-7 is 4e-6 of 64 columns, amplified 63-fold at the seam, where column 63
                    // meets column 0.
                    assert!((read - stored).abs() < 3e-4, "{x}, {y}: {read}");
                }
            }
        }
    }

    #[test]
    fn the_middle_is_ahead_and_right_is_right() {
        // One bright pixel of 8x4: columns are 45 degrees wide, with edges at multiples of 45.
        let bright = |x: usize, y: usize| {
            Environment::from_fn(
                8,
                4,
                |i, j| if (i, j) == (x, y) { [1.0; 3] } else { [0.0; 3] },
            )
        };
        let azimuth = 22.5_f32.to_radians();
        let seen = |map: &Environment, d: [f32; 3]| map.radiance(d)[0];
        // Column 4 lies just right of the middle; row 1 is above the horizon, at 22.5 degrees.
        let [sin, cos] = [azimuth.sin(), azimuth.cos()];
        let ahead_right = [sin * cos, sin, -cos * cos];
        assert!((seen(&bright(4, 1), ahead_right) - 1.0).abs() < 1e-5);
        // Column 6 begins at +x.
        let right = [cos * cos, sin, sin * cos];
        assert!((seen(&bright(6, 1), right) - 1.0).abs() < 1e-5);
        // A quarter turn to the right moves the first to the second.
        let turned = bright(4, 1).rotated_deg(90.0);
        assert!((seen(&turned, right) - 1.0).abs() < 1e-5);
        let twice = bright(4, 1).rotated_deg(-300.0).rotated_deg(30.0);
        assert!((seen(&twice, right) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn seam_and_poles_are_crossed_without_a_step() {
        let map = smooth_map(64, 32);
        // Great circles: across the seam at +z, and over both poles.
        for tilt in [0.0_f32, 0.3, 1.0, 1.5] {
            let at = |i: u32| {
                let (sin, cos) = (i as f32 / 7200.0 * std::f32::consts::TAU).sin_cos();
                Vec3::new(tilt.sin() * cos, sin, tilt.cos() * cos)
            };
            for i in 0..7200 {
                let (a, b) = (map.radiance(at(i).into()), map.radiance(at(i + 1).into()));
                for c in 0..3 {
                    // The function's slope is below 1.5 per radian, a step 8.7e-4 radians; next to a pole that step
                    // crosses half a pixel of the map, 0.05 radians.
                    assert!((a[c] - b[c]).abs() < 2e-3, "tilt {tilt}, step {i}");
                    let error = (a[c] - smooth(at(i))[c]).abs();
                    assert!(error < 5e-3, "tilt {tilt}, step {i}: {error}");
                }
            }
        }
    }

    #[test]
    fn every_direction_gives_a_finite_radiance() {
        for (width, height) in [(64, 32), (1, 1), (3, 1), (1, 3)] {
            let map = numbered(width, height)
                .rotated_deg(f32::NAN)
                .rotated_deg(1e30);
            let values = [
                0.0,
                -0.0,
                1.0,
                -1.0,
                1e-30,
                1e30,
                f32::MAX,
                f32::MIN_POSITIVE,
                f32::NAN,
                f32::INFINITY,
                f32::NEG_INFINITY,
            ];
            for x in values {
                for y in values {
                    for z in values {
                        let read = map.radiance([x, y, z]);
                        let in_range = read[0] < width as f32 && read[1] < height as f32;
                        assert!(
                            in_range && (read[2] - 1.0).abs() < 1e-6,
                            "{x} {y} {z}: {read:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn solid_angles_add_up_to_the_sphere() {
        for (width, height) in [(64, 32), (5, 7), (1, 1)] {
            let map = Environment::from_fn(width, height, |_, _| [1.0, 2.0, 0.0]);
            let power = map.power();
            assert!((power[0] - 4.0 * PI).abs() < 1e-12 && (power[1] - 8.0 * PI).abs() < 1e-12);
        }
        // The area of a zone is 2 pi times its height: the top row of 4 reaches down to cos 45 degrees.
        let map = numbered(8, 4);
        let zone = 2.0 * PI * (1.0 - 0.5_f64.sqrt()) / 8.0;
        assert!((map.solid_angle(0) - zone).abs() < 1e-14);
    }

    #[test]
    fn resizing_keeps_power_and_rotation() {
        let map = smooth_map(200, 101).rotated_deg(40.0);
        for width in [199, 64, 7, 1, 0] {
            let small = map.resized(width);
            assert_eq!(small.width(), width.max(1));
            for (a, b) in small.power().into_iter().zip(map.power()) {
                assert!((a / b - 1.0).abs() < 1e-6, "{width}: {a}, not {b}");
            }
        }
        let small = map.resized(64);
        for (x, y) in [(0, 5), (20, 20), (63, 25)] {
            let direction = small.direction(x, y);
            let (a, b) = (small.pixel(x, y), map.radiance(direction.into()));
            // The mean of a pixel differs from its centre by h^2/24 times the second derivatives, and its weight is
            // h^2/12 cot(25 degrees) closer to the equator: 2e-3, with h = 0.098.
            assert!(
                (0..3).all(|i| (a[i] - b[i]).abs() < 3e-3),
                "{a:?}, not {b:?}"
            );
        }
        assert_eq!(map.resized(200), map);
    }

    #[test]
    fn the_largest_luminance_is_found() {
        let map = numbered(5, 3);
        assert_eq!(map.largest_luminance([1.0, 10.0, 0.5]), 4.0 + 20.0 + 0.5);
    }
}
