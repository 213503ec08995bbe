//! Kernels of lines at every level of vector extensions.

use crate::frame::DepthKind;
use crate::kernel::simd::Simd;
use crate::kernel::simd::levels::{WIDTH, assert_same_bits, at, row, rows};
use crate::line::direction::fill;
use crate::line::direction_field::directions::{self, Averaged, Source};
use crate::line::direction_field::forms::{self, Lanes, Neighbourhoods, PatchSource, Tensors};
use crate::line::direction_field::{self, Weighted, between_patches, patches};
use crate::line::normal_rays::bundle::{self, Bundle, Directions, Pixels, PointSource};
use crate::line::placed::{self, Beside};
use crate::line::specular::map_directions::{self, LargerTangents};

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
    let [mut x, mut y] = [(); 2].map(|()| vec![0.0; 4 * (WIDTH - 2)]);
    let [own, beside]: [Vec<[[f32; 2]; 1]>; 2] =
        [0, 1].map(|r| (0..WIDTH).map(|i| [[gx[r][i], gy[r][i]]]).collect());
    let places = [-0.375, -0.125, 0.125, 0.375];
    at!(
        simd,
        between_patches::spread_row(&mut [[&mut x, &mut y]], &own, &beside, 0.125, &places)
    );
    results.extend([x, y]);
    results.extend(made_of_rays(simd));
    results.extend(made_of_patches(simd));
    results.extend(made_of_curvature(simd));
    results.extend(made_of_cells(simd, &gx, &gy));
    results.extend(made_of_points(simd));
    results.extend(made_of_texels(simd));
    results
}

