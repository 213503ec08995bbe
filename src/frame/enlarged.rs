//! Enlarging a frame, for drawings that need more pixels.

use super::plane::each_row_of;
use super::{Camera, Frame, Mask, Plane, Projection, Vector3Planes, Window};
use std::cell::Cell;

/// Samples belong to one surface if neither is nearer than this share of the other's depth.
const SAME: f32 = 0.965;

/// How many times steeper than on both sides a surface gets from one pixel to the next at the most.
const STEEPER: f32 = 3.0;

impl Frame {
    /// The frame enlarged `factor` times in both directions, rounded to whole pixels, seen by the same camera: samples
    /// are interpolated within surfaces, whose borders stay sharp. Beside a jump of depth, where a filter mixes two
    /// surfaces, normals are means of nearby pixels of the same surface. Lengths of filtered normals are rescaled to the
    /// share of an edge within an enlarged pixel.
    ///
    /// # Panics
    /// If `factor` is less than 1.
    pub fn enlarged(&self, factor: f64) -> Frame {
        let enlarged = self.enlarged_while(factor, &|| true, &|_| ());
        enlarged.expect("nobody stops it")
    }

    /// [`Frame::enlarged`], told the share that is done as each plane begins; `None` where it no longer `goes_on`, which
    /// is asked at every row.
    pub(crate) fn enlarged_while(
        &self,
        factor: f64,
        goes_on: &(dyn Fn() -> bool + Sync),
        tell: &dyn Fn(f32),
    ) -> Option<Frame> {
        assert!(factor >= 1.0, "a frame is enlarged");
        if factor == 1.0 {
            return Some(self.clone());
        }
        let (begun, planes) = (Cell::new(0), self.planes_to_enlarge());
        let begins = || tell(begun.replace(begun.get() + 1) as f32 / planes as f32);
        begins();
        let mask = Mask::new(self.spread(factor, goes_on, |around| around.is_some()));
        let plane = |plane: &Plane| {
            begins();
            self.spread(factor, goes_on, |around| {
                around.map_or(0.0, |around| mean(plane, &around))
            })
        };
        let mut frame = Frame {
            data_window: enlarged(self.data_window, self.display_window, factor),
            display_window: enlarged(self.display_window, self.display_window, factor),
            camera: self.camera.map(|camera| Camera {
                projection: camera.projection.of_pixels(factor.recip()),
                ..camera
            }),
            ..self.with_planes(mask, plane)
        };
        frame.depth = self.depth.as_ref().map(|depth| {
            self.spread(factor, goes_on, |around| {
                around.map_or(0.0, |around| self.mean_depth(depth, &around))
            })
        });
        frame.objects = self.objects.as_ref().map(|numbers| {
            let number = |around| heaviest(numbers, &around);
            self.spread(factor, goes_on, |around| around.map_or(0.0, number))
        });
        if let Some(is_mixed) = self.beside_jumps() {
            let unmixed = |mixed: &Plane| plane(&self.of_one_surface(mixed, &is_mixed));
            frame.normal = self.normal.mapped(unmixed);
            frame.normal_length = self.normal_length.as_ref().map(unmixed);
        }
        if !goes_on() {
            return None;
        }
        // An edge within a pixel is spread over several.
        if let Some(lengths) = &mut frame.normal_length {
            lengths.each_row(|_, row| {
                for length in row {
                    *length = (length.clamp(0.0, 1.0).acos() / factor as f32).cos();
                }
            });
        }
        let Vector3Planes { x, y, z } = &mut frame.normal;
        each_row_of([x, y, z], |_, [x, y, z]| {
            for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
                let length = (*x * *x + *y * *y + *z * *z).sqrt();
                if length > 0.0 {
                    (*x, *y, *z) = (*x / length, *y / length, *z / length);
                }
            }
        });
        Some(frame)
    }

    /// A plane that goes with this frame, enlarged as those of its own are; `outside` where the frame shows nothing.
    pub(super) fn enlarged_plane(&self, plane: &Plane, factor: f64, outside: f32) -> Plane {
        let mean = |around| mean(plane, &around);
        self.spread(factor, &|| true, |around| around.map_or(outside, mean))
    }

    /// A plane of the enlarged frame, of the samples around each pixel, as far as it `goes_on`.
    fn spread<T: Copy + Default + Send>(
        &self,
        factor: f64,
        goes_on: &(dyn Fn() -> bool + Sync),
        sample: impl Fn(Option<Around>) -> T + Sync,
    ) -> Plane<T> {
        let (data, display) = (self.data_window, self.display_window);
        let across = Side::new([data.x0, display.x0], data.width(), factor);
        let down = Side::new([data.y0, display.y0], data.height(), factor);
        let window = enlarged(data, display, factor);
        samples([window.width(), window.height()], goes_on, |x, y| {
            sample(self.around(across.place(x), down.place(y)))
        })
    }

    /// How many planes an enlarged frame takes: the mask, its own, and beside jumps the normals once more.
    fn planes_to_enlarge(&self) -> usize {
        let count = Cell::new(1);
        self.with_planes(self.mask.clone(), |_| {
            count.set(count.get() + 1);
            Plane::default()
        });
        let again = 3 + usize::from(self.normal_length.is_some());
        count.get() + self.depth.as_ref().map_or(0, |_| again)
    }

    /// The samples around a pixel of the enlarged frame that belong to the surface seen there, with weights that add up
    /// to 1, from its positions across and down; `None` if most of the samples around are uncovered.
    fn around(&self, across: Place, down: Place) -> Option<Around> {
        let ([left, right], across) = across;
        let ([above, below], down) = down;
        let mut samples = [
            ([left, above], (1.0 - across) * (1.0 - down)),
            ([right, above], across * (1.0 - down)),
            ([left, below], (1.0 - across) * down),
            ([right, below], across * down),
        ];
        for ([x, y], weight) in &mut samples {
            *weight *= f32::from(u8::from(self.mask.at(*x, *y)));
        }
        let covered: f32 = samples.iter().map(|(_, weight)| weight).sum();
        if covered < 0.5 {
            return None;
        }
        self.keep_one_surface(&mut samples);
        let sum: f32 = samples.iter().map(|(_, weight)| weight).sum();
        samples.iter_mut().for_each(|(_, weight)| *weight /= sum);
        Some(samples)
    }

    /// Pixels beside a jump of depth, where a filter mixes two surfaces; `None` without depth.
    fn beside_jumps(&self) -> Option<Plane<bool>> {
        let depth = self.depth.as_ref()?;
        let size = [depth.width(), depth.height()];
        Some(samples(size, &|| true, |x, y| {
            let mut beside = around_pixel([x, y], size, 1).filter(|&[i, k]| self.mask.at(i, k));
            self.mask.at(x, y) && beside.any(|at| !self.is_one_surface([x, y], at))
        }))
    }

    /// The plane with samples of mixed pixels replaced by the mean of nearby unmixed ones of the same surface: enlarged, a
    /// mixed pixel would be a bend.
    fn of_one_surface(&self, plane: &Plane, is_mixed: &Plane<bool>) -> Plane {
        let size = [plane.width(), plane.height()];
        samples(size, &|| true, |x, y| {
            if !is_mixed.at(x, y) {
                return plane.at(x, y);
            }
            let is_pure = |&[i, k]: &[usize; 2]| {
                self.mask.at(i, k) && !is_mixed.at(i, k) && self.is_one_surface([x, y], [i, k])
            };
            let pure = around_pixel([x, y], size, 2).filter(is_pure);
            let add = |(sum, count), [i, k]: [usize; 2]| (sum + plane.at(i, k), count + 1.0);
            match pure.fold((0.0, 0.0), add) {
                (_, 0.0) => plane.at(x, y),
                (sum, count) => sum / count,
            }
        })
    }

    /// Whether two pixels side by side belong to one surface; without depth all do.
    fn is_one_surface(&self, a: [usize; 2], b: [usize; 2]) -> bool {
        let Some(depth) = &self.depth else {
            return true;
        };
        let [near, far] = [a, b].map(|[x, y]| depth.at(x, y));
        near.min(far) >= SAME * near.max(far) || self.goes_on_steeply(depth, a, b)
    }

    /// What is linear over a plane at this depth: its inverse in perspective. Its own inverse but for depth up to 0.
    fn linear(&self, depth: f32) -> f32 {
        let projection = self.camera.map(|camera| camera.projection);
        let is_parallel = matches!(projection, Some(Projection::Orthographic { .. }));
        if is_parallel || depth <= 0.0 {
            depth
        } else {
            depth.recip()
        }
    }

    /// The depth of the plane through samples around a position.
    fn mean_depth(&self, depth: &Plane, around: &Around) -> f32 {
        let samples = around.iter().filter(|(_, weight)| *weight > 0.0);
        let samples = samples.map(|&([x, y], weight)| (depth.at(x, y), weight));
        if samples.clone().all(|(depth, _)| depth > 0.0) {
            let mean: f32 = samples
                .map(|(depth, weight)| weight * self.linear(depth))
                .sum();
            return self.linear(mean);
        }
        samples.map(|(depth, weight)| weight * depth).sum()
    }

    /// Whether the surface of two pixels side by side is as steep on both sides as between them, like a floor far away.
    fn goes_on_steeply(&self, depth: &Plane, a: [usize; 2], b: [usize; 2]) -> bool {
        let beyond = |from: [usize; 2], to: [usize; 2]| {
            let next = |axis: usize| (2 * to[axis]).checked_sub(from[axis]);
            let (x, y) = (next(0)?, next(1)?);
            let is_inside = x < depth.width() && y < depth.height() && self.mask.at(x, y);
            is_inside.then(|| self.linear(depth.at(x, y)))
        };
        let [here, there] = [a, b].map(|[x, y]| self.linear(depth.at(x, y)));
        let between = there - here;
        let on_sides = [
            beyond(b, a).map(|before| here - before),
            beyond(a, b).map(|after| after - there),
        ];
        let is_alike = |step: f32| step * between > 0.0 && between.abs() <= STEEPER * step.abs();
        on_sides.iter().any(Option::is_some) && on_sides.into_iter().flatten().all(is_alike)
    }

    /// Removes the weight of samples from surfaces other than the one with most of the weight.
    fn keep_one_surface(&self, samples: &mut Around) {
        let Some(depth) = &self.depth else {
            return;
        };
        let depths = samples.map(|([x, y], _)| depth.at(x, y));
        let [nearest, farthest] =
            [f32::min, f32::max].map(|of| depths.into_iter().fold(depths[0], of));
        // Nearly everywhere.
        if nearest >= SAME * farthest && depths.iter().all(|depth| depth.is_finite()) {
            return;
        }
        let weights = samples.map(|(of, _)| -> f32 {
            let same = samples
                .iter()
                .filter(|(at, _)| self.is_one_surface(of, *at));
            same.map(|(_, weight)| weight).sum()
        });
        let most = (0..4).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let Some([x, y]) = most.map(|most| samples[most].0) else {
            return;
        };
        if !depth.at(x, y).is_finite() {
            return;
        }
        for (at, weight) in samples.iter_mut() {
            if !self.is_one_surface([x, y], *at) {
                *weight = 0.0;
            }
        }
    }
}

