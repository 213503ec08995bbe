//! Cost of lighting by the number of lights, and by the covered share of the frame.

use super::lit::LitFrame;
use super::lit::bare;
use crate::Result;
use crate::frame::{Frame, Mask, Plane};
use crate::light::environment::Environment;
use crate::light::light_samples::uniform_directions;
use crate::light::lights::{DirectionalLight, Illumination};
use crate::params::{AUTO_SAMPLES, Material, Method, RelightParams, ShapeParams, WarpBy};
use crate::report::timing::{Effort, Times};
use serde::Serialize;

/// Numbers of lights tried.
pub(crate) const COUNTS: [usize; 6] = [1, 4, 16, 64, 256, 1024];

/// Cost of one number of lights.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct CostRow {
    pub lights: usize,
    pub relight: Times,
    /// Nanoseconds per covered pixel and light, over all threads together.
    pub nanoseconds: f64,
}

/// A straight line through times.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Line {
    /// Time in seconds without lights.
    pub start: f64,
    /// Seconds per light.
    pub slope: f64,
    /// Share of the variance that the line explains (R squared).
    #[serde(rename = "told")]
    pub r_squared: f64,
}

/// Cost with part of the frame covered.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct CoveredRow {
    /// Covered share of the frame.
    pub share: f64,
    pub pixels: usize,
    pub relight: Times,
    /// Nanoseconds per covered pixel and light.
    pub nanoseconds: f64,
}

/// Cost of Blinn-Phong under a warp.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Cost {
    pub width: usize,
    pub height: usize,
    pub rows: Vec<CostRow>,
    /// The least-squares line through the minimum times.
    pub line: Line,
    /// Number of lights of the rows below.
    pub lights: usize,
    pub covered: Vec<CoveredRow>,
}

/// Lights the fully covered `frame` by increasing numbers of lights, then by [`AUTO_SAMPLES`] with decreasing coverage.
pub(crate) fn measured(frame: &Frame, environment: &Environment, effort: Effort) -> Result<Cost> {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let time = |frame: &Frame, lights: usize| -> Result<(Times, f64)> {
        let bench = LitFrame::new(frame, ShapeParams::default(), environment, effort);
        let relight = bench.timed(params(), &even(lights))?.relight;
        let each = 1e9 * relight.min / (frame.mask.count().max(1) * lights) as f64;
        Ok((relight, each))
    };
    let rows = COUNTS.into_iter().map(|lights| {
        let (relight, nanoseconds) = time(frame, lights)?;
        Ok(CostRow {
            lights,
            relight,
            nanoseconds,
        })
    });
    let rows = rows.collect::<Result<Vec<CostRow>>>()?;
    let points: Vec<_> = rows
        .iter()
        .map(|row| [row.lights as f64, row.relight.min])
        .collect();
    let lights = AUTO_SAMPLES as usize;
    let covered = [1.0, 0.1].into_iter().map(|share| {
        let part = covered_in_part(frame, share);
        let (relight, nanoseconds) = time(&part, lights)?;
        Ok(CoveredRow {
            share,
            pixels: part.mask.count(),
            relight,
            nanoseconds,
        })
    });
    Ok(Cost {
        width,
        height,
        covered: covered.collect::<Result<_>>()?,
        lights,
        line: line(&points),
        rows,
    })
}

fn params() -> RelightParams {
    RelightParams {
        warp_by: WarpBy::Lights,
        ..bare(Material::BlinnPhong, Method::Warp)
    }
}

/// Uniform lights with a total of 1.
fn even(count: usize) -> Illumination {
    let lights = uniform_directions(count).into_iter();
    Illumination {
        directional: lights
            .map(|to_light| DirectionalLight {
                to_light,
                intensity: [1.0 / count as f32; 3],
            })
            .collect(),
        ..Illumination::default()
    }
}

/// The frame covered by a central disc that takes `share` of it; fully for 1.
fn covered_in_part(frame: &Frame, share: f64) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let radius = (share * (width * height) as f64 / std::f64::consts::PI).sqrt();
    let inside = |x: usize, y: usize| {
        let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
        share >= 1.0 || (x - 0.5 * width as f64).hypot(y - 0.5 * height as f64) < radius
    };
    Frame {
        mask: Mask::new(Plane::from_fn(width, height, inside)),
        ..frame.clone()
    }
}

/// The least-squares line through `points` with distinct first coordinates.
fn line(points: &[[f64; 2]]) -> Line {
    let count = points.len() as f64;
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / count;
    let middle = [mean(0), mean(1)];
    let product = |i: usize, j: usize| -> f64 {
        let around = |p: &[f64; 2]| (p[i] - middle[i]) * (p[j] - middle[j]);
        points.iter().map(around).sum()
    };
    let slope = product(0, 1) / product(0, 0);
    Line {
        start: middle[1] - slope * middle[0],
        slope,
        r_squared: product(0, 1).powi(2) / (product(0, 0) * product(1, 1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_again() {
        let exact = [[1.0, 5.0], [4.0, 11.0], [16.0, 35.0]];
        let found = line(&exact);
        assert!((found.start - 3.0).abs() < 1e-12 && (found.slope - 2.0).abs() < 1e-12);
        assert!((found.r_squared - 1.0).abs() < 1e-12);
        // 0, 1, 0 at -1, 0, 1: no slope, and nothing explained.
        let none = line(&[[-1.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        assert!(none.slope.abs() < 1e-12 && none.r_squared.abs() < 1e-12);
    }
}
