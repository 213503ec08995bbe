//! Texture coordinates that move with the surface.
//!
//! Theory: [LA] section 8 leaves open the shower-door effect: if the texture of strokes is fixed in the picture, the
//! surface slides away under it. Here every pixel has a *place*, the pixel coordinates in which the texture is fixed,
//! and the surface carries it along: place(x) = place before(x - motion). The Jacobian D of the places with respect to
//! the picture describes the distortion of the texture: strokes along t in the picture are strokes along D t in the
//! texture, so rigid motion in the picture keeps them, with any rotation; and its singular values give the factors by
//! which strokes have become larger or smaller than intended.
//!
//! Where that is too much the texture has to be laid anew. A worn map of places hands over to a younger one: its
//! [`soundness`] falls, and with it its share of the optical density, so strokes of the one drop out one by one while
//! those of the other appear, and tone stays. A shift or a rotation in the picture distorts nothing and needs no
//! handover.

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod hidden;
pub(crate) mod origin;
pub(crate) mod places;
pub(crate) mod shares;
pub(crate) mod sheet;
pub(crate) mod stage;
pub(crate) mod step;

use super::random::Random;

/// Places of adjacent pixels farther apart than this belong to different surfaces. Twice the width of a pixel under the
/// worst distortion ever drawn.
pub(crate) const JUMP: f32 = 2.0 * OUTWORN;

/// Distortion up to which a map is used alone.
const WORN: f32 = 1.2;

/// Distortion from which a map is no longer used: strokes are never drawn larger or smaller than this makes them.
const OUTWORN: f32 = 1.5;

/// Derivatives of the place by the picture, rows down in both: columns first, `[d/dx, d/dy]`.
pub(crate) type Jacobian = [[f32; 2]; 2];

/// The Jacobian of a fixed texture.
pub(crate) const STILL: Jacobian = [[1.0, 0.0], [0.0, 1.0]];

/// Whether two places, of adjacent pixels, can belong to one surface.
#[inline(always)]
pub(crate) fn is_joined(a: [f32; 2], b: [f32; 2]) -> bool {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    x * x + y * y < JUMP * JUMP
}

/// Largest step of depth, as a share of it, between pixels of one surface, and between frames, after removing the
/// median. A surface that approaches by more in a frame is laid anew; behind an edge that is closer than this to its
/// background the background keeps strokes of the surface that covered it.
pub(crate) const DEPTH_STEP: f32 = 0.08;

/// Without depth: largest difference of their motions, in pixels and as a share of the lesser.
pub(crate) const MOTION_STEP: [f32; 2] = [1.5, 0.5];

/// Whether two depths, of neighbours or of one pixel in two frames, can belong to one surface.
#[inline(always)]
pub(crate) fn is_one_depth(a: f32, b: f32) -> bool {
    // NaN depths separate nothing.
    let parted = (a - b).abs() > DEPTH_STEP * a.abs().min(b.abs());
    !parted
}

/// Whether two motions, of neighbours or of one pixel in two frames, can belong to one surface.
#[inline(always)]
pub(crate) fn is_one_motion(a: [f32; 2], b: [f32; 2]) -> bool {
    let length = |x: f32, y: f32| (x * x + y * y).sqrt();
    let change = length(a[0] - b[0], a[1] - b[1]);
    change <= MOTION_STEP[0] + MOTION_STEP[1] * length(a[0], a[1]).min(length(b[0], b[1]))
}

/// The Jacobian at the place `here`, from the neighbours left and right, and above and below, where they exist. Places
/// of other surfaces are left out; a derivative that is then missing is replaced by the other, rotated.
#[inline(always)]
pub(crate) fn jacobian(
    here: [f32; 2],
    beside: [Option<[f32; 2]>; 2],
    over: [Option<[f32; 2]>; 2],
) -> Jacobian {
    match (slope(here, beside), slope(here, over)) {
        (Some(dx), Some(dy)) => [dx, dy],
        (Some([x, y]), None) => [[x, y], [-y, x]],
        (None, Some([x, y])) => [[y, -x], [x, y]],
        (None, None) => STILL,
    }
}

