//! The background of a drawing: floor and walls, the planes that a subject stands on or before.
//!
//! Theory: a plane is linear over the picture in the inverse of depth, and under parallel lines of sight in depth itself,
//! whatever the camera. One that fills much of the picture's border is what the subject is in front of, unless planes are
//! nearly all there is: then they are the subject, as of a relief. A draughtsman leaves them to the paper, but for the
//! shadow that the subject casts and the dark line where it stands, and fades what lies far behind it.
//!
//! Practice: all of it is found on the cells that tones have.

mod fit;
mod regions;
pub(crate) mod stage;

use crate::frame::{DepthKind, Frame, Mask, Plane, Projection};
use crate::kernel::quantile::quantile;
use crate::line::contours::network::Line;
use crate::line::grid::cell_px;
use crate::line::smooth_step::smooth_step;
use fit::{Linear, PlaneFit};
use glam::Vec2;
use regions::{closed, count, distances, large_pieces, opened};

/// Shares of the picture's border and of the surface that planes of a background have at the least.
const LEAST_BORDER: f32 = 0.2;
const LEAST_AREA: f32 = 0.1;

/// The share of the surface beyond which planes are the subject.
const ALL_PLANES: f32 = 0.92;

/// By how much more planes under parallel lines of sight have to cover to be preferred where there is no camera.
const PREFERRED: f32 = 1.3;

/// Shares of the picture's size, the root of its area: gaps in planes that are closed, and details of a subject that are not
/// its own.
const GAP: f32 = 1.0 / 250.0;
const DETAIL: f32 = 1.0 / 400.0;

/// Parts of a subject are larger than this share of the picture.
const LEAST_PART: f32 = 0.0015;

/// How near to a plane and to a subject its rim is, in cells, and how far from where it stands the plane may have its depth,
/// as a share of the picture's size.
const RIM_CELLS: f32 = 3.0;
const STANDS_WITHIN: f32 = 1.0 / 60.0;

/// The enlargement up to which steps in depth are allowed for.
const MOST_ENLARGED: f32 = 8.0;

/// Rounding of depth that a subject stands on a plane with.
const ROUNDING: f32 = 5e-4;

/// A plane that changes less than this from one side of the picture to the other has no level direction.
const FACING: f32 = 0.02;

/// From which to which distance things fade, in doublings of that of the subject.
const FADES: [f32; 2] = [0.15, 1.45];

/// How far from the subject, and from where it stands, distances are counted, as shares of the picture's size: beyond them
/// its shadow and the dark line there have faded.
const FARTHEST: [f32; 2] = [1.0 / 4.0, 1.0 / 11.0];

/// Planes behind a subject, in cells of the picture.
#[derive(Debug, Clone)]
pub(crate) struct Backdrop {
    cell_px: f32,
    /// The size of the picture, the root of its area, in cells.
    pub(crate) size: f32,
    /// The plane of each cell, counted from 1; 0 for the subject and for nothing.
    planes: Plane<u8>,
    /// The directions that are level in each plane, x right, y up; `None` where it faces the viewer.
    level: Vec<Option<Vec2>>,
    /// Distances in cells from the subject, and from where it stands on its planes, infinite if far.
    pub(crate) to_subject: Plane,
    pub(crate) to_contact: Plane,
    /// How far cells lie behind the subject, 0..1.
    pub(crate) remote: Plane,
}

/// The covered cells of a frame, with a value that is linear over planes.
struct DepthCells {
    mask: Mask,
    depth: Plane,
}

/// What is in the middles of cells of pixels.
fn middles<T: Copy>(pixels: &Plane, step: usize, sample: impl Fn(usize, usize) -> T) -> Plane<T> {
    let [width, height] = [pixels.width(), pixels.height()];
    let place = |at: usize, length: usize| (at * step + step / 2).min(length - 1);
    Plane::from_fn(width.div_ceil(step), height.div_ceil(step), |x, y| {
        sample(place(x, width), place(y, height))
    })
}

