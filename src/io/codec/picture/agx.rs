//! AgX: a mapping of scene-linear light to a display that rolls highlights off toward white.
//!
//! Theory: T. Sobotka's AgX as Blender has it (E. Chow, AgX_LUT_Gen, AgXBasesRGB.py), simplified as by A. Pestaluky
//! (AgX-GLSL-Shaders, earychow-agx-simplified): colours are drawn toward grey, each channel's logarithm goes through a
//! sigmoid, and part of the purity is given back. Change, as there: negative light is 0, and hues are not turned back
//! after the sigmoid; greys are exact.

/// Rec. 709 to the inset of Rec. 2020.
const INSET: [[f64; 3]; 3] = [
    [0.54490813676363, 0.37377945959812, 0.08138497668641],
    [0.14044005884001, 0.75410959864014, 0.10543358536858],
    [0.08882741185192, 0.17887712465044, 0.73224999956948],
];

/// The way back, to an outset that is narrower.
const OUTSET: [[f64; 3]; 3] = [
    [1.96455096027333, -0.85585845117808, -0.10886710826832],
    [-0.29932243390911, 1.32645107415024, -0.02708402098387],
    [-0.16436833806080, -0.23822464068861, 1.40266534714327],
];

/// Light of the middle grey, which stays.
const GREY: f64 = 0.18;

/// Stops below middle grey that become black, and above it that become white.
const STOPS: [f64; 2] = [10.0, 6.5];

/// Slope of the sigmoid at middle grey, the power of its ends, and that of the display it is for.
const SLOPE: f64 = 2.4;
const ENDS: f64 = 1.5;
const DISPLAY: f64 = 2.4;

/// Linear light of a display, Rec. 709, for scene-linear Rec. 709. NaN stays.
pub(super) fn agx(color: [f64; 3]) -> [f64; 3] {
    let light = color.map(|v| v.max(0.0));
    let shown = product(&INSET, light).map(|v| sigmoid(v).powf(DISPLAY));
    let shown = product(&OUTSET, shown);
    std::array::from_fn(|k| {
        if color[k].is_nan() {
            color[k]
        } else {
            shown[k]
        }
    })
}

/// The value of a display with a power for this light.
fn sigmoid(light: f64) -> f64 {
    let [below, above] = STOPS;
    let pivot = below / (below + above);
    let grey = GREY.powf(1.0 / DISPLAY);
    let x = (((light / GREY).log2() + below) / (below + above)).clamp(0.0, 1.0);
    let line = SLOPE * (x - pivot);
    // The line at the pivot bends so that it reaches 0 at one end and 1 at the other.
    let (room, run) = match x < pivot {
        true => (grey, pivot),
        false => (1.0 - grey, 1.0 - pivot),
    };
    let bend = (room.powf(-ENDS) - (SLOPE * run).powf(-ENDS)) * line.abs().powf(ENDS);
    (grey + line / (1.0 + bend).powf(1.0 / ENDS)).max(0.0)
}

fn product(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_follow_the_published_curve_and_bright_colours_lose_theirs() {
        // The published curve from its own constants, in the logarithm of light: 0 for 10 stops below middle grey, 1
        // for 6.5 above; its display has a power of 2.4.
        for (light, expected) in [
            (1e-5, 0.0),
            (0.01, 0.120_774_598_513),
            (0.18, 0.489_437_089_574),
            (1.0, 0.783_034_430_557),
            (8.0, 0.963_791_944_794),
        ] {
            // The rows of the outset add up to 1 but for 2e-4.
            let expected: f64 = f64::powf(expected, 2.4);
            let found = agx([light; 3]);
            assert!(
                found
                    .iter()
                    .all(|v| (v - expected).abs() <= 2e-4 * expected),
                "{light}: {found:?}, not {expected}"
            );
        }
        let [_, dim, _] = agx([0.18, 0.0, 0.0]);
        let [_, bright, blue] = agx([16.0, 0.0, 0.0]);
        assert!(
            dim < 0.02 && bright > 0.5 && blue > 0.5,
            "{dim} {bright} {blue}"
        );
        let odd = [f64::NAN, f64::INFINITY, -1.0];
        let found = agx(odd);
        assert!(
            found[0].is_nan() && found[1..].iter().all(|v| !v.is_infinite()),
            "{found:?}"
        );
    }
}
