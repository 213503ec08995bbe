//! Enlarging a frame, for drawings that need more pixels.

use super::{Camera, Frame, Mask, Plane, Vector3Planes, Window};
use rayon::prelude::*;

/// Samples are of one surface where neither is nearer than this share of the other's depth.
const SAME: f32 = 0.965;

impl Frame {
    /// The frame enlarged `factor` times in both directions, in whole pixels, seen by the same camera: samples are
    /// interpolated within surfaces, whose borders stay sharp. Beside a jump of depth, where a filter mixes two surfaces,
    /// normals are those of the pixels around that are of the same surface. Lengths of filtered normals tell of the share
    /// of an edge that an enlarged pixel has.
    ///
    /// # Panics
    /// If `factor` is less than 1.
    pub fn enlarged(&self, factor: f64) -> Frame {
        assert!(factor >= 1.0, "a frame is enlarged");
        if factor == 1.0 {
            return self.clone();
        }
        let (data, display) = (self.data_window, self.display_window);
        let across = Side::new([data.x0, display.x0], data.width(), display.width(), factor);
        let down = Side::new(
            [data.y0, display.y0],
            data.height(),
            display.height(),
            factor,
        );
        let (width, height) = (across.data_length, down.data_length);
        let around = |x, y| self.around(across.place(x), down.place(y));
        let mask = Mask::new(samples(width, height, |x, y| around(x, y).is_some()));
        let plane = |plane: &Plane| {
            samples(width, height, |x, y| match around(x, y) {
                Some(around) => around
                    .iter()
                    .map(|&([x, y], weight)| weight * plane.at(x, y))
                    .sum(),
                None => 0.0,
            })
        };
        let mut frame = Frame {
            data_window: Window::at(across.data_from, down.data_from, width, height),
            display_window: Window::at(
                across.display_from,
                down.display_from,
                across.display_length,
                down.display_length,
            ),
            camera: self.camera.map(|camera| Camera {
                projection: camera.projection.of_pixels(factor.recip()),
                ..camera
            }),
            ..self.with_planes(mask, plane)
        };
        if let Some(is_mixed) = self.beside_jumps() {
            let unmixed = |mixed: &Plane| plane(&self.of_one_surface(mixed, &is_mixed));
            let Vector3Planes { x, y, z } = &self.normal;
            let [x, y, z] = [x, y, z].map(unmixed);
            frame.normal = Vector3Planes { x, y, z };
            frame.normal_length = self.normal_length.as_ref().map(unmixed);
        }
        // An edge within a pixel is spread over several.
        for length in frame.normal_length.iter_mut().flat_map(Plane::samples_mut) {
            *length = (length.clamp(0.0, 1.0).acos() / factor as f32).cos();
        }
        for [x, y, z] in frame.normal.components_mut() {
            let length = (*x * *x + *y * *y + *z * *z).sqrt();
            if length > 0.0 {
                (*x, *y, *z) = (*x / length, *y / length, *z / length);
            }
        }
        frame
    }

