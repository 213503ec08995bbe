//! Row kernels compiled for vectors wider than the baseline's, chosen at run time.
//!
//! The compiler widens the same loops; it neither reorders nor contracts floating-point operations, so every level
//! gives the same bits. Only a kernel that asks for fused multiply-adds may give others where there are none.

/// Vector extensions of this machine. Only [`Simd::available`] constructs one, for features it has detected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Simd(Level);

/// Vector extensions that a kernel is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Level {
    /// The baseline of the target.
    Baseline,
    /// 256 bits, with fused multiply-adds.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 512 bits, with fused multiply-adds.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Simd {
    /// All levels of this machine, the widest last.
    pub(crate) fn available() -> Vec<Self> {
        #[cfg(not(target_arch = "x86_64"))]
        let levels = vec![Self(Level::Baseline)];
        #[cfg(target_arch = "x86_64")]
        let levels = {
            let mut levels = vec![Self(Level::Baseline)];
            let has_avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if has_avx2 {
                levels.push(Self(Level::Avx2));
            }
            if has_avx2
                && is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
            {
                levels.push(Self(Level::Avx512));
            }
            levels
        };
        levels
    }

    /// The widest level of this machine.
    pub(crate) fn widest() -> Self {
        *Self::available()
            .last()
            .expect("the baseline is always there")
    }

    /// Its level.
    pub(crate) fn level(self) -> Level {
        self.0
    }

    /// Vector width in bits.
    pub(crate) fn bits(self) -> u32 {
        match self.0 {
            Level::Baseline => 128,
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => 256,
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => 512,
        }
    }
}

impl Level {
    /// Whether kernels may ask for fused multiply-adds: elsewhere each would be a call of a function. On x86 such a level
    /// has AVX2.
    pub(crate) const fn has_fma(self) -> bool {
        !matches!(self, Self::Baseline) || cfg!(target_arch = "aarch64")
    }
}

