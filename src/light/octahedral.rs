//! An environment at all resolutions, for look-ups by the thousand: octahedral maps, whose position needs no
//! trigonometry, of sides that are powers of two.
//!
//! Theory: T. Engelhardt, C. Dachsbacher: Octahedron Environment Maps (2008). A direction divided by the sum of its
//! magnitudes lies on an octahedron; the half with z below 0 is folded out. Changes: a map is blurred over [`FINER`] of its
//! pixels, so that the nearest one serves for a look-up between them, and place and resolution of a whole batch come from
//! shifts and masks alone.

use super::batch::{BATCH, Lanes, Vectors};
use super::environment::Environment;
use super::texels::Texel;
use rayon::prelude::*;

/// Pixels of a map across one of what it shows, and the power of two that it is.
const FINER: usize = 1 << FINER_LOG2;
const FINER_LOG2: u32 = 2;

/// The finest map has a side of 2 to this: 4 MiB, and pixels of 0.4 degrees.
const FINEST: u32 = 9;

/// Pixels of all maps smaller than the coarsest, which has one blurred pixel.
const LEFT_OUT: u32 = all_below(FINER_LOG2);

/// Look-ups for one pixel of a map that is made of an environment, across.
const LOOK_UPS: usize = 2;

/// Maps from the coarsest to the finest, one after the other.
#[derive(Debug)]
pub(crate) struct OctahedralMaps {
    texels: Vec<Texel>,
    finest: u32,
}

/// Pixels of maps with sides of all powers of two below that of `log2`: (4^n - 1) / 3 is binary 1 at every other place.
#[inline(always)]
const fn all_below(log2: u32) -> u32 {
    0x5555_5555 & ((1 << (2 * log2)) - 1)
}

impl OctahedralMaps {
    /// The maps down to blurred pixels of `least` steradians.
    pub(crate) fn new(environment: &Environment, least: f32) -> Self {
        // Pixels at the corners of the octahedron have the least solid angle.
        let finest = side_log2(map_share(least, 1.0), FINEST);
        let mut shown = vec![PowerMap::of(environment, 1 << (finest - FINER_LOG2))];
        while let Some(finer) = shown.last()
            && finer.side > 1
        {
            shown.push(finer.halved());
        }
        let maps = shown.iter().rev().map(PowerMap::enlarged);
        Self {
            texels: maps.collect::<Vec<_>>().concat(),
            finest,
        }
    }

    /// Finds the texels toward unit vectors, in the maps whose blurred pixels have about the solid angles given. Any
    /// numbers give some texel.
    #[inline(always)]
    pub(crate) fn find(&self, found: &mut [u32; BATCH], [x, y, z]: &Vectors, solid_angle: &Lanes) {
        for i in 0..BATCH {
            let size = (x[i].abs() + y[i].abs() + z[i].abs()).max(f32::MIN_POSITIVE);
            let per_size = 1.0 / size;
            let [u, v] = folded([x[i] * per_size, y[i] * per_size], z[i]);
            let log2 = side_log2(map_share(solid_angle[i], per_size), self.finest);
            let (column, row) = (cell(u, log2), cell(v, log2));
            found[i] = (all_below(log2) - LEFT_OUT) + (row << log2) + column;
        }
    }

    /// A texel that [`OctahedralMaps::find`] found.
    #[inline(always)]
    pub(crate) fn at(&self, found: u32) -> Texel {
        self.texels[found as usize]
    }
}

/// The share of a map's area that a solid angle covers where a unit vector has 1 over this sum of magnitudes: that is
/// d, so many steradians per area are `4 / d^3`.
#[inline(always)]
fn map_share(solid_angle: f32, per_size: f32) -> f32 {
    0.25 * solid_angle * (per_size * per_size * per_size)
}

/// The logarithm of the side, at most `finest`, whose blurred pixels are the closest to this share of the map: the exponent
/// of the share, halved by a shift.
#[inline(always)]
fn side_log2(share: f32, finest: u32) -> u32 {
    let log2 = (63 + FINER_LOG2) as i32 - (share.to_bits() >> 24) as i32;
    log2.clamp(FINER_LOG2 as i32, finest as i32) as u32
}

