//! The last guard: results are finite wherever all inputs are.
//!
//! Ranges of parameters, cameras and attributes keep every stage within single precision. Exceptions, such as
//! brightened pictures of 1e38, are found here before anything is written.

use super::job::Job;
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::io::exr::OutputChannel;
use crate::io::picture::Picture;
use crate::io::svg;
use rayon::prelude::*;

/// Samples checked by one task.
const SAMPLES_PER_TASK: usize = 1 << 16;

impl Job<'_> {
    /// Refuses channels with samples that are not finite where all inputs are.
    pub(super) fn check_channels(&self, frame: &Frame, channels: &[OutputChannel]) -> Result<()> {
        let mut named = channels.iter().map(|c| (c.name.as_str(), c.plane));
        self.refuse(named.find_map(|(name, plane)| not_finite(name, plane, frame)))
    }

    /// Refuses a picture with samples that are not finite where all inputs are.
    pub(super) fn check_picture(&self, frame: &Frame, picture: &Picture) -> Result<()> {
        let mut planes = picture.planes().into_iter();
        self.refuse(planes.find_map(|plane| not_finite("picture", plane, frame)))
    }

    /// Refuses lines that are not finite.
    pub(super) fn check_lines(&self, drawing: &svg::LinePage) -> Result<()> {
        let is_finite = |(points, widths): &svg::SvgLine| {
            points.iter().all(|p| p.is_finite()) && widths.iter().all(|width| width.is_finite())
        };
        let mut layers = drawing.layers.iter();
        let bad = layers.find(|(_, lines)| !lines.iter().all(is_finite));
        self.refuse(bad.map(|(layer, _)| format!("a line of {layer}")))
    }

    fn refuse(&self, found: Option<String>) -> Result<()> {
        let path = self.args().input.clone();
        found.map_or(Ok(()), |found| Err(Error::NotFinite { path, found }))
    }
}

/// The first pixel of a result that is not finite where all planes of `frame` are.
fn not_finite(name: &str, result: &Plane, frame: &Frame) -> Option<String> {
    if is_finite(result) {
        return None;
    }
    let inputs = inputs(frame);
    let bad = result.samples().iter().enumerate();
    let bad = bad.filter(|(_, sample)| !sample.is_finite());
    let mut bad = bad.map(|(i, _)| (i % result.width(), i / result.width()));
    let (x, y) = bad.find(|&(x, y)| inputs.iter().all(|plane| plane.at(x, y).is_finite()))?;
    let corner = frame.data_window;
    let (x, y) = (
        i64::from(corner.x0) + x as i64,
        i64::from(corner.y0) + y as i64,
    );
    Some(format!("{name} at ({x}, {y})"))
}

/// Whether all samples are finite. Without a branch, so that the loop vectorises.
fn is_finite(plane: &Plane) -> bool {
    let finite = |samples: &[f32]| samples.iter().fold(true, |all, v| all & v.is_finite());
    plane.samples().par_chunks(SAMPLES_PER_TASK).all(finite)
}

/// The planes of a frame that results are made of.
fn inputs(frame: &Frame) -> Vec<&Plane> {
    let light = &frame.light;
    let lobes = light.lobes.iter();
    let lobes = lobes.flat_map(|l| [&l.direct, &l.indirect, &l.color, &l.albedo]);
    let colors = [&frame.color, &frame.albedo].into_iter().chain(lobes);
    let colors = colors.flatten();
    let colors = colors.chain(light.groups.iter().map(|group| &group.light));
    let normal = &frame.normal;
    let single = [
        &frame.normal_length,
        &frame.depth,
        &frame.occlusion,
        &frame.importance,
        &frame.alpha,
        &light.occlusion,
    ];
    colors
        .flat_map(|ColorPlanes { r, g, b }| [r, g, b])
        .chain([&normal.x, &normal.y, &normal.z])
        .chain(single.into_iter().flatten())
        // Normals may have been consumed; where they are not finite the mask shows no surface.
        .filter(|plane| !plane.samples().is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_that_is_not_finite_passes_only_where_an_input_is_not() {
        let plane = || Plane::filled(40, 30, 0.5);
        let mut frame = crate::scenes::Scene::waves(40, 30).frame;
        frame.color = Some(ColorPlanes {
            r: plane(),
            g: plane(),
            b: plane(),
        });
        let mut result = plane();
        assert_eq!(not_finite("kappa", &result, &frame), None);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            // The last sample of the plane, and one before it.
            result.samples_mut()[40 * 30 - 1] = bad;
            result.samples_mut()[40 * 7 + 3] = bad;
            let found = not_finite("kappa", &result, &frame);
            assert_eq!(found.as_deref(), Some("kappa at (3, 7)"));
        }
        // Fireflies in the input picture.
        let color = frame.color.as_mut().unwrap();
        color.g.samples_mut()[40 * 7 + 3] = f32::NAN;
        let found = not_finite("kappa", &result, &frame);
        assert_eq!(found.as_deref(), Some("kappa at (39, 29)"));
        let color = frame.color.as_mut().unwrap();
        color.g.samples_mut()[40 * 30 - 1] = f32::INFINITY;
        assert_eq!(not_finite("kappa", &result, &frame), None);
    }
}