/// The derivative of the place along one axis, from the neighbours before and after `here` on the same surface.
#[inline(always)]
pub(crate) fn slope(here: [f32; 2], [before, after]: [Option<[f32; 2]>; 2]) -> Option<[f32; 2]> {
    let joined = |place: Option<[f32; 2]>| place.filter(|&place| is_joined(here, place));
    let between = |a: [f32; 2], b: [f32; 2], by: f32| [by * (b[0] - a[0]), by * (b[1] - a[1])];
    match (joined(before), joined(after)) {
        (Some(before), Some(after)) => Some(between(before, after, 0.5)),
        (Some(before), None) => Some(between(before, here, 1.0)),
        (None, Some(after)) => Some(between(here, after, 1.0)),
        (None, None) => None,
    }
}

/// The direction in the texture of the direction `t` in the picture, both x right, y **up**; not unit.
#[inline(always)]
pub(crate) fn in_texture(by: &Jacobian, t: [f32; 2]) -> [f32; 2] {
    let [dx, dy] = by;
    [dx[0] * t[0] - dy[0] * t[1], -(dx[1] * t[0] - dy[1] * t[1])]
}

/// Sum and difference of the singular values, the smaller one negative where the texture is mirrored.
#[inline(always)]
fn singular_values(by: &Jacobian) -> [f32; 2] {
    let [[a, c], [b, d]] = *by;
    let length = |x: f32, y: f32| 0.5 * (x * x + y * y).sqrt();
    let (turned, rest) = (length(a + d, c - b), length(a - d, c + b));
    [turned + rest, turned - rest]
}

/// Factor by which the distorted texture shows strokes too large or too small, along the worse axis: 1 is undistorted.
/// Infinite where it is reversed or folded.
#[inline(always)]
pub fn distortion(by: &Jacobian) -> f32 {
    let [larger, smaller] = singular_values(by);
    match smaller > 0.0 {
        true => larger.max(smaller.recip()),
        false => f32::INFINITY,
    }
}

/// Soundness of a distorted map: 1 as good as new, 0 unusable; smooth between.
#[inline(always)]
pub fn soundness(distortion: f32) -> f32 {
    let worn = ((distortion - WORN) / (OUTWORN - WORN)).clamp(0.0, 1.0);
    1.0 - worn * worn * (3.0 - 2.0 * worn)
}

/// Cosine and sine of the turn that is in a Jacobian, or a sum of several.
#[inline(always)]
pub(crate) fn turn(by: &Jacobian) -> [f32; 2] {
    let [dx, dy] = by;
    let [cos, sin] = [dx[0] + dy[1], dx[1] - dy[0]];
    let length = (cos * cos + sin * sin).sqrt();
    match length > 0.0 && length.is_finite() {
        true => [cos / length, sin / length],
        false => [1.0, 0.0],
    }
}

/// The place at an offset in pixels (rows down) from a pixel at `place`, if the texture continues from there by a
/// [`turn`], undistorted.
#[inline(always)]
pub(crate) fn continued(place: [f32; 2], [cos, sin]: [f32; 2], [x, y]: [f32; 2]) -> [f32; 2] {
    [place[0] + cos * x - sin * y, place[1] + sin * x + cos * y]
}

