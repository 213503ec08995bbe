//! Confidence that a pixel shows a single surface.
//!
//! In defocus, motion blur, fur and fog a pixel's normal is a mean of different ones, and shorter than 1; its depth is
//! that of the surface hit by its first sample. At outlines the same holds for a pixel or two, so a pixel counts as
//! mixed only where a whole square of normals is short, or many depths around it are isolated.

use super::squares::{around, mean_over_squares, of_rows, over_squares, sum_over_squares};
use super::tiled::{lay_tiles, of_tiles};
use crate::frame::{Frame, Mask, Plane, Projection, Vector3Planes, Window};

/// Half size of the square of normals around a pixel that must be mixed. In sharp renders some 3x3 squares are, at
/// corners of outlines, but no 5x5 ones.
const NORMALS_REACH: usize = 2;

/// Lengths of normals, relative to those around, for confidence 1 and 0. No 5x5 square of the sharp renders tried
/// has all its lengths below 0.94; means of directions 41 degrees to either side have length 0.75.
const LENGTHS: [f32; 2] = [0.93, 0.75];

/// A square whose longest normal has at most the first length is in fog, or blurred; one with a normal of the second
/// length is not. The second is that of [`LENGTHS`], so that sharp frames keep the lengths they have.
const FOG: [f32; 2] = [0.91, LENGTHS[0]];

/// Half size of the square whose longest normals a pixel's normal is compared with: in fog all are short, by the share
/// of their samples that hit it.
const FOG_REACH: usize = 8;

/// Deficit from length 1 of the mean over a square of unit normals, below which short normals do not count, and above
/// which they count in full: for a bend of 8 and of 20 degrees across the square. Near and far objects in fog differ
/// only in length.
const SPREADS: [f32; 2] = [0.001, 0.005];

/// Half size of the square of depths around a pixel, and the number of its pixels.
const DEPTHS_REACH: usize = 5;
const DEPTHS: usize = (2 * DEPTHS_REACH + 1).pow(2);

/// A depth is isolated if both its neighbours along a row or a column differ from it by more than this share of the
/// picture's longer side: a tenth of the distance for a lens of 44 degrees across.
const ALONE: f32 = 0.125;

/// Shares of isolated depths for confidence 1 and 0. No 11x11 square of the sharp renders tried has a share above 0.08.
const SHARES_ALONE: [f32; 2] = [0.1, 0.3];

/// Number of rows within which a sample can affect the confidence: means of the longest normals, squares found, pixels
/// in them, and their mean; or a square, and the neighbours of its depths.
pub(crate) const CONFIDENCE_REACH: usize = FOG_REACH + 4 * NORMALS_REACH;
const _: () = assert!(CONFIDENCE_REACH > DEPTHS_REACH);

/// Confidence that each pixel shows a single surface, 0..1, from the original lengths of normals and from depths;
/// `None` if it is 1 everywhere, as in sharp frames.
pub(crate) fn confidence(frame: &Frame) -> Option<Plane> {
    let lengths = frame.normal_length.as_ref();
    let of_normals = lengths.and_then(|lengths| of_normals(lengths, &frame.normal, &frame.mask));
    let of_depths = frame
        .depth
        .as_ref()
        .and_then(|depth| of_depths(depth, &frame.mask, isolation(frame)));
    match (of_normals, of_depths) {
        (Some(a), Some(b)) => Some(of_two(&a, &b, f32::min)),
        (a, b) => a.or(b),
    }
}

