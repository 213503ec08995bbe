//! Line integral convolution: noise smeared along directions shows where they lead.

use crate::frame::{Mask, Plane, Vector2Planes};

/// Pixels to either side along which noise is averaged.
const REACH: usize = 12;

/// How much of the grey between black and white the averages are spread over: what is left of even noise, averaged over
/// so many pixels, deviates by about 1 / sqrt(12 (2 REACH + 1)).
const SPREAD: f32 = 3.5;

/// Grey 0..1 that runs along `directions`, x right and y up, each equal to its opposite; white where nothing is covered.
pub(super) fn along(directions: &Vector2Planes, mask: &Mask) -> Plane {
    let (width, height) = (mask.width(), mask.height());
    let mut smeared = Plane::filled(width, height, 1.0);
    smeared.each_row(|y, row| {
        let covered = mask.row(y);
        for x in mask.span(y).filter(|&x| covered[x]) {
            let mut sum = noise(x, y);
            let mut count = 1.0;
            for sign in [1.0, -1.0] {
                walk(directions, mask, [x, y], sign, |x, y| {
                    sum += noise(x, y);
                    count += 1.0;
                });
            }
            row[x] = (0.5 + SPREAD * (sum / count - 0.5)).clamp(0.0, 1.0);
        }
    });
    smeared
}

/// Visits the pixels along a direction, as far as there is one.
fn walk(
    directions: &Vector2Planes,
    mask: &Mask,
    [x, y]: [usize; 2],
    sign: f32,
    mut visit: impl FnMut(usize, usize),
) {
    let at = |x: usize, y: usize| [directions.x.at(x, y), -directions.y.at(x, y)];
    let mut heading = at(x, y).map(|d| sign * d);
    let (mut px, mut py) = (x as f32 + 0.5, y as f32 + 0.5);
    for _ in 0..REACH {
        px += heading[0];
        py += heading[1];
        let (x, y) = (px.floor(), py.floor());
        let inside = x >= 0.0 && y >= 0.0 && x < mask.width() as f32 && y < mask.height() as f32;
        if !inside || !mask.at(x as usize, y as usize) {
            return;
        }
        let (x, y) = (x as usize, y as usize);
        visit(x, y);
        let next = at(x, y);
        let along = next[0] * heading[0] + next[1] * heading[1];
        if along == 0.0 {
            return;
        }
        // A direction is equal to its opposite: go on, not back.
        heading = next.map(|d| d * along.signum());
    }
}

/// Even noise, 0..1, the same for the same pixel.
fn noise(x: usize, y: usize) -> f32 {
    let mut bits = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    bits ^= bits >> 15;
    bits = bits.wrapping_mul(0x2c1b_3c6d);
    bits ^= bits >> 13;
    (bits >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_changes_less_along_the_directions_than_across() {
        let (width, height) = (64, 64);
        let directions = Vector2Planes {
            x: Plane::filled(width, height, 1.0),
            y: Plane::filled(width, height, 0.0),
        };
        let grey = along(&directions, &Mask::full(width, height));
        let change = |dx: usize, dy: usize| -> f32 {
            let pixels = (16..48).flat_map(|y| (16..48).map(move |x| (x, y)));
            pixels
                .map(|(x, y)| (grey.at(x, y) - grey.at(x + dx, y + dy)).abs())
                .sum()
        };
        // Neighbours along share all but two of 25 samples: the change is about sqrt(1/25) of that across.
        assert!(change(1, 0) < 0.35 * change(0, 1));
    }
}
