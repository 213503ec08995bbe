//! Which pixels of a position layer a camera is recovered from.

use crate::frame::{Mask, Vector3Planes, Window};
use half::f16;
use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

/// Samples that the fit works on; more gain nothing that a pixel's own rounding does not hide.
const WANTED: usize = 4_000;
/// Pixels examined to find that many; edges and gaps cost some.
const CANDIDATES: usize = 2 * WANTED;
/// Below this many samples away from edges, edge pixels are let in and left to the robust fit.
const ENOUGH: usize = 400;
/// Coordinates from here on mean "no surface" in some renderers.
const FARTHEST: f64 = 1e9;

/// A surface point and its image position.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenPoint {
    /// Position less the centroid, in units of the spread.
    pub(super) point: Vector3<f64>,
    /// Place on the picture from the centre of the display window, x right and y up, in pixel widths.
    pub(super) seen: Vector2<f64>,
}

/// Samples in a normalised frame: `world = centroid + spread * point`.
#[derive(Debug)]
pub(super) struct UnitSamples {
    pub(super) list: Vec<SeenPoint>,
    pub(super) centroid: Vector3<f64>,
    pub(super) spread: f64,
    /// Largest step between neighbouring values of the positions, in scene units.
    pub(super) quantum: f64,
    /// Whether every coordinate is a half float.
    pub(super) half: bool,
}

impl UnitSamples {
    /// Reverses y of the world.
    pub(super) fn mirror(&mut self) {
        self.centroid.y = -self.centroid.y;
        for sample in &mut self.list {
            sample.point.y = -sample.point.y;
        }
    }
}

/// Where the pixels of a layer are on the picture.
#[derive(Clone, Copy)]
pub(super) struct PixelGrid {
    pub(super) data: Window,
    pub(super) display: Window,
    /// Width of a pixel over its height.
    pub(super) aspect: f64,
}

impl PixelGrid {
    pub(super) fn new(data: Window, display: Window, pixel_aspect: f32) -> Self {
        let is_usable = pixel_aspect.is_finite() && pixel_aspect > 0.0;
        Self {
            data,
            display,
            aspect: if is_usable { pixel_aspect.into() } else { 1.0 },
        }
    }

    /// The place of a pixel from the centre of the display window, x right and y up, in pixel widths.
    pub(super) fn seen(&self, x: usize, y: usize) -> Vector2<f64> {
        let (at, centre) = (self.data.middle(x, y), self.display.center());
        Vector2::new(at.x - centre.x, (centre.y - at.y) / self.aspect)
    }
}

/// A position layer with the pixels it covers.
struct PositionsRead<'a> {
    position: &'a Vector3Planes,
    mask: &'a Mask,
}

impl PositionsRead<'_> {
    /// The position at column `x` of row `y`, if there is one.
    fn at(&self, x: isize, y: isize) -> Option<Vector3<f64>> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        if x >= self.mask.width() || y >= self.mask.height() || !self.mask.at(x, y) {
            return None;
        }
        let p = Vector3::from(self.position.at(x, y).to_array());
        let real = p.iter().all(|c| c.is_finite() && c.abs() < FARTHEST);
        // Renderers write the origin itself where there is no surface.
        (real && p != Vector3::zeros()).then_some(p)
    }

    /// Whether the surface continues smoothly for two pixels to either side.
    ///
    /// For a pixel on or beside an edge, one or two of the four steps along a row or column dwarf the others. Jittered
    /// sample positions make single steps short, so the measure is the second shortest one.
    fn is_smooth(&self, x: isize, y: isize, quantum: f64) -> bool {
        [(1, 0), (0, 1)].into_iter().all(|(dx, dy)| {
            let mut line = [Vector3::zeros(); 5];
            for (slot, i) in line.iter_mut().zip(-2..=2) {
                match self.at(x + i * dx, y + i * dy) {
                    Some(p) => *slot = p,
                    None => return false,
                }
            }
            let mut steps = [0, 1, 2, 3].map(|i| (line[i + 1] - line[i]).norm());
            steps.sort_by(f64::total_cmp);
            steps[3] <= 5.0 * steps[1] + 4.0 * quantum
        })
    }
}

