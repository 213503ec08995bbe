//! Ink that fades: a drawing of a part of the picture.

use crate::frame::Plane;

/// Scales the `ink` of a layer by `share`, 0..1, and by `strength`, 0..1, of each pixel.
pub(crate) fn faded(ink: &mut Plane, strength: Option<&Plane>, share: f32) {
    if strength.is_none() && share == 1.0 {
        return;
    }
    match strength {
        Some(strength) => ink.each_with(strength, |ink, strength| *ink *= share * strength),
        None => ink.each_row(|_, row| row.iter_mut().for_each(|ink| *ink *= share)),
    }
}

/// The largest sample of the square of `reach` pixels to each side of each pixel.
pub(crate) fn largest_around(plane: &Plane, reach: usize) -> Plane {
    let (width, height) = (plane.width(), plane.height());
    let largest = |samples: &mut dyn Iterator<Item = f32>| samples.fold(0.0, f32::max);
    let span = |at: usize, length: usize| at.saturating_sub(reach)..(at + reach + 1).min(length);
    let across = Plane::from_fn(width, height, |x, y| {
        largest(&mut plane.row(y)[span(x, width)].iter().copied())
    });
    Plane::from_fn(width, height, |x, y| {
        largest(&mut span(y, height).map(|y| across.at(x, y)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ink_fades_by_its_share_and_reaches_out_by_its_width() {
        let mut ink = Plane::from_samples(3, 1, vec![0.8, 0.4, 1.0]);
        let strength = Plane::from_samples(3, 1, vec![1.0, 0.5, 0.0]);
        faded(&mut ink, Some(&strength), 0.5);
        assert_eq!(ink.samples(), [0.4, 0.1, 0.0]);
        faded(&mut ink, None, 1.0);
        assert_eq!(ink.samples(), [0.4, 0.1, 0.0]);
        let mut one = Plane::filled(6, 5, 0.0);
        one.row_mut(2)[1] = 0.7;
        let around = largest_around(&one, 1);
        let lit = |x: usize, y: usize| x <= 2 && (1..=3).contains(&y);
        let expected = Plane::from_fn(6, 5, |x, y| if lit(x, y) { 0.7 } else { 0.0 });
        assert_eq!(around, expected);
        let nothing = largest_around(&Plane::filled(0, 0, 1.0), 2);
        assert!(nothing.samples().is_empty());
    }
}
