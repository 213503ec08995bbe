//! Kernels of lines at every level of vector extensions.

use crate::frame::DepthKind;
use crate::kernel::simd::Simd;
use crate::kernel::simd::levels::{WIDTH, assert_same_bits, at, row, rows};
use crate::line::direction_field::{self, Weighted};
use crate::line::normal_rays::bundle::{self, Bundle, BundlePixels, Directions, PointSource};

/// Results of the kernels on sample rows.
fn made(simd: Simd) -> Vec<Vec<f32>> {
    let (gx, gy) = (rows(1), rows(4));
    let [mut half_x, mut half_y] = [gx[0].clone(), gy[0].clone()];
    at!(simd, direction_field::halve_row(&mut half_x, &mut half_y));
    let mut results = vec![half_x, half_y];
    let value = |row: usize, i| [gx[row][i], gy[row][i], gx[row + 1][i], 1.0];
    let chain: Vec<[Weighted; 2]> = (0..WIDTH).map(|i| [value(0, i), value(1, i)]).collect();
    let reach: Vec<f32> = gy[1].iter().map(|v| 0.5 + 9.0 * v).collect();
    let mut sums = vec![[[0.0; 4]; 2]; WIDTH];
    at!(
        simd,
        direction_field::sums_along(&mut sums, &chain, &reach[..WIDTH], &mut Vec::new())
    );
    results.push(sums.concat().concat());
    results.extend(made_of_rays(simd));
    results
}

/// Directions of curvature on sample pixels, for every way from pixels to points.
fn made_of_rays(simd: Simd) -> Vec<Vec<f32>> {
    const LANES: usize = bundle::LANES;
    let lanes = |seed: u32| std::array::from_fn(|i| row(seed)[i]);
    let places = |seed: u32, scale: f64| lanes(seed).map(|v: f32| scale * f64::from(v));
    let pixels = |seed: u32, scale: f64| BundlePixels {
        // Nearly one normal, at places a few pixels apart: most lanes have a direction.
        normal: [lanes(seed), lanes(seed + 1), [4.0; LANES]].map(|c| c.map(|v| 0.2 * v)),
        depth: lanes(seed + 2).map(|v: f32| 5.0 + 0.001 * v),
        across: places(seed + 3, scale),
        up: places(seed + 4, scale),
        is_there: std::array::from_fn(|lane| u8::from(lane % 7 != seed as usize % 5)),
    };
    let kinds = [None, Some(DepthKind::Planar), Some(DepthKind::Ray)];
    let ways = [(false, 1.0), (true, 0.01)].map(|way| kinds.map(|depth| (way, depth)));
    let made = ways
        .as_flattened()
        .iter()
        .map(|&((is_perspective, scale), depth)| {
            let bundle = Bundle {
                here: pixels(40, scale),
                beside: [50, 61, 72, 83].map(|seed| pixels(seed, scale)),
                steps_px: [[2.0; LANES]; 2],
            };
            let source = PointSource {
                depth,
                is_perspective,
                pixel_shape: 1.25,
                normal_noise: 1e-7,
                offset_noise: 1e-8,
            };
            let mut found = Directions::default();
            at!(
                simd,
                bundle::larger_curvature_directions(&mut found, &bundle, &source)
            );
            let forms = found.forms.map(|form| form as u8 as f32);
            let known = forms.iter().filter(|&&form| form > 0.0).count();
            assert!(known > LANES / 2, "{known} of {LANES} at {depth:?}");
            [found.x, found.y, forms].concat()
        });
    made.collect()
}

#[test]
fn wider_vectors_give_the_same_bits() {
    assert_same_bits(made);
}
