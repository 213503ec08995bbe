//! Removes noise from stored normals.
//!
//! The slopes of a surface are the gradient of its height, which has no curl; those of noise have as much curl as
//! divergence. So slopes are split into octaves of detail, and of each the share is removed that is noise by the curl
//! and the divergence around. Which way y is stored need not be known: the lower curl and the higher divergence of both
//! readings count, so that noise is missed rather than a surface smoothed.

use super::unrounded::{double_row, halved};
use super::{Plane, Vector3Planes, Window};
use glam::{Vec2, Vec3};

/// Octaves of detail looked at: of 1 to 4 pixels.
const OCTAVES: usize = 3;

/// Squares of curl and divergence are compared after so many halvings: over a Gaussian of 2.2 pixels of the octave.
const HALVINGS: usize = 2;

/// Curl as a share of divergence, both squared, at which an octave is a surface, and at which it is noise. White noise
/// has .83 (1, were it not for the choice between two readings), scans of rock, brick and stone up to .2.
const SHARES: [f32; 2] = [0.5, 0.8];

/// Sum of squared differences of slopes across two pixels up to which they can be noise, and of twice as large ones they
/// are not: noise of a deviation of .03 has .005, outlines have more.
const LARGE: f32 = 0.01;

/// Pixels at the border of an octave that do not count: there it is not known how slopes go on.
const BORDER: usize = 3;

/// Slopes are of normals with at least this z.
const LEAST_Z: f32 = 0.1;

/// Number of rows within which a normal can affect another: 23 of the widest octave, and those that are halved to it.
pub(crate) const DENOISING_REACH: usize = 32 << (OCTAVES - 1);

/// Removes the noise of vectors stored as `(n + 1) / 2`, whose left and right borders continue each other, or top and
/// bottom. Vectors with all components 0 were never written, and stay. Returns the root mean square of the noise of a slope.
pub(crate) fn denoise(stored: &mut Vector3Planes, wraps: [bool; 2]) -> f32 {
    let whole = Window::from_size(stored.x.width(), stored.x.height());
    let [mx, my] = wraps.map(|wraps| if wraps { DENOISING_REACH as i32 } else { 0 });
    let around = Window {
        x0: -mx,
        y0: -my,
        x1: whole.x1 + mx,
        y1: whole.y1 + my,
    };
    let slopes = [0, 1].map(|axis| {
        let mut slopes = stored.z.clone();
        slopes.each_row(|y, row| {
            for (x, slope) in row.iter_mut().enumerate() {
                *slope = slope_of(stored.at(x, y).as_vec3())[axis];
            }
        });
        slopes.repeated(whole, around)
    });
    let noise = noise(&slopes, OCTAVES);
    let Vector3Planes { x, y, z } = stored;
    super::plane::each_row_of([x, y, z], |row, [x, y, z]| {
        let noise = noise
            .each_ref()
            .map(|plane| &plane.row(row + my as usize)[mx as usize..]);
        for i in 0..x.len() {
            let (code, noise) = (
                Vec3::new(x[i], y[i], z[i]),
                Vec2::new(noise[0][i], noise[1][i]),
            );
            if noise != Vec2::ZERO && code != Vec3::ZERO {
                let n = 2.0 * code - 1.0;
                let quiet = n - (noise * n.z.abs().max(LEAST_Z)).extend(0.0);
                let code = 0.5 * (quiet.normalize_or_zero() * n.length() + 1.0);
                (x[i], y[i]) = (code.x, code.y);
                z[i] = code.z;
            }
        }
    });
    let squares = noise
        .iter()
        .flat_map(Plane::samples)
        .map(|&noise| f64::from(noise).powi(2));
    (squares.sum::<f64>() / (noise[0].samples().len() * 2).max(1) as f64).sqrt() as f32
}

/// The slopes of a stored vector, up to their sign; 0 if it was never written.
fn slope_of(code: Vec3) -> Vec2 {
    let n = 2.0 * code - 1.0;
    match code == Vec3::ZERO {
        true => Vec2::ZERO,
        false => n.truncate() / n.z.abs().max(LEAST_Z),
    }
}

/// The noise of slopes in so many octaves.
fn noise(slopes: &[Plane; 2], octaves: usize) -> [Plane; 2] {
    let size = [slopes[0].width(), slopes[0].height()];
    if octaves == 0 || size.iter().any(|&side| side <= 2 * BORDER) {
        return slopes.each_ref().map(|plane| plane.map(|_| 0.0));
    }
    let halves = slopes.each_ref().map(halved);
    let details = [0, 1].map(|axis| {
        let mut detail = doubled(&halves[axis], size);
        detail.each_row(|y, row| {
            for (detail, slope) in row.iter_mut().zip(slopes[axis].row(y)) {
                *detail = slope - *detail;
            }
        });
        detail
    });
    let share = share_of_noise(&details);
    let wider = noise(&halves, octaves - 1);
    [0, 1].map(|axis| {
        let mut noise = doubled(&wider[axis], size);
        noise.each_row(|y, row| {
            let own = details[axis].row(y).iter().zip(share.row(y));
            for (noise, (detail, share)) in row.iter_mut().zip(own) {
                *noise += share * detail;
            }
        });
        noise
    })
}

