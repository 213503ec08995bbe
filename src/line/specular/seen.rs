//! The pixels of a frame through its mirrors and lenses, in bands of rows.

use crate::frame::Frame;
use crate::frame::memory::Memory;
use crate::line::linear_camera::seen_by_steps;
use crate::line::propagation::{Beside, external_camera};
use crate::line::specular::tangents::Tangents;
use crate::trace::{Hit, Path, Tracer};
use glam::{DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// Rows that one task traces: two more beside them are bent twice.
const ROWS: usize = 16;

/// The surface point that a specular pixel shows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeenPixel {
    pub(crate) x: usize,
    pub(crate) y: usize,
    /// The normal of the surface seen, rotated to where it appears.
    pub(crate) normal: Vec3,
    /// Apparent depth along the view axis.
    pub(crate) depth: f32,
    /// Stroke directions in the picture, unit, in the order wanted; 0 for none.
    pub(crate) directions: [Vec2; 2],
}

/// All pixels in which a surface is seen, row by row.
pub(crate) fn seen_pixels(
    frame: &Frame,
    tracer: &Tracer,
    tangents: &Tangents,
    memory: &Memory,
) -> Vec<SeenPixel> {
    let height = frame.mask.height();
    let bands: Vec<Vec<SeenPixel>> = (0..height.div_ceil(ROWS))
        .into_par_iter()
        .filter(|_| !memory.is_cancelled())
        .map(|band| {
            let rows = band * ROWS..((band + 1) * ROWS).min(height);
            PathBand::bent(frame, tracer, rows).seen(frame, tracer, tangents)
        })
        .collect();
    bands.concat()
}

/// The paths of some rows and of the adjacent ones.
struct PathBand {
    rows: std::ops::Range<usize>,
    first: usize,
    width: usize,
    paths: Vec<Option<Path>>,
}

impl PathBand {
    fn bent(frame: &Frame, tracer: &Tracer, rows: std::ops::Range<usize>) -> Self {
        let width = frame.mask.width();
        let first = rows.start.saturating_sub(1);
        let last = (rows.end + 1).min(frame.mask.height());
        let mut paths = vec![None; (last - first) * width];
        for (y, paths) in (first..last).zip(paths.chunks_mut(width)) {
            for x in frame.mask.runs(y).flatten() {
                paths[x] = tracer.path(x, y);
            }
        }
        Self {
            rows,
            first,
            width,
            paths,
        }
    }

    fn path(&self, x: usize, y: usize) -> Option<&Path> {
        let row = y.checked_sub(self.first)?;
        let is_inside = x < self.width && row < self.paths.len() / self.width;
        is_inside.then(|| self.paths[row * self.width + x].as_ref())?
    }

    fn seen(&self, frame: &Frame, tracer: &Tracer, tangents: &Tangents) -> Vec<SeenPixel> {
        let mut found = Vec::new();
        for y in self.rows.clone() {
            for x in frame.mask.runs(y).flatten() {
                let Some(path) = self.path(x, y) else {
                    continue;
                };
                let Some(hit) = tracer.hit(&path.leaving()) else {
                    continue;
                };
                found.push(self.pixel([x, y], path, &hit, tracer, tangents));
            }
        }
        found
    }

    fn pixel(
        &self,
        [x, y]: [usize; 2],
        path: &Path,
        hit: &Hit,
        tracer: &Tracer,
        tangents: &Tangents,
    ) -> SeenPixel {
        let beside = Beside {
            across: [self.path(x.wrapping_sub(1), y), self.path(x + 1, y)],
            up: [self.path(x, y + 1), self.path(x, y.wrapping_sub(1))],
        };
        let camera = external_camera(path, &beside);
        let mut directions = [Vec2::ZERO; 2];
        for (order, direction) in directions[..tangents.families.len()].iter_mut().enumerate() {
            let seen = tangents.at(hit, order).and_then(|tangent| {
                let seen = camera.as_ref()?.seen(hit.point, tangent).try_normalize();
                seen.or_else(|| seen_by_steps(steps(tracer, hit, &beside)?, tangent))
            });
            *direction = seen.unwrap_or(DVec2::ZERO).as_vec2();
        }
        let length = path.length_inside() + path.leaving().start.distance(hit.point);
        SeenPixel {
            x,
            y,
            normal: path.as_it_appears(hit.normal).as_vec3(),
            depth: (-path.sight.z * length) as f32,
            directions,
        }
    }
}

/// Change of the hit point from pixel to pixel.
fn steps(tracer: &Tracer, hit: &Hit, beside: &Beside) -> Option<[DVec3; 2]> {
    let point = |path: Option<&Path>| Some(tracer.hit(&path?.leaving())?.point);
    let step = |[before, after]: [Option<&Path>; 2]| match (point(before), point(after)) {
        (Some(before), Some(after)) => Some(0.5 * (after - before)),
        (Some(before), None) => Some(hit.point - before),
        (None, Some(after)) => Some(after - hit.point),
        (None, None) => None,
    };
    Some([step(beside.across)?, step(beside.up)?])
}
