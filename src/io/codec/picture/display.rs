//! Mapping of light to the range of a display.

use super::agx::agx;
use super::filmic::filmic;
use super::straight::largest;
use crate::frame::ColorPlanes;

/// Light above this value is compressed: 0.906 of a display's range by the sRGB curve.
const KNEE: f64 = 0.8;

/// Light from this value on is white in eight bits: the sRGB curve is at 254.5/255 there, ((0.99804 + 0.055) /
/// 1.055)^2.4 = 0.99555. Compressed light stays below.
pub(super) const WHITE: f64 = 0.9955;

/// Mapping of linear light to the range of a display.
#[derive(Debug, Clone, Copy, Default)]
pub struct Display<'a> {
    /// Exposure in stops.
    pub exposure: f32,
    /// Treatment of light that is too bright.
    pub bright: Bright<'a>,
}

/// Treatment of light that is too bright for a display.
#[derive(Debug, Clone, Copy, Default)]
pub enum Bright<'a> {
    /// Clipped at white, channel by channel.
    #[default]
    Clipped,
    /// Compressed.
    Compressed,
    /// This picture, with the same primaries and alpha, is clipped at white, and the change from it is applied to the
    /// clipped colours as factors, so that shape shows in overexposed parts too. Pixels brighter than before are
    /// compressed.
    ChangedFrom(&'a ColorPlanes),
    /// All light is mapped by AgX, which leaves room for highlights 6.5 stops above middle grey and takes their colour.
    Agx,
    /// All light is mapped by Filmic, which has the room of AgX and keeps purer colours.
    Filmic,
}

/// A display mapping, with its per-picture constants.
#[derive(Debug, Clone, Copy)]
pub(super) struct DisplayMapping<'a> {
    /// The factor of its exposure.
    gain: f64,
    bright: Bright<'a>,
}

impl<'a> Display<'a> {
    /// The mapping of light.
    pub(super) fn mapping(&self) -> DisplayMapping<'a> {
        DisplayMapping {
            gain: f64::from(self.exposure).exp2(),
            bright: self.bright,
        }
    }
}

impl DisplayMapping<'_> {
    /// The displayed colour: `of` reads that of the picture that it was changed from, divided by alpha.
    #[inline]
    pub(super) fn shown(
        &self,
        color: [f64; 3],
        of: impl FnOnce(&ColorPlanes) -> [f64; 3],
    ) -> [f64; 3] {
        let color = times(self.gain, color);
        match self.bright {
            Bright::Clipped => color,
            Bright::Agx => agx(color),
            Bright::Filmic => filmic(color),
            Bright::Compressed => compressed(color, KNEE),
            Bright::ChangedFrom(before) => {
                let before = times(self.gain, of(before));
                compressed(changed(color, before), KNEE.max(largest(before)))
            }
        }
    }
}

#[cfg(feature = "cli")]
impl DisplayMapping<'_> {
    /// Whether a colour is too bright to stay as it is, unless by clipping; `of` is the colour there of the picture that it was changed
    /// from.
    pub(super) fn compresses(
        &self,
        color: [f64; 3],
        of: impl Fn(&ColorPlanes) -> [f64; 3],
    ) -> bool {
        let color = color.map(|v| self.gain * v);
        match self.bright {
            Bright::Clipped | Bright::Agx | Bright::Filmic => false,
            Bright::Compressed => largest(color) > KNEE,
            Bright::ChangedFrom(before) => {
                let before = of(before).map(|v| self.gain * v);
                let before_is = largest(before);
                before_is > 1.0 || largest(changed(color, before)) > KNEE.max(before_is)
            }
        }
    }
}

/// The change from `before`, applied to it clipped at white.
#[inline(always)]
fn changed([r, g, b]: [f64; 3], before: [f64; 3]) -> [f64; 3] {
    let shown = |v: f64| if v.is_finite() { v.max(1.0) } else { 1.0 };
    [
        r / shown(before[0]),
        g / shown(before[1]),
        b / shown(before[2]),
    ]
}