    /// The samples around a pixel of the enlarged frame that are of the surface seen there, and their weights, which add up
    /// to 1, of its places across and down; `None` where most of what is around is not covered.
    fn around(&self, across: Place, down: Place) -> Option<[([usize; 2], f32); 4]> {
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

    /// Which pixels are beside a jump of depth, where a filter mixes two surfaces; `None` without depth.
    fn beside_jumps(&self) -> Option<Plane<bool>> {
        let depth = self.depth.as_ref()?;
        let size = [depth.width(), depth.height()];
        Some(samples(size[0], size[1], |x, y| {
            let mut beside = around_pixel([x, y], size, 1).filter(|&[i, k]| self.mask.at(i, k));
            self.mask.at(x, y) && beside.any(|at| !self.is_one_surface([x, y], at))
        }))
    }

    /// A plane whose samples in mixed pixels are taken from those around them that are of the same surface and not mixed:
    /// enlarged, a mixed pixel would be a bend.
    fn of_one_surface(&self, plane: &Plane, is_mixed: &Plane<bool>) -> Plane {
        let size = [plane.width(), plane.height()];
        samples(size[0], size[1], |x, y| {
            if !is_mixed.at(x, y) {
                return plane.at(x, y);
            }
            let (mut sum, mut count) = (0.0, 0.0);
            for [i, k] in around_pixel([x, y], size, 2) {
                let is_pure = self.mask.at(i, k) && !is_mixed.at(i, k);
                if is_pure && self.is_one_surface([x, y], [i, k]) {
                    sum += plane.at(i, k);
                    count += 1.0;
                }
            }
            if count > 0.0 {
                sum / count
            } else {
                plane.at(x, y)
            }
        })
    }

    /// Whether two pixels are of one surface; without depth all are.
    fn is_one_surface(&self, [x, y]: [usize; 2], [i, k]: [usize; 2]) -> bool {
        let depth = self.depth.as_ref();
        depth.is_none_or(|depth| is_one_surface(depth.at(x, y), depth.at(i, k)))
    }

    /// Takes the weight from samples of other surfaces than the one that has most of it.
    fn keep_one_surface(&self, samples: &mut [([usize; 2], f32); 4]) {
        let Some(depth) = &self.depth else {
            return;
        };
        let depths = samples.map(|([x, y], _)| depth.at(x, y));
        let of_surface = |of: f32| -> f32 {
            let same = samples
                .iter()
                .zip(depths)
                .filter(|&(_, d)| is_one_surface(of, d));
            same.map(|((_, weight), _)| weight).sum()
        };
        let weights = depths.map(of_surface);
        let most = (0..4).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let Some(kept) = most
            .map(|most| depths[most])
            .filter(|kept| kept.is_finite())
        else {
            return;
        };
        for ((_, weight), depth) in samples.iter_mut().zip(depths) {
            if !is_one_surface(kept, depth) {
                *weight = 0.0;
            }
        }
    }
}

/// Whether samples at these depths are of one surface.
fn is_one_surface(a: f32, b: f32) -> bool {
    a.min(b) >= SAME * a.max(b)
}

/// The pixels of a plane of this `size` around one, itself left out, that are no more than so many `steps` across and down
/// away in all.
fn around_pixel(
    [x, y]: [usize; 2],
    size: [usize; 2],
    steps: u32,
) -> impl Iterator<Item = [usize; 2]> {
    let near = (-1..=1).flat_map(|down: i32| (-1..=1).map(move |across: i32| [across, down]));
    let near =
        near.filter(move |[a, d]| (1..=steps).contains(&(a.unsigned_abs() + d.unsigned_abs())));
    let places = near.map(move |[a, d]| {
        [
            x.wrapping_add_signed(a as isize),
            y.wrapping_add_signed(d as isize),
        ]
    });
    places.filter(move |[x, y]| *x < size[0] && *y < size[1])
}

/// The two samples about a place along a side, and the share of the second.
type Place = ([usize; 2], f32);

/// Columns or rows of an enlarged frame.
struct Side {
    factor: f32,
    /// Where its first pixel begins, in its pixels from where that of the original does; 0 for whole factors.
    shift: f32,
    /// Samples of the original.
    count: usize,
    data_from: i32,
    data_length: usize,
    display_from: i32,
    display_length: usize,
}

/// By how much of a pixel a length may fall short of a whole number for rounding's sake.
const SHORT_PX: f64 = 0.01;

impl Side {
    /// Of a frame whose data and display windows begin at `data` and `display`, and are so long. Its display window begins
    /// where the original's does, for a camera counts from there.
    fn new([data, display]: [i32; 2], count: usize, shown: usize, factor: f64) -> Self {
        let whole = |length: i64| (length as f64 * factor + SHORT_PX).floor() as i64;
        let clamped = |at: i64| at.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
        let origin = (f64::from(display) * factor).round() as i64;
        let before = i64::from(data) - i64::from(display);
        let from = whole(before);
        Self {
            factor: factor as f32,
            shift: (from as f64 - before as f64 * factor) as f32,
            count,
            data_from: clamped(origin + from),
            data_length: (whole(before + count as i64) - from) as usize,
            display_from: clamped(origin),
            display_length: whole(shown as i64) as usize,
        }
    }

    /// Where the middle of pixel `at` lies.
    fn place(&self, at: usize) -> Place {
        let at = (at as f32 + 0.5 + self.shift) / self.factor - 0.5;
        let inside = |i: f32| (i.max(0.0) as usize).min(self.count - 1);
        let first = at.floor();
        ([inside(first), inside(first + 1.0)], at - first)
    }
}

/// A plane of `sample(x, y)`, rows in parallel.
fn samples<T: Copy + Default + Send>(
    width: usize,
    height: usize,
    sample: impl Fn(usize, usize) -> T + Sync,
) -> Plane<T> {
    let mut plane = Plane::filled(width, height, T::default());
    let rows = plane.samples_mut().par_chunks_mut(width.max(1)).enumerate();
    rows.for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            *out = sample(x, y);
        }
    });
    plane
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
    fn a_slope_stays_a_slope() {
        let slope = Frame {
            depth: Some(Plane::from_fn(6, 3, |x, _| 100.0 + x as f32)),
            ..Frame::of_normals(
                Vector3Planes::from_fn(6, 3, |_, _| DVec3::Z),
                Mask::full(6, 3),
            )
        };
        let depth = slope.enlarged(2.0).depth.unwrap();
        // Pixel x lies at (x + 1/2)/2 - 1/2 of the original; beyond its middles nothing is known.
        for x in 1..11 {
            let expected = 100.0 + (x as f32 + 0.5) / 2.0 - 0.5;
            assert!((depth.at(x, 3) - expected).abs() < 1e-4, "{x}");
        }
        assert_eq!(slope.enlarged(1.0).normal, slope.normal);
    }

    #[test]
    fn a_factor_need_not_be_whole() {
        let mut ramp = Frame {
            depth: Some(Plane::from_fn(6, 4, |x, _| 100.0 + x as f32)),
            ..Frame::of_normals(
                Vector3Planes::from_fn(6, 4, |_, _| DVec3::Z),
                Mask::full(6, 4),
            )
        };
        // Of 10 columns from -3, 6 from column 1 of them: at 2.5 the whole begins at -7.5, which rounds to -8.
        ramp.display_window = Window::at(-3, 0, 10, 4);
        ramp.data_window = Window::at(-2, 0, 6, 4);
        let large = ramp.enlarged(2.5);
        assert_eq!(large.display_window, Window::at(-8, 0, 25, 10));
        // Columns from 2.5 to 17.5 of the whole: pixels 2 to 17.
        assert_eq!(large.data_window, Window::at(-6, 0, 15, 10));
        let depth = large.depth.unwrap();
        for x in 2..13 {
            // Pixel x begins at 2 + x of the whole, half a pixel before its place from 2.5.
            let expected = 100.0 + x as f32 / 2.5 - 0.5;
            assert!((depth.at(x, 3) - expected).abs() < 1e-4, "{x}");
        }
    }
}