/// The place `here` without the roughness that motion adds from frame to frame: averaged with its neighbours, given in
/// opposite pairs: first left and right, then above and below, then the two diagonals. Any affine map, such as a shift
/// or a rotation, is preserved.
///
/// A place torn from most of its neighbours, which agree with each other, is replaced by them. Only then `farther`
/// pairs are requested.
#[inline(always)]
pub(crate) fn calmed<const N: usize>(
    here: [f32; 2],
    near: [Option<[[f32; 2]; 2]>; 4],
    farther: impl FnOnce() -> [Option<[[f32; 2]; 2]>; N],
) -> [f32; 2] {
    let mut calm = here;
    let mut joined = 0;
    for (pair, weight) in near.iter().zip([0.125, 0.125, 0.0625, 0.0625]) {
        if let Some([a, b]) = pair
            && is_joined(here, *a)
            && is_joined(here, *b)
        {
            calm[0] += weight * ((a[0] - here[0]) + (b[0] - here[0]));
            calm[1] += weight * ((a[1] - here[1]) + (b[1] - here[1]));
            joined += 1;
        }
    }
    if joined == near.len() {
        return calm;
    }
    let pairs = near.into_iter().chain(farther()).flatten();
    let (mut sum, mut agreed) = ([0.0; 2], 0);
    for [a, b] in pairs {
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        if is_joined(a, middle) && !is_joined(here, middle) {
            sum = [sum[0] + middle[0], sum[1] + middle[1]];
            agreed += 1;
        }
    }
    match agreed > 1 && agreed > joined {
        true => sum.map(|sum| sum / agreed as f32),
        false => calm,
    }
}

/// The place at `offset` pixels (rows down) from a pixel at `place`, by the Jacobian there.
#[inline(always)]
pub(crate) fn extrapolated(place: [f32; 2], by: &Jacobian, [x, y]: [f32; 2]) -> [f32; 2] {
    let [dx, dy] = by;
    [
        place[0] + dx[0] * x + dy[0] * y,
        place[1] + dx[1] * x + dy[1] * y,
    ]
}

/// Offset of a generation's map in the texture, added to pixel coordinates. The first is placed as in a still picture;
/// later ones elsewhere, since two in agreement would print strokes of both onto each other.
pub(crate) fn origin(generation: u32) -> [f32; 2] {
    if generation == 0 {
        return [0.0; 2];
    }
    let mut random = Random::new(u64::from(generation));
    [(); 2].map(|()| FARTHEST * random.unit())
}

