//! The intensity, 0..1, of light that is looked up or traced: what radiance scaling compares with its invariant point.
//!
//! Theory: [RS] section 5.3 divides light by the largest there is. Change: in light without an upper limit the largest
//! is a lamp or the sun, and nearly all of the surface falls below the invariant point, where convexities darken and
//! hollows glow. Most of the area has to lie above it, so such light is compared with its median m: `L / (L + m)`, which
//! passes 1/4 at m/3. No sample is clipped, and a single bright one changes nothing elsewhere.

use crate::kernel::quantile::quantile;
use crate::light::environment::Environment;
use crate::light::lit_sphere::LitSphere;
use crate::params::Adaptive;

/// Rows of pixels on the ball that the median is taken over.
const BALL_PX: usize = 128;

/// The luminance that intensity is told from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum White {
    /// The median of light without an upper limit; the largest of light for a display.
    Auto,
    /// This is taken for the median.
    Middle(f32),
    /// This has intensity 1, as all that is brighter.
    Level(f32),
}

impl White {
    /// The luminance asked for: as intensity 1, else as the median.
    pub(crate) fn given(level: Adaptive, middle: Adaptive) -> Self {
        match (level, middle) {
            (Adaptive::Fixed(level), _) => Self::Level(level),
            (Adaptive::Auto, Adaptive::Fixed(middle)) => Self::Middle(middle),
            (Adaptive::Auto, Adaptive::Auto) => Self::Auto,
        }
    }

    /// The intensity of light without an upper limit, whose median is `median()`.
    pub(crate) fn unlimited(self, median: impl FnOnce() -> f32) -> Intensity {
        match self {
            Self::Auto => Intensity::by_middle(median()),
            Self::Middle(middle) => Intensity::by_middle(middle),
            Self::Level(level) => Intensity::by_level(level),
        }
    }

    /// The intensity of the light that spheres show: compared with its largest where all are for a display.
    pub(crate) fn of_spheres(self, spheres: &[LitSphere], weights: [f32; 3]) -> Intensity {
        let largest = || {
            let each = spheres.iter().map(|s| s.largest_luminance(weights));
            each.fold(0.0, f32::max)
        };
        if self == Self::Auto && spheres.iter().all(LitSphere::is_for_display) {
            return Intensity::by_level(largest());
        }
        self.unlimited(|| {
            let seen = |[x, y, _]: [f32; 3]| spheres.iter().map(move |s| s.color([x, y]));
            let colors = ball().flat_map(seen);
            median(colors, weights).unwrap_or_else(largest)
        })
    }
}

/// How a luminance becomes an intensity: `L / (bend L + level)`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Intensity {
    /// 1 where `level` is a median, 0 where it is the luminance of intensity 1.
    pub(crate) bend: f32,
    pub(crate) level: f32,
}

impl Intensity {
    pub(crate) fn by_level(level: f32) -> Self {
        Self {
            bend: 0.0,
            level: level.max(f32::MIN_POSITIVE),
        }
    }

    fn by_middle(middle: f32) -> Self {
        Self {
            bend: 1.0,
            ..Self::by_level(middle)
        }
    }

    /// The median that light is compared with, if it is.
    pub(crate) fn middle(self) -> Option<f32> {
        (self.bend > 0.0).then_some(self.level)
    }

    /// The intensity of a finite `luminance`.
    #[inline(always)]
    pub(crate) fn of(self, luminance: f32) -> f32 {
        luminance / (self.bend * luminance + self.level)
    }
}

/// The normals of a ball seen from the front, one for each of its pixels.
pub(crate) fn ball() -> impl Iterator<Item = [f32; 3]> {
    let across = |i: usize| (2 * i + 1) as f32 / BALL_PX as f32 - 1.0;
    let pixels = (0..BALL_PX * BALL_PX).map(move |i| [across(i % BALL_PX), -across(i / BALL_PX)]);
    pixels.filter_map(|[x, y]| {
        let square = 1.0 - x * x - y * y;
        (square >= 0.0).then(|| [x, y, square.sqrt()])
    })
}

