//! Creases: lines along which the surface turns fastest, where it turns sharply.

use crate::frame::{Frame, Plane};
use crate::line::contours::ground::Ground;
use crate::line::contours::log_depth_of;
use crate::line::contours::network::Line;
use crate::line::contours::ridge;
use crate::line::contours::smoothing::Smoothing;
use crate::line::interior::crests::{Crest, crest, each_pixel};
use crate::line::turning::Turning;
use crate::params::ContourParams;
use glam::Vec3A;

/// Distance of a crest from the crease, in pixels of the frame before it was enlarged.
const OFF: f32 = 0.5;

/// The lines along creases that keep away from silhouettes.
pub(crate) fn lines(
    [weight, silhouette]: [&Plane; 2],
    silhouettes: &Ground,
    frame: &Frame,
    params: &ContourParams,
) -> Vec<Line> {
    let surface = TurningSurface {
        frame,
        silhouette,
        apart: (params.step_px.round() as usize).max(1),
    };
    let (crests, corners) = surface.crests(weight, silhouettes);
    let size = [frame.mask.width(), frame.mask.height()];
    let log_depth = |pixel: u32| log_depth_of(frame, pixel as usize).unwrap_or(0.0);
    ridge::lines(
        &crests,
        &corners,
        size,
        log_depth,
        Smoothing::of(params, OFF),
    )
}

/// A surface that ends at silhouettes.
struct TurningSurface<'a> {
    frame: &'a Frame,
    /// The weight of silhouettes.
    silhouette: &'a Plane,
    /// Distance of the normals compared, in pixels.
    apart: usize,
}

impl TurningSurface<'_> {
    /// The crests of the rate of turning where there is a `weight`, and the pixels of corners, which join them, in order.
    fn crests(&self, weight: &Plane, silhouettes: &Ground) -> (Vec<Crest>, Vec<u32>) {
        let mask = &self.frame.mask;
        let turns = each_pixel(mask, |x, y| {
            (weight.at(x, y) > 0.0).then(|| ([x, y], self.turning(x, y)))
        });
        let mut rate = Plane::filled(mask.width(), mask.height(), 0.0);
        for ([x, y], turning) in &turns {
            rate.row_mut(*y)[*x] = turning.largest();
        }
        let (mut crests, mut corners) = (Vec::new(), Vec::new());
        for ([x, y], turning) in turns {
            let pixel = y * mask.width() + x;
            let is_free = silhouettes.is_free(pixel);
            match crest(&rate, x, y, turning.direction(), || weight.at(x, y)) {
                Some(crest) if is_free => crests.push(crest),
                None if is_free && turning.is_both_ways() => corners.push(pixel as u32),
                _ => {}
            }
        }
        (crests, corners)
    }

    /// Twice the turning at a pixel, over two distances: over one it would be even where an edge is half as wide as that.
    fn turning(&self, x: usize, y: usize) -> Turning {
        let apart = [self.apart, self.apart.div_ceil(2)];
        let ahead = |way| apart.map(|apart| self.ahead([x, y], way, apart) / apart as f32);
        let row = |down| [-1, 0, 1].map(|across| ahead([across, down]).into_iter().sum());
        Turning::amid([row(-1), row(0), row(1)])
    }

    /// The normal so many steps ahead, or the last before a silhouette.
    fn ahead(&self, [mut x, mut y]: [usize; 2], [across, down]: [isize; 2], steps: usize) -> Vec3A {
        for _ in 0..steps {
            let there = [x.wrapping_add_signed(across), y.wrapping_add_signed(down)];
            if !self.frame.mask.has(there[0], there[1])
                || self.silhouette.at(there[0], there[1]) > 0.0
            {
                break;
            }
            [x, y] = there;
        }
        self.frame.normal.at(x, y).as_vec3a()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes};
    use glam::{DVec3, Vec2};

    #[test]
    fn both_edges_of_a_narrow_bevel_are_lines() {
        // Three columns, from 20 on, are turned by 60 degrees; enlarged four times they reach from 80 to 92. The edges
        // lie half-way between the centres of pixels, where normals are interpolated.
        let slanted = DVec3::new(60.0_f64.to_radians().sin(), 0.0, 0.5);
        let normal = |x: usize, _| {
            if (20..23).contains(&x) {
                slanted
            } else {
                DVec3::Z
            }
        };
        let frame = Frame::of_normals(Vector3Planes::from_fn(44, 30, normal), Mask::full(44, 30));
        let frame = frame.enlarged(4.0);
        let size = [frame.mask.width(), frame.mask.height()];
        let params = ContourParams::default().enlarged(4.0);
        let none = Ground::of_points(std::iter::empty::<Vec<Vec2>>(), size, 1);
        let plane = |weight: f32| Plane::filled(size[0], size[1], weight);
        let lines = lines([&plane(1.0), &plane(0.0)], &none, &frame, &params);
        assert_eq!(lines.len(), 2);
        for spot in lines.iter().flat_map(|line| &line.spots) {
            let off = [80.0, 92.0].map(|edge| (spot.at.x - edge).abs());
            assert!(off[0].min(off[1]) < 0.5, "{}", spot.at);
        }
    }
}