/// A colour whose brightness above the knee stays below white: by a hyperbola whose slope at the knee is 1.
#[inline(always)]
fn compressed(color: [f64; 3], knee: f64) -> [f64; 3] {
    let brightest = largest(color);
    if brightest <= knee || knee >= WHITE || !brightest.is_finite() {
        return color;
    }
    let room = WHITE - knee;
    let beyond = (brightest - knee) / room;
    let below_white = knee + room * (1.0 - 1.0 / (1.0 + beyond));
    times(below_white / brightest, color)
}

#[inline(always)]
fn times(factor: f64, [r, g, b]: [f64; 3]) -> [f64; 3] {
    [factor * r, factor * g, factor * b]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    fn shown(color: [f64; 3], exposure: f32, bright: Bright) -> [f64; 3] {
        let of = |before: &ColorPlanes| before.at(0, 0).map(f64::from);
        Display { exposure, bright }.mapping().shown(color, of)
    }

    fn picture(color: [f32; 3]) -> ColorPlanes {
        let [r, g, b] = color.map(|v| Plane::filled(1, 1, v));
        ColorPlanes { r, g, b }
    }

    fn are_near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
    }

    #[test]
    fn new_light_keeps_order_and_hue_and_stays_below_white() {
        // 0.1955 above the knee is half of the way to white: 0.8 + 0.1955 / 2 = 0.89775.
        let found = shown([0.9955, 0.49775, 0.0], 0.0, Bright::Compressed);
        assert!(are_near(found, [0.89775, 0.448875, 0.0]), "{found:?}");
        // A stop less is a half: below the knee nothing changes.
        let found = shown([1.5, 1.0, 0.5], -1.0, Bright::Compressed);
        assert_eq!(found, [0.75, 0.5, 0.25]);
        let levels: Vec<f64> = (0..400)
            .map(|i| 0.7 * 1.05_f64.powi(i))
            .map(|v| shown([v, 0.5 * v, 0.1 * v], 0.0, Bright::Compressed))
            .inspect(|color| assert!((color[1] / color[0] - 0.5).abs() < 1e-12))
            .map(|color| color[0])
            .collect();
        assert!(levels.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(levels.iter().all(|&v| v < WHITE));
        assert!(levels[..200].windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn what_did_not_change_stays_and_what_became_brighter_is_compressed() {
        let of = |before: [f32; 3], color| {
            let before = picture(before);
            shown(color, 0.0, Bright::ChangedFrom(&before))
        };
        // Unchanged and darker colours are left alone, whites too.
        for color in [[0.95, 0.9, 0.1], [1.0, 1.0, 1.0], [0.3, 0.2, 0.1]] {
            let before = color.map(|v: f64| v as f32);
            let same = before.map(f64::from);
            assert_eq!(of(before, same), same);
            let darker = same.map(|v| 0.7 * v);
            assert_eq!(of(before, darker), darker);
        }
        // Headroom from 0.875 to white is 0.1205; half as bright again is 0.4375 more and leaves 1/(1 + 0.4375/0.1205)
        // of it: 0.9955 - 0.1205 / 4.630705 = 0.969478.
        let found = of([0.875, 0.0, 0.0], [1.3125, 0.0, 0.0]);
        assert!(are_near(found, [0.969478, 0.0, 0.0]), "{found:?}");
        // Colours four times too bright are white if unchanged, and 0.9 of white after losing a tenth.
        assert_eq!(of([4.0, 2.0, 0.5], [4.0, 2.0, 0.5]), [1.0, 1.0, 0.5]);
        let found = of([4.0, 2.0, 0.5], [3.6, 1.8, 0.45]);
        assert!(are_near(found, [0.9, 0.9, 0.45]), "{found:?}");
    }

    #[test]
    fn numbers_without_a_meaning_come_through() {
        let before = picture([f32::NAN, f32::INFINITY, -1.0]);
        for bright in [
            Bright::Clipped,
            Bright::Compressed,
            Bright::ChangedFrom(&before),
        ] {
            for color in [[f64::NAN; 3], [f64::INFINITY; 3], [-1.0; 3], [f64::MAX; 3]] {
                let found = shown(color, 3.0, bright);
                let has_meaning = |v: &f64| !v.is_nan() && (*v > 0.0) == (color[0] > 0.0);
                assert_eq!(
                    found.iter().all(has_meaning),
                    !color[0].is_nan(),
                    "{found:?}"
                );
            }
        }
    }
}