impl DepthCells {
    /// The depth in the middles of cells where it is known.
    fn of(frame: &Frame, depth: &Plane, step: usize) -> Self {
        let depth = middles(depth, step, |x, y| {
            match frame.mask.at(x, y) && depth.at(x, y).is_finite() {
                true => depth.at(x, y),
                false => f32::NAN,
            }
        });
        Self {
            mask: Mask::new(depth.map(|depth| !depth.is_nan())),
            depth,
        }
    }

    fn values(&self, linear: Linear) -> Plane {
        self.depth.map(|depth| match linear {
            Linear::Depth => depth,
            Linear::InverseDepth if depth > 0.0 => depth.recip(),
            Linear::InverseDepth => f32::NAN,
        })
    }

    /// The number of the plane in each cell, counted from 1, gaps closed; 0 where there is none.
    fn planes(&self, fits: &[Fitted], size: f32) -> Plane<u8> {
        let mut planes = Plane::filled(self.mask.width(), self.mask.height(), 0);
        for (number, (_, within)) in (1..).zip(fits) {
            let within = closed(within, GAP * size);
            for y in 0..planes.height() {
                for x in self.mask.runs(y).flatten().filter(|&x| within.at(x, y)) {
                    let plane = &mut planes.row_mut(y)[x];
                    *plane = if *plane == 0 { number } else { *plane };
                }
            }
        }
        planes
    }

    /// The rim of the subject where it stands: beside a plane that has its depth within reach.
    fn stands(
        &self,
        fits: &[Fitted],
        linear: Linear,
        [subject, behind]: [&Plane<bool>; 2],
        size: f32,
    ) -> Plane<bool> {
        let values = self.values(linear);
        let beside_subject = distances(subject, RIM_CELLS);
        let mut stands = Plane::filled(values.width(), values.height(), false);
        for (fit, within) in fits {
            let near = distances(within, RIM_CELLS);
            let slack = fit.slope.length() * STANDS_WITHIN * size;
            for y in 0..values.height() {
                for x in self.mask.runs(y).flatten().filter(|&x| !behind.at(x, y)) {
                    let both = [near.at(x, y), beside_subject.at(x, y)];
                    let [own, there] = [values.at(x, y), fit.at(x, y)];
                    let is_there = (own - there).abs() < slack + ROUNDING * there.abs();
                    stands.row_mut(y)[x] |= is_there && both.iter().all(|d| d.is_finite());
                }
            }
        }
        stands
    }
}

impl Backdrop {
    /// The planes behind the subject of a frame, which was enlarged by a factor, if there are any beside one.
    pub(crate) fn of(frame: &Frame, factor: f32) -> Option<Self> {
        let depth = frame.depth.as_ref()?;
        let size_px = frame.display_window.size_px();
        let step = cell_px(size_px);
        let size = size_px / step as f32;
        let cells = DepthCells::of(frame, depth, step);
        // Enlarged pixels may be steps, half of them on either side of the plane, beside a pixel's own middle.
        let same = 0.5 * (factor.clamp(1.0, MOST_ENLARGED) + 1.0) / step as f32;
        let (linear, fits) = fitted(&cells, frame, same)?;
        let mut planes = cells.planes(&fits, size);
        if let Some(objects) = &frame.objects {
            leave_to_objects(
                &mut planes,
                &middles(objects, step, |x, y| objects.at(x, y)),
            );
        }
        let behind = planes.map(|plane| plane > 0);
        if count(&behind) > ALL_PLANES * cells.mask.count() as f32 {
            return None;
        }
        let beside = distances(&behind, 2.0);
        let before = Plane::from_fn(planes.width(), planes.height(), |x, y| {
            cells.mask.at(x, y) && beside.at(x, y) > 1.0
        });
        let subject = large_pieces(&opened(&before, DETAIL * size), LEAST_PART * size * size);
        let stands = cells.stands(&fits, linear, [&subject, &behind], size);
        let [far_from_subject, far_from_contact] = FARTHEST.map(|share| share * size);
        Some(Self {
            cell_px: step as f32,
            size,
            level: fits.iter().map(|(fit, _)| fit.level(size)).collect(),
            to_subject: distances(&subject, far_from_subject),
            to_contact: distances(&stands, far_from_contact),
            remote: remote(&cells.depth, &subject, linear),
            planes,
        })
    }

