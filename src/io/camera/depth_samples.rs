//! Patches of surface that a rotation is recovered from: how fast depth changes, and the normal.

use super::samples::{PixelGrid, quantile};
use crate::frame::{Mask, Plane, Vector3Planes};
use half::f16;
use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

/// Pixels tried for patches of 3x3 pixels, and a share of them for larger ones, whose errors are smaller; about half
/// survive on a typical picture.
const CANDIDATES: usize = 10_000;
/// Enough patches; with fewer, smaller and rougher ones are accepted.
const ENOUGH: usize = 700;
/// Covered pixels from which on larger patches leave enough of them.
const ROOMY: usize = 8_000;
/// Criteria for choosing patches.
#[derive(Clone, Copy)]
struct PatchCriteria {
    /// Pixels to each side of the middle one.
    reach: usize,
    /// Shortest normal that counts as unfiltered.
    shortest: f64,
    /// Length of the mean of a patch's normals as a share of their own: at 0.99 they lie 8 degrees about
    /// it, and no sharp crease runs through.
    alike: f64,
}

const fn choice(reach: usize, shortest: f64, alike: f64) -> PatchCriteria {
    PatchCriteria {
        reach,
        shortest,
        alike,
    }
}

/// Strictest first, where depth is exact: small patches follow curved surface best.
const FINE: [PatchCriteria; 3] = [
    choice(1, 0.98, 0.99),
    choice(1, 0.95, 0.98),
    choice(1, 0.9, 0.96),
];
/// Strictest first, for renderers that sample depth at a random place inside each pixel, or round it to half floats.
/// The slope of a plane fitted to 7x7 pixels has an eighth of the error of one fitted to 3x3.
const COARSE: [PatchCriteria; 4] = [
    choice(3, 0.98, 0.99),
    choice(2, 0.98, 0.99),
    choice(1, 0.98, 0.98),
    choice(1, 0.9, 0.96),
];
/// Offset of depth samples from the pixel centre, in pixels, from which the coarse criteria apply.
const OFF_CENTRE: f64 = 0.2;
/// Number of pixels at which the error of depth is measured.
const PROBES: usize = 4_000;
/// Normals longer than this are not normals.
const LONGEST: f64 = 1.05;
/// Depths from here on mean "no surface" in some renderers.
const FARTHEST: f64 = 1e9;
/// Scatter of depth about the fitted plane, in pixels of its slope: random places in the pixel give
/// 0.3 to 0.4, a step from one surface to the next gives about 1.
const SCATTER_PX: f64 = 0.7;
/// Tolerated scatter on surfaces that face the viewer, as a slope seen from a distance of one width.
const SCATTER_SLOPE: f64 = 0.03;
/// Tiles along each side of the picture; errors within one are taken to be related.
pub(super) const TILES: usize = 12;

/// A small piece of surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// Place on the picture from the centre of the display window, x right and y up, in pixel widths.
    pub(super) seen: Vector2<f64>,
    /// Depth in scene units.
    pub(super) depth: f64,
    /// Change of the logarithm of depth per pixel width, to the right and up.
    pub(super) slope: Vector2<f64>,
    /// Unit normal in the space of the normal map.
    pub(super) normal: Vector3<f64>,
    /// Spread of the normals about their mean, as an angle in radians.
    pub(super) bend: f64,
    /// Index of its tile of the picture.
    pub(super) tile: usize,
}

/// Normals and depth of one picture.
pub(super) struct NormalsAndDepth<'a> {
    pub(super) normal: &'a Vector3Planes,
    pub(super) depth: &'a Plane,
    pub(super) mask: &'a Mask,
    pub(super) grid: PixelGrid,
}

/// Sums over the pixels of a patch.
#[derive(Default)]
struct PatchSums {
    /// Inverse depth of the middle pixel; that of the others is measured from it.
    middle: f64,
    rise: f64,
    square: f64,
    across: f64,
    up: f64,
    normal: Vector3<f64>,
    length: f64,
}

