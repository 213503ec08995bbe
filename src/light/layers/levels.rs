//! Kernels of light layers at every level of vector extensions.

use crate::kernel::simd::Simd;
use crate::kernel::simd::levels::{WIDTH, assert_same_bits, at, rows};
use crate::light::layers::{self, LobeRow, TermScaling};
use crate::light::radiance_scaling::cpu::{Scaler, scale_row};
use crate::params::Magnitude;

/// Results of the light-layer kernels on sample rows.
fn made(simd: Simd) -> Vec<Vec<f32>> {
    let (a, b) = (rows(1), rows(4));
    let [a, b] = [&a, &b].map(|rows| [&rows[0][..WIDTH], &rows[1][..WIDTH], &rows[2][..WIDTH]]);
    let covered: Vec<bool> = b[1].iter().map(|&v| v > 0.1).collect();
    let by = TermScaling {
        magnitude: Magnitude::of_both(1.3),
        invariant_point: 0.25,
        white: 0.8,
        weights: [0.2, 0.7, 0.1],
    };
    let blank = || vec![0.0; WIDTH];
    let [mut kappa, mut toward, mut lobe, mut group] = [blank(), blank(), blank(), blank()];
    let [mut plain, mut scaled, mut change, mut layered] = [blank(), blank(), blank(), blank()];
    at!(simd, layers::kappa_row(&mut kappa, a[0], -3.0));
    at!(
        simd,
        layers::kappa_toward_row(&mut toward, a, [0.6, -0.3], 2.0, 0.7)
    );
    let row = LobeRow {
        direct: a,
        indirect: b,
        color: a,
        albedo: b,
    };
    at!(simd, layers::lobe_sigma_row(&mut lobe, &row, &kappa, &by));
    at!(
        simd,
        layers::add_direction_row(&mut plain, &mut scaled, a, [0.6, 0.0, -0.8], &toward, &by)
    );
    at!(simd, layers::group_sigma_row(&mut group, &plain, &scaled));
    at!(
        simd,
        layers::add_change_row(&mut change, &mut layered, a, &lobe)
    );
    let mut out = blank();
    at!(
        simd,
        layers::changed_row(&mut out, b[0], &change, &layered, &covered)
    );
    let scaler = Scaler {
        magnitude: Magnitude {
            convex: 1.0,
            concave: 0.4,
        },
        invariant_point: 0.25,
        gain: -3.0,
        white: 0.8,
        weights: by.weights,
    };
    let mut results = vec![toward, plain, scaled, group, out];
    for given in [None, Some(a[1])] {
        let [mut red, mut green, mut blue] = [blank(), blank(), blank()];
        let color = [&mut red[..], &mut green[..], &mut blue[..]];
        at!(simd, scale_row(&scaler, color, b, given, a[0], &covered));
        results.extend([red, green, blue]);
    }
    results
}

#[test]
fn wider_vectors_give_the_same_bits() {
    assert_same_bits(made);
}
