//! Height and occlusion: error against run time on surfaces with exact answers.

use crate::frame::{Mask, Plane, Vector3Planes};
use crate::report::Extent;
use crate::shape::height::{Problem, Slopes, solve};
use crate::shape::occlusion::sky;
use glam::DVec3;
use serde::Serialize;
use std::f64::consts::TAU;
use std::time::Instant;

/// Height and occlusion.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ReliefReport {
    pub size: usize,
    pub heights: Vec<HeightRow>,
    pub skies: Vec<SkyRow>,
}

/// A height that was solved for.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct HeightRow {
    pub surface: &'static str,
    pub tolerance: f32,
    pub rounds: usize,
    pub seconds: f64,
    /// Largest error and its root mean square, in relation to the range of the height.
    pub largest: f64,
    pub mean: f64,
}

/// The sky at the bottom of a groove whose sides rise at 45 degrees: of its light sin(pi/4) arrives.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct SkyRow {
    pub slices: u32,
    pub radius_px: f32,
    pub seconds: f64,
    /// Relative error.
    pub error: f64,
}

/// The error up to which rounds go on.
const TOLERANCES: [f32; 4] = [1e-1, 1e-2, 1e-3, 1e-4];

const SLICES: [u32; 5] = [2, 4, 8, 16, 32];

pub(crate) fn run(extent: Extent) -> ReliefReport {
    let size = match extent {
        Extent::Full => 1024,
        Extent::Quick => 256,
    };
    let mut heights = Vec::new();
    for tolerance in TOLERANCES {
        heights.push(height_row(
            "tile of waves",
            size,
            [true; 2],
            None,
            tolerance,
        ));
        heights.push(height_row(
            "waves with borders",
            size,
            [false; 2],
            None,
            tolerance,
        ));
        let ring = Mask::new(Plane::from_fn(size, size, |x, y| {
            let middle = 0.5 * size as f64;
            let distance = (x as f64 - middle).hypot(y as f64 - middle) / size as f64;
            (0.2..0.45).contains(&distance)
        }));
        heights.push(height_row(
            "waves on a ring",
            size,
            [false; 2],
            Some(ring),
            tolerance,
        ));
    }
    ReliefReport {
        size,
        heights,
        skies: SLICES.map(|slices| sky_row(size, slices)).to_vec(),
    }
}

/// Three waves with exact slopes; periodic over the size.
fn wave(size: usize, x: f64, y: f64) -> (f64, [f64; 2]) {
    let k = TAU / size as f64;
    let (u, v) = (k * x, k * y);
    let height = 12.0 * (3.0 * u).sin() * (2.0 * v).cos() + 3.0 * (11.0 * u + 5.0 * v).cos();
    let along = 36.0 * (3.0 * u).cos() * (2.0 * v).cos() - 33.0 * (11.0 * u + 5.0 * v).sin();
    let down = -24.0 * (3.0 * u).sin() * (2.0 * v).sin() - 15.0 * (11.0 * u + 5.0 * v).sin();
    (height, [k * along, k * down])
}

fn height_row(
    surface: &'static str,
    size: usize,
    wraps: [bool; 2],
    mask: Option<Mask>,
    tolerance: f32,
) -> HeightRow {
    let at = |x: usize, y: usize| wave(size, x as f64, y as f64);
    let slopes = Slopes {
        x: Plane::from_fn(size, size, |x, y| at(x, y).1[0] as f32),
        y: Plane::from_fn(size, size, |x, y| at(x, y).1[1] as f32),
    };
    let mask = mask.unwrap_or_else(|| Mask::full(size, size));
    let problem = Problem {
        slopes: &slopes,
        conductance: &Plane::filled(size, size, 1.0),
        mask: &mask,
        wraps,
        near: None,
        tolerance,
    };
    let start = Instant::now();
    let (height, rounds) = solve(&problem);
    let seconds = start.elapsed().as_secs_f64();
    let pixels = (0..size).flat_map(|y| mask.runs(y).flatten().map(move |x| (x, y)));
    let pairs: Vec<[f64; 2]> = pixels
        .map(|(x, y)| [f64::from(height.at(x, y)), at(x, y).0])
        .collect();
    let count = pairs.len().max(1) as f64;
    let offset = pairs
        .iter()
        .map(|[found, exact]| found - exact)
        .sum::<f64>()
        / count;
    let exact = pairs.iter().map(|[_, exact]| *exact);
    let range = exact.clone().fold(f64::MIN, f64::max) - exact.fold(f64::MAX, f64::min);
    let errors = pairs
        .iter()
        .map(|[found, exact]| (found - exact - offset).abs() / range);
    HeightRow {
        surface,
        tolerance,
        rounds,
        seconds,
        largest: errors.clone().fold(0.0, f64::max),
        mean: (errors.map(|e| e * e).sum::<f64>() / count).sqrt(),
    }
}

fn sky_row(size: usize, slices: u32) -> SkyRow {
    let middle = size / 2;
    let away = |x: usize| x as f64 - middle as f64;
    let height = Plane::from_fn(size, size, |x, _| away(x).abs() as f32);
    let normal = Vector3Planes::from_fn(size, size, |x, _| {
        let slope = if x == middle { 0.0 } else { away(x).signum() };
        DVec3::new(-slope, 0.0, 1.0).normalize()
    });
    let radius_px = 32.0;
    let start = Instant::now();
    let seen = sky(&height, &normal, &Mask::full(size, size), radius_px, slices).seen;
    let seconds = start.elapsed().as_secs_f64();
    let exact = std::f64::consts::FRAC_1_SQRT_2;
    SkyRow {
        slices,
        radius_px,
        seconds,
        error: (f64::from(seen.at(middle, middle)) / exact - 1.0).abs(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waves of at least 23 pixels are solved within a thousandth, more rounds never being worse by more than rounding.
    #[test]
    fn more_rounds_and_slices_bring_the_answer_nearer() {
        let report = run(Extent::Quick);
        for surface in ["tile of waves", "waves with borders", "waves on a ring"] {
            let rows = report.heights.iter().filter(|row| row.surface == surface);
            let rows: Vec<_> = rows.collect();
            assert!(rows.is_sorted_by(|a, b| a.rounds <= b.rounds), "{rows:?}");
            assert!(
                rows[3].largest < 3e-3 && rows[3].largest < rows[0].largest,
                "{rows:?}"
            );
        }
        assert!(report.skies[2].error < 0.02, "{:?}", report.skies);
        assert!(
            report.skies[4].error < report.skies[0].error,
            "{:?}",
            report.skies
        );
    }
}
