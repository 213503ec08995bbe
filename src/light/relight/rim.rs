//! Pixels with little coverage: too little for a normal of their own, enough to be visible.

use crate::frame::{ColorPlanes, Mask, Plane};
use rayon::prelude::*;

/// Sets pixels that are partly covered by alpha but outside the mask to the mean light of the covered ones around them.
/// Left unchanged they would keep the old light as a seam.
pub(crate) fn light_rims(color: &mut ColorPlanes, alpha: &Plane, mask: &Mask) {
    let planes = [&color.r, &color.g, &color.b];
    let rows = (0..mask.height()).into_par_iter();
    let found: Vec<_> = rows
        .flat_map_iter(|y| {
            let partly = alpha.row(y).iter().zip(mask.row(y)).enumerate();
            let partly = partly.filter(|(_, (alpha, covered))| **alpha > 0.0 && !**covered);
            partly.filter_map(move |(x, (&cover, _))| {
                let light = light_around(planes, alpha, mask, x, y)?;
                Some((x, y, light.map(|channel| channel * cover)))
            })
        })
        .collect();
    for (x, y, [r, g, b]) in found {
        color.r.row_mut(y)[x] = r;
        color.g.row_mut(y)[x] = g;
        color.b.row_mut(y)[x] = b;
    }
}

/// The mean colour, divided by alpha, of the covered pixels that touch the one at (`x`, `y`).
fn light_around(
    planes: [&Plane; 3],
    alpha: &Plane,
    mask: &Mask,
    x: usize,
    y: usize,
) -> Option<[f32; 3]> {
    let (mut sum, mut cover) = ([0.0; 3], 0.0);
    for y in y.saturating_sub(1)..(y + 2).min(mask.height()) {
        for x in x.saturating_sub(1)..(x + 2).min(mask.width()) {
            if mask.at(x, y) {
                cover += alpha.at(x, y);
                for (sum, plane) in sum.iter_mut().zip(planes) {
                    *sum += plane.at(x, y);
                }
            }
        }
    }
    let light = sum.map(|channel| channel / cover);
    light
        .iter()
        .all(|channel| channel.is_finite())
        .then_some(light)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rim_is_lit_as_its_neighbours_and_as_much_as_it_is_covered() {
        // Column 0 is fully covered, light 0.8. Column 1 is covered by a quarter, column 2 not at all.
        let alpha = Plane::from_fn(3, 3, |x, _| [1.0, 0.25, 0.0][x]);
        let mask = Mask::new(Plane::from_fn(3, 3, |x, _| x == 0));
        let old = Plane::from_fn(3, 3, |x, _| [0.8, 9.0, 7.0][x]);
        let mut color = ColorPlanes {
            r: old.clone(),
            g: old.clone(),
            b: old,
        };
        light_rims(&mut color, &alpha, &mask);
        for y in 0..3 {
            let row = color.g.row(y);
            assert_eq!(row[0], 0.8);
            assert!((row[1] - 0.2).abs() < 1e-6);
            assert_eq!(row[2], 7.0);
        }
    }
}