/// Position in the map, -1..1, of a vector with magnitudes that add up to 1; it is its own inverse for z below 0.
#[inline(always)]
fn folded([x, y]: [f32; 2], z: f32) -> [f32; 2] {
    let across = [(1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)];
    if z < 0.0 { across } else { [x, y] }
}

/// The column or row at a position -1..1.
#[inline(always)]
fn cell(position: f32, log2: u32) -> u32 {
    // Adding 2^23 leaves the whole part in the last bits; below it there would be halves.
    const WHOLE: f32 = 8_388_608.0;
    let side = f32::from_bits((127 + log2) << 23);
    let whole = (0.5 * side) * (position + 1.0) + (WHOLE - 0.5);
    (whole.max(WHOLE).to_bits() & 0xffff).min((1 << log2) - 1)
}

/// What a map shows before it is blurred: power and solid angle of every pixel.
struct PowerMap {
    side: usize,
    texels: Vec<Texel>,
}

impl PowerMap {
    fn of(environment: &Environment, side: usize) -> Self {
        let place = |i: usize| (2 * i + 1) as f32 / (LOOK_UPS * side) as f32 - 1.0;
        let pixel = |x: usize, y: usize| {
            let mut sum = [0.0; 4];
            for i in 0..LOOK_UPS * LOOK_UPS {
                let [u, v] = [LOOK_UPS * x + i % LOOK_UPS, LOOK_UPS * y + i / LOOK_UPS].map(place);
                let z = 1.0 - u.abs() - v.abs();
                let [x, y] = folded([u, v], z);
                let square = x * x + y * y + z * z;
                let solid_angle = 1.0 / (square * square.sqrt());
                let [r, g, b] = environment.radiance([x, y, z]);
                let look_up = [r, g, b, 1.0].map(|v| solid_angle * v);
                sum = std::array::from_fn(|k| sum[k] + look_up[k]);
            }
            sum
        };
        let pixels = (0..side * side).into_par_iter();
        Self {
            side,
            texels: pixels.map(|i| pixel(i % side, i / side)).collect(),
        }
    }

    fn halved(&self) -> Self {
        let side = self.side / 2;
        let pixel = |x: usize, y: usize| {
            let at =
                |i: usize, k: usize| self.texels[(2 * y + i / 2) * self.side + 2 * x + i % 2][k];
            std::array::from_fn(|k| at(0, k) + at(1, k) + at(2, k) + at(3, k))
        };
        Self {
            side,
            texels: (0..side * side)
                .map(|i| pixel(i % side, i / side))
                .collect(),
        }
    }

    /// The radiance between pixels, at [`FINER`] places of each.
    fn enlarged(&self) -> Vec<Texel> {
        let (old, side) = (self.side as isize, FINER * self.side);
        // The pixel before a place, which lies between its centre and that of the next, and the share of the way.
        let place = |i: usize| {
            let place = (i as f32 + 0.5) / FINER as f32 + 0.5;
            (place as isize - 1, place.fract())
        };
        let between = |a: Texel, b: Texel, share: f32| -> Texel {
            std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
        };
        let row = |y: usize| {
            let (y, down) = place(y);
            let column = |x: isize| between(self.at(x, y), self.at(x, y + 1), down);
            let columns: Vec<_> = (-1..=old).map(column).collect();
            let pixel = |x: usize| {
                let (x, across) = place(x);
                let left = (x + 1) as usize;
                let sum = between(columns[left], columns[left + 1], across);
                sum.map(|v| v / sum[3])
            };
            (0..side).map(pixel).collect::<Vec<_>>()
        };
        (0..side).into_par_iter().flat_map_iter(row).collect()
    }

