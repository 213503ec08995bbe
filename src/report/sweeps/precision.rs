//! Input precision: half floats and bytes instead of floats.

use super::{Measuring, named};
use crate::Result;
use crate::frame::{Frame, Mask, Plane, Vector3Planes};
use crate::params::{Scale, ShapeParams};
use crate::report::compare::{Errors, compare_where, covered};
use crate::report::engine::layers;
use crate::report::surface::Surface;
use half::f16;
use serde::Serialize;

/// Rounding of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Stored {
    /// Unrounded.
    Float,
    /// 16-bit floats, normals and depth.
    Half,
    /// Normals as bytes of (n + 1) / 2, depth unrounded.
    Byte,
}

/// Results with rounded input compared with unrounded input.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct PrecisionRow {
    pub frame: String,
    pub stored: Stored,
    pub scale: String,
    /// Change of the gradient, relative to the largest |g| before diffusion.
    pub gradient: Errors,
    /// Change of the trace per pixel, relative to the same.
    pub trace: Errors,
    /// Number of pixels that rounding removed from the mask, or whose conductance it changed by more than one half.
    pub edges_moved: usize,
}

/// Compares float, half and byte input, at the undiffused and the given scale, with the double-precision reference for
/// unrounded input.
pub(crate) fn sweep(
    name: &str,
    frame: &Frame,
    surface: &Surface,
    shape: ShapeParams,
) -> Result<Vec<PrecisionRow>> {
    let measuring = Measuring::from(frame, surface, shape)?;
    let mut scales = vec![Scale::Iterations(0)];
    if shape.diffusion_time() > 0.0 {
        scales.push(shape.scale);
    }
    let mut rows = Vec::new();
    for scale in scales {
        let gradient = measuring.diffused(scale);
        let trace = measuring.trace(&gradient);
        for stored in Stored::ALL {
            let rounded = rounded(frame, stored);
            let found = layers(&rounded, ShapeParams { scale, ..shape })?;
            let moved = |x: usize, y: usize| {
                let before = measuring.conductance.at(x, y);
                let after = f64::from(found.conductance.at(x, y));
                !rounded.mask.at(x, y) || (before - after).abs() > 0.5
            };
            // A moved edge is counted separately; it is not an error of a slope.
            let kept = |x: usize, y: usize| frame.mask.at(x, y) && !moved(x, y);
            let [gx, gy] = &gradient;
            let steepest = measuring.steepest;
            rows.push(PrecisionRow {
                frame: name.into(),
                stored,
                scale: named(scale),
                gradient: compare_where(
                    [&found.gradient.x, &found.gradient.y],
                    [gx, gy],
                    steepest,
                    kept,
                )
                .in_window(frame.data_window),
                trace: compare_where([&found.mean.map(|m| 2.0 * m)], [&trace], steepest, kept)
                    .in_window(frame.data_window),
                edges_moved: covered(&frame.mask).filter(|&[x, y]| moved(x, y)).count(),
            });
        }
    }
    Ok(rows)
}

impl Stored {
    /// All roundings, finest first.
    pub(crate) const ALL: [Self; 3] = [Self::Float, Self::Half, Self::Byte];

    /// Largest rounding error of a component of a normal: half a step between bytes, or between half floats just below
    /// 1.
    fn normal_rounding(self) -> f32 {
        match self {
            Self::Float => 0.0,
            Self::Half => f16::EPSILON.to_f32() / 4.0,
            Self::Byte => 1.0 / 255.0,
        }
    }
}

/// The frame as it would be loaded after storage with this rounding.
pub(crate) fn rounded(frame: &Frame, stored: Stored) -> Frame {
    let (normal, length) = match stored {
        Stored::Float => return frame.clone(),
        Stored::Half => rounded_normals(frame, |v| f16::from_f32(v).to_f32()),
        Stored::Byte => rounded_normals(frame, |v| (127.5 * (v + 1.0)).round() / 127.5 - 1.0),
    };
    let depth = frame.depth.as_ref().map(|depth| match stored {
        Stored::Half => depth.map(|v| f16::from_f32(v).to_f32()),
        Stored::Float | Stored::Byte => depth.clone(),
    });
    // A distance beyond the range of half floats is a hole in the mask.
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let covered = |x, y| {
        let known = depth
            .as_ref()
            .is_none_or(|d| d.at(x, y) > 0.0 && d.at(x, y) < 65504.0 || stored != Stored::Half);
        frame.mask.at(x, y) && known
    };
    let mut source = frame.source.clone();
    source.normal_rounding = source.normal_rounding.max(stored.normal_rounding());
    Frame {
        source,
        mask: Mask::new(Plane::from_fn(width, height, covered)),
        normal,
        // As in `io`: the length of an encoded normal is rounding, not filtering.
        normal_length: (stored == Stored::Half).then_some(length),
        depth,
        ..frame.clone()
    }
}

/// The normals after `round` and normalisation, and their original lengths.
fn rounded_normals(frame: &Frame, round: impl Fn(f32) -> f32) -> (Vector3Planes, Plane) {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let stored = |x: usize, y: usize| {
        let length = frame.normal_length.as_ref().map_or(1.0, |l| l.at(x, y));
        let n =
            [&frame.normal.x, &frame.normal.y, &frame.normal.z].map(|p| round(length * p.at(x, y)));
        glam::Vec3::from_array(n)
    };
    let plane =
        |axis: usize| Plane::from_fn(width, height, |x, y| stored(x, y).normalize_or_zero()[axis]);
    let normal = Vector3Planes {
        x: plane(0),
        y: plane(1),
        z: plane(2),
    };
    (
        normal,
        Plane::from_fn(width, height, |x, y| stored(x, y).length()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::scenes::Scene;

    #[test]
    fn rounding_costs_what_its_last_digit_is_worth() {
        let scene = Scene::ball(120, 100);
        let rows = sweep(
            "ball",
            &scene.frame,
            &Surface::of(&scene.frame),
            ShapeParams::default(),
        )
        .unwrap();
        let at = |stored| {
            rows.iter()
                .find(|row| row.stored == stored)
                .unwrap()
                .gradient
        };
        assert!(at(Stored::Float).max < 1e-6, "{:?}", at(Stored::Float));
        // Half floats near 1 are 2^-11 apart: half of that per component, and z may add as much.
        assert!(
            (1e-4..5e-4).contains(&at(Stored::Half).max),
            "{:?}",
            at(Stored::Half)
        );
        // Bytes are 2/255 apart.
        assert!(
            (2e-3..8e-3).contains(&at(Stored::Byte).max),
            "{:?}",
            at(Stored::Byte)
        );
    }

    #[test]
    fn depth_past_half_floats_leaves_the_mask() {
        let mut frame = Scene::waves(8, 8).frame;
        frame.depth = Some(Plane::from_fn(8, 8, |x, _| if x < 4 { 1e5 } else { 10.0 }));
        assert_eq!(rounded(&frame, Stored::Half).mask.count(), 32);
        assert_eq!(rounded(&frame, Stored::Byte).mask.count(), 64);
    }
}