/// Samples around a position, with their weights.
type Around = [([usize; 2], f32); 4];

fn mean(plane: &Plane, around: &Around) -> f32 {
    let weighted = around
        .iter()
        .map(|&([x, y], weight)| weight * plane.at(x, y));
    weighted.sum()
}

/// The sample with most weight.
fn heaviest(plane: &Plane, around: &Around) -> f32 {
    let most = around.iter().max_by(|(_, a), (_, b)| a.total_cmp(b));
    most.map_or(0.0, |&([x, y], _)| plane.at(x, y))
}

/// The other pixels of a plane of this `size` within one column and one row of `[x, y]`, and within `steps` across and
/// down taken together.
pub(super) fn around_pixel(
    [x, y]: [usize; 2],
    size: [usize; 2],
    steps: usize,
) -> impl Iterator<Item = [usize; 2]> {
    let near = (-1..=1).flat_map(|down: isize| (-1..=1).map(move |across: isize| [across, down]));
    let near =
        near.filter(move |[a, d]| (1..=steps).contains(&(a.unsigned_abs() + d.unsigned_abs())));
    let places = near.map(move |[a, d]| [x.wrapping_add_signed(a), y.wrapping_add_signed(d)]);
    places.filter(move |[x, y]| *x < size[0] && *y < size[1])
}

