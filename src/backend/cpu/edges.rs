//! Silhouettes, creases and conductance in one sweep over rows.

use super::ROWS_PER_TASK;
use crate::frame::{Frame, Plane, Vector3Planes};
use crate::params::SoftThreshold;
use crate::plan::{Plan, Stage};
use crate::shape::Rows;
use crate::shape::conductance::conductance;
use crate::shape::crease::CreaseDetector;
use crate::shape::silhouette::{on_border, silhouette_weight};
use glam::Vec3;
use rayon::prelude::*;

/// Edge weights; the two separate ones only where they are asked for.
pub(super) struct Edges {
    pub(super) silhouette: Option<Plane>,
    pub(super) crease: Option<Plane>,
    pub(super) conductance: Plane,
}

pub(super) fn edges(plan: &Plan, frame: &Frame) -> Edges {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let sources = Sources {
        frame,
        jumps: jump_map(plan, frame),
        creases: CreaseDetector::new(plan.shape.crease),
    };
    let blank = || Plane::filled(width, height, 0.0);
    let mut conductances = blank();
    let (mut silhouettes, mut creases) = match plan.has(Stage::Hessian) {
        true => (Some(blank()), Some(blank())),
        false => (None, None),
    };
    conductances
        .samples_mut()
        .par_chunks_mut(width)
        .zip(optional_rows(&mut silhouettes, height))
        .zip(optional_rows(&mut creases, height))
        .enumerate()
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(y, ((out, mut silhouette_row), mut crease_row))| {
            sources.for_covered(y, |x, silhouette, crease| {
                out[x] = conductance(silhouette, crease);
                if let Some(row) = &mut silhouette_row {
                    row[x] = silhouette;
                }
                if let Some(row) = &mut crease_row {
                    row[x] = crease;
                }
            });
        });
    Edges {
        silhouette: silhouettes,
        crease: creases,
        conductance: conductances,
    }
}

/// The rows of a plane that may not be wanted: as many `None` as there would be rows.
fn optional_rows(plane: &mut Option<Plane>, height: usize) -> Vec<Option<&mut [f32]>> {
    match plane {
        Some(plane) => {
            let width = plane.width();
            plane.samples_mut().chunks_mut(width).map(Some).collect()
        }
        None => (0..height).map(|_| None).collect(),
    }
}

/// What silhouettes are sought in, with the threshold of its jumps.
struct JumpMap<'a> {
    map: std::borrow::Cow<'a, Plane>,
    threshold: SoftThreshold,
}

fn jump_map<'a>(plan: &Plan, frame: &'a Frame) -> Option<JumpMap<'a>> {
    if plan.has(Stage::DepthSilhouettes) {
        let depth = frame
            .depth
            .as_ref()
            .expect("the plan found depth in the frame");
        let map = std::borrow::Cow::Owned(log_depth(depth, frame));
        Some(JumpMap {
            map,
            threshold: plan.shape.silhouette,
        })
    } else if plan.has(Stage::OcclusionSilhouettes) {
        let map = frame
            .occlusion
            .as_ref()
            .expect("the plan found occlusion in the frame");
        let map = std::borrow::Cow::Borrowed(map);
        Some(JumpMap {
            map,
            threshold: plan.shape.occlusion_silhouette,
        })
    } else {
        None
    }
}

/// The logarithm of depth where covered, 0 elsewhere.
fn log_depth(depth: &Plane, frame: &Frame) -> Plane {
    let mut log = Plane::filled(depth.width(), depth.height(), 0.0);
    log.samples_mut()
        .par_chunks_mut(depth.width())
        .enumerate()
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(y, out)| {
            let (depth, covered) = (depth.row(y), frame.mask.row(y));
            for x in frame.mask.span(y) {
                out[x] = if covered[x] { depth[x].ln() } else { 0.0 };
            }
        });
    log
}

struct Sources<'a> {
    frame: &'a Frame,
    jumps: Option<JumpMap<'a>>,
    creases: CreaseDetector,
}

impl Sources<'_> {
    /// Calls `visit(x, silhouette, crease)` for every covered pixel of row `y`.
    #[inline(always)]
    fn for_covered(&self, y: usize, mut visit: impl FnMut(usize, f32, f32)) {
        let mask = &self.frame.mask;
        let covered = Rows::around(mask.plane(), y);
        let jumps = self
            .jumps
            .as_ref()
            .map(|j| (Rows::around(&j.map, y), j.threshold));
        let lengths = self.frame.normal_length.as_ref().map(|plane| plane.row(y));
        let normals = NormalRows::around(&self.frame.normal, y);
        for x in mask.span(y).filter(|&x| covered.at[x]) {
            let silhouette = match &jumps {
                Some((map, threshold)) => silhouette_weight(map, &covered, x, *threshold),
                None => f32::from(on_border(&covered, x)),
            };
            let length = lengths.map_or(1.0, |row| row[x]);
            let crease = self
                .creases
                .weight(normals.at(x), length, normals.beside(x, &covered));
            visit(x, silhouette, crease);
        }
    }
}

/// The normals of three rows.
struct NormalRows<'a> {
    x: Rows<'a>,
    y: Rows<'a>,
    z: Rows<'a>,
}

impl<'a> NormalRows<'a> {
    fn around(normal: &'a Vector3Planes, y: usize) -> Self {
        let rows = |plane| Rows::around(plane, y);
        Self {
            x: rows(&normal.x),
            y: rows(&normal.y),
            z: rows(&normal.z),
        }
    }

    #[inline(always)]
    fn at(&self, x: usize) -> Vec3 {
        Vec3::new(self.x.at[x], self.y.at[x], self.z.at[x])
    }

    /// The normals left, right, above and below column `x`, where covered.
    #[inline(always)]
    fn beside(&self, x: usize, covered: &Rows<bool>) -> [Option<Vec3>; 4] {
        let (left, right) = (x.saturating_sub(1), (x + 1).min(covered.at.len() - 1));
        let above = Vec3::new(self.x.above[x], self.y.above[x], self.z.above[x]);
        let below = Vec3::new(self.x.below[x], self.y.below[x], self.z.below[x]);
        [
            covered.at[left].then_some(self.at(left)),
            covered.at[right].then_some(self.at(right)),
            covered.above[x].then_some(above),
            covered.below[x].then_some(below),
        ]
    }
}