/// Far beyond the period of any texture of strokes, near enough for places to be exact to 1/4000 of a pixel.
const FARTHEST: f32 = 2048.0;

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn around(place: impl Fn(f32, f32) -> [f32; 2]) -> Jacobian {
        jacobian(
            place(0.0, 0.0),
            [Some(place(-1.0, 0.0)), Some(place(1.0, 0.0))],
            [Some(place(0.0, -1.0)), Some(place(0.0, 1.0))],
        )
    }

    #[test]
    fn a_turned_object_keeps_the_angles_of_its_strokes() {
        for degrees in [0.0_f32, 20.0, 90.0, 135.0, 200.0] {
            // Rotated counterclockwise in the picture; places rotate back. Rows run down.
            let (sin, cos) = degrees.to_radians().sin_cos();
            let by = around(|x, y| [cos * x - sin * y, sin * x + cos * y]);
            assert!((distortion(&by) - 1.0).abs() < 1e-6);
            assert_eq!(soundness(distortion(&by)), 1.0);
            // A stroke that was drawn at 30 degrees is now at 30 + degrees.
            let now = (30.0 + degrees).to_radians();
            let [x, y] = in_texture(&by, [now.cos(), now.sin()]);
            let angle = y.atan2(x).to_degrees();
            assert!((angle - 30.0).abs() < 1e-4, "{angle}");
        }
    }

    #[test]
    fn distortion_is_the_worse_of_both_axes() {
        // Twice as large along one axis of 30 degrees, 1.2 times smaller along the other.
        let (sin, cos) = (PI / 6.0).sin_cos();
        let by = around(|x, y| {
            let [u, v] = [0.5 * (cos * x + sin * y), 1.2 * (cos * y - sin * x)];
            [cos * u - sin * v, sin * u + cos * v]
        });
        assert!((distortion(&by) - 2.0).abs() < 1e-5);
        assert_eq!(soundness(distortion(&by)), 0.0);
        // Mirrored, and folded to a line.
        assert_eq!(distortion(&[[-1.0, 0.0], [0.0, 1.0]]), f32::INFINITY);
        assert_eq!(distortion(&[[1.0, 0.0], [1.0, 0.0]]), f32::INFINITY);
        assert_eq!(soundness(f32::INFINITY), 0.0);
        // Half-way between 1.2 and 1.5, a smooth step is at one half.
        assert!((soundness(1.35) - 0.5).abs() < 1e-5);
    }

    #[test]
    fn other_surfaces_have_no_say() {
        // A texture rotated by 40 degrees that ends to the right and above.
        let (sin, cos) = 40.0_f32.to_radians().sin_cos();
        let place = |x: f32, y: f32| [9.0 + cos * x - sin * y, sin * x + cos * y];
        let whole = around(place);
        let far = Some([500.0, -3.0]);
        let beside = [Some(place(-1.0, 0.0)), far];
        let half = jacobian(place(0.0, 0.0), beside, [None, Some(place(0.0, 1.0))]);
        let line = jacobian(place(0.0, 0.0), beside, [None, far]);
        let column = jacobian(place(0.0, 0.0), [None, far], [Some(place(0.0, -1.0)), None]);
        for by in [half, line, column] {
            for (a, b) in by.as_flattened().iter().zip(whole.as_flattened()) {
                assert!((a - b).abs() < 1e-5, "{by:?}");
            }
        }
        assert_eq!(jacobian([0.0; 2], [None, far], [None, None]), STILL);
    }

    #[test]
    fn what_comes_into_view_goes_on_undistorted() {
        // Compressed to half along x in the picture, rotated by a right angle: only the rotation continues.
        let by = [[0.0, 2.0], [-1.0, 0.0]];
        assert_eq!(continued([5.0, 5.0], turn(&by), [3.0, 0.0]), [5.0, 8.0]);
        assert_eq!(extrapolated([5.0, 5.0], &by, [3.0, 0.0]), [5.0, 11.0]);
        assert_eq!(turn(&[[0.0; 2]; 2]), [1.0, 0.0]);
    }

    #[test]
    fn roughness_is_calmed_and_maps_are_not() {
        let pairs = |place: &dyn Fn(f32, f32) -> [f32; 2], far: f32| {
            [[far, 0.0], [0.0, far], [far, far], [far, -far]]
                .map(|[x, y]| Some([place(-x, -y), place(x, y)]))
        };
        let calm = |place: &dyn Fn(f32, f32) -> [f32; 2]| {
            calmed(place(0.0, 0.0), pairs(place, 1.0), || pairs(place, 2.0))
        };
        // An affine map, in numbers that have no rounding.
        let affine = |x: f32, y: f32| [3.0 + 1.25 * x - 0.5 * y, 7.0 + 0.25 * x + 0.75 * y];
        assert_eq!(calm(&affine), affine(0.0, 0.0));
        // A checkerboard of 0.5 px: both straight pairs sum to an error of -1, an eighth of which counts, the diagonals
        // have none. 0.5 - 2/8 = 0.25, the mean of the board.
        let board = |x: f32, y: f32| {
            let off = if (x + y).rem_euclid(2.0) == 0.0 {
                0.5
            } else {
                0.0
            };
            [x + off, y]
        };
        assert_eq!(calm(&board), [0.25, 0.0]);
        // One pixel, or a line of two, that went astray.
        let astray = |x: f32, y: f32| {
            if x == 0.0 && y == 0.0 {
                [40.0, 9.0]
            } else {
                [x, y]
            }
        };
        assert_eq!(calm(&astray), [0.0, 0.0]);
        let line = |x: f32, y: f32| {
            if y == 0.0 || y == 1.0 {
                [x + 50.0, y]
            } else {
                [x, y]
            }
        };
        assert_eq!(calm(&line), [0.0, 0.0]);
        // A seam between two surfaces stays in place.
        let seam = |x: f32, y: f32| if x > 0.0 { [x + 50.0, y] } else { [x, y] };
        assert_eq!(calm(&seam), [0.0, 0.0]);
        assert_eq!(calmed::<0>([4.0, 5.0], [None; 4], || []), [4.0, 5.0]);
    }
}