/// The two samples around a position along one axis, and the weight of the second.
type Place = ([usize; 2], f32);

/// Shortfall of a length from a whole number, in pixels, that is attributed to rounding.
const SHORT_PX: f64 = 0.01;

/// A length, enlarged and rounded to whole pixels.
fn whole(length: i64, factor: f64) -> i64 {
    (length as f64 * factor + SHORT_PX).floor() as i64
}

/// A window of a frame enlarged, whose display window starts where the original's does, since the camera counts from there.
fn enlarged(window: Window, display: Window, factor: f64) -> Window {
    let place = |at: i32, from: i32| {
        let origin = (f64::from(from) * factor).round() as i64;
        let place = origin + whole(i64::from(at) - i64::from(from), factor);
        place.clamp(i32::MIN.into(), i32::MAX.into()) as i32
    };
    Window {
        x0: place(window.x0, display.x0),
        y0: place(window.y0, display.y0),
        x1: place(window.x1, display.x0),
        y1: place(window.y1, display.y0),
    }
}

/// Columns or rows of an enlarged frame.
struct Side {
    factor: f32,
    /// Start of the first pixel relative to that of the original, in pixels of the enlarged frame; 0 for whole factors.
    shift: f32,
    /// Number of samples of the original.
    count: usize,
}