    /// A pixel, or beyond an edge the one that the edge folds it onto.
    fn at(&self, x: isize, y: isize) -> Texel {
        let side = self.side as isize;
        let beyond = |i: isize| i < 0 || i >= side;
        let inside = |i: isize| i.clamp(0, side - 1);
        let [mut column, mut row] = [inside(x), inside(y)];
        if beyond(x) {
            row = side - 1 - row;
        }
        if beyond(y) {
            column = side - 1 - column;
        }
        self.texels[(row * side + column) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::light_samples::uniform_directions;

    /// The radiance toward vectors, from maps for this solid angle.
    fn read(maps: &OctahedralMaps, toward: &[[f32; 3]], solid_angle: f32) -> Vec<[f32; 3]> {
        let batches = toward.chunks(BATCH).flat_map(|some| {
            let lanes = std::array::from_fn(|k| {
                std::array::from_fn(|i| some.get(i).map_or(0.0, |toward| toward[k]))
            });
            let mut found = [0; BATCH];
            maps.find(&mut found, &lanes, &[solid_angle; BATCH]);
            let texels = found.map(|found| maps.at(found));
            (0..some.len()).map(move |i| [texels[i][0], texels[i][1], texels[i][2]])
        });
        batches.collect()
    }

    fn directions() -> Vec<[f32; 3]> {
        let axes = [0, 1, 2].map(|k| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }));
        let axes = axes
            .into_iter()
            .flat_map(|axis: [f32; 3]| [axis, axis.map(|v| -v)]);
        let around = uniform_directions(2000).into_iter().map(Into::into);
        around.chain(axes).collect()
    }

    #[test]
    fn a_direction_finds_what_shines_there() {
        // 1 + d by component. Pixels are at most 0.016 apart from edge to centre at a corner of the octahedron, where they
        // are as long as they get, 2 sqrt 2 / 256; and look-ups in the map err by 1e-3.
        let grid = Environment::from_fn(256, 128, |_, _| [0.0; 3]);
        let map = Environment::from_fn(256, 128, |x, y| {
            grid.direction(x, y).to_array().map(|v| 1.0 + v)
        });
        let map = map.rotated_deg(70.0).rotated_deg(-70.0);
        let maps = OctahedralMaps::new(&map, 1e-3);
        for (d, found) in directions().iter().zip(read(&maps, &directions(), 1e-4)) {
            for (d, found) in d.iter().zip(found) {
                assert!((1.0 + d - found).abs() < 0.02, "{d}: {found}");
            }
        }
    }

    #[test]
    fn every_map_has_the_light_of_the_environment() {
        // White above the horizon. Directions are even, so that their mean is that over the sphere, but for the pixels that
        // the few largest maps are made of.
        let map = Environment::from_fn(128, 64, |_, y| [if y < 32 { 4.0 } else { 0.0 }; 3]);
        let maps = OctahedralMaps::new(&map, 1e-4);
        for log2 in 0..16 {
            let solid_angle = 12.0 * 0.25_f32.powi(log2);
            let found = read(&maps, &directions()[..2000], solid_angle);
            let mean = found.iter().map(|c| c[0]).sum::<f32>() / found.len() as f32;
            assert!((mean - 2.0).abs() < 0.02, "{solid_angle}: {mean}");
        }
    }

    #[test]
    fn any_numbers_find_some_texel() {
        let numbers = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            1e-38,
            f32::MAX,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
        ];
        let all = numbers
            .iter()
            .flat_map(|&x| numbers.iter().map(move |&y| [x, y]));
        let all = all.flat_map(|[x, y]| numbers.iter().map(move |&z| [x, y, z]));
        let all: Vec<_> = all.collect();
        for least in [100.0, 1e-2, 0.0, f32::NAN] {
            let map = Environment::from_fn(3, 1, |_, _| [3.0; 3]);
            let maps = OctahedralMaps::new(&map, least);
            for solid_angle in numbers {
                for found in read(&maps, &all, solid_angle) {
                    assert!((found[0] - 3.0).abs() < 1e-5, "{found:?}");
                }
            }
        }
    }
}