impl NormalsAndDepth<'_> {
    /// Patches on an even grid over the picture, of the strictest choice that gives enough of them.
    pub(super) fn patches(&self) -> Vec<Facet> {
        let roomy = self.mask.count() >= ROOMY;
        let rough = self.is_half() || self.off_centre().is_some_and(|px| px > OFF_CENTRE);
        let choices = if roomy && rough {
            &COARSE[..]
        } else {
            &FINE[..]
        };
        let (mut best, mut most) = (Vec::new(), 0);
        for &choice in choices {
            let found = self.patches_of(choice);
            let count = found.len() * choice.reach;
            if count >= ENOUGH {
                return found;
            }
            if count > 2 * most {
                (best, most) = (found, count);
            }
        }
        best
    }

    /// Whether depth looks rounded to half floats.
    fn is_half(&self) -> bool {
        let (width, height) = (self.depth.width(), self.depth.height());
        let stride = stride(self.mask.count(), PROBES);
        let places = (0..height)
            .step_by(stride)
            .flat_map(|y| (0..width).step_by(stride).map(move |x| (x, y)));
        places
            .filter(|&(x, y)| self.mask.at(x, y))
            .map(|(x, y)| self.depth.at(x, y))
            .all(|depth| f16::from_f32(depth).to_f32() == depth)
    }

    /// Typical offset of depth samples from the pixel centre, in pixels.
    pub(super) fn off_centre(&self) -> Option<f64> {
        let (width, height) = (self.depth.width(), self.depth.height());
        let stride = stride(self.mask.count(), PROBES);
        let rows = (1..height.saturating_sub(1)).step_by(stride);
        let mut found: Vec<f64> = rows
            .flat_map(|y| {
                let columns = (2..width.saturating_sub(2)).step_by(stride);
                columns.filter_map(move |x| self.off_centre_at(x, y))
            })
            .collect();
        // Half of all normal errors lie within 0.67 standard deviations.
        (found.len() > PROBES / 40).then(|| quantile(&mut found, 0.5) / 0.6745)
    }

    /// Error of depth in pixels of its slope, from one fourth difference, which cancels smooth shape and adds up the
    /// errors of five pixels to `sqrt(70)` times that of one.
    fn off_centre_at(&self, x: usize, y: usize) -> Option<f64> {
        let at = |x: usize, y: usize| {
            let depth = f64::from(self.depth.at(x, y));
            let real = self.mask.at(x, y) && depth > 0.0 && depth < FARTHEST;
            real.then_some(1.0 / depth)
        };
        let (a, b, c) = (at(x - 2, y)?, at(x - 1, y)?, at(x, y)?);
        let (d, e) = (at(x + 1, y)?, at(x + 2, y)?);
        let fourth = a - 4.0 * b + 6.0 * c - 4.0 * d + e;
        let slope = (2.0 * (e - a) + d - b) / 10.0;
        let slope = slope.hypot(0.5 * (at(x, y - 1)? - at(x, y + 1)?));
        // Errors on surfaces facing the viewer are harmless, however large relative to the slope.
        let facing = SCATTER_SLOPE * c / self.grid.display.width().max(1) as f64;
        Some(fourth.abs() / (70f64.sqrt() * (slope + facing)))
    }

    fn patches_of(&self, choice: PatchCriteria) -> Vec<Facet> {
        let reach = choice.reach;
        let (width, height) = (self.depth.width(), self.depth.height());
        let stride = stride(self.mask.count(), CANDIDATES / reach);
        let rows: Vec<usize> = (reach..height.saturating_sub(reach))
            .step_by(stride)
            .collect();
        let of_row = |y: usize| {
            let columns = (reach..width.saturating_sub(reach)).step_by(stride);
            columns.filter_map(move |x| self.patch(x, y, choice))
        };
        rows.into_par_iter().flat_map_iter(of_row).collect()
    }

    /// The patch around a pixel; `None` unless it is one smooth surface.
    fn patch(&self, x: usize, y: usize, choice: PatchCriteria) -> Option<Facet> {
        let reach = choice.reach;
        let sums = self.sums(x, y, reach, choice.shortest)?;
        let side = (2 * reach + 1) as f64;
        let count = side * side;
        // Inverse depth is linear in the picture wherever the surface is plane. Columns and rows of a
        // patch are uncorrelated, so the two slopes of the least-squares plane come one by one.
        let spread = count * (side * side - 1.0) / 12.0;
        let inverse = sums.middle + sums.rise / count;
        let per_column = sums.across / spread;
        let per_row = sums.up / spread;
        let explained = spread * (per_column * per_column + per_row * per_row);
        let unexplained = sums.square - sums.rise * sums.rise / count - explained;
        let scatter = (unexplained.max(0.0) / count).sqrt();
        let allowed = SCATTER_PX * per_column.hypot(per_row)
            + SCATTER_SLOPE * reach as f64 * inverse / self.grid.display.width().max(1) as f64;
        let alike = sums.normal.norm() / sums.length;
        (scatter <= allowed && alike >= choice.alike).then(|| Facet {
            seen: self.grid.seen(x, y),
            depth: 1.0 / inverse,
            slope: -Vector2::new(per_column, per_row * self.grid.aspect) / inverse,
            normal: sums.normal.normalize(),
            bend: (2.0 * (1.0 - alike).max(0.0)).sqrt(),
            tile: self.tile(x, y),
        })
    }

    fn sums(&self, x: usize, y: usize, reach: usize, shortest: f64) -> Option<PatchSums> {
        let mut sums = PatchSums {
            middle: 1.0 / f64::from(self.depth.at(x, y)),
            ..PatchSums::default()
        };
        let columns = x - reach..x + reach + 1;
        let n = self.normal;
        for row in y - reach..y + reach + 1 {
            let covered = &self.mask.row(row)[columns.clone()];
            let depths = &self.depth.row(row)[columns.clone()];
            let [nx, ny, nz] = [&n.x, &n.y, &n.z].map(|plane| &plane.row(row)[columns.clone()]);
            for (i, (&covered, &depth)) in covered.iter().zip(depths).enumerate() {
                let depth = f64::from(depth);
                let normal = Vector3::new(nx[i], ny[i], nz[i]).map(f64::from);
                let length = normal.norm();
                let is_surface = covered && depth > 0.0 && depth < FARTHEST;
                if !(is_surface && (shortest..=LONGEST).contains(&length)) {
                    return None;
                }
                // Sums about the middle keep their digits where depth hardly changes.
                let rise = 1.0 / depth - sums.middle;
                sums.rise += rise;
                sums.square += rise * rise;
                sums.across += rise * (i as f64 - reach as f64);
                sums.up += rise * (y as f64 - row as f64);
                sums.normal += normal;
                sums.length += length;
            }
        }
        Some(sums)
    }

    fn tile(&self, x: usize, y: usize) -> usize {
        let column = x * TILES / self.depth.width().max(1);
        let row = y * TILES / self.depth.height().max(1);
        row * TILES + column
    }
}

/// The step along rows and columns that keeps about `wanted` of `count` pixels.
fn stride(count: usize, wanted: usize) -> usize {
    ((count as f64 / wanted as f64).sqrt().ceil() as usize).max(1)
}
