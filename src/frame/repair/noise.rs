//! Removes noise from stored normals.
//!
//! The slopes of a surface are the gradient of its height, which has no curl; those of noise have as much curl as
//! divergence. So slopes are split into octaves of detail, and of each the share is removed that is noise by the curl
//! and the divergence around. Which way y is stored need not be known: the lower curl and the higher divergence of both
//! readings count, so that noise is missed rather than a surface smoothed.

use super::unrounded::{double_row, halved, smoothed, unwritten, with_margins};
use crate::frame::{Plane, Vector3Planes, Window, each_row_of};

/// Octaves of detail looked at: of 1 to 4 pixels.
const OCTAVES: usize = 3;

/// Side of the cells, in pixels of the octave, that squares of curl and divergence are summed over; 3x3 cells are
/// compared.
const CELL: usize = 4;

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

/// Number of rows within which a normal can affect another: 19 of the widest octave, and those that are halved to it.
pub(crate) const DENOISING_REACH: usize = 24 << (OCTAVES - 1);

/// Removes the noise of vectors stored as `(n + 1) / 2`, whose left and right borders continue each other, or top and
/// bottom. Vectors with all components 0 were never written, and stay.
pub(crate) fn denoise(stored: &mut Vector3Planes, wraps: [bool; 2]) {
    let unwritten = unwritten(stored);
    let whole = Window::from_size(stored.x.width(), stored.x.height());
    let around = with_margins(whole, DENOISING_REACH, wraps);
    let Vector3Planes { x, y, z } = stored;
    let run = |z: f32| (2.0 * z - 1.0).abs().max(LEAST_Z);
    for plane in [&mut *x, &mut *y] {
        plane.each_with(z, |code, z| *code = (2.0 * *code - 1.0) / run(z));
        unwritten.iter().for_each(|&i| plane.samples_mut()[i] = 0.0);
        *plane = plane.repeated(whole, around);
    }
    quieten([x, y], OCTAVES);
    for plane in [x, y] {
        *plane = plane.crop(around, whole);
        plane.each_with(z, |slope, z| *slope = 0.5 * (*slope * run(z) + 1.0));
        unwritten.iter().for_each(|&i| plane.samples_mut()[i] = 0.0);
    }
}

/// Removes the noise of slopes in so many octaves.
fn quieten([p, q]: [&mut Plane; 2], octaves: usize) {
    if octaves == 0 || p.width().min(p.height()) <= 2 * BORDER {
        return;
    }
    let [mut half_p, mut half_q] = [halved(p), halved(q)];
    // What halving takes off is detail of this octave.
    for (plane, half) in [(&mut *p, &half_p), (&mut *q, &half_q)] {
        change_rows(plane, half, |detail, low| *detail -= low);
    }
    let share = share_of_noise(p, q);
    quieten([&mut half_p, &mut half_q], octaves - 1);
    for (plane, half) in [(p, half_p), (q, half_q)] {
        change_rows(plane, &share, |detail, share| *detail -= share * *detail);
        change_rows(plane, &half, |detail, low| *detail += low);
    }
}

/// Changes each sample of a plane by that of another of half the size.
fn change_rows(plane: &mut Plane, half: &Plane, change: impl Fn(&mut f32, f32) + Sync) {
    plane.each_row(|y, row| {
        let mut double = vec![0.0; row.len()];
        double_row(half, y, &mut double);
        row.iter_mut()
            .zip(double)
            .for_each(|(sample, double)| change(sample, double));
    });
}