/// How much of the details of slopes is noise, 0 to 1.
fn share_of_noise([p, q]: &[Plane; 2]) -> Plane {
    let mut sizes = vec![[p.width(), p.height()]];
    let mut around = |of: fn([f32; 4]) -> f32| {
        let mut squares = p.map(|_| 0.0);
        let [last_x, last_y] = sizes[0].map(|side| side - BORDER);
        squares.each_row(|y, row| {
            if !(BORDER..last_y).contains(&y) {
                return;
            }
            let [rows_p, rows_q] = [p, q].map(|plane| [y - 1, y, y + 1].map(|y| plane.row(y)));
            for x in BORDER..last_x {
                let change = |[above, own, below]: [&[f32]; 3]| {
                    [own[x + 1] - own[x - 1], below[x] - above[x]]
                };
                let ([px, py], [qx, qy]) = (change(rows_p), change(rows_q));
                row[x] = of([px, py, qx, qy]);
            }
        });
        sizes.truncate(1);
        for _ in 0..HALVINGS {
            squares = halved(&squares);
            sizes.push([squares.width(), squares.height()]);
        }
        squares
    };
    // The squared divergence with y either way is divergence +- 2 both, and the curl likewise.
    let divergence = around(|[px, _, _, qy]| px * px + qy * qy);
    let both_divergence = around(|[px, _, _, qy]| px * qy);
    let curl = around(|[_, py, qx, _]| py * py + qx * qx);
    let mut share = around(|[_, py, qx, _]| py * qx);
    share.each_row(|y, row| {
        let [d, dd, c] = [&divergence, &both_divergence, &curl].map(|plane| plane.row(y));
        for (x, share) in row.iter_mut().enumerate() {
            let ratio =
                (c[x] - 2.0 * share.abs()) / (d[x] + 2.0 * dd[x].abs()).max(f32::MIN_POSITIVE);
            let [surface, noise] = SHARES;
            let is_noise = ((ratio - surface) / (noise - surface)).clamp(0.0, 1.0);
            *share = is_noise * (2.0 - (c[x] + d[x]) / LARGE).clamp(0.0, 1.0);
        }
    });
    sizes.pop();
    let wider = sizes.iter().rev();
    wider.fold(share, |share, &size| doubled(&share, size))
}

fn doubled(half: &Plane, [width, height]: [usize; 2]) -> Plane {
    let mut double = Plane::filled(width, height, 0.0);
    double.each_row(|y, row| double_row(half, y, row));
    double
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Normals of slopes, stored.
    fn stored(size: [usize; 2], mut slopes: impl FnMut(usize, usize) -> [f64; 2]) -> Vector3Planes {
        Vector3Planes::from_fn(size[0], size[1], |x, y| {
            let [p, q] = slopes(x, y);
            0.5 * (DVec3::new(-p, -q, 1.0).normalize() + 1.0)
        })
    }

    fn largest_change(a: &Vector3Planes, b: &Vector3Planes) -> f64 {
        let changes = a.vectors().zip(b.vectors()).map(|(a, b)| (a - b).length());
        changes.fold(0.0, f32::max).into()
    }

    #[test]
    fn surfaces_stay_whichever_way_y_is_stored() {
        // The gradient of .06 sin(x/2) sin(y/3).
        for sign in [1.0, -1.0] {
            let surface = stored([96, 80], |x, y| {
                let [x, y] = [x as f64 / 2.0, y as f64 / 3.0];
                [0.03 * x.cos() * y.sin(), sign * 0.02 * x.sin() * y.cos()]
            });
            let mut quiet = surface.clone();
            assert!(denoise(&mut quiet, [false; 2]) < 1e-4);
            assert!(largest_change(&quiet, &surface) < 1e-4);
        }
        for size in [[1, 1], [1, 50], [50, 1], [7, 9]] {
            let flat = stored(size, |_, _| [0.0; 2]);
            let mut quiet = flat.clone();
            assert_eq!(denoise(&mut quiet, [true; 2]), 0.0);
            assert_eq!(quiet, flat);
        }
    }

    #[test]
    fn noise_goes_and_what_was_never_written_stays() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        // Evenly within .05: a deviation of .05 / sqrt(12) = .0144.
        let noise = |_: usize, _: usize| [0.05 * random(), 0.05 * random()];
        let mut noisy = stored([160, 160], noise);
        for plane in [&mut noisy.x, &mut noisy.y, &mut noisy.z] {
            plane.row_mut(80)[80] = 0.0;
        }
        let found = denoise(&mut noisy, [true; 2]);
        assert!((found / 0.0144 - 1.0).abs() < 0.2, "{found}");
        assert_eq!(noisy.at(80, 80), DVec3::ZERO);
        let written = noisy.vectors().filter(|&code| code != Vec3::ZERO);
        let left: f32 = written.map(|code| slope_of(code).length_squared()).sum();
        let left = (left / (2.0 * 160.0 * 160.0)).sqrt();
        assert!(left < 0.3 * 0.0144, "{left}");
    }
}