    /// The cell that a place in the frame, in pixels, lies in.
    fn cell(&self, at: Vec2) -> [usize; 2] {
        self.planes.pixel_at(at / self.cell_px)
    }

    /// The number of the plane of a cell, counted from 1, if it is in one.
    pub(crate) fn plane(&self, x: usize, y: usize) -> Option<u8> {
        Some(self.planes.at(x, y)).filter(|&plane| plane > 0)
    }

    /// How many planes there are.
    pub(crate) fn count(&self) -> usize {
        self.level.len()
    }

    /// The direction that is level at a place in the frame, in pixels, if that is in a plane.
    pub(crate) fn level(&self, at: Vec2) -> Option<Vec2> {
        let [x, y] = self.cell(at);
        self.level[usize::from(self.plane(x, y)?) - 1]
    }

    /// Takes away the lines that run inside planes for most of their length; they are in pixels `factor` times as large as
    /// the frame's.
    pub(crate) fn leave_blank<T>(
        &self,
        lines: &mut Vec<T>,
        line: impl Fn(&T) -> &Line,
        factor: f32,
    ) {
        lines.retain(|each| {
            let spots = &line(each).spots;
            let inside = spots.iter().filter(|spot| self.is_inside(factor * spot.at));
            2 * inside.count() < spots.len()
        });
    }

    /// Whether a place in the frame, in pixels, is inside a plane, and not where it meets something else.
    fn is_inside(&self, at: Vec2) -> bool {
        let reach = self.cell_px * (GAP * self.size).max(2.0);
        let around = [Vec2::X, Vec2::Y, Vec2::NEG_X, Vec2::NEG_Y];
        let there = around.map(|way| self.planes.nearest(at + reach * way));
        there[0] > 0 && there.iter().all(|&plane| plane == there[0])
    }
}

/// Takes from planes what they have of objects, whose numbers these are by cell, that lie in none for the most part: the
/// foot of what stands on one.
fn leave_to_objects(planes: &mut Plane<u8>, objects: &Plane) {
    let most = objects.samples().iter().fold(0.0, |a: f32, &b| a.max(b));
    let mut cells = vec![[0; 2]; most as usize + 1];
    for (&object, &plane) in objects.samples().iter().zip(planes.samples()) {
        cells[object as usize][usize::from(plane > 0)] += 1;
    }
    planes.each_with(objects, |plane, object| {
        let [apart, inside] = cells[object as usize];
        *plane = if object > 0.0 && apart > inside {
            0
        } else {
            *plane
        };
    });
}

/// A plane, and the cells in it.
type Fitted = (PlaneFit, Plane<bool>);

/// The planes that a frame's camera allows, with the cells in each; without a camera those that cover more.
fn fitted(cells: &DepthCells, frame: &Frame, same: f32) -> Option<(Linear, Vec<Fitted>)> {
    let covered = cells.mask.count() as f32;
    let around = 2.0 * (cells.mask.width() + cells.mask.height()) as f32;
    let found = |linear: Linear| {
        let values = cells.values(linear);
        let planes = fit::planes(&values, same);
        let large = planes.into_iter().filter(|(_, within)| {
            let on_border = regions::on_border(within) as f32;
            on_border > LEAST_BORDER * around && count(within) > LEAST_AREA * covered
        });
        (linear, large.collect::<Vec<_>>())
    };
    let area = |(_, planes): &(Linear, Vec<Fitted>)| -> f32 {
        planes.iter().map(|(_, within)| count(within)).sum()
    };
    let is_relative = frame.source.depth_kind == DepthKind::Relative;
    let camera = frame.camera.filter(|_| !is_relative);
    let found = match camera.map(|camera| camera.projection) {
        Some(Projection::Perspective { .. }) => found(Linear::InverseDepth),
        Some(Projection::Orthographic { .. }) => found(Linear::Depth),
        None => {
            let [perspective, parallel] = [Linear::InverseDepth, Linear::Depth].map(found);
            match area(&parallel) > PREFERRED * area(&perspective) {
                true => parallel,
                false => perspective,
            }
        }
    };
    Some(found).filter(|(_, planes)| !planes.is_empty())
}

