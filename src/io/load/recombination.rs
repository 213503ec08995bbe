//! Whether light layers add up to their picture.

use crate::frame::{ColorPlanes, LobeLayers, Mask};
use crate::kernel::quantile::quantile;

/// Pixels that the median is taken over, about.
const WANTED: usize = 5_000;

/// Pixels darker than this have no meaningful relative difference.
const MIN_LIGHT: f32 = 1e-4;

/// Median over the covered pixels of `|sum - picture| / picture`, over all channels, where the sum is that of all
/// lobes, `(direct + indirect) * color` each, and of `rest`. `None` for a dark picture.
pub(crate) fn difference(
    picture: &ColorPlanes,
    lobes: &[LobeLayers],
    rest: &[ColorPlanes],
    mask: &Mask,
) -> Option<f32> {
    let mut differences: Vec<f32> = mask
        .sample(WANTED)
        .filter_map(|(x, y)| {
            let shown = picture.at(x, y);
            let summed = sum(lobes, rest, (x, y));
            let size: f32 = shown.iter().map(|c| c.abs()).sum();
            let apart: f32 = shown.iter().zip(summed).map(|(c, t)| (c - t).abs()).sum();
            (size > MIN_LIGHT).then(|| apart / size)
        })
        .collect();
    quantile(&mut differences, 0.5, f32::total_cmp)
}

fn sum(lobes: &[LobeLayers], rest: &[ColorPlanes], (x, y): (usize, usize)) -> [f32; 3] {
    let mut sum = [0.0; 3];
    let or = |planes: &Option<ColorPlanes>, absent| {
        planes
            .as_ref()
            .map_or([absent; 3], |planes| planes.at(x, y))
    };
    for lobe in lobes {
        let (direct, indirect) = (or(&lobe.direct, 0.0), or(&lobe.indirect, 0.0));
        let color = or(&lobe.color, 1.0);
        for i in 0..3 {
            sum[i] += (direct[i] + indirect[i]) * color[i];
        }
    }
    for layer in rest {
        for (sum, light) in sum.iter_mut().zip(layer.at(x, y)) {
            *sum += light;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Lobe, Plane};

    fn grey(values: [f32; 3]) -> ColorPlanes {
        let plane = Plane::from_samples(3, 1, values.to_vec());
        ColorPlanes {
            r: plane.clone(),
            g: plane.clone(),
            b: plane,
        }
    }

    #[test]
    fn the_median_is_that_of_covered_pixels_with_light() {
        let lobes = [LobeLayers {
            lobe: Lobe::Diffuse,
            direct: Some(grey([1.0, 2.0, 9.0])),
            indirect: Some(grey([1.0, 0.0, 0.0])),
            color: Some(grey([0.5, 0.5, 0.5])),
            albedo: None,
        }];
        let rest = [grey([0.25, 0.0, 0.0])];
        // The sum is 1.25, 1 and 4.5; the picture 1, 2 and black: 0.25 and 0.5, with the upper one as the median.
        let picture = grey([1.0, 2.0, 0.0]);
        let full = Mask::full(3, 1);
        assert_eq!(difference(&picture, &lobes, &rest, &full), Some(0.5));
        let first = Mask::new(Plane::from_samples(3, 1, vec![true, false, false]));
        assert_eq!(difference(&picture, &lobes, &rest, &first), Some(0.25));
        let last = Mask::new(Plane::from_samples(3, 1, vec![false, false, true]));
        assert_eq!(difference(&picture, &lobes, &rest, &last), None);
    }
}