/// The median luminance of `colors`; if that is 0, that of those which are not black. `None` if all are.
pub(crate) fn median(colors: impl Iterator<Item = [f32; 3]>, weights: [f32; 3]) -> Option<f32> {
    let luminances = colors.map(|color| crate::frame::luminance(color, weights));
    let mut luminances: Vec<f32> = luminances.collect();
    let middle = |of: &mut Vec<f32>| quantile(of, 0.5, f32::total_cmp).filter(|&m| m > 0.0);
    middle(&mut luminances).or_else(|| {
        luminances.retain(|&luminance| luminance > 0.0);
        middle(&mut luminances)
    })
}

/// A look-up map, and the intensity of its light.
#[derive(Debug)]
pub(crate) struct Map {
    pub(crate) environment: Environment,
    pub(crate) intensity: Intensity,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{ColorPlanes, Plane};

    /// A grey sphere of this luminance by its normal's x and y.
    fn sphere(luminance: impl Fn(f32, f32) -> f32) -> LitSphere {
        let across = |i: usize| (2 * i + 1) as f32 / 256.0 - 1.0;
        let plane = Plane::from_fn(256, 256, |x, y| luminance(across(x), -across(y)));
        LitSphere::new(ColorPlanes::grey(plane))
    }

    fn of(white: White, spheres: &[LitSphere]) -> Intensity {
        white.of_spheres(spheres, [0.25, 0.5, 0.25])
    }

    #[test]
    fn light_for_a_display_is_compared_with_its_largest_and_other_light_with_its_median() {
        let shown = sphere(|x, _| if x > 0.9 { 1.0 } else { 0.5 });
        assert_eq!(
            of(White::Auto, std::slice::from_ref(&shown)),
            Intensity::by_level(1.0)
        );
        let dark = of(White::Auto, &[shown.clone().scene_linear()]);
        assert_eq!(dark, Intensity::by_middle(0.5));
        // Half of the disc lies right of its middle, where 2 + x has its median.
        let bright = sphere(|x, _| 2.0 + x);
        let found = of(White::Auto, std::slice::from_ref(&bright));
        assert!(
            found.bend == 1.0 && (found.level - 2.0).abs() < 0.01,
            "{found:?}"
        );
        assert_eq!(found.of(found.level), 0.5);
        // Of two spheres, as many samples are up to 1 as there are above.
        let both = of(White::Auto, &[shown.clone(), bright.clone()]);
        assert!((both.level - 1.0).abs() < 0.02, "{both:?}");
        // A level of 4 halves 2; a median of 4 makes it a third.
        assert_eq!(
            of(White::Level(4.0), std::slice::from_ref(&bright)).of(2.0),
            0.5
        );
        assert_eq!(of(White::Middle(4.0), &[shown]).of(2.0), 1.0 / 3.0);
    }

    #[test]
    fn of_a_ball_that_is_mostly_black_the_rest_counts() {
        let lit = sphere(|x, _| if x > 0.5 { 3.0 } else { 0.0 });
        assert_eq!(of(White::Auto, &[lit]), Intensity::by_middle(3.0));
        // Black stays black, and has no division by 0.
        let black = of(White::Auto, &[sphere(|_, _| 0.0)]);
        assert_eq!(black.of(0.0), 0.0);
        assert_eq!(median(std::iter::empty(), [1.0; 3]), None);
    }

    #[test]
    fn one_bright_sample_moves_no_other() {
        let plain = of(White::Auto, &[sphere(|x, _| 2.0 + x)]);
        let spark = |x: f32, y: f32| if x.hypot(y) < 0.01 { 1e6 } else { 2.0 + x };
        let sparkling = of(White::Auto, &[sphere(spark)]);
        for luminance in [1.0, 2.0, 3.0] {
            // Four of 12,868 samples at most: the median moves by a rank or two, each a step of 1/64 at most.
            let moved = sparkling.of(luminance) - plain.of(luminance);
            assert!(moved.abs() < 2e-3, "{luminance}: {moved}");
        }
    }
}
