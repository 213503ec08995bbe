//! Filmic: a mapping of scene-linear light to a display in which bright colours go to white, as Blender had it before AgX.
//!
//! Theory: T. Sobotka's Filmic in Blender 2.79 to 3.6, medium contrast. Its tables were measured: the nodes of the cube
//! that takes colour from bright light are one formula, met within 4e-6, and the curve is kept at 17 places, 0.25 of 255
//! levels from its own 4096. Change: the formula has its corner, 6 stops above middle grey, where the cube's cells round it:
//! 99 of 100 colours are within 0.5 levels, the rest up to 3.3.

use crate::srgb::decoded;

/// Light of the middle grey, which the curve takes to half of a display's code.
const GREY: f64 = 0.18;

/// Stops below middle grey that become black, and above it that become white.
const STOPS: [f64; 2] = [10.0, 6.5];

/// Stops above middle grey at which colours begin to lose their purity, and at which they have none.
const LOSES: [f64; 2] = [6.0, 15.0];

/// The power of that loss.
const LOSS: f64 = 1.1;

/// The sRGB codes of the curve, evenly spaced in the logarithm of light.
const CURVE: [f64; 17] = [
    0.0, 0.00448, 0.0118, 0.02368, 0.04277, 0.07296, 0.11941, 0.18803, 0.28332, 0.40471, 0.5424,
    0.67869, 0.79727, 0.88742, 0.94775, 0.98303, 1.0,
];

/// Linear light of a display, Rec. 709, for scene-linear Rec. 709. NaN stays.
pub(super) fn filmic(color: [f64; 3]) -> [f64; 3] {
    let brightest = color.into_iter().fold(0.0, f64::max);
    let [first, last] = LOSES.map(|stops| GREY * stops.exp2());
    let bright = brightest.min(last);
    let lost = ((bright - first).max(0.0) / (last - first)).powf(LOSS);
    color.map(|v| match v.is_nan() {
        true => v,
        false => {
            let light = v.clamp(0.0, last);
            decoded(curve(light + lost * (bright - light)))
        }
    })
}

/// The sRGB code of this light: Catmull and Rom's cubic between the places of the curve.
fn curve(light: f64) -> f64 {
    let [below, above] = STOPS;
    let intervals = CURVE.len() - 1;
    let x = ((light / GREY).log2() + below) / (below + above);
    let x = x.clamp(0.0, 1.0) * intervals as f64;
    let k = (x as usize).min(intervals - 1);
    let t = x - k as f64;
    let [b, c] = [CURVE[k], CURVE[k + 1]];
    // Beyond its ends the curve goes on as a line.
    let a = match k {
        0 => 2.0 * b - c,
        _ => CURVE[k - 1],
    };
    let d = CURVE.get(k + 2).copied().unwrap_or(2.0 * c - b);
    let cubic = 3.0 * (b - c) + d - a;
    let square = 2.0 * a - 5.0 * b + 4.0 * c - d;
    b + 0.5 * t * (c - a + t * (square + t * cubic))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::srgb::encoded;

    #[test]
    fn codes_are_those_of_its_tables() {
        // What OpenColorIO gives for Blender 3.4's tables, in sRGB codes.
        for (light, expected) in [
            ([0.01; 3], [0.1011; 3]),
            ([0.18; 3], [0.50021; 3]),
            ([1.0; 3], [0.80724; 3]),
            ([8.0; 3], [0.98316; 3]),
            ([0.5, 0.2, 0.05], [0.69495, 0.5207, 0.27308]),
            ([30.0, 2.0, 0.5], [1.0, 0.89478, 0.71288]),
            ([16.0, 0.0, 0.0], [0.99974, 0.06978, 0.06978]),
            ([200.0, 0.0, 0.0], [1.0, 0.95707, 0.95707]),
            ([1e6, 1.0, -3.0], [1.0; 3]),
        ] {
            let found = filmic(light).map(encoded);
            for k in 0..3 {
                let off = (found[k] - expected[k]).abs();
                assert!(off < 0.3 / 255.0, "{light:?}: {found:?}, not {expected:?}");
            }
        }
        let odd = filmic([f64::NAN, f64::INFINITY, -1.0]);
        assert!(
            odd[0].is_nan() && odd[1..].iter().all(|v| (v - 1.0).abs() < 1e-9),
            "{odd:?}"
        );
    }
}
