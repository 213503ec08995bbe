//! Line integral convolution: noise smeared along directions makes them visible.

use crate::frame::{Mask, Plane, Vector2Planes};

/// Pixels to either side along which noise is averaged.
const REACH: usize = 12;

/// Contrast of the averages, as a factor: uniform noise averaged over 2 REACH + 1 pixels deviates by only about 1 /
/// sqrt(12 (2 REACH + 1)).
const SPREAD: f32 = 3.5;

/// Grey 0..1 smeared along `directions`, x right and y up, opposite directions being equal; white outside the mask.
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

/// Visits pixels along the directions until they end.
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
        // Opposite directions are equal: pick the one that continues forward.
        heading = next.map(|d| d * along.signum());
    }
}

/// Uniform noise, 0..1, a fixed value for each pixel.
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
        // Neighbours along the direction share all but two of 25 samples: their change is about sqrt(1/25) of that
        // across.
        assert!(change(1, 0) < 0.35 * change(0, 1));
    }
}
