//! Kernels of shape at every level of vector extensions.

use crate::frame::gap::rows::{self, GapRow};
use crate::frame::gap::scale::GapScale;
use crate::frame::{DepthKind, Frame, Mask, Vector3Planes};
use crate::kernel::simd::Simd;
use crate::kernel::simd::levels::{
    BASELINE, WIDTH, assert_same_bits, at, fused, row, rows as rows_of,
};
use crate::params::SoftThreshold;
use crate::shape::crease::{self, NormalRows};
use crate::shape::curvature::cpu;
use crate::shape::diffusion::kernel::{self, Chunk, FlowSweep, Sum};
use crate::shape::diffusion::{self, LEVELS, Update};
use crate::shape::occlusion::{self, SliceStep};
use crate::shape::{Rows, conductance, hessian, silhouette};

fn around(rows: &[Vec<f32>; 3]) -> Rows<'_> {
    Rows {
        above: &rows[0],
        at: &rows[1],
        below: &rows[2],
    }
}

/// Results of the kernels on sample rows.
fn made(simd: Simd) -> Vec<Vec<f32>> {
    let (gx, gy) = (rows_of(1), rows_of(4));
    let open = rows_of(7).map(|row| row.into_iter().map(|c| c.max(0.4) / 0.4).collect());
    let open = open.map(|row: Vec<f32>| row.into_iter().map(|c| 1.0 / c).collect::<Vec<f32>>());
    let covered = [0, 1, 2].map(|y| row(30 + y).into_iter().map(|v| v > 0.1).collect());
    let covered: [Vec<bool>; 3] = covered;
    let seen = Rows {
        above: &covered[0],
        at: &covered[1],
        below: &covered[2],
    };
    let columns = || 0..WIDTH;
    let blank = || vec![0.0; WIDTH];
    let [mut trace, mut faces, mut gaps] = [blank(), blank(), blank()];
    let [mut cosines, mut silhouette, mut conductance] = [blank(), blank(), blank()];

    let [x, y, c] = [&gx, &gy, &open].map(around);
    at!(simd, hessian::trace_row(&mut trace, &x, &y, &c, columns()));
    at!(
        simd,
        conductance::face_conductance_row(&mut faces, &open[0], &open[1])
    );
    let [mut front, mut beside] = [blank(), blank()];
    made_of_gaps(simd, &gx, &gy, [&mut gaps, &mut front, &mut beside]);
    let normals = NormalRows { x, y, z: c };
    at!(
        simd,
        crease::least_cosine_row(&mut cosines, &normals, &seen, columns())
    );
    let threshold = SoftThreshold { lo: 0.1, hi: 0.5 };
    at!(
        simd,
        silhouette::jumps_row(&mut silhouette, &x, columns(), threshold)
    );
    let both = [&mut silhouette[..]];
    at!(simd, silhouette::close_border_row(both, &seen, columns()));
    at!(
        simd,
        conductance::conductance_row(&mut conductance, &gx[0], &gy[0], &covered[0])
    );
    let hessian = [&gx[0][..], &gy[0], &gx[1]];
    let [u, v, mean] = &mut [(); 3].map(|()| blank());
    at!(
        simd,
        cpu::curvatures_row([u, v, mean], hessian, &covered[1][..WIDTH])
    );
    let [along, upward, mapped] = &mut [(); 3].map(|()| blank());
    at!(
        simd,
        cpu::directions_row([along, upward], hessian, &covered[1][..WIDTH])
    );
    at!(
        simd,
        cpu::mapped_row([mapped], &gx[0], 3.0, &covered[1][..WIDTH])
    );

    let mut results = vec![trace, faces, gaps, cosines, silhouette, conductance];
    results.extend([front, beside]);
    let of_curvature = [u, v, mean, along, upward, mapped];
    results.extend(of_curvature.map(std::mem::take));
    for update in UPDATES {
        results
            .extend([swept::<8>(simd, update), swept::<16>(simd, update)].map(|[terms, _]| terms));
    }
    results.extend(made_of_sky(simd, &gx, &gy));
    results
}