/// Directions of curvature on sample pixels, for every way from pixels to points.
fn made_of_rays(simd: Simd) -> Vec<Vec<f32>> {
    const LANES: usize = bundle::LANES;
    let lanes = |seed: u32| std::array::from_fn(|i| row(seed)[i]);
    let places = |seed: u32, scale: f64| lanes(seed).map(|v: f32| scale * f64::from(v));
    let pixels = |seed: u32, scale: f64| Pixels {
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

/// Tensors of patches in perspective, and in parallel lines.
fn made_of_patches(simd: Simd) -> Vec<Vec<f32>> {
    let lanes = |seed: u32, scale: f64| {
        std::array::from_fn::<f64, { forms::LANES }, _>(|i| scale * f64::from(row(seed)[i]))
    };
    // Nearly one normal, at places a few pixels apart: most lanes have a tensor.
    let patches = |seed: u32| Lanes {
        normal: [lanes(seed, 0.2), lanes(seed + 1, 0.2), [0.8; forms::LANES]],
        line: [lanes(seed + 2, 0.01), lanes(seed + 3, 0.01)],
        is_there: std::array::from_fn(|lane| u8::from(lane % 7 != seed as usize % 5)),
    };
    let around = Neighbourhoods {
        here: patches(90),
        beside: [96, 102, 108, 114].map(patches),
    };
    let made = [false, true].map(|is_perspective| {
        let source = PatchSource {
            is_perspective,
            step_px: 4.0,
            pixels: 800.0,
        };
        let mut found = Tensors::default();
        at!(simd, forms::patch_tensors(&mut found, &around, &source));
        let known = found.mean.iter().filter(|&&mean| mean != 0.0).count();
        assert!(known > forms::LANES / 2, "{known}");
        [found.x, found.y, found.mean].concat()
    });
    made.to_vec()
}

/// Directions of patches in perspective, and in parallel lines, of both curvatures.
fn made_of_curvature(simd: Simd) -> Vec<Vec<f32>> {
    let lanes = |seed: u32| std::array::from_fn::<f32, { forms::LANES }, _>(|i| row(seed)[i]);
    let small = |seed: u32, scale: f32| lanes(seed).map(|v| scale * (v - 0.5));
    let patches = directions::Lanes {
        normal: [lanes(150), small(151, 1.0), lanes(152)].map(|n| n.map(f64::from)),
        line: [small(153, 0.5), small(154, 0.5)].map(|l| l.map(f64::from)),
        // Flat, round, straight and twisted.
        form: [small(155, 0.02), small(156, 0.002), small(157, 0.01)],
        fallback: [[small(158, 2.0), small(159, 2.0)]; 2],
    };
    let mut made = Vec::new();
    for is_perspective in [false, true] {
        let source = Source {
            is_perspective,
            pixel_shape: 1.25,
            doubt: 1e-3,
            families: [1, 0],
        };
        let mut found = [[[0.0; forms::LANES]; 3]; 2];
        at!(
            simd,
            directions::patch_directions(&mut found, &patches, &source)
        );
        let sure = found[0][2].iter().filter(|&&sure| sure > 0.1).count();
        assert!(sure > forms::LANES / 4, "{sure}");
        made.extend(found.as_flattened().iter().map(|lanes| lanes.to_vec()));
        let averaged = Averaged {
            own: found[0],
            around: [found[1][0], found[1][1]],
        };
        let mut calmed = [[0.0; forms::LANES]; 2];
        at!(simd, directions::calm_patches(&mut calmed, &averaged));
        // Some of them short.
        let mut settled = calmed.map(|lanes| lanes.map(|v| 0.1 * v));
        at!(
            simd,
            directions::settle_patches(&mut settled, &patches.fallback[0])
        );
        made.extend([calmed, settled].as_flattened().iter().map(|l| l.to_vec()));
    }
    made
}

/// Normals and sums in the middle of cells of four pixels, open pixels, and those without a direction.
fn made_of_cells(simd: Simd, a: &[Vec<f32>; 3], b: &[Vec<f32>; 3]) -> Vec<Vec<f32>> {
    let cells = WIDTH / 4;
    let rows = |i: usize| [a[i].as_chunks().0, b[i].as_chunks().0];
    let blank = || vec![0.0; cells];
    let [mut x, mut y, mut z, mut sums] = [blank(), blank(), blank(), blank()];
    at!(
        simd,
        patches::middle_normals([&mut x, &mut y, &mut z], [rows(0), rows(1), rows(2)])
    );
    at!(simd, patches::middle_sums(&mut sums, rows(0)));
    let [mut open, mut lacking] = [vec![3; WIDTH], vec![0; WIDTH]];
    at!(simd, patches::count_open_row(&mut open, &a[0]));
    let some = a.each_ref().map(|row| {
        let kept = row.iter().map(|&v| if v < 0.5 { 0.0 } else { v });
        kept.collect::<Vec<f32>>()
    });
    let covered: Vec<bool> = b[0].iter().map(|&v| v > 0.1).collect();
    at!(
        simd,
        fill::lacking_in_row(&mut lacking, [&some[0], &some[1]], &covered)
    );
    let bytes = |row: Vec<u8>| row.into_iter().map(f32::from).collect();
    let halves = |row: Vec<f64>| row.into_iter().map(|v| v as f32).collect();
    let mut made = [x, y, z, sums].map(halves).to_vec();
    made.extend([open, lacking].map(bytes));
    made
}

/// Distances to points of other lines on both sides.
fn made_of_points(simd: Simd) -> Vec<Vec<f32>> {
    let [x, y] = [170, 171].map(row);
    let lines: Vec<u32> = row(172).iter().map(|v| (4.0 * v) as u32).collect();
    let points = || [&x, &y].map(|axis| axis.as_chunks().0);
    let room = |i: usize, limit: f32| {
        let mut squares = [f32::INFINITY; 2];
        let beside = Beside {
            at: [x[i], y[i]],
            along: [y[i + 1], x[i + 1] - 0.5],
            line: lines[i],
            least_across: 0.5,
            limit,
        };
        at!(
            simd,
            placed::nearest_beside(&mut squares, points(), lines.as_chunks().0, &beside)
        );
        squares.to_vec()
    };
    let numbers = 0..WIDTH - 1;
    let near = numbers.clone().map(|i| room(i, 0.01));
    near.chain(numbers.map(|i| room(i, f32::NAN))).collect()
}

/// Tangents on a wall with small bumps, one unit from texel to texel.
fn made_of_texels(simd: Simd) -> Vec<Vec<f32>> {
    let texels = |seed: u32, [x, y]: [f32; 2]| {
        let middles = [x, y, 9.0, 0.0, 0.0, 1.0];
        let components = std::array::from_fn(|k| {
            let bumps = row(seed + k as u32);
            std::array::from_fn(|lane| middles[k] + 0.1 * bumps[lane])
        });
        map_directions::Lanes {
            components,
            is_there: std::array::from_fn(|lane| u8::from(lane % 7 != seed as usize % 5)),
        }
    };
    let bundle = map_directions::Bundle {
        here: texels(120, [0.0; 2]),
        beside: [
            [texels(126, [-1.0, 0.0]), texels(132, [1.0, 0.0])],
            [texels(138, [0.0, -1.0]), texels(144, [0.0, 1.0])],
        ],
    };
    let mut found = LargerTangents::default();
    at!(
        simd,
        map_directions::larger_curvature_tangents(&mut found, &bundle, 1e-7)
    );
    let known = found.components[0].iter().filter(|&&x| x != 0.0).count();
    assert!(known > map_directions::LANES / 2, "{known}");
    let forms = found.forms.map(|form| form as u8 as f32);
    let mut made = found.components.map(Vec::from).to_vec();
    made.push(forms.into());
    made
}

#[test]
fn wider_vectors_give_the_same_bits() {
    assert_same_bits(made);
}