/// Divides normals that fog or blur has shortened, together with all around, by their mean length: a short normal then
/// hides a crease only where it is short among its neighbours.
pub(crate) fn lift_out_of_fog(lengths: &mut Plane, mask: &Mask) {
    let lifted = of_tiles(lengths, NORMALS_REACH, |tile| {
        if !has_short_square(lengths, mask, tile.window) {
            return None;
        }
        let (lengths, mask) = tile.parts(lengths, mask);
        let longest = longest(&ended(&lengths, &mask), NORMALS_REACH);
        let mean = mean_of_covered(&lengths, &covered_in_squares(&mask));
        Some(of_rows(&lengths, |y, row| {
            let squares = longest.row(y).iter().zip(mean.row(y));
            for ((sample, &length), (&longest, &mean)) in
                row.iter_mut().zip(lengths.row(y)).zip(squares)
            {
                let fog = 1.0 - ramp(longest, FOG);
                let compared = (length / mean.max(f32::MIN_POSITIVE)).min(1.0);
                *sample = if fog > 0.0 {
                    length + fog * (compared - length)
                } else {
                    length
                };
            }
        }))
    });
    lay_tiles(&lifted, lengths);
}

/// The difference from which a depth is isolated: a share of it, and a length.
type Isolation = [f32; 2];

fn isolation(frame: &Frame) -> Isolation {
    let window = frame.display_window;
    let limit = ALONE * window.width().max(window.height()) as f32;
    match frame.likely_projection() {
        Projection::Perspective { fx, .. } => [limit / fx.abs() as f32, 0.0],
        Projection::Orthographic { sx, .. } => [0.0, limit / sx.abs() as f32],
    }
}

/// The confidence from the lengths of normals before normalisation.
fn of_normals(lengths: &Plane, normal: &Vector3Planes, mask: &Mask) -> Option<Plane> {
    let found = of_tiles(lengths, CONFIDENCE_REACH, |tile| {
        // Only pixels of short squares are mixed, and the mean takes their deficit as far again.
        if !has_short_square(lengths, mask, tile.window.grown(2 * NORMALS_REACH)) {
            return None;
        }
        let (lengths, mask) = tile.parts(lengths, mask);
        let counts = covered_in_squares(&mask);
        let mean = |plane: &Plane| mean_of_covered(plane, &counts);
        let around = longest(&mean(&lengths), FOG_REACH);
        let compared = of_two(&ended(&lengths, &mask), &around, |length, around| {
            // Never shorter than before.
            length / around.clamp(f32::MIN_POSITIVE, 1.0)
        });
        let longest = longest(&compared, NORMALS_REACH);
        if !longest.samples().iter().any(|&length| is_short(length)) {
            return None;
        }
        let mixed = over_squares(&longest, NORMALS_REACH, f32::MAX, f32::min);
        let [x, y, z] = [&normal.x, &normal.y, &normal.z].map(|plane| mean(&tile.part(plane)));
        let squared = of_two(&of_two(&x, &y, |x, y| x * x + y * y), &z, |sum, z| {
            sum + z * z
        });
        let deficit = of_two(&mixed, &squared, |length, squared| {
            let lack = 1.0 - ramp(length, [LENGTHS[1], LENGTHS[0]]);
            lack * ramp(1.0 - squared.sqrt(), SPREADS)
        });
        // The mean smooths away the corners of squares.
        let mean = mean_over_squares(&deficit, NORMALS_REACH);
        Some(mean.map(|deficit| 1.0 - deficit))
    });
    joined(lengths, &found)
}

/// The confidence of the whole picture, 1 outside `tiles`; `None` if it is 1 everywhere.
fn joined(like: &Plane, tiles: &[(Window, Plane)]) -> Option<Plane> {
    let mut samples = tiles.iter().flat_map(|(_, made)| made.samples());
    samples.any(|&sample| sample < 1.0).then(|| {
        let mut whole = Plane::filled(like.width(), like.height(), 1.0);
        lay_tiles(tiles, &mut whole);
        whole
    })
}

/// The longest length of the square around each pixel.
fn longest(lengths: &Plane, reach: usize) -> Plane {
    over_squares(lengths, reach, f32::MIN, f32::max)
}

/// Lengths as they end a square: pixels without surface do, like long normals.
fn ended(lengths: &Plane, mask: &Mask) -> Plane {
    of_rows(lengths, |y, row| {
        let lengths = lengths.row(y).iter().zip(mask.row(y));
        for (sample, (&length, &covered)) in row.iter_mut().zip(lengths) {
            *sample = if covered { length.min(1.0) } else { 1.0 };
        }
    })
}

