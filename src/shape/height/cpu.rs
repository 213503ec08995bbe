//! From a frame to its height.

use super::{HeightSlopes, NAME, Problem, goes_over_edges, residual, solve};
use crate::frame::{DepthKind, Frame, Mask, Plane, Projection, SightLines, Window};
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::product::Product;
use std::borrow::Cow;

/// What is solved for: the height toward the viewer, or in perspective the logarithm of the distance, which perspective
/// leaves linear: `d ln Z / du = n_x / (f n.v)`.
enum Unknown {
    Height,
    LogDistance { focal_px: f64 },
}

impl Unknown {
    fn of(sight: &Projection) -> Self {
        match *sight {
            Projection::Orthographic { .. } => Self::Height,
            Projection::Perspective { fx, fy, .. } => Self::LogDistance {
                focal_px: (fx * fy).sqrt(),
            },
        }
    }
}

/// The height of the frame, and what it misses of the normals if that is wanted.
pub(super) fn find_height(run: &mut Execution) {
    let (plan, frame) = (run.plan, run.frame);
    let is_alone = !plan.wants(Product::HeightResidual);
    if is_alone && run.has_kept(&[Product::Height], plan.key(NAME)) {
        return;
    }
    let mut shape = std::mem::take(&mut run.made.outcome.shape);
    let (height, missed) = run.timed(NAME, || {
        let open = match goes_over_edges(plan) {
            true => Cow::Owned(
                frame
                    .mask
                    .plane()
                    .map(|covered| f32::from(u8::from(covered))),
            ),
            false => Cow::Borrowed(shape.conductance.as_ref().expect("height takes it")),
        };
        made(plan, frame, &open)
    });
    (shape.height, shape.height_residual) = (Some(height), missed);
    run.made.outcome.shape = shape;
}

fn made(plan: &Plan, frame: &Frame, conductance: &Plane) -> (Plane, Option<Plane>) {
    let projection = SightLines::of(frame).projection();
    let (mut slopes, mut known) = (
        slopes(frame, &projection, plan.shape.min_nz),
        known(frame, &projection),
    );
    // A frame that repeats a tile is solved as the tile, and repeated.
    let whole = frame.data_window;
    let part = plan.tile.map_or(whole, |tile| tile.window);
    let (mut mask, mut conductance) = (Cow::Borrowed(&frame.mask), Cow::Borrowed(conductance));
    if plan.tile.is_some() {
        let planes = [&mut slopes.x, &mut slopes.y].into_iter().chain(&mut known);
        planes.for_each(|plane| *plane = plane.crop(whole, part));
        mask = Cow::Owned(mask.crop(whole, part));
        conductance = Cow::Owned(conductance.crop(whole, part));
    }
    let problem = Problem {
        slopes: &slopes,
        conductance: &conductance,
        mask: &mask,
        wraps: plan.tile.map_or([false; 2], |tile| tile.wraps),
        near: known
            .as_ref()
            .map(|known| (known, plan.shape.height_detail)),
        tolerance: plan.shape.height_tolerance,
    };
    let (mut height, _) = solve(&problem);
    let wants_missed = plan.wants(Product::HeightResidual);
    let mut missed = wants_missed.then(|| residual(&problem, &height));
    if let Unknown::LogDistance { focal_px } = Unknown::of(&projection) {
        // The scene's size may not be known: then in pixels at its mean distance.
        let focal_px = known.is_none().then_some(focal_px as f32);
        from_logarithm(&mut height, &mask, focal_px);
    }
    if plan.tile.is_some() {
        height = height.repeated(part, whole);
        missed = missed.map(|missed| missed.repeated(part, whole));
    }
    (height, missed)
}

/// The height from the logarithm of the distance, or of its ratio to the mean distance seen by this focal length.
fn from_logarithm(height: &mut Plane, mask: &Mask, focal_px: Option<f32>) {
    height.each_with(mask.plane(), |log, covered| {
        *log = match focal_px {
            _ if !covered => 0.0,
            None => -log.exp(),
            Some(focal_px) => -focal_px * log.exp_m1(),
        };
    });
}

/// Changes of the unknown per pixel, from the normals; the surface is taken no steeper than `least_nz` allows.
fn slopes(frame: &Frame, projection: &Projection, least_nz: f32) -> HeightSlopes {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let sight = SightLines::new(*projection);
    let change = |axis: usize| {
        let mut plane = Plane::filled(width, height, 0.0);
        let normal = [&frame.normal.x, &frame.normal.y][axis];
        plane.each_row(|y, row| {
            let along = normal.row(y);
            let [nx, ny, nz] =
                [&frame.normal.x, &frame.normal.y, &frame.normal.z].map(|p| p.row(y));
            for x in frame.mask.runs(y).flatten() {
                let (facing, pixel) = match *projection {
                    Projection::Orthographic { sx, sy, .. } => (nz[x], [-1.0 / sx, 1.0 / sy][axis]),
                    Projection::Perspective { fx, fy, .. } => {
                        let at = frame.data_window.middle(x, y);
                        let (_, line) = sight.line(at.x, at.y);
                        let [to_x, to_y] = [-line.x, -line.y].map(|v| v as f32);
                        let facing = nz[x] + nx[x] * to_x + ny[x] * to_y;
                        (facing, [1.0 / fx, -1.0 / fy][axis])
                    }
                };
                row[x] = along[x] / facing.max(least_nz) * pixel as f32;
            }
        });
        plane
    };
    HeightSlopes {
        x: change(0),
        y: change(1),
    }
}

/// The unknown as depth tells it; `None` without depth that tells distances in the units of the projection.
fn known(frame: &Frame, projection: &Projection) -> Option<Plane> {
    let kind = frame.source.depth_kind;
    let depth = frame.depth.as_ref();
    let depth = depth.filter(|_| frame.camera.is_some() && kind != DepthKind::Relative)?;
    let window: Window = frame.data_window;
    let sight = SightLines::new(*projection);
    let mut known = Plane::filled(depth.width(), depth.height(), 0.0);
    known.each_row(|y, row| {
        for x in frame.mask.runs(y).flatten() {
            let distance = depth.at(x, y);
            row[x] = match projection {
                Projection::Orthographic { .. } => -distance,
                Projection::Perspective { .. } => {
                    let at = window.middle(x, y);
                    let along = match kind {
                        DepthKind::Ray => sight.line(at.x, at.y).1.length() as f32,
                        _ => 1.0,
                    };
                    (distance / along).ln()
                }
            };
        }
    });
    Some(known)
}