/// How far cells lie behind most of the subject, 0..1; nowhere under parallel lines of sight, where distances have no origin.
fn remote(depth: &Plane, subject: &Plane<bool>, linear: Linear) -> Plane {
    let own = depth.samples().iter().zip(subject.samples());
    let own = own.filter(|(depth, is_subject)| **is_subject && !depth.is_nan());
    let mut own: Vec<f32> = own.map(|(depth, _)| *depth).collect();
    let back = quantile(&mut own, 0.9, f32::total_cmp).filter(|_| linear == Linear::InverseDepth);
    depth.map(|depth| match back {
        Some(back) if depth > back => smooth_step(FADES, (depth / back).log2()),
        _ => 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Vector3Planes;
    use glam::DVec3;

    /// A floor one unit below a camera with its horizon in row 40, and a ball of 50 pixels before it that is nearer than
    /// all of it. Bumps are a share of the distance.
    fn floor_with_ball(bumps: f32) -> Frame {
        let ball = |x: usize, y: usize| (x as f32 - 159.5).hypot(y as f32 - 69.5) < 50.0;
        let depth = Plane::from_fn(320, 240, |x, y| {
            let bump = bumps * (0.3 * x as f32).sin() * (0.3 * y as f32).sin();
            match ball(x, y) {
                true => 1.2,
                false => 300.0 * (1.0 + bump) / (y as f32 - 39.5),
            }
        });
        let mask = Mask::new(Plane::from_fn(320, 240, |x, y| y >= 40 || ball(x, y)));
        let normal = Vector3Planes::from_fn(320, 240, |_, _| DVec3::Y);
        Frame {
            depth: Some(depth),
            ..Frame::of_normals(normal, mask)
        }
    }

    #[test]
    fn a_floor_is_behind_the_ball_on_it_whatever_its_bumps() {
        let even = Backdrop::of(&floor_with_ball(0.0), 1.0).expect("there is a floor");
        let bumpy = Backdrop::of(&floor_with_ball(0.01), 1.0).expect("there is a floor");
        for (x, y) in (0..240).flat_map(|y| (0..320).map(move |x| (x, y))) {
            let on_floor = y >= 40 && even.to_subject.at(x, y) > 3.0;
            assert!(
                even.plane(x, y).is_some() == on_floor || even.to_subject.at(x, y) < 4.0,
                "{x} {y}"
            );
            if on_floor {
                assert_eq!(even.plane(x, y), bumpy.plane(x, y), "{x} {y}");
            }
        }
        let level = even.level(Vec2::new(20.0, 200.0));
        assert!(level.is_some_and(|level| level.y.abs() < 1e-6));
    }

    #[test]
    fn the_foot_of_an_object_is_its_own() {
        let is_card = |x: usize, y: usize| (220..280).contains(&x) && (120..200).contains(&y);
        let mut frame = floor_with_ball(0.0);
        let depth = frame.depth.as_mut().expect("the frame has depth");
        // Upright: as far all over as the floor where it stands.
        depth.each_row(|y, row| {
            for x in (0..320).filter(|&x| is_card(x, y)) {
                row[x] = 300.0 / 160.0;
            }
        });
        let taken = |frame: &Frame| {
            let planes = Backdrop::of(frame, 1.0).expect("there is a floor");
            let card = (120..200).flat_map(|y| (220..280).map(move |x| (x, y)));
            card.filter(|&(x, y)| planes.plane(x, y).is_some()).count()
        };
        // Its last row is the floor's depth within a third of a percent.
        assert!(taken(&frame) >= 60);
        frame.objects = Some(Plane::from_fn(320, 240, |x, y| {
            if is_card(x, y) { 2.0 } else { 1.0 }
        }));
        assert_eq!(taken(&frame), 0);
    }
}
