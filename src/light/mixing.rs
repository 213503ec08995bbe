//! Blending a result with its input picture.

use crate::frame::{ColorPlanes, Plane};

/// Blends `made` with the picture `before`, or with nothing if there was none: `share`, 0..1, times the `strength` of
/// each pixel, 0..1, is the weight of `made`.
///
/// Colours are linear and premultiplied. A weight of 1 keeps the bits of `made`, one of 0 gives `before`.
pub(crate) fn mix(
    made: &mut ColorPlanes,
    before: Option<&ColorPlanes>,
    strength: Option<&Plane>,
    share: f32,
) {
    if strength.is_none() && share == 1.0 {
        return;
    }
    let before = before.map(|before| [&before.r, &before.g, &before.b]);
    let planes = [&mut made.r, &mut made.g, &mut made.b].into_iter();
    for (channel, plane) in planes.enumerate() {
        plane.each_row(|y, row| {
            let count = row.len();
            let was = before.map(|planes| &planes[channel].row(y)[..count]);
            let strength = strength.map(|strength| &strength.row(y)[..count]);
            match (was, strength) {
                (Some(was), Some(own)) => mix_row(row, |x| was[x], |x| share * own[x]),
                (Some(was), None) => mix_row(row, |x| was[x], |_| share),
                (None, Some(own)) => mix_row(row, |_| 0.0, |x| share * own[x]),
                (None, None) => mix_row(row, |_| 0.0, |_| share),
            }
        });
    }
}

/// Blends a row with what it was, by the weights `taken`.
#[inline(always)]
fn mix_row(row: &mut [f32], was: impl Fn(usize) -> f32, taken: impl Fn(usize) -> f32) {
    for (x, sample) in row.iter_mut().enumerate() {
        let (was, taken) = (was(x), taken(x));
        // Both are computed and one is chosen: a branch would keep the compiler from taking many at a time.
        let mixed = was + taken * (*sample - was);
        *sample = if taken == 1.0 { *sample } else { mixed };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(samples: [f32; 4]) -> ColorPlanes {
        ColorPlanes::grey(Plane::from_samples(4, 1, samples.to_vec()))
    }

    #[test]
    fn as_much_is_taken_as_is_asked_for() {
        let before = picture([0.1, 0.2, 0.3, 1e30]);
        let strength = Plane::from_samples(4, 1, vec![0.0, 0.5, 1.0, 0.0]);
        let mixed = |strength, share| {
            let mut made = picture([0.7, 0.6, 0.9, 2.0]);
            mix(&mut made, Some(&before), strength, share);
            made.g.samples().to_vec()
        };
        assert_eq!(mixed(None, 1.0), [0.7, 0.6, 0.9, 2.0]);
        assert_eq!(mixed(None, 0.0), [0.1, 0.2, 0.3, 1e30]);
        // 0.2 plus half the difference to 0.6.
        assert_eq!(
            mixed(Some(&strength), 1.0),
            [0.1, 0.2 + 0.5 * (0.6 - 0.2), 0.9, 1e30]
        );
        let half = mixed(Some(&strength), 0.5);
        assert_eq!(half[..2], [0.1, 0.2 + 0.25 * (0.6 - 0.2)]);
        assert!((half[2] - 0.6).abs() < 1e-6);
    }

    #[test]
    fn of_no_picture_nothing_is_left() {
        let mut made = picture([1.0; 4]);
        mix(&mut made, None, None, 0.25);
        assert_eq!(made.r.samples(), [0.25; 4]);
    }
}