impl Side {
    /// The axis of a frame whose data and display windows start at `data` and `display`, with `count` pixels.
    fn new([data, display]: [i32; 2], count: usize, factor: f64) -> Self {
        let before = i64::from(data) - i64::from(display);
        Self {
            factor: factor as f32,
            shift: (whole(before, factor) as f64 - before as f64 * factor) as f32,
            count,
        }
    }

    /// Position of the centre of pixel `at` in the original.
    fn place(&self, at: usize) -> Place {
        let at = (at as f32 + 0.5 + self.shift) / self.factor - 0.5;
        let inside = |i: f32| (i.max(0.0) as usize).min(self.count - 1);
        let first = at.floor();
        ([inside(first), inside(first + 1.0)], at - first)
    }
}

/// A plane of `sample(x, y)`, rows in parallel, of the rows that begin while it `goes_on`.
fn samples<T: Copy + Default + Send>(
    [width, height]: [usize; 2],
    goes_on: &(dyn Fn() -> bool + Sync),
    sample: impl Fn(usize, usize) -> T + Sync,
) -> Plane<T> {
    Plane::of_rows(width, height, |y, row| {
        let row = if goes_on() { row } else { &mut [] };
        for (x, out) in row.iter_mut().enumerate() {
            *out = sample(x, y);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Two planes, one at depth 1 on the left of column 4 and one at depth 2; a filter mixed their normals where they meet.
    fn step() -> Frame {
        let left = DVec3::new(0.6, 0.0, 0.8);
        let normal = Vector3Planes::from_fn(8, 4, |x, _| match x {
            0..3 => left,
            3..5 => (left + DVec3::Z).normalize(),
            _ => DVec3::Z,
        });
        let mask = Mask::new(Plane::from_fn(8, 4, |x, _| x > 0));
        // Lengths are those of two normals at 60 degrees in column 6.
        let length = |x: usize| match x {
            3 | 4 => 0.9,
            6 => 30.0_f32.to_radians().cos(),
            _ => 1.0,
        };
        Frame {
            normal_length: Some(Plane::from_fn(8, 4, |x, _| length(x))),
            depth: Some(Plane::from_fn(8, 4, |x, _| if x < 4 { 1.0 } else { 2.0 })),
            ..Frame::of_normals(normal, mask)
        }
    }

    #[test]
    fn surfaces_stay_apart_and_their_normals_unit() {
        let frame = step().enlarged(3.0);
        assert_eq!((frame.mask.width(), frame.mask.height()), (24, 12));
        // Column 1 begins at pixel 3, column 4 at pixel 12.
        assert_eq!(frame.mask.span(5), 3..24);
        for x in 3..24 {
            let [depth, nx] = if x < 12 { [1.0, 0.6] } else { [2.0, 0.0] };
            assert_eq!(frame.depth.as_ref().unwrap().at(x, 5), depth, "{x}");
            assert!((frame.normal.x.at(x, 5) - nx).abs() < 1e-6, "{x}");
        }
        // An edge of 60 degrees within a pixel is one of 20 degrees within each of three.
        let length = frame.normal_length.unwrap();
        let found = [9, 11, 13, 19].map(|x| length.at(x, 5));
        let expected = [1.0, 1.0, 1.0, 10.0_f32.to_radians().cos()];
        let near = |(a, b): (&f32, f32)| (a - b).abs() < 1e-6;
        assert!(found.iter().zip(expected).all(near), "{found:?}");
    }

    #[test]
    fn a_floor_stays_a_floor_to_its_horizon() {
        // The inverse of its depth is linear over the picture: from row to row depth falls to a third, to three fifths ...
        let floor = Frame {
            depth: Some(Plane::from_fn(6, 3, |x, _| 300.0 / (x as f32 + 0.5))),
            ..Frame::of_normals(
                Vector3Planes::from_fn(6, 3, |_, _| DVec3::Z),
                Mask::full(6, 3),
            )
        };
        let depth = floor.enlarged(2.0).depth.unwrap();
        // Pixel x maps to (x + 1/2)/2 - 1/2 of the original; beyond its outer centres values are clamped.
        for x in 1..11 {
            let expected = 600.0 / (x as f32 + 0.5);
            assert!((depth.at(x, 3) / expected - 1.0).abs() < 1e-5, "{x}");
        }
        assert_eq!(floor.enlarged(1.0).normal, floor.normal);
    }

    #[test]
    fn a_factor_need_not_be_whole() {
        let mut ramp = Frame {
            depth: Some(Plane::from_fn(6, 4, |x, _| 1e4 / (100.0 + x as f32))),
            ..Frame::of_normals(
                Vector3Planes::from_fn(6, 4, |_, _| DVec3::Z),
                Mask::full(6, 4),
            )
        };
        // Of 10 columns from -3, 6 from the second on: at 2.5 the whole starts at -7.5, rounded to -8.
        ramp.display_window = Window::at(-3, 0, 10, 4);
        ramp.data_window = Window::at(-2, 0, 6, 4);
        let large = ramp.enlarged(2.5);
        assert_eq!(large.display_window, Window::at(-8, 0, 25, 10));
        // Columns from 2.5 to 17.5 of the whole: pixels 2 to 17.
        assert_eq!(large.data_window, Window::at(-6, 0, 15, 10));
        let depth = large.depth.unwrap();
        for x in 2..13 {
            // Pixel x starts at 2 + x of the whole, half a pixel before its position from 2.5.
            let expected = 1e4 / (100.0 + x as f32 / 2.5 - 0.5);
            assert!((depth.at(x, 3) - expected).abs() < 1e-4, "{x}");
        }
    }
}