/// The number of covered pixels in the square around each pixel.
fn covered_in_squares(mask: &Mask) -> Plane {
    let covered = mask.plane().map(|c| f32::from(u8::from(c)));
    sum_over_squares(&covered, NORMALS_REACH)
}

/// The mean over the covered pixels of the square around each pixel, given their number.
fn mean_of_covered(plane: &Plane, counts: &Plane) -> Plane {
    let sum = sum_over_squares(plane, NORMALS_REACH);
    of_two(&sum, counts, |sum, count| sum / count.max(1.0))
}

fn is_short(length: f32) -> bool {
    length < LENGTHS[0]
}

/// Whether the normals of a whole square around a pixel of `within` are covered and short, be the square cut off at the
/// picture's border or not.
fn has_short_square(lengths: &Plane, mask: &Mask, within: Window) -> bool {
    let size = [lengths.width(), lengths.height()];
    let is_short_at = |x: usize, y: usize| mask.at(x, y) && is_short(lengths.at(x, y));
    let is_square = |x: usize, y: usize| {
        let columns = around(x, NORMALS_REACH, size[0]);
        around(y, NORMALS_REACH, size[1]).all(|y| columns.clone().all(|x| is_short_at(x, y)))
    };
    let Some(within) = within.common(&Window::from_size(size[0], size[1])) else {
        return false;
    };
    let columns = within.x0 as usize..within.x1 as usize;
    (within.y0 as usize..within.y1 as usize).any(|y| {
        let pixels = mask.row(y)[columns.clone()]
            .iter()
            .zip(&lengths.row(y)[columns.clone()]);
        // Without branches, the compiler takes several at a time: most rows have none.
        let any_is_short = pixels.fold(false, |any, (&is_in, &length)| {
            any | (is_in & is_short(length))
        });
        any_is_short
            && columns
                .clone()
                .any(|x| is_short_at(x, y) && is_square(x, y))
    })
}

/// The confidence from isolated depths.
fn of_depths(depth: &Plane, mask: &Mask, from: Isolation) -> Option<Plane> {
    let found = of_tiles(depth, DEPTHS_REACH + 1, |tile| {
        let (depth, mask) = tile.parts(depth, mask);
        let alone = of_rows(&depth, |y, row| alone_in_row((&depth, &mask), from, y, row));
        if alone.samples().iter().sum::<f32>() <= SHARES_ALONE[0] * DEPTHS as f32 {
            return None;
        }
        let share = mean_over_squares(&alone, DEPTHS_REACH);
        Some(share.map(|share| 1.0 - ramp(share, SHARES_ALONE)))
    });
    joined(depth, &found)
}

/// 1 where the depth of a pixel of row `y` is isolated, else 0.
fn alone_in_row((depth, mask): (&Plane, &Mask), from: Isolation, y: usize, alone: &mut [f32]) {
    alone.fill(0.0);
    let span = mask.span(y);
    if span.is_empty() {
        return;
    }
    let within = |y: usize| (&depth.row(y)[span.clone()], &mask.row(y)[span.clone()]);
    let (here, covered) = within(y);
    let alone = &mut alone[span.clone()];
    let inner = alone.len().saturating_sub(2);
    if inner > 0 {
        let shifted = |by: usize| (&here[by..][..inner], &covered[by..][..inner]);
        mark_alone(&mut alone[1..][..inner], [0, 1, 2].map(shifted), from);
    }
    if y > 0 && y + 1 < depth.height() {
        mark_alone(alone, [within(y - 1), (here, covered), within(y + 1)], from);
    }
}

