//! Enlarging a frame, for drawings that need more pixels.

use super::gap::of_frame::parted;
use super::{Camera, Frame, Mask, Plane, Projection, Vector2Planes, Window};
use crate::params::ShapeParams;
use std::cell::Cell;

/// Length of a filtered normal above which it is one surface's: the mean of two at an angle of 16 degrees has it.
const PURE: f32 = 0.99;

impl Frame {
    /// The frame enlarged `factor` times in both directions, rounded to whole pixels, seen by the same camera: samples
    /// are interpolated within surfaces, whose borders stay sharp. Beside a silhouette, where a filter mixes two
    /// surfaces, normals are means of nearby pixels of the same surface. Lengths of filtered normals are rescaled to the
    /// share of an edge within an enlarged pixel. Fur, leaves and fog, whose silhouettes lie closer together than a
    /// drawing can tell apart, become masses with one outline.
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
        let enlarger = Enlarger::new(self, factor);
        let calm = enlarger.parted.as_ref().and_then(|p| self.calmed(p));
        match &calm {
            Some(calm) => calm.enlarged_by(Enlarger::new(calm, factor), goes_on, &begins),
            None => self.enlarged_by(enlarger, goes_on, &begins),
        }
    }

    /// The `motion` of its surface for the frame [enlarged](Self::enlarged) so many times, in pixels of that.
    pub fn enlarged_motion(&self, motion: &Vector2Planes, factor: f64) -> Vector2Planes {
        let enlarger = Enlarger::new(self, factor);
        let enlarged = |plane: &Plane| enlarger.plane(plane, Vector2Planes::AWAY);
        let plane = |plane: &Plane| enlarged(plane).map(|by| by * factor as f32);
        Vector2Planes {
            x: plane(&motion.x),
            y: plane(&motion.y),
        }
    }

    /// The frame enlarged as it is; `begins` is called as each plane does.
    fn enlarged_by(
        &self,
        enlarger: Enlarger,
        goes_on: &(dyn Fn() -> bool + Sync),
        begins: &dyn Fn(),
    ) -> Option<Frame> {
        let enlarger = Enlarger {
            goes_on,
            ..enlarger
        };
        let factor = enlarger.factor;
        let mask = Mask::new(enlarger.samples(|around| around.is_some()));
        let plane = |plane: &Plane| {
            begins();
            enlarger.plane(plane, 0.0)
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
        frame.depth = self.depth.as_ref().map(|depth| enlarger.depth(depth));
        frame.objects = self.objects.as_ref().map(|numbers| {
            let number = |around| heaviest(numbers, &around);
            enlarger.samples(|around| around.map_or(0.0, number))
        });
        if let Some(parted) = &enlarger.parted {
            let is_mixed = enlarger.mixed(parted);
            let unmixed = |mixed: &Plane| plane(&enlarger.of_one_surface(mixed, &is_mixed));
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
        frame.normal.make_unit();
        Some(frame)
    }

    /// How many planes an enlarged frame takes: the mask, its own, and beside silhouettes the normals once more.
    fn planes_to_enlarge(&self) -> usize {
        let count = Cell::new(1);
        self.with_planes(self.mask.clone(), |_| {
            count.set(count.get() + 1);
            Plane::default()
        });
        let again = 3 + usize::from(self.normal_length.is_some());
        count.get() + self.depth.as_ref().map_or(0, |_| again)
    }
}

/// Enlarges planes of a frame.
pub(super) struct Enlarger<'a> {
    frame: &'a Frame,
    factor: f64,
    /// Whether a silhouette lies between a pixel and the next to the right, and the one below; without depth there is none.
    parted: Option<Plane<[bool; 2]>>,
    /// Whether a pixel and those to the right, below, and below to the right are of one surface: nearly everywhere.
    is_even: Plane<bool>,
    goes_on: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Enlarger<'a> {
    /// Enlarges planes of `frame` so many times.
    pub(super) fn new(frame: &'a Frame, factor: f64) -> Self {
        let parted = parted(frame, ShapeParams::default().silhouette);
        let mut enlarger = Self {
            frame,
            factor,
            parted,
            is_even: Plane::default(),
            goes_on: &|| true,
        };
        enlarger.is_even = enlarger.even();
        enlarger
    }

    fn even(&self) -> Plane<bool> {
        let mask = &self.frame.mask;
        Plane::of_pixels(mask.width(), mask.height(), |x, y| {
            let [right, below] = [
                (x + 1).min(mask.width() - 1),
                (y + 1).min(mask.height() - 1),
            ];
            let is_parted = self.parted.as_ref().is_some_and(|parted| {
                let [across, down] = parted.at(x, y);
                across || down || parted.at(x, below)[0] || parted.at(right, y)[1]
            });
            let corners = [[x, y], [right, y], [x, below], [right, below]];
            !is_parted && corners.iter().all(|&[x, y]| mask.at(x, y))
        })
    }

    /// A plane that goes with the frame, enlarged; `outside` where the frame shows nothing.
    pub(super) fn plane(&self, plane: &Plane, outside: f32) -> Plane {
        let mean = |around| mean(plane, &around);
        self.samples(|around| around.map_or(outside, mean))
    }

    /// The depth of the planes through the samples around.
    fn depth(&self, depth: &Plane) -> Plane {
        let mean = |around| self.mean_depth(depth, &around);
        self.samples(|around| around.map_or(0.0, mean))
    }

    /// A plane of the enlarged frame, of the samples around each pixel, as far as it goes on.
    fn samples<T: Copy + Default + Send>(
        &self,
        sample: impl Fn(Option<WeighedSamples>) -> T + Sync,
    ) -> Plane<T> {
        let (data, display) = (self.frame.data_window, self.frame.display_window);
        let across = EnlargedAxis::new([data.x0, display.x0], data.width(), self.factor);
        let down = EnlargedAxis::new([data.y0, display.y0], data.height(), self.factor);
        let window = enlarged(data, display, self.factor);
        let columns: Vec<SamplePair> = (0..window.width()).map(|x| across.place(x)).collect();
        samples([window.width(), window.height()], self.goes_on, |x, y| {
            sample(self.around(columns[x], down.place(y)))
        })
    }

    /// The samples around a pixel of the enlarged frame that belong to the surface seen there, with weights that add up
    /// to 1, from its positions across and down; `None` if most of the samples around are uncovered.
    fn around(&self, across: SamplePair, down: SamplePair) -> Option<WeighedSamples> {
        let ([left, right], across) = across;
        let ([above, below], down) = down;
        let mut samples = [
            ([left, above], (1.0 - across) * (1.0 - down)),
            ([right, above], across * (1.0 - down)),
            ([left, below], (1.0 - across) * down),
            ([right, below], across * down),
        ];
        if !self.is_even.at(left, above) {
            for ([x, y], weight) in &mut samples {
                *weight *= f32::from(u8::from(self.frame.mask.at(*x, *y)));
            }
            let covered: f32 = samples.iter().map(|(_, weight)| weight).sum();
            if covered < 0.5 {
                return None;
            }
            self.keep_one_surface(&mut samples);
        }
        let sum: f32 = samples.iter().map(|(_, weight)| weight).sum();
        samples.iter_mut().for_each(|(_, weight)| *weight /= sum);
        Some(samples)
    }

    /// Removes the weight of samples from surfaces other than the one with most of the weight.
    fn keep_one_surface(&self, samples: &mut WeighedSamples) {
        let weights = samples.map(|(of, _)| -> f32 {
            let same = samples
                .iter()
                .filter(|(at, _)| self.is_one_surface(of, *at));
            same.map(|(_, weight)| weight).sum()
        });
        let most = (0..4).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let kept = most.map_or(samples[0].0, |most| samples[most].0);
        for (at, weight) in samples.iter_mut() {
            if !self.is_one_surface(kept, *at) {
                *weight = 0.0;
            }
        }
    }

    /// Whether two pixels within one column and one row of each other belong to one surface: whether one of the ways from
    /// one to the other crosses no silhouette.
    fn is_one_surface(&self, a: [usize; 2], b: [usize; 2]) -> bool {
        let Some(parted) = &self.parted else {
            return true;
        };
        let is_open = |from: [usize; 2], to: [usize; 2]| match [0, 1].map(|i| from[i] != to[i]) {
            [true, _] => !parted.at(from[0].min(to[0]), from[1])[0],
            [_, true] => !parted.at(from[0], from[1].min(to[1]))[1],
            _ => true,
        };
        let corners = [[a[0], b[1]], [b[0], a[1]]];
        let is_way = |corner: &[usize; 2]| is_open(a, *corner) && is_open(*corner, b);
        corners.iter().any(is_way)
    }

    /// Pixels beside a silhouette that a filter mixes two surfaces in, as far as lengths of normals tell.
    fn mixed(&self, parted: &Plane<[bool; 2]>) -> Plane<bool> {
        let (mask, size) = (&self.frame.mask, [parted.width(), parted.height()]);
        let lengths = self.frame.normal_length.as_ref();
        let is_pure = |x, y| lengths.is_some_and(|lengths| lengths.at(x, y) > PURE);
        samples(size, &|| true, |x, y| {
            let mut beside = around_pixel([x, y], size, 1).filter(|&[i, k]| mask.at(i, k));
            mask.at(x, y) && !is_pure(x, y) && beside.any(|at| !self.is_one_surface([x, y], at))
        })
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
                self.frame.mask.at(i, k)
                    && !is_mixed.at(i, k)
                    && self.is_one_surface([x, y], [i, k])
            };
            let pure = around_pixel([x, y], size, 2).filter(is_pure);
            let add = |(sum, count), [i, k]: [usize; 2]| (sum + plane.at(i, k), count + 1.0);
            match pure.fold((0.0, 0.0), add) {
                (_, 0.0) => plane.at(x, y),
                (sum, count) => sum / count,
            }
        })
    }

    /// What is linear over a plane at this depth: its inverse in perspective. Its own inverse but for depth up to 0.
    fn linear(&self, depth: f32) -> f32 {
        let projection = self.frame.camera.map(|camera| camera.projection);
        let is_parallel = matches!(projection, Some(Projection::Orthographic { .. }));
        if is_parallel || depth <= 0.0 {
            depth
        } else {
            depth.recip()
        }
    }

    /// The depth of the plane through samples around a position.
    fn mean_depth(&self, depth: &Plane, around: &WeighedSamples) -> f32 {
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
}

/// Samples around a position, with their weights.
type WeighedSamples = [([usize; 2], f32); 4];

fn mean(plane: &Plane, around: &WeighedSamples) -> f32 {
    let weighted = around
        .iter()
        .map(|&([x, y], weight)| weight * plane.at(x, y));
    weighted.sum()
}

/// The sample with most weight.
fn heaviest(plane: &Plane, around: &WeighedSamples) -> f32 {
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
type SamplePair = ([usize; 2], f32);

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
struct EnlargedAxis {
    factor: f32,
    /// Start of the first pixel relative to that of the original, in pixels of the enlarged frame; 0 for whole factors.
    shift: f32,
    /// Number of samples of the original.
    count: usize,
}

impl EnlargedAxis {
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
    fn place(&self, at: usize) -> SamplePair {
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
        let samples = row.iter_mut().enumerate();
        samples.for_each(|(x, out)| *out = sample(x, y));
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Vector3Planes;
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
                // The likely focal length is 7.5 pixels and the middle in column 3: the plane is 7.5 x + 3 depth = 300.
                Vector3Planes::from_fn(6, 3, |_, _| DVec3::new(-7.5, 0.0, 3.0).normalize()),
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
