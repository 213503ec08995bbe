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
use glam::{DVec3, Vec2};
use regions::{closed, count, distances, large_pieces, opened};

/// Shares of the picture's border and of the surface that planes of a background have at the least.
const LEAST_BORDER: f32 = 0.2;
const LEAST_AREA: f32 = 0.1;

/// The share of the border from which on further planes are of the background, as walls of a room.
const MORE_BORDER: f32 = 0.1;

/// The share of the surface beyond which planes are the subject.
const ALL_PLANES: f32 = 0.92;

/// Planes are the subject, too, if the cosine between their normals and the mean of these is less than this for most of them,
/// 3 degrees, and nearly all else lies within this share of the distance of them: they are what a relief rises from.
const EVEN: f64 = 0.9986;
const RELIEF: f32 = 0.25;

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
    /// The side of cells in pixels.
    step: usize,
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
            step,
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

    /// Whether planes are those of a relief, uneven, with nothing far off them.
    fn is_relief(
        &self,
        planes: &Plane<u8>,
        (linear, fits): (Linear, &[Fitted]),
        frame: &Frame,
    ) -> bool {
        let values = self.values(linear);
        let (mut off, mut normals) = (Vec::new(), vec![Vec::new(); fits.len()]);
        let seen = middles(&frame.normal.x, self.step, |x, y| frame.normal.at(x, y));
        for y in 0..planes.height() {
            for x in self.mask.runs(y).flatten() {
                match usize::from(planes.at(x, y)).checked_sub(1) {
                    Some(plane) => normals[plane].push(seen.at(x, y)),
                    None => {
                        let off_plane =
                            |fit: &PlaneFit| (values.at(x, y) / fit.at(x, y) - 1.0).abs();
                        let least = fits.iter().map(|(fit, _)| off_plane(fit));
                        off.push(least.fold(f32::INFINITY, f32::min));
                    }
                }
            }
        }
        let is_uneven = normals.iter().any(|normals| {
            let mean = normals.iter().sum::<DVec3>().normalize_or_zero();
            let turned = normals.iter().filter(|normal| normal.dot(mean) < EVEN);
            2 * turned.count() > normals.len()
        });
        let far = quantile(&mut off, 0.95, f32::total_cmp);
        let has_distances = !frame.source.heights && !is_relative(frame);
        is_uneven && far.is_none_or(|far| far < RELIEF || !has_distances)
    }

    /// The rim of the subject where it stands: beside a plane that has its depth within reach, and that of the subject there.
    fn stands(
        &self,
        fits: &[Fitted],
        linear: Linear,
        [subject, behind]: [&Plane<bool>; 2],
        (size, same): (f32, f32),
    ) -> Plane<bool> {
        let values = self.values(linear);
        let [width, height] = [values.width(), values.height()];
        let mut stands = Plane::filled(width, height, false);
        for (fit, within) in fits {
            let slack = fit.slope.length() * STANDS_WITHIN * size;
            let has_depth = |x: usize, y: usize, slack: f32| {
                let [own, there] = [values.at(x, y), fit.at(x, y)];
                (own - there).abs() < slack + ROUNDING * there.abs()
            };
            // A corner of the plane before its horizon lies on it, and is the rim of nothing. Within a few cells of its rim a
            // ball leaves the plane.
            let own = Plane::from_fn(width, height, |x, y| {
                let is_on = fit.holds([x, y], values.at(x, y), (1.5, same));
                subject.at(x, y) && !is_on && has_depth(x, y, RIM_CELLS * slack)
            });
            let both = [within, &own].map(|region| distances(region, RIM_CELLS));
            for y in 0..height {
                for x in self.mask.runs(y).flatten().filter(|&x| !behind.at(x, y)) {
                    let is_beside = both.iter().all(|distance| distance.at(x, y).is_finite());
                    stands.row_mut(y)[x] |= is_beside && has_depth(x, y, slack);
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
            let objects = middles(objects, step, |x, y| objects.at(x, y));
            leave_to_objects(&mut planes, &objects);
        }
        let behind = planes.map(|plane| plane > 0);
        let is_all = count(&behind) > ALL_PLANES * cells.mask.count() as f32;
        if is_all || cells.is_relief(&planes, (linear, &fits), frame) {
            return None;
        }
        let beside = distances(&behind, 2.0);
        let before = Plane::from_fn(planes.width(), planes.height(), |x, y| {
            cells.mask.at(x, y) && beside.at(x, y) > 1.0
        });
        let subject = large_pieces(&opened(&before, DETAIL * size), LEAST_PART * size * size);
        let stands = cells.stands(&fits, linear, [&subject, &behind], (size, same));
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

    /// Whether the subject stands beside this pixel of the frame.
    pub(crate) fn is_contact(&self, [x, y]: [usize; 2]) -> bool {
        let [x, y] = self.cell(Vec2::new(x as f32, y as f32));
        self.to_contact.at(x, y) < STANDS_WITHIN * self.size
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
        let cells = around.map(|way| self.cell(at + reach * way));
        let there = cells.map(|[x, y]| self.planes.at(x, y));
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
        let is_apart = object > 0.0 && apart > inside;
        *plane = if is_apart { 0 } else { *plane };
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
        let large = planes
            .into_iter()
            .filter(|(_, within)| count(within) > LEAST_AREA * covered);
        let on_border = |(_, within): &Fitted| regions::on_border(within) as f32 / around;
        let mut large: Vec<_> = large
            .filter(|plane| on_border(plane) > MORE_BORDER)
            .collect();
        if !large.iter().any(|plane| on_border(plane) > LEAST_BORDER) {
            large.clear();
        }
        (linear, large)
    };
    let area = |(_, planes): &(Linear, Vec<Fitted>)| -> f32 {
        planes.iter().map(|(_, within)| count(within)).sum()
    };
    let camera = frame.camera.filter(|_| !is_relative(frame));
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

/// Whether depth has neither an origin nor a unit.
fn is_relative(frame: &Frame) -> bool {
    frame.source.depth_kind == DepthKind::Relative
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
    use glam::Vec3;

    /// A floor one unit below a camera that sees 300 pixels to a unit of distance, with its horizon in row 40, and a ball of
    /// half a unit three units away, 100 pixels wide, whose lowest point is above the floor by a `lift`. Bumps are a share of
    /// the distance.
    fn floor_with_ball(lift: f32, bumps: f32) -> Frame {
        let centre = Vec3::new(0.0, lift - 0.5, 3.0);
        let ball = |x: usize, y: usize| {
            let ray = Vec3::new((x as f32 - 159.5) / 300.0, (39.5 - y as f32) / 300.0, 1.0);
            let (a, b) = (ray.length_squared(), ray.dot(centre));
            let root = b * b - a * (centre.length_squared() - 0.25);
            (root > 0.0).then(|| (b - root.sqrt()) / a)
        };
        let depth = Plane::from_fn(320, 240, |x, y| {
            let bump = bumps * (0.3 * x as f32).sin() * (0.3 * y as f32).sin();
            ball(x, y).unwrap_or(300.0 * (1.0 + bump) / (y as f32 - 39.5))
        });
        let is_seen = |x: usize, y: usize| y >= 40 || ball(x, y).is_some();
        let mask = Mask::new(Plane::from_fn(320, 240, is_seen));
        let normal = Vector3Planes::from_fn(320, 240, |_, _| DVec3::Y);
        Frame {
            depth: Some(depth),
            ..Frame::of_normals(normal, mask)
        }
    }

    #[test]
    fn a_floor_is_behind_the_ball_on_it_whatever_its_bumps() {
        let even = Backdrop::of(&floor_with_ball(0.0, 0.0), 1.0).expect("there is a floor");
        let bumpy = Backdrop::of(&floor_with_ball(0.0, 0.01), 1.0).expect("there is a floor");
        for (x, y) in (0..240).flat_map(|y| (0..320).map(move |x| (x, y))) {
            // Where the ball stands, its lowest tenth is no farther from the floor than a hundredth of the distance.
            let near = (140..180).contains(&x) && (120..160).contains(&y);
            let on_floor = y >= 40 && even.to_subject.at(x, y) > 3.0;
            if !near && even.to_subject.at(x, y) >= 4.0 {
                assert_eq!(even.plane(x, y).is_some(), on_floor, "{x} {y}");
            }
            if on_floor && !near {
                assert_eq!(even.plane(x, y), bumpy.plane(x, y), "{x} {y}");
            }
        }
        let level = even.level(Vec2::new(20.0, 200.0));
        assert!(level.is_some_and(|level| level.y.abs() < 1e-6));
    }

    #[test]
    fn walls_beside_a_floor_are_of_the_background_and_alone_they_are_not() {
        // 1.2 units to the left, before the floor above a line from row 172 of the left side to the middle of the horizon: 12 % of
        // the border, 16 % of the surface.
        let is_wall = |x: usize, y: usize| x < 160 && (y as f32 - 39.5) < (159.5 - x as f32) / 1.2;
        let mut frame = floor_with_ball(0.0, 0.0);
        let depth = frame.depth.as_mut().expect("the frame has depth");
        depth.each_row(|y, row| {
            for x in (0..160).filter(|&x| is_wall(x, y)) {
                row[x] = row[x].min(360.0 / (159.5 - x as f32));
            }
        });
        let both = Backdrop::of(&frame, 1.0).expect("there is a floor");
        let [wall, floor] = [[5, 100], [300, 200]].map(|[x, y]| both.plane(x, y));
        assert!(wall.is_some() && floor.is_some() && wall != floor);
        frame.mask = Mask::new(Plane::from_fn(320, 240, |x, y| y >= 40 && is_wall(x, y)));
        assert!(Backdrop::of(&frame, 1.0).is_none());
    }

    #[test]
    fn the_foot_of_an_object_is_its_own() {
        let is_card = |x: usize, y: usize| (220..280).contains(&x) && (120..200).contains(&y);
        let mut frame = floor_with_ball(0.0, 0.0);
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

    #[test]
    fn a_ball_stands_below_its_middle_and_one_above_the_floor_nowhere() {
        // Its middle is atan(0.5 / 3) = 9.5 degrees below the horizon, and its rim as far below that: in row
        // 39.5 + 300 tan 18.9 = 142, where it is 2.84 units away and the floor 2.92. The dark line ends 277/60 = 4.6 cells on.
        let stands = Backdrop::of(&floor_with_ball(0.0, 0.0), 1.0).expect("there is a floor");
        let at = |x: usize, y: usize| stands.to_contact.at(x, y);
        assert!(
            stands.is_contact([160, 144]) && !stands.is_contact([160, 150]),
            "{}",
            at(160, 144)
        );
        // The corners between the ball and the horizon have the depth of the floor.
        let corners = (40..60).flat_map(|y| (100..220).map(move |x| (x, y)));
        corners.for_each(|(x, y)| assert!(at(x, y).is_infinite(), "{x} {y}"));
        // Lifted by half its radius it is a quarter of a unit above the floor, a twelfth of the distance.
        let lifted = Backdrop::of(&floor_with_ball(0.25, 0.0), 1.0).expect("there is a floor");
        let floats = lifted
            .to_contact
            .samples()
            .iter()
            .all(|to| to.is_infinite());
        assert!(floats);
    }

    #[test]
    fn bosses_that_fill_the_frame_are_no_floor() {
        // Bosses of 2.4 hundredths of the distance, whose flanks are within the tolerance of a plane through half of them.
        let height =
            |x: f32, y: f32| 24.0 * (0.5 + 0.5 * (x / 23.0).sin() * (y / 19.0).sin()).powi(2);
        let depth = Plane::from_fn(320, 240, |x, y| 1000.0 - height(x as f32, y as f32));
        let normal = Vector3Planes::from_fn(320, 240, |x, y| {
            let (x, y) = (x as f32, y as f32);
            let here = height(x, y);
            let slopes = Vec2::new(height(x + 1.0, y) - here, here - height(x, y + 1.0));
            -slopes.extend(-1.0).normalize().as_dvec3()
        });
        let relief = Frame {
            depth: Some(depth),
            ..Frame::of_normals(normal, Mask::full(320, 240))
        };
        assert!(Backdrop::of(&relief, 1.0).is_none());
    }
}