/// Marks the pixels in the middle of three covered ones whose depths are isolated between the two others.
fn mark_alone(alone: &mut [f32], [before, here, after]: [(&[f32], &[bool]); 3], from: Isolation) {
    let count = alone.len();
    let [a, b, c] = [before.0, here.0, after.0].map(|depth| &depth[..count]);
    let [in_a, in_b, in_c] = [before.1, here.1, after.1].map(|covered| &covered[..count]);
    // Without branches, so that the compiler takes several pixels at a time.
    for (x, alone) in alone.iter_mut().enumerate() {
        let is_alone = in_a[x] & in_b[x] & in_c[x] & stands_alone(b[x], [a[x], c[x]], from);
        *alone = alone.max(f32::from(u8::from(is_alone)));
    }
}

/// Whether a depth differs from both its neighbours, other than along a steady slope.
#[inline(always)]
fn stands_alone(depth: f32, [before, after]: [f32; 2], from: Isolation) -> bool {
    let [to_before, to_after] = [before - depth, after - depth];
    let bend = (to_before + to_after).abs();
    (to_before.abs().min(to_after.abs()) > from[0] * depth + from[1])
        & (bend >= 0.5 * to_before.abs().max(to_after.abs()))
}

/// 0 up to the first number, 1 from the second on.
fn ramp(value: f32, [from, to]: [f32; 2]) -> f32 {
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}

