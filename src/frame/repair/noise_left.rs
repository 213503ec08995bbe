//! Whether the normals of a surface have noise that would be taken for relief.
//!
//! As in [`denoise`](super::denoise), noise has as much curl as divergence, and a surface little of it. Here only the
//! finest detail counts, in blocks spread over the surface, so that bends and outlines do not: that is evidence enough
//! for a warning, at any strength of noise, and nothing is changed.

use crate::frame::{Mask, Plane, Vector3Planes};
use crate::kernel::quantile::quantile;

/// Blocks looked at, about, and their side in pixels.
const BLOCKS: usize = 50;
const SIDE: usize = 32;

/// Pixels of a surface that are enough to tell.
const LEAST_PIXELS: usize = 16 * SIDE * SIDE;

/// Pixels of a block from which on it counts, of [`SIDE`] squared.
const LEAST_SEEN: usize = 300;

/// Slopes are of normals with at least this z.
const LEAST_Z: f32 = 0.25;

/// Curl as a share of divergence from which on a block is noise: renders tried without noise have more in at most a
/// fifth of their blocks, which outlines cross, and noise of .01 on them has .6 to .9 in most.
const NOISY: f32 = 0.6;

/// Deviation of slopes from which on it shows as relief. Renders of few samples, smooth to the eye, have up to .004.
const LEAST_NOISE: f32 = 0.005;

/// Share of the blocks that must be noisy.
const SHARE: f64 = 0.4;

/// The deviation of slopes that is noise, in the median of the blocks that have noise; `None` if few do.
pub(crate) fn noise_left(normal: &Vector3Planes, mask: &Mask) -> Option<f32> {
    if mask.count() < LEAST_PIXELS {
        return None;
    }
    let blocks: Vec<_> = mask
        .sample(BLOCKS)
        .filter_map(|center| curl_and_divergence(normal, mask, center))
        .collect();
    let is_noisy =
        |[curl, divergence]: &[f32; 2]| *curl >= LEAST_NOISE && *curl > NOISY * divergence;
    let mut noisy: Vec<f32> = blocks
        .iter()
        .filter(|b| is_noisy(b))
        .map(|b| b[0])
        .collect();
    let is_noise = noisy.len() as f64 >= SHARE * blocks.len() as f64;
    quantile(&mut noisy, 0.5, f32::total_cmp).filter(|_| is_noise)
}

/// Deviations of slopes that would have the curl, and the divergence, of the finest detail of a block, by the way of
/// reading y that has less curl; the divergence of little curl is not looked at.
fn curl_and_divergence(
    normal: &Vector3Planes,
    mask: &Mask,
    (x, y): (usize, usize),
) -> Option<[f32; 2]> {
    let [left, top] = [x, y].map(|center| center.saturating_sub(SIDE / 2));
    let [width, height] = [SIDE.min(mask.width() - left), SIDE.min(mask.height() - top)];
    // What is not seen is no number, and neither is what is made of it.
    let of_block = |value: &dyn Fn(usize, usize) -> f32| {
        Plane::from_fn(width, height, |x, y| value(left + x, top + y))
    };
    let run = of_block(&|x, y| {
        let z = normal.z.at(x, y);
        if mask.at(x, y) && z >= LEAST_Z {
            z
        } else {
            f32::NAN
        }
    });
    let slope = |of: &Plane| {
        let mut slope = of_block(&|x, y| of.at(x, y));
        slope.each_with(&run, |slope, run| *slope /= run);
        slope
    };
    let [p, q] = [&normal.x, &normal.y].map(slope);
    let [along_x, along_y] = [[1, 0], [0, 1]];
    let detail = |slope: &Plane, along| finest(&change(slope, along));
    let deviation = |of_p: &Plane, of_q: &Plane, sign: f32| {
        let both = of_p.samples().iter().zip(of_q.samples());
        let sizes = both
            .zip(run.samples())
            .map(|((p, q), z)| ((p + sign * q) * z).abs());
        let mut sizes: Vec<f32> = sizes.filter(|size| size.is_finite()).collect();
        let seen = sizes.len();
        let median = quantile(&mut sizes, 0.5, f32::total_cmp);
        // Differences across two pixels of p and of q, less the mean of four such: 4 (1 + 1/4) times the variance of a
        // slope, and half of a normal distribution is within .6745 of its deviation.
        let median = median.filter(|_| seen >= LEAST_SEEN)?;
        Some(median / (0.6745 * 5_f32.sqrt()))
    };
    let [py, qx] = [detail(&p, along_y), detail(&q, along_x)];
    let [up, down] = [-1.0, 1.0].map(|sign| deviation(&py, &qx, sign));
    let (up, down) = (up?, down?);
    let curl = up.min(down);
    if curl < LEAST_NOISE {
        return Some([curl, f32::INFINITY]);
    }
    let sign = if up <= down { 1.0 } else { -1.0 };
    let divergence = deviation(&detail(&p, along_x), &detail(&q, along_y), sign);
    Some([curl, divergence?])
}