const UPDATES: [Update; 3] = [Update::Step(0.2), Update::First, Update::Next];

/// What the kernels of diffusion make of six sample rows, by sweeps of four rows, then of one: the terms, and their
/// sums.
fn swept<const N: usize>(simd: Simd, update: Update) -> [Vec<f32>; 2] {
    let count = WIDTH / N;
    let mut seed = 40;
    let mut lanes = || {
        seed += 1;
        row(seed).as_chunks::<N>().0[..count].to_vec()
    };
    let mut rows: [Vec<Chunk<N>>; 6] = std::array::from_fn(|_| {
        let [even_x, even_y, odd_x, odd_y, left, above] = std::array::from_fn(|_| lanes());
        let chunk = |i| Chunk {
            terms: [[even_x[i], even_y[i]], [odd_x[i], odd_y[i]]],
            left: left[i],
            above: above[i],
        };
        (0..count).map(chunk).collect()
    });
    let mut sums: [_; 4] = std::array::from_fn(|_| vec![Sum([[0.5; N]; 2]); count]);
    let sweep = FlowSweep {
        update,
        from: 1,
        weights: [0.7, -0.2],
    };
    let [above, a, b, c, d, below] = &mut rows;
    let into = sums.each_mut().map(|sum| &mut sum[..]);
    at!(simd, |fma| kernel::sweep_rows(
        fma,
        above,
        [a, b, c, d],
        below,
        into,
        sweep
    ));
    let [above, at, below, ..] = &mut rows;
    let again = FlowSweep { from: 0, ..sweep };
    at!(simd, |fma| kernel::sweep_row(
        fma,
        above,
        at,
        below,
        &mut sums[0],
        again
    ));
    at!(simd, |fma| kernel::sweep_row(
        fma,
        above,
        at,
        below,
        &mut [],
        sweep
    ));

    let levels: Vec<_> = (0..count).map(|i| [(i % 8) as u16; N]).collect();
    let weights = std::array::from_fn::<f32, LEVELS, _>(|i| 0.3 + i as f32);
    let few = weights.first_chunk().expect("there are more in all");
    let mut by_few = sums[1].clone();
    at!(simd, |fma| diffusion::add_terms_by_few_levels_row(
        fma,
        &mut by_few,
        &rows[2],
        0,
        &levels,
        [few, few]
    ));
    at!(simd, |fma| diffusion::add_terms_by_level_row(
        fma,
        &mut sums[1],
        &rows[2],
        0,
        &levels,
        [&weights, &weights]
    ));
    let numbers =
        |sum: &[Sum<N>]| -> Vec<f32> { sum.iter().flat_map(|sum| sum.0).flatten().collect() };
    assert_eq!(numbers(&by_few), numbers(&sums[1]));
    at!(simd, |fma| diffusion::add_terms_row(
        fma,
        &mut sums[2],
        &rows[3],
        1,
        [0.7, -0.2]
    ));
    let terms = rows.iter().flatten().flat_map(|chunk| chunk.terms);
    let sums = sums.iter().flat_map(|sum| numbers(sum));
    [terms.flatten().flatten().collect(), sums.collect()]
}

