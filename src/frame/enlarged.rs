//! A frame of more pixels, for drawings that need room.

use super::{Camera, Frame, Mask, Plane, Window};
use rayon::prelude::*;

/// Samples are of one surface where neither is nearer than this share of the other's depth.
const SAME: f32 = 0.965;

impl Frame {
    /// The frame `times` as large both ways, seen by the same camera: samples are interpolated within surfaces, whose
    /// borders stay sharp.
    ///
    /// # Panics
    /// If `times` is 0.
    pub fn enlarged(&self, times: usize) -> Frame {
        assert!(times > 0, "there is something to see");
        if times == 1 {
            return self.clone();
        }
        let (width, height) = (self.mask.width() * times, self.mask.height() * times);
        let covered = samples(width, height, |x, y| self.around(x, y, times).is_some());
        let mask = Mask::new(covered);
        let larger = |window: Window| {
            let scaled = |at: i32| at.saturating_mul(times as i32);
            let (x, y) = (scaled(window.x0), scaled(window.y0));
            Window::at(x, y, window.width() * times, window.height() * times)
        };
        let plane = |plane: &Plane| {
            samples(width, height, |x, y| match self.around(x, y, times) {
                Some(around) => around
                    .iter()
                    .map(|&([x, y], weight)| weight * plane.at(x, y))
                    .sum(),
                None => 0.0,
            })
        };
        let mut frame = Frame {
            data_window: larger(self.data_window),
            display_window: larger(self.display_window),
            camera: self.camera.map(|camera| Camera {
                projection: camera.projection.of_pixels((times as f64).recip()),
                ..camera
            }),
            ..self.with_planes(mask, plane)
        };
        for [x, y, z] in frame.normal.components_mut() {
            let length = (*x * *x + *y * *y + *z * *z).sqrt();
            if length > 0.0 {
                (*x, *y, *z) = (*x / length, *y / length, *z / length);
            }
        }
        frame
    }

    /// The samples around a pixel of the enlarged frame that are of the surface seen there, and their weights, which add up
    /// to 1; `None` where most of what is around is not covered.
    fn around(&self, x: usize, y: usize, times: usize) -> Option<[([usize; 2], f32); 4]> {
        let place = |at: usize, count: usize| {
            let at = (at as f32 + 0.5) / times as f32 - 0.5;
            let inside = |i: f32| (i.max(0.0) as usize).min(count - 1);
            let first = at.floor();
            ([inside(first), inside(first + 1.0)], at - first)
        };
        let ([left, right], across) = place(x, self.mask.width());
        let ([above, below], down) = place(y, self.mask.height());
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

    /// Takes the weight from samples of other surfaces than the one that has most of it.
    fn keep_one_surface(&self, samples: &mut [([usize; 2], f32); 4]) {
        let Some(depth) = &self.depth else {
            return;
        };
        let depths = samples.map(|([x, y], _)| depth.at(x, y));
        let is_same = |a: f32, b: f32| a.min(b) >= SAME * a.max(b);
        let of_surface = |of: f32| -> f32 {
            let same = samples.iter().zip(depths).filter(|&(_, d)| is_same(of, d));
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
            if !is_same(kept, depth) {
                *weight = 0.0;
            }
        }
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
    use crate::frame::Vector3Planes;
    use glam::DVec3;

    /// Two planes, one at depth 1 on the left of column 4 and one at depth 2.
    fn step() -> Frame {
        let normal = Vector3Planes::from_fn(8, 4, |x, _| match x {
            0..4 => DVec3::new(0.6, 0.0, 0.8),
            _ => DVec3::Z,
        });
        let mask = Mask::new(Plane::from_fn(8, 4, |x, _| x > 0));
        Frame {
            depth: Some(Plane::from_fn(8, 4, |x, _| if x < 4 { 1.0 } else { 2.0 })),
            ..Frame::of_normals(normal, mask)
        }
    }

    #[test]
    fn surfaces_stay_apart_and_their_normals_unit() {
        let frame = step().enlarged(3);
        assert_eq!((frame.mask.width(), frame.mask.height()), (24, 12));
        // Column 1 begins at pixel 3, column 4 at pixel 12.
        assert_eq!(frame.mask.span(5), 3..24);
        for x in 3..24 {
            let [depth, nx] = if x < 12 { [1.0, 0.6] } else { [2.0, 0.0] };
            assert_eq!(frame.depth.as_ref().unwrap().at(x, 5), depth, "{x}");
            assert!((frame.normal.x.at(x, 5) - nx).abs() < 1e-6, "{x}");
        }
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
        let depth = slope.enlarged(2).depth.unwrap();
        // Pixel x lies at (x + 1/2)/2 - 1/2 of the original; beyond its middles nothing is known.
        for x in 1..11 {
            let expected = 100.0 + (x as f32 + 0.5) / 2.0 - 0.5;
            assert!((depth.at(x, 3) - expected).abs() < 1e-4, "{x}");
        }
        assert_eq!(slope.enlarged(1).normal, slope.normal);
    }
}