/// At most [`WANTED`] covered pixels of `position`, away from edges if there are enough of those.
pub(super) fn gather(position: &Vector3Planes, mask: &Mask, grid: PixelGrid) -> UnitSamples {
    let layer = PositionsRead { position, mask };
    let candidates = candidates(&layer);
    let half = is_half(&candidates);
    let quantum = quantum(&candidates, half);
    let smooth: Vec<_> = candidates
        .par_iter()
        .filter(|(x, y, _)| layer.is_smooth(*x as isize, *y as isize, quantum))
        .copied()
        .collect();
    let are_enough = smooth.len() >= ENOUGH;
    let chosen = spread_out(if are_enough { &smooth } else { &candidates }, WANTED);
    let seen = |&(x, y, p): &PositionCandidate| (p, grid.seen(x, y));
    let raw = chosen.iter().map(seen).collect();
    normalised(raw, quantum, half)
}

type PositionCandidate = (usize, usize, Vector3<f64>);

/// Covered pixels with a position.
fn candidates(layer: &PositionsRead) -> Vec<PositionCandidate> {
    let places: Vec<_> = layer.mask.sample(CANDIDATES).collect();
    let found = places.into_par_iter().filter_map(|(x, y)| {
        let position = layer.at(x as isize, y as isize)?;
        Some((x, y, position))
    });
    found.collect()
}

/// At most `count` elements, evenly spread over the list.
pub(super) fn spread_out<T: Copy>(list: &[T], count: usize) -> Vec<T> {
    let count = count.min(list.len());
    (0..count).map(|i| list[i * list.len() / count]).collect()
}

/// Whether the coordinates look stored as half floats; a share of stray values, from resampled edges, is tolerated.
fn is_half(candidates: &[PositionCandidate]) -> bool {
    let is_half =
        |(_, _, p): &&PositionCandidate| p.iter().all(|&c| f16::from_f64(c).to_f64() == c);
    10 * candidates.iter().filter(is_half).count() > 9 * candidates.len()
}

/// The step between neighbouring values of the largest coordinates.
fn quantum(candidates: &[PositionCandidate], half: bool) -> f64 {
    let mut sizes: Vec<f64> = candidates.iter().map(|(_, _, p)| p.amax()).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let typical = quantile(&mut sizes, 0.9).max(f64::from(f32::MIN_POSITIVE));
    let digits = if half { 10 } else { 23 };
    (typical.log2().floor() - f64::from(digits)).exp2()
}

fn normalised(raw: Vec<(Vector3<f64>, Vector2<f64>)>, quantum: f64, half: bool) -> UnitSamples {
    let (centroid, spread) = frame_of(&raw);
    let unit = if spread > 0.0 { spread } else { 1.0 };
    let list = raw
        .into_iter()
        .map(|(p, seen)| SeenPoint {
            point: (p - centroid) / unit,
            seen,
        })
        .collect();
    UnitSamples {
        list,
        centroid,
        spread,
        quantum,
        half,
    }
}

/// Mean and root mean square distance from it, of the points that are no strays.
fn frame_of(raw: &[(Vector3<f64>, Vector2<f64>)]) -> (Vector3<f64>, f64) {
    let middle = Vector3::from_fn(|axis, _| {
        let mut values: Vec<f64> = raw.iter().map(|(p, _)| p[axis]).collect();
        quantile(&mut values, 0.5)
    });
    let mut distances: Vec<f64> = raw.iter().map(|(p, _)| (p - middle).norm()).collect();
    let reach = 10.0 * quantile(&mut distances, 0.75);
    let offsets = raw.iter().map(|(p, _)| p - middle);
    let near: Vec<Vector3<f64>> = offsets.filter(|d| d.norm() <= reach).collect();
    let count = near.len().max(1) as f64;
    let mean = near.iter().sum::<Vector3<f64>>() / count;
    let square: f64 = near.iter().map(|d| (d - mean).norm_squared()).sum();
    (middle + mean, (square / count).sqrt())
}

/// The `q` quantile of `values`; 0 for none. Reorders `values`.
pub(super) fn quantile(values: &mut [f64], q: f64) -> f64 {
    crate::kernel::quantile::quantile(values, q, f64::total_cmp).unwrap_or(0.0)
}

/// The median; `None` for fewer than `fewest` values, which decide nothing.
pub(in crate::io) fn median(values: &mut [f64], fewest: usize) -> Option<f64> {
    (values.len() >= fewest).then(|| quantile(values, 0.5))
}