/// Strengths of gaps across, and silhouettes of gaps, of sample rows.
fn made_of_gaps(simd: Simd, a: &[Vec<f32>; 3], b: &[Vec<f32>; 3], out: [&mut [f32]; 3]) {
    let normal = [&a[0][..WIDTH], &b[0][..WIDTH], &a[1][..WIDTH]];
    let covered: Vec<bool> = b[1].iter().map(|&v| v > 0.1).collect();
    let mut frame = Frame::of_normals(
        Vector3Planes::from_fn(WIDTH, 1, |_, _| glam::DVec3::Z),
        Mask::full(WIDTH, 1),
    );
    frame.source.depth_kind = DepthKind::Ray;
    let scale = GapScale::of(&frame, SoftThreshold { lo: 0.01, hi: 1.0 });
    let depth: Vec<f32> = b[2][..WIDTH].iter().map(|v| 1.0 + v).collect();
    let samples = rows::GapSamples {
        first: 0,
        depth: &depth,
        covered: &covered[..WIDTH],
        normal,
        to_eye: (&a[2], 0.2),
    };
    let mut row = GapRow::new(WIDTH);
    at!(simd, rows::fill_gap_row(&mut row, &samples, &scale));
    let [across, front, beside] = out;
    let along = rows::Along {
        axis: 0,
        first: 0,
        normals: [normal[0], &normal[0][1..]],
    };
    let after = &mut across[1..];
    let mut found = Vec::new();
    at!(
        simd,
        rows::gap_strength_row(after, &mut found, [&row; 4], &along, &scale)
    );
    assert!(after.iter().any(|&strength| strength < 0.0));
    let across = [&[0.0], &*across, &[0.0; 2]].concat();
    let down = [&b[1][..], &a[1], &b[0], &a[0]];
    at!(
        simd,
        silhouette::silhouettes_of_gaps_row([front, beside], &across, down)
    );
}

/// Results of the occlusion kernels on sample rows.
fn made_of_sky(simd: Simd, a: &[Vec<f32>; 3], b: &[Vec<f32>; 3]) -> Vec<Vec<f32>> {
    let [a, b] = [a, b].map(|rows| [&rows[0][..WIDTH], &rows[1][..WIDTH], &rows[2][..WIDTH]]);
    let covered: Vec<bool> = b[1].iter().map(|&v| v > 0.1).collect();
    let blank = || vec![0.0; WIDTH];
    let [mut p, mut q, mut horizon] = [blank(), blank(), blank()];
    let [mut seen, mut x, mut y, mut z] = [blank(), blank(), blank(), blank()];
    at!(simd, occlusion::tangent_row(&mut p, &mut q, a));
    let step = SliceStep::along([0.8, 0.6], 5.0);
    at!(simd, occlusion::raise_row(&mut horizon, b, [&p, &q], &step));
    let out = [&mut seen[..], &mut x[..], &mut y[..], &mut z[..]];
    at!(
        simd,
        occlusion::add_slice_row(out, a, [&horizon, b[0], &p, &q], [0.8, 0.6])
    );
    let out = [&mut seen[..], &mut x[..], &mut y[..], &mut z[..]];
    at!(simd, occlusion::finish_row(out, a, &covered, 0.125));
    vec![p, q, horizon, seen, x, y, z]
}

#[test]
fn wider_vectors_give_the_same_bits() {
    assert_same_bits(made);
}

#[test]
fn sums_of_terms_have_the_same_bits_wherever_multiply_adds_are_fused() {
    for update in UPDATES {
        let summed = |simd: Simd| {
            let [eight, sixteen] = [swept::<8>(simd, update), swept::<16>(simd, update)];
            [eight, sixteen].map(|[_, sums]| sums)
        };
        let separate = summed(BASELINE);
        let mut fused = fused();
        let Some(first) = fused.next().map(&summed) else {
            eprintln!("skipped: this machine has no fused multiply-adds");
            return;
        };
        for simd in fused {
            assert_eq!(summed(simd), first, "{simd:?}");
        }
        for (fused, separate) in first.iter().zip(&separate) {
            // The largest are the sums by level: a pair of terms up to 2.6 is added with weights up to 7.3, rounded
            // twice instead of four times at magnitudes up to 38, five times the largest sum: 5 (2 + 4) 2^-24.
            let largest = separate.iter().fold(0.0_f32, |a, b| a.max(b.abs()));
            for (a, b) in fused.iter().zip(separate) {
                assert!((a - b).abs() <= 1.8e-6 * largest, "{update:?}: {a} and {b}");
            }
        }
    }
}