/// The change of a plane across two pixels; no number at its border.
fn change(plane: &Plane, [dx, dy]: [usize; 2]) -> Plane {
    inside(plane, |x, y| {
        plane.at(x + dx, y + dy) - plane.at(x - dx, y - dy)
    })
}

/// A plane less the mean of the four neighbours; no number at its border.
fn finest(plane: &Plane) -> Plane {
    inside(plane, |x, y| {
        let beside = plane.at(x - 1, y) + plane.at(x + 1, y);
        let above_below = plane.at(x, y - 1) + plane.at(x, y + 1);
        plane.at(x, y) - 0.25 * (beside + above_below)
    })
}

/// A plane of the size of another whose border is no number.
fn inside(like: &Plane, value: impl Fn(usize, usize) -> f32) -> Plane {
    let [width, height] = [like.width(), like.height()];
    Plane::from_fn(width, height, |x, y| {
        let is_inside = x > 0 && y > 0 && x + 1 < width && y + 1 < height;
        if is_inside { value(x, y) } else { f32::NAN }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::frames::noise as random;
    use glam::DVec3;

    /// Waves on a ball of radius 150, with noise added to its normals, evenly within `noise`.
    fn ball(noise: f64, sign: f64) -> (Vector3Planes, Mask) {
        let normal = Vector3Planes::from_fn(256, 240, |x, y| {
            let off = [0, 1, 2].map(|i| 2.0 * f64::from(random(x, y, i)) - 1.0);
            let off = DVec3::from_array(off);
            let [x, y] = [(x as f64 - 128.0) / 150.0, (y as f64 - 120.0) / 150.0];
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            let waves = 0.2 * (40.0 * (x + 0.5 * y)).cos();
            let n = DVec3::new(x + waves, y + 0.5 * waves, z).normalize_or_zero();
            let n = n + noise * off;
            DVec3::new(n.x, sign * n.y, n.z).normalize_or_zero()
        });
        let seen = Plane::from_fn(256, 240, |x, y| {
            (x as f64 - 128.0).hypot(y as f64 - 120.0) < 110.0
        });
        (normal, Mask::new(seen))
    }

    #[test]
    fn noise_is_told_from_relief_whichever_way_y_points() {
        for sign in [1.0, -1.0] {
            let (normal, mask) = ball(0.0, sign);
            assert_eq!(noise_left(&normal, &mask), None);
            // Evenly within .05: a deviation of .05 / sqrt(3) = .029.
            let (normal, mask) = ball(0.05, sign);
            let found = noise_left(&normal, &mask).unwrap();
            assert!((found / 0.029 - 1.0).abs() < 0.25, "{found}");
        }
    }

    #[test]
    fn small_and_empty_frames_have_none() {
        for size in [0, 1, 2, 7] {
            let normal = Vector3Planes::from_fn(size, size, |_, _| DVec3::Z);
            assert_eq!(noise_left(&normal, &Mask::full(size, size)), None);
        }
    }
}