/// How much of the details of slopes is noise, 0 to 1, at half the size.
fn share_of_noise(p: &Plane, q: &Plane) -> Plane {
    let size = [p.width(), p.height()];
    let [columns, rows] = size.map(|side| side.div_ceil(CELL));
    let [last_x, last_y] = size.map(|side| side - BORDER);
    // Where p, q change by px, qx along x and by py, qy along y: px^2 + qy^2, px qy, py^2 + qx^2, py qx.
    let mut sums = [(); 4].map(|()| Plane::filled(columns, rows, 0.0));
    each_row_of(sums.each_mut(), |cell, mut sums| {
        // Cells lie around every fourth pixel, as halving places them.
        let [first, last] = [cell, cell + 1].map(|cell| (CELL * cell).saturating_sub(CELL / 2));
        for y in first.max(BORDER)..last.min(last_y) {
            let [[p_above, p, p_below], [q_above, q, q_below]] =
                [p, q].map(|plane| [y - 1, y, y + 1].map(|y| plane.row(y)));
            for x in BORDER..last_x {
                let (px, py) = (p[x + 1] - p[x - 1], p_below[x] - p_above[x]);
                let (qx, qy) = (q[x + 1] - q[x - 1], q_below[x] - q_above[x]);
                let products = [px * px + qy * qy, px * qy, py * py + qx * qx, py * qx];
                let cell = ((x + CELL / 2) / CELL).min(columns - 1);
                for (sum, product) in sums.iter_mut().zip(products) {
                    sum[cell] += product;
                }
            }
        }
    });
    let [divergence, both_divergence, curl, mut share] = sums.each_ref().map(smoothed);
    share.each_row(|y, row| {
        let [d, dd, c] = [&divergence, &both_divergence, &curl].map(|plane| plane.row(y));
        for (x, share) in row.iter_mut().enumerate() {
            // The squared divergence with y either way is divergence +- 2 both, and the curl likewise.
            let ratio =
                (c[x] - 2.0 * share.abs()) / (d[x] + 2.0 * dd[x].abs()).max(f32::MIN_POSITIVE);
            let [surface, noise] = SHARES;
            let is_noise = ((ratio - surface) / (noise - surface)).clamp(0.0, 1.0);
            let mean = (c[x] + d[x]) / (CELL * CELL) as f32;
            *share = is_noise * (2.0 - mean / LARGE).clamp(0.0, 1.0);
        }
    });
    let [width, height] = size.map(|side| side.div_ceil(2));
    Plane::of_rows(width, height, |y, row| double_row(&share, y, row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Window;
    use glam::{DVec3, Vec3};

    /// Normals of slopes, stored.
    fn stored(size: [usize; 2], mut slopes: impl FnMut(usize, usize) -> [f64; 2]) -> Vector3Planes {
        Vector3Planes::from_fn(size[0], size[1], |x, y| {
            let [p, q] = slopes(x, y);
            0.5 * (DVec3::new(-p, -q, 1.0).normalize() + 1.0)
        })
    }

    /// Noise of slopes, evenly within .05: a deviation of .05 / sqrt(12) = .0144.
    fn noisy(size: [usize; 2]) -> Vector3Planes {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        stored(size, |_, _| [0.05 * random(), 0.05 * random()])
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
            denoise(&mut quiet, [false; 2]);
            assert!(largest_change(&quiet, &surface) < 1e-4);
        }
        for size in [[1, 1], [1, 50], [50, 1], [7, 9]] {
            let flat = stored(size, |_, _| [0.0; 2]);
            let mut quiet = flat.clone();
            denoise(&mut quiet, [true; 2]);
            assert_eq!(quiet, flat);
        }
    }

    #[test]
    fn noise_goes_and_what_was_never_written_stays() {
        let mut noisy = noisy([160, 160]);
        for plane in [&mut noisy.x, &mut noisy.y, &mut noisy.z] {
            plane.row_mut(80)[80] = 0.0;
        }
        denoise(&mut noisy, [true; 2]);
        assert_eq!(noisy.at(80, 80), DVec3::ZERO);
        let written = noisy.vectors().filter(|&code| code != Vec3::ZERO);
        let slopes = written.map(|code| (2.0 * code - 1.0).truncate());
        let left: f32 = slopes.map(|slope| slope.length_squared()).sum();
        let left = (left / (2.0 * 160.0 * 160.0)).sqrt();
        assert!(left < 0.3 * 0.0144, "{left}");
    }

    #[test]
    fn rows_apart_and_moved_tiles_are_those_of_the_whole() {
        let part = |of: &Vector3Planes, part: Window| {
            let whole = Window::from_size(of.x.width(), of.x.height());
            let [x, y, z] = [&of.x, &of.y, &of.z].map(|plane| plane.repeated(whole, part));
            Vector3Planes { x, y, z }
        };
        let codes = noisy([64, 320]);
        let [mut whole, mut apart] = [codes.clone(), part(&codes, Window::at(0, 32, 64, 288))];
        denoise(&mut whole, [false; 2]);
        denoise(&mut apart, [false; 2]);
        let reach = DENOISING_REACH as i32;
        let rows = part(&apart, Window::at(0, reach, 64, 40));
        assert_eq!(rows, part(&whole, Window::at(0, 32 + reach, 64, 40)));
        // A tile that starts elsewhere, by as many pixels as halvings and cells take together, is the same tile.
        let moved = Window::at(16, 48, 64, 320);
        let [mut tile, mut elsewhere] = [codes.clone(), part(&codes, moved)];
        denoise(&mut tile, [true; 2]);
        denoise(&mut elsewhere, [true; 2]);
        assert_eq!(elsewhere, part(&tile, moved));
    }
}