/// Methods of [`Simd`] that call a row kernel compiled for its level. Kernels request one in their own file: those that
/// are generic over a number of lanes by `<N>`, and over whether their level has fused multiply-adds by `<N, has_fma>`
/// or, without lanes, by `[has_fma]`.
macro_rules! widened {
    ($(
        fn $name:ident$(<$lanes:ident$(, $has_fma:ident)?>)?$([$fused:ident])?($($arg:ident: $type:ty),* $(,)?);
    )*) => {
        #[allow(
            unsafe_code,
            reason = "calling a function compiled for features that were just detected"
        )]
        impl $crate::kernel::simd::Simd {$(
            #[inline]
            pub(crate) fn $name$(<const $lanes: usize>)?(self, $($arg: $type),*) {
                use $crate::kernel::simd::Level;
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx2,fma")]
                fn avx2$(<const $lanes: usize>)?($($arg: $type),*) {
                    $name$(::<$lanes$(, { Level::Avx2.$has_fma() })?>)?$(::<{ Level::Avx2.$fused() }>)?($($arg),*)
                }
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx2,fma,avx512f,avx512vl,avx512bw,avx512dq")]
                fn avx512$(<const $lanes: usize>)?($($arg: $type),*) {
                    $name$(::<$lanes$(, { Level::Avx512.$has_fma() })?>)?$(::<{ Level::Avx512.$fused() }>)?($($arg),*)
                }
                match self.level() {
                    Level::Baseline => {
                        $name$(::<$lanes$(, { Level::Baseline.$has_fma() })?>)?$(::<{ Level::Baseline.$fused() }>)?($($arg),*)
                    }
                    // SAFETY: only `available` constructs this level, after detecting the features.
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx2 => unsafe { avx2$(::<$lanes>)?($($arg),*) },
                    // SAFETY: as above.
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx512 => unsafe { avx512$(::<$lanes>)?($($arg),*) },
                }
            }
        )*}
    };
}
pub(crate) use widened;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{DepthKind, Frame, Mask, Vector3Planes};
    use crate::light::layers::{LobeRow, TermScaling};
    use crate::line::direction_field::Weighted;
    use crate::line::direction_field::directions::{self, Averaged, Source};
    use crate::line::direction_field::forms::{self, Lanes, Neighbourhoods, PatchSource, Tensors};
    use crate::line::normal_rays::bundle::{self, Bundle, Directions, Pixels, PointSource};
    use crate::line::placed::Beside;
    use crate::line::specular::map_directions::{self, LargerTangents};
    use crate::params::SoftThreshold;
    use crate::shape::Rows;
    use crate::shape::crease::NormalRows;
    use crate::shape::diffusion::kernel::{Chunk, Sum, Sweep};
    use crate::shape::diffusion::{LEVELS, Update};
    use crate::shape::gap::rows::{self, GapRow};
    use crate::shape::gap::scale::GapScale;
    use crate::shape::occlusion::Step;

    const WIDTH: usize = 83;

    /// A row of numbers between 0 and 1, determined by the seed.
    fn row(seed: u32) -> Vec<f32> {
        let hash = |x: u32| (x.wrapping_mul(0x9e37_79b9) ^ seed.wrapping_mul(0x85eb_ca6b)) >> 8;
        let value = |x| (hash(hash(x)) % 1000) as f32 / 1000.0;
        (0..WIDTH as u32 + 2).map(value).collect()
    }

    fn rows(seed: u32) -> [Vec<f32>; 3] {
        [row(seed), row(seed + 1), row(seed + 2)]
    }

    fn around(rows: &[Vec<f32>; 3]) -> Rows<'_> {
        Rows {
            above: &rows[0],
            at: &rows[1],
            below: &rows[2],
        }
    }

    /// Results of the kernels on sample rows.
    fn made(simd: Simd) -> Vec<Vec<f32>> {
        let (gx, gy) = (rows(1), rows(4));
        let open = rows(7).map(|row| row.into_iter().map(|c| c.max(0.4) / 0.4).collect());
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
        simd.trace_row(&mut trace, &x, &y, &c, columns());
        simd.face_conductance_row(&mut faces, &open[0], &open[1]);
        let [mut front, mut beside] = [blank(), blank()];
        made_of_gaps(simd, &gx, &gy, [&mut gaps, &mut front, &mut beside]);
        let normals = NormalRows { x, y, z: c };
        simd.least_cosine_row(&mut cosines, &normals, &seen, columns());
        let threshold = SoftThreshold { lo: 0.1, hi: 0.5 };
        simd.silhouette_row(&mut silhouette, &x, &seen, columns(), threshold);
        simd.conductance_row(&mut conductance, &gx[0], &gy[0], &covered[0]);
        let [mut half_x, mut half_y] = [gx[0].clone(), gy[0].clone()];
        simd.halve_row(&mut half_x, &mut half_y);
        let hessian = [&gx[0][..], &gy[0], &gx[1]];
        let [u, v, mean] = &mut [(); 3].map(|()| blank());
        simd.curvatures_row([u, v, mean], hessian, &covered[1][..WIDTH]);
        let [along, upward, mapped] = &mut [(); 3].map(|()| blank());
        simd.directions_row([along, upward], hessian, &covered[1][..WIDTH]);
        simd.mapped_row([mapped], &gx[0], 3.0, &covered[1][..WIDTH]);

        let mut results = vec![trace, faces, gaps, cosines, silhouette, conductance];
        results.extend([half_x, half_y, front, beside]);
        let of_curvature = [u, v, mean, along, upward, mapped];
        results.extend(of_curvature.map(std::mem::take));
        let value = |row: usize, i| [gx[row][i], gy[row][i], gx[row + 1][i], 1.0];
        let chain: Vec<[Weighted; 2]> = (0..WIDTH).map(|i| [value(0, i), value(1, i)]).collect();
        let reach: Vec<f32> = gy[1].iter().map(|v| 0.5 + 9.0 * v).collect();
        let mut sums = vec![[[0.0; 4]; 2]; WIDTH];
        simd.sums_along(&mut sums, &chain, &reach[..WIDTH], &mut Vec::new());
        results.push(sums.concat().concat());
        let [mut x, mut y] = [(); 2].map(|()| vec![0.0; 4 * (WIDTH - 2)]);
        let [own, beside]: [Vec<[[f32; 2]; 1]>; 2] =
            [0, 1].map(|r| (0..WIDTH).map(|i| [[gx[r][i], gy[r][i]]]).collect());
        let places = [-0.375, -0.125, 0.125, 0.375];
        simd.spread_row(&mut [[&mut x, &mut y]], &own, &beside, 0.125, &places);
        results.extend([x, y]);
        for update in UPDATES {
            results.extend(
                [swept::<8>(simd, update), swept::<16>(simd, update)].map(|[terms, _]| terms),
            );
        }
        results.extend(made_of_sky(simd, &gx, &gy));
        results.extend(made_of_light(simd, &gx, &gy));
        results.extend(made_of_rays(simd));
        results.extend(made_of_patches(simd));
        results.extend(made_of_curvature(simd));
        results.extend(made_of_cells(simd, &gx, &gy));
        results.extend(made_of_points(simd));
        results.extend(made_of_texels(simd));
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
        let sweep = Sweep {
            update,
            from: 1,
            weights: [0.7, -0.2],
        };
        let [above, a, b, c, d, below] = &mut rows;
        let into = sums.each_mut().map(|sum| &mut sum[..]);
        simd.sweep_rows(above, [a, b, c, d], below, into, sweep);
        let [above, at, below, ..] = &mut rows;
        let again = Sweep { from: 0, ..sweep };
        simd.sweep_row(above, at, below, &mut sums[0], again);
        simd.sweep_row(above, at, below, &mut [], sweep);

        let levels: Vec<_> = (0..count).map(|i| [(i % 8) as u16; N]).collect();
        let weights = std::array::from_fn::<f32, LEVELS, _>(|i| 0.3 + i as f32);
        let few = weights.first_chunk().expect("there are more in all");
        let mut by_few = sums[1].clone();
        simd.add_terms_by_few_levels_row(&mut by_few, &rows[2], 0, &levels, [few, few]);
        simd.add_terms_by_level_row(&mut sums[1], &rows[2], 0, &levels, [&weights, &weights]);
        let numbers =
            |sum: &[Sum<N>]| -> Vec<f32> { sum.iter().flat_map(|sum| sum.0).flatten().collect() };
        assert_eq!(numbers(&by_few), numbers(&sums[1]));
        simd.add_terms_row(&mut sums[2], &rows[3], 1, [0.7, -0.2]);
        let terms = rows.iter().flatten().flat_map(|chunk| chunk.terms);
        let sums = sums.iter().flat_map(|sum| numbers(sum));
        [terms.flatten().flatten().collect(), sums.collect()]
    }

    /// Weights of gaps across, and silhouettes of gaps, of sample rows.
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
        simd.fill_gap_row(&mut row, &samples, &scale);
        let [across, front, beside] = out;
        let along = rows::Along {
            axis: 0,
            first: 0,
            normals: [normal[0], &normal[0][1..]],
        };
        let after = &mut across[1..];
        let mut is_any = false;
        simd.look_for_gap(&mut is_any, after.len(), [&row; 4], &along, &scale);
        assert!(is_any);
        simd.gap_weight_row(after, [&row; 4], &along, &scale);
        assert!(after.iter().any(|&weight| weight < 0.0));
        // Not numbers beside uncovered pixels, of any bits.
        after
            .iter_mut()
            .filter(|weight| weight.is_nan())
            .for_each(|weight| *weight = 0.0);
        let all = [true; WIDTH];
        let covered = Rows {
            above: &all[..],
            at: &all,
            below: &all,
        };
        let across = [&*across, &[0.0]].concat();
        let weights = [&across[..], &b[1], &a[1]];
        simd.silhouettes_of_gaps_row([front, beside], weights, &covered, 0..WIDTH);
    }

    /// Results of the occlusion kernels on sample rows.
    fn made_of_sky(simd: Simd, a: &[Vec<f32>; 3], b: &[Vec<f32>; 3]) -> Vec<Vec<f32>> {
        let [a, b] = [a, b].map(|rows| [&rows[0][..WIDTH], &rows[1][..WIDTH], &rows[2][..WIDTH]]);
        let covered: Vec<bool> = b[1].iter().map(|&v| v > 0.1).collect();
        let blank = || vec![0.0; WIDTH];
        let [mut p, mut q, mut horizon] = [blank(), blank(), blank()];
        let [mut seen, mut x, mut y, mut z] = [blank(), blank(), blank(), blank()];
        simd.tangent_row(&mut p, &mut q, a);
        let step = Step::along([0.8, 0.6], 5.0);
        simd.raise_row(&mut horizon, b, [&p, &q], &step);
        let out = [&mut seen[..], &mut x[..], &mut y[..], &mut z[..]];
        simd.add_slice_row(out, a, [&horizon, b[0], &p, &q], [0.8, 0.6]);
        let out = [&mut seen[..], &mut x[..], &mut y[..], &mut z[..]];
        simd.finish_row(out, a, &covered, 0.125);
        vec![p, q, horizon, seen, x, y, z]
    }

    /// Results of the light-layer kernels on sample rows.
    fn made_of_light(simd: Simd, a: &[Vec<f32>; 3], b: &[Vec<f32>; 3]) -> Vec<Vec<f32>> {
        let [a, b] = [a, b].map(|rows| [&rows[0][..WIDTH], &rows[1][..WIDTH], &rows[2][..WIDTH]]);
        let covered: Vec<bool> = b[1].iter().map(|&v| v > 0.1).collect();
        let by = TermScaling {
            magnitude: 1.3,
            invariant_point: 0.25,
            white: 0.8,
            weights: [0.2, 0.7, 0.1],
        };
        let blank = || vec![0.0; WIDTH];
        let [mut kappa, mut toward, mut lobe, mut group] = [blank(), blank(), blank(), blank()];
        let [mut plain, mut scaled, mut change, mut layered] = [blank(), blank(), blank(), blank()];
        simd.kappa_row(&mut kappa, a[0], -3.0);
        simd.kappa_toward_row(&mut toward, a, [0.6, -0.3], 2.0, 0.7);
        let row = LobeRow {
            direct: a,
            indirect: b,
            color: a,
            albedo: b,
        };
        simd.lobe_sigma_row(&mut lobe, &row, &kappa, &by);
        simd.add_direction_row(&mut plain, &mut scaled, a, [0.6, 0.0, -0.8], &toward, &by);
        simd.group_sigma_row(&mut group, &plain, &scaled);
        simd.add_change_row(&mut change, &mut layered, a, &lobe);
        let mut out = blank();
        simd.changed_row(&mut out, b[0], &change, &layered, &covered);
        let [mut red, mut green, mut blue] = b.map(<[f32]>::to_vec);
        let color = [&mut red[..], &mut green[..], &mut blue[..]];
        simd.occlude_row(color, a[1], &kappa, &covered, &by);
        vec![toward, plain, scaled, group, out, red, green, blue]
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
                simd.larger_curvature_directions(&mut found, &bundle, &source);
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
            simd.patch_tensors(&mut found, &around, &source);
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
            simd.patch_directions(&mut found, &patches, &source);
            let sure = found[0][2].iter().filter(|&&sure| sure > 0.1).count();
            assert!(sure > forms::LANES / 4, "{sure}");
            made.extend(found.as_flattened().iter().map(|lanes| lanes.to_vec()));
            let averaged = Averaged {
                own: found[0],
                around: [found[1][0], found[1][1]],
            };
            let mut calmed = [[0.0; forms::LANES]; 2];
            simd.calm_patches(&mut calmed, &averaged);
            // Some of them short.
            let mut settled = calmed.map(|lanes| lanes.map(|v| 0.1 * v));
            simd.settle_patches(&mut settled, &patches.fallback[0]);
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
        simd.middle_normals([&mut x, &mut y, &mut z], [rows(0), rows(1), rows(2)]);
        simd.middle_sums(&mut sums, rows(0));
        let [mut open, mut lacking] = [vec![3; WIDTH], vec![0; WIDTH]];
        simd.count_open_row(&mut open, &a[0]);
        let some = a.each_ref().map(|row| {
            let kept = row.iter().map(|&v| if v < 0.5 { 0.0 } else { v });
            kept.collect::<Vec<f32>>()
        });
        let covered: Vec<bool> = b[0].iter().map(|&v| v > 0.1).collect();
        simd.lacking_in_row(&mut lacking, [&some[0], &some[1]], &covered);
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
            simd.nearest_beside(&mut squares, points(), lines.as_chunks().0, &beside);
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
        simd.larger_curvature_tangents(&mut found, &bundle, 1e-7);
        let known = found.components[0].iter().filter(|&&x| x != 0.0).count();
        assert!(known > map_directions::LANES / 2, "{known}");
        let forms = found.forms.map(|form| form as u8 as f32);
        let mut made = found.components.map(Vec::from).to_vec();
        made.push(forms.into());
        made
    }

    #[test]
    fn wider_vectors_give_the_same_bits() {
        let bits = |rows: Vec<Vec<f32>>| -> Vec<u32> {
            rows.into_iter().flatten().map(f32::to_bits).collect()
        };
        let expected = bits(made(Simd(Level::Baseline)));
        for simd in Simd::available() {
            println!("{simd:?}");
            assert!(bits(made(simd)) == expected, "{simd:?} has other bits");
        }
    }

    #[test]
    fn sums_of_terms_have_the_same_bits_wherever_multiply_adds_are_fused() {
        for update in UPDATES {
            let summed = |simd: Simd| {
                let [eight, sixteen] = [swept::<8>(simd, update), swept::<16>(simd, update)];
                [eight, sixteen].map(|[_, sums]| sums)
            };
            let separate = summed(Simd(Level::Baseline));
            let levels = Simd::available();
            let mut fused = levels.iter().filter(|simd| simd.level().has_fma());
            let Some(first) = fused.next().map(|&simd| summed(simd)) else {
                eprintln!("skipped: this machine has no fused multiply-adds");
                return;
            };
            for &simd in fused {
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
}
