//! Quantised tones, as in cartoons.

use crate::params::Quantisation;

/// The factor that quantises a colour of luminance `y` (1 is white) to the given tones, of which `most` is the last.
///
/// Tones are evenly spaced in the square root of luminance, which is roughly perceptual, from black to white and
/// beyond; half-way between two tones lies a step with a width of `softness` times their distance. Source: [LW] section
/// 6.2, after H. Winnemoeller, S. Olsen, B. Gooch: Real-Time Video Abstraction, 2006. Departs from it: a cubic step
/// instead of a hyperbolic tangent, so that tones are exactly flat.
#[inline(always)]
pub(crate) fn tone_factor(y: f32, tones: Quantisation, most: f32) -> f32 {
    if !(y > 0.0 && y.is_finite()) {
        return 1.0;
    }
    let levels = tones.levels as f32;
    let position = y.sqrt() * levels;
    let below = position.floor();
    // Position between the tones: 0 before the step, 1 after it.
    let aside = position - below - 0.5;
    let t = if tones.softness > 0.0 {
        (aside / tones.softness + 0.5).clamp(0.0, 1.0)
    } else if aside < 0.0 {
        0.0
    } else {
        1.0
    };
    let tone = (below + t * t * (3.0 - 2.0 * t)).min(most) / levels;
    tone * tone / y
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tone(y: f32, levels: u32, softness: f32) -> f32 {
        y * tone_factor(y, Quantisation { levels, softness }, f32::MAX)
    }

    #[test]
    fn hard_steps_leave_the_tones_alone() {
        // Four levels: 0, 1/4, 1/2, 3/4, 1 of the square root; steps at 1/8, 3/8, 5/8, 7/8.
        for (root, expected) in [
            (0.1, 0.0),
            (0.13, 0.25),
            (0.37, 0.25),
            (0.4, 0.5),
            (0.9, 1.0),
        ] {
            let found = tone(root * root, 4, 0.0).sqrt();
            assert!((found - expected).abs() < 1e-6, "{root}: {found}");
        }
        assert!((tone(1.3 * 1.3, 4, 0.0).sqrt() - 1.25).abs() < 1e-6);
        let four = Quantisation {
            levels: 4,
            softness: 0.0,
        };
        // To rounding of the product.
        assert!((1.69 * tone_factor(1.69, four, 4.0) - 1.0).abs() < 2e-7);
    }

    #[test]
    fn soft_steps_rise_and_are_flat_beside() {
        let at = |root: f32| tone(root * root, 2, 0.5).sqrt();
        assert!((at(0.25) - 0.25).abs() < 1e-6, "half-way in the step");
        assert!((at(0.375) - 0.5).abs() < 1e-6, "the step ends here");
        assert!((at(0.5) - 0.5).abs() < 1e-6);
        let values: Vec<f32> = (1..1000).map(|i| tone(i as f32 / 500.0, 5, 1.0)).collect();
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1] + 1e-6));
    }

    #[test]
    fn what_is_no_colour_stays() {
        let few = Quantisation {
            levels: 4,
            softness: 0.15,
        };
        for y in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(tone_factor(y, few, 4.0), 1.0);
        }
        assert!(tone_factor(f32::MAX, few, f32::MAX).is_finite());
        assert!(tone_factor(1e-40, few, f32::MAX).is_finite());
    }
}