/// A plane combined from the samples of two.
fn of_two(a: &Plane, b: &Plane, make: impl Fn(f32, f32) -> f32) -> Plane {
    of_rows(a, |y, row| {
        for (sample, (&a, &b)) in row.iter_mut().zip(a.row(y).iter().zip(b.row(y))) {
            *sample = make(a, b);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::repair::tiled::TILE;
    use glam::DVec3;

    fn lengths(width: usize, height: usize, length: impl Fn(usize, usize) -> f32) -> Plane {
        Plane::from_fn(width, height, length)
    }

    /// The confidence for normals that turn by this many degrees per column.
    fn of(lengths: &Plane, turn_deg: f64) -> Option<Plane> {
        let (width, height) = (lengths.width(), lengths.height());
        let normal = Vector3Planes::from_fn(width, height, |x, _| {
            let (sin, cos) = (turn_deg.to_radians() * x as f64).sin_cos();
            DVec3::new(sin, 0.0, cos)
        });
        of_normals(lengths, &normal, &Mask::full(width, height))
    }

    #[test]
    fn a_band_of_blur_is_told_from_outlines() {
        // Two pixels at an outline, four at a corner, and a line of four: no square of five.
        let outlines = lengths(40, 30, |x, y| match (x, y) {
            (10 | 11, _) | (_, 14 | 15) | (20..=23, 3..=12) => 0.3,
            _ => 1.0,
        });
        assert_eq!(of(&outlines, 8.0), None);
        // A band of nine columns at length 0.84: half-way from 0.93 to 0.75, with a fifth of the effect per column of
        // the five around that is inside.
        let band = lengths(40, 30, |x, _| match x {
            15..24 => 0.84,
            _ => 1.0,
        });
        let found = of(&band, 8.0).unwrap();
        for x in 0..40 {
            let inside = (x.max(2) - 2..=x + 2)
                .filter(|x| (15..24).contains(x))
                .count();
            let expected = 1.0 - 0.1 * inside as f32;
            assert!((found.at(x, 15) - expected).abs() < 1e-5, "{x}");
        }
        // In fog that absorbs a quarter of all samples the result is the same.
        let in_fog = |lengths: &Plane| of(&lengths.map(|length| 0.75 * length), 8.0);
        assert_eq!(in_fog(&outlines), None);
        let fog = in_fog(&band).unwrap();
        let difference = fog
            .samples()
            .iter()
            .zip(found.samples())
            .map(|(a, b)| (a - b).abs());
        assert!(difference.fold(0.0, f32::max) < 1e-5);
        // A far object in fog next to a near one, both flat.
        assert_eq!(of(&band, 0.0), None);
    }

    /// Beside a band of blur, normals of length 1.25 are all alike.
    #[test]
    fn normals_longer_than_1_are_whole() {
        let long = lengths(60, 30, |x, _| if x < 14 { 0.5 } else { 1.25 });
        let found = of(&long, 8.0).unwrap();
        assert_eq!(found.at(11, 15), 0.0);
        assert!((16..60).all(|x| found.at(x, 15) == 1.0));
    }

    /// What is found of a pixel depends on what lies around it, not on where tiles end.
    #[test]
    fn tiles_do_not_show() {
        let blur = |x: usize, y: usize| 0.75 + 0.25 * (0.13 * x as f32 + 0.07 * y as f32).sin();
        let whole = Window::from_size(TILE[0] + 60, 3 * TILE[1]);
        let part = Window::at(29, 37, TILE[0] + 20, 2 * TILE[1]);
        let reach = CONFIDENCE_REACH as i32;
        // What lies in the part with all around it.
        let inner = Window {
            x0: part.x0 + reach,
            y0: part.y0 + reach,
            x1: part.x1 - reach,
            y1: part.y1 - reach,
        };
        let found = |window: Window| {
            let (width, height) = (window.width(), window.height());
            let (x, y) = (window.x0 as usize, window.y0 as usize);
            let lengths = lengths(width, height, |i, j| blur(x + i, y + j));
            let mask = Mask::full(width, height);
            let normal = Vector3Planes::from_fn(width, height, |i, _| {
                let (sin, cos) = (0.1 * (x + i) as f64).sin_cos();
                DVec3::new(sin, 0.0, cos)
            });
            let mut lifted = lengths.clone();
            lift_out_of_fog(&mut lifted, &mask);
            assert_ne!(lifted, lengths);
            let confidence = of_normals(&lengths, &normal, &mask).unwrap();
            [confidence, lifted].map(|plane| plane.crop(window, inner))
        };
        let in_whole = found(whole);
        assert_eq!(in_whole, found(part));
        let mixed = in_whole[0].samples().iter().filter(|&&sample| sample < 1.0);
        assert!(mixed.count() > 1000);
    }

    /// Pictures of every small size, with random samples: a quick look finds what a look at every square finds.
    #[test]
    fn no_square_is_missed() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        let mut found = [0; 2];
        for (width, height) in (1..17).flat_map(|width| (1..17).map(move |height| (width, height)))
        {
            let mut chance = |share: f32| random() < share;
            let short = Plane::from_fn(width, height, |_, _| if chance(0.9) { 0.5 } else { 1.0 });
            let mask = Mask::new(Plane::from_fn(width, height, |_, _| chance(0.99)));
            let ended = Plane::from_fn(width, height, |x, y| {
                if mask.at(x, y) { short.at(x, y) } else { 1.0 }
            });
            let longest = longest(&ended, NORMALS_REACH);
            let has_square = longest.samples().iter().any(|&length| is_short(length));
            // The whole picture, and a part of it.
            for within in [Window::from_size(16, 16), Window::at(3, 2, 7, 6)] {
                let mut middles = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
                let any = middles.any(|(x, y)| {
                    let middle = Window::at(x as i32, y as i32, 1, 1);
                    is_short(longest.at(x, y)) && within.encloses(&middle)
                });
                let found = has_short_square(&short, &mask, within);
                assert_eq!(found, any, "{width}x{height}");
            }
            let depth = Plane::from_fn(width, height, |_, _| if chance(0.12) { 9.0 } else { 5.0 });
            let alone = of_rows(&depth, |y, row| {
                alone_in_row((&depth, &mask), [0.1, 0.0], y, row)
            });
            let shares = mean_over_squares(&alone, DEPTHS_REACH);
            let is_mixed = shares
                .samples()
                .iter()
                .any(|&share| share > SHARES_ALONE[0]);
            let confidence = of_depths(&depth, &mask, [0.1, 0.0]);
            assert_eq!(confidence.is_some(), is_mixed, "{width}x{height}");
            found[0] += usize::from(has_square);
            found[1] += usize::from(is_mixed);
        }
        // Both ways often enough.
        assert!(found.iter().all(|n| (10..246).contains(n)), "{found:?}");
    }

    #[test]
    fn fog_hides_no_crease() {
        // A fold two pixels wide, of length 0.8: in fog that absorbs half of all samples its normals have length 0.4
        // among 0.5. The mean of its square of 25, ten of them in the fold, is 0.46.
        let fold = |x, _| if (20..22).contains(&x) { 0.8 } else { 1.0 };
        let clear = lengths(40, 30, fold);
        let mask = Mask::full(40, 30);
        let mut same = clear.clone();
        lift_out_of_fog(&mut same, &mask);
        assert_eq!(same, clear);
        let mut foggy = clear.map(|length| 0.5 * length);
        lift_out_of_fog(&mut foggy, &mask);
        assert!((foggy.at(20, 15) - 0.4 / 0.46).abs() < 1e-6);
        assert_eq!(foggy.at(5, 15), 1.0);
        assert_eq!(foggy.at(0, 0), 1.0);
    }

    #[test]
    fn a_square_of_short_normals_is_found_wherever_it_is() {
        let is_found = |left: usize, top: usize, side: usize| {
            let short = lengths(20, 17, |x, y| {
                match (left..left + side).contains(&x) && (top..top + side).contains(&y) {
                    true => 0.5,
                    false => 1.0,
                }
            });
            has_short_square(&short, &Mask::full(20, 17), Window::from_size(20, 17))
        };
        for (left, top) in (0..=15).flat_map(|x| (0..=12).map(move |y| (x, y))) {
            assert!(is_found(left, top, 5), "{left}, {top}");
            // Squares are cut off at borders.
            let is_corner = (left == 0 || left == 16) && (top == 0 || top == 13);
            assert_eq!(is_found(left, top, 4), is_corner, "{left}, {top}");
        }
        assert!(is_found(17, 14, 3), "the last corner");
    }

    #[test]
    fn what_shows_nothing_is_not_mixed() {
        let short = Plane::from_fn(24, 24, |x, _| if x < 12 { 0.2 } else { 1.0 });
        let mask = Mask::new(Plane::from_fn(24, 24, |x, y| (x + y) % 4 != 0));
        let normal = Vector3Planes::from_fn(24, 24, |x, _| match x % 2 {
            0 => DVec3::X,
            _ => DVec3::Z,
        });
        assert_eq!(of_normals(&short, &normal, &mask), None);
        let found = of_normals(&short, &normal, &Mask::full(24, 24)).unwrap();
        assert_eq!(found.at(6, 12), 0.0);
        assert_eq!(of(&Plane::filled(1, 1, 0.0), 8.0), None);
        assert_eq!(of(&Plane::filled(3, 1, 0.98), 8.0), None);
    }

    #[test]
    fn depths_that_stand_alone_are_mixed_but_not_steps_slopes_and_wires() {
        let of = |depth: &Plane| {
            of_depths(
                depth,
                &Mask::full(depth.width(), depth.height()),
                [0.1, 0.0],
            )
        };
        let scenes: [fn(usize, usize) -> f32; 3] = [
            |x, y| if x + y < 40 { 5.0 } else { 9.0 },
            |_, y| 100.0 / (20.0 + y as f32),
            |x, y| if x == y { 5.0 } else { 9.0 },
        ];
        for scene in scenes {
            assert_eq!(of(&Plane::from_fn(40, 40, scene)), None);
        }
        // Every third pixel of every third row shows the background.
        let every = Plane::from_fn(40, 40, |x, y| match (x % 3, y % 3) {
            (0, 0) => 9.0,
            _ => 5.0,
        });
        let found = of(&every).unwrap();
        // Among eleven columns three or four have such pixels: 16, 12 or 9 of 121.
        for (x, y, count) in [(19, 19, 16.0), (21, 19, 12.0), (21, 21, 9.0)] {
            let expected = 1.0 - ((count / 121.0 - 0.1) / 0.2f32).max(0.0);
            assert!((found.at(x, y) - expected).abs() < 1e-5, "{x}, {y}");
        }
    }
}
