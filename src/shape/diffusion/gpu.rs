//! Diffusion of the gradient: several sweeps at a time in workgroup memory.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::constants::{
    REGION, REGION_GROUP_ROWS, ROWS_PER_INVOCATION, SWEEPS_PER_PASS,
};
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::made::Shape;
use crate::engine::gpu::recording::{NOWHERE, Recording};
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::U32;
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::plan::Plan;
use crate::shape::diffusion::sweeps::{Readout, Recurrence};

/// The conductance of the face between two pixels.
pub(crate) const FACE_CONDUCTANCE: Wgsl = wgsl!("../face_conductance.wgsl");

/// The flux between pixels, and the update of a sweep.
const FLUX: Wgsl = wgsl!("flux.wgsl");

uniforms! {
    /// Uniforms of `diffusion.wgsl`.
    DiffusionParams {
        width: u32,
        height: u32,
        /// Sweeps of this pass.
        sweeps: u32,
        /// Number of the starting term.
        first_term: u32,
        /// 1 for the last pass.
        is_final: u32,
        /// Number of importance levels with their own weights.
        level_count: u32,
        /// Length of an explicit step.
        time_step: f32,
        /// The tile that the frame repeats: its first column and row, their numbers, and whether each of them repeats.
        tile_x: u32,
        tile_y: u32,
        tile_width: u32,
        tile_height: u32,
        wraps_x: u32,
        wraps_y: u32,
    }
}

bindings! {
    DiffusionBuffers {
        last: &[vec2<f32>],
        /// The term before the last; unused if there is none.
        earlier: &[vec2<f32>], conductance: &[f32],
        /// Weights of the terms, for all levels of importance together.
        term_weights: &[f32], levels: &[u32], covered: &[u32], next_last: &mut [vec2<f32>],
        next_earlier: &mut [vec2<f32>], sums: &mut [vec2<f32>],
    }
}

/// Several sweeps in the memory of a workgroup.
pub(crate) static DIFFUSION: Kernel = Kernel::new::<DiffusionParams, DiffusionBuffers>(
    "Diffusion",
    &[
        FACE_CONDUCTANCE,
        FLUX,
        wgsl!(
            "diffusion.wgsl",
            [
                ("REGION_COLUMNS", U32(REGION[0])),
                ("REGION_ROWS", U32(REGION[1])),
                ("REGION_PIXELS", U32(REGION[0] * REGION[1])),
                ("REGION_GROUP_ROWS", U32(REGION_GROUP_ROWS)),
                ("ROWS_PER_INVOCATION", U32(ROWS_PER_INVOCATION))
            ]
        ),
    ],
);

/// Weights for summing the terms of a recurrence.
enum TermWeights<'a> {
    /// No sum: the last term is the result.
    None,
    /// Equal weights for all pixels.
    Same(&'a [f32]),
    /// Weights by the pixel's level of importance.
    ByLevel,
}

/// Bindings shared by the kernels of a run of sweeps.
struct Sweeping<'a> {
    gradient: &'a wgpu::Buffer,
    conductance: &'a wgpu::Buffer,
    /// Weights of the terms, for all levels together, and number of levels.
    term_weights: wgpu::Buffer,
    level_count: u32,
    by_level: bool,
    /// Whether terms follow the Chebyshev recurrence, or are steps of this length.
    is_expansion: bool,
    time_step: f32,
    /// Number of sweeps, 1 or more.
    count: usize,
}

impl Sweeping<'_> {
    fn is_summed(&self) -> bool {
        self.is_expansion || self.by_level
    }
}

/// Diffuses the gradient, or keeps it if there are no sweeps.
pub(crate) fn diffuse(run: &mut Recording) {
    run.change_shape(Recording::with_diffusion);
}

impl Recording<'_> {
    /// A shape with its gradient at all scales.
    pub(crate) fn with_diffusion(&mut self, shape: Shape) -> Shape {
        let plan = self.plan;
        let mut gradients = match plan.sweeps.count() {
            0 => {
                let copies = (0..plan.more_px.len()).map(|_| self.copy_of(&shape.gradient));
                let copies: Vec<_> = copies.collect();
                std::iter::once(shape.gradient).chain(copies).collect()
            }
            _ => self.diffused(plan, shape.gradient, &shape.conductance),
        };
        let more_gradients = gradients.split_off(1);
        Shape {
            gradient: gradients.remove(0),
            more_gradients,
            ..shape
        }
    }

    /// The gradient after all sweeps, at every scale read out.
    pub(crate) fn diffused(
        &mut self,
        plan: &Plan,
        gradient: wgpu::Buffer,
        conductance: &wgpu::Buffer,
    ) -> Vec<wgpu::Buffer> {
        let sweeps = &plan.sweeps;
        let all = sweeps.count();
        let results: Vec<(usize, TermWeights)> = match &sweeps.readout {
            Readout::Last => vec![(all, TermWeights::None)],
            Readout::ByImportance(_) => vec![(all, TermWeights::ByLevel)],
            // Each scale separately: on a device sweeps cost less than memory for several sums.
            Readout::Sums(sums) => sums
                .iter()
                .map(|weights| (weights.len() - 1, TermWeights::Same(weights)))
                .collect(),
        };
        let diffused = results.into_iter().map(|(count, weights)| match count {
            0 => self.copy_of(&gradient),
            _ => self.swept(plan, [&gradient, conductance], count, weights),
        });
        let diffused = diffused.collect();
        self.buffers.recycle([gradient]);
        diffused
    }

    /// The gradient after `count` sweeps, or the sum of their terms.
    fn swept(
        &mut self,
        plan: &Plan,
        [gradient, conductance]: [&wgpu::Buffer; 2],
        count: usize,
        weights: TermWeights,
    ) -> wgpu::Buffer {
        let importance = self.surface.importance.as_ref();
        let (by_level, level_count, weights) = match (weights, importance) {
            (TermWeights::Same(weights), _) => (false, 1, weights.to_vec()),
            (TermWeights::ByLevel, Some(importance)) => {
                (true, importance.count, importance.weights.clone())
            }
            _ => (false, 1, vec![0.0]),
        };
        let (is_expansion, time_step) = match plan.sweeps.recurrence {
            Recurrence::Explicit(time_step) => (false, time_step),
            Recurrence::Chebyshev => (true, 0.0),
        };
        let sweeping = Sweeping {
            gradient,
            conductance,
            term_weights: self.uploaded(&weights),
            level_count,
            by_level,
            is_expansion,
            time_step,
            count,
        };
        self.swept_in_regions(&sweeping)
    }

    fn swept_in_regions(&mut self, sweeping: &Sweeping) -> wgpu::Buffer {
        let [width, height] = self.surface.size;
        let whole = self.host.frame.data_window;
        let (tile, wraps) = match self.plan.tile {
            Some(tile) => (tile.window.relative_to(whole), tile.wraps),
            None => (whole.relative_to(whole), [false; 2]),
        };
        let bytes = 2 * self.surface.plane_bytes();
        let (is_expansion, is_summed) = (sweeping.is_expansion, sweeping.is_summed());
        let two = |wanted: bool| [(); 2].map(|()| self.take(if wanted { bytes } else { NOWHERE }));
        let (last, earlier) = (two(true), two(is_expansion));
        let sums = self.take(if is_summed { bytes } else { NOWHERE });
        let passes = sweeping.count.div_ceil(SWEEPS_PER_PASS);
        for pass in 0..passes {
            let first = pass * SWEEPS_PER_PASS;
            let sweeps = SWEEPS_PER_PASS.min(sweeping.count - first) as u32;
            let params = DiffusionParams {
                width,
                height,
                sweeps,
                first_term: first as u32,
                is_final: u32::from(pass + 1 == passes),
                level_count: sweeping.level_count,
                time_step: sweeping.time_step,
                tile_x: tile.x0 as u32,
                tile_y: tile.y0 as u32,
                tile_width: tile.width() as u32,
                tile_height: tile.height() as u32,
                wraps_x: wraps[0].into(),
                wraps_y: wraps[1].into(),
            };
            // Output of one pass is input of the next.
            let (from, to) = ((pass + 1) % 2, pass % 2);
            let start = (pass == 0).then_some(sweeping.gradient);
            let before = start.or((!is_expansion).then_some(sweeping.gradient));
            let importance = self.surface.importance.as_ref();
            let buffers = DiffusionBuffers {
                last: start.unwrap_or(&last[from]),
                earlier: before.unwrap_or(&earlier[from]),
                conductance: sweeping.conductance,
                term_weights: &sweeping.term_weights,
                levels: importance.map_or(&self.surface.covered, |i| &i.levels),
                covered: &self.surface.covered,
                next_last: &last[to],
                next_earlier: &earlier[to],
                sums: &sums,
            };
            let switches = [
                ("IS_EXPANSION", is_expansion),
                ("BY_LEVEL", sweeping.by_level),
            ];
            let [columns, rows] = REGION.map(|side| side - 2 * sweeps);
            let groups = [width.div_ceil(columns), height.div_ceil(rows)];
            let kernel: (&Kernel, &[_]) = (&DIFFUSION, &switches);
            self.recorder
                .dispatch("diffusion", kernel, &params, &buffers, groups);
        }
        let [first, second] = last;
        let (result, other) = match (is_summed, passes % 2 == 1) {
            (true, _) => (sums, [first, second]),
            (false, true) => (first, [second, sums]),
            (false, false) => (second, [first, sums]),
        };
        self.buffers.recycle(other);
        self.buffers.recycle(earlier);
        result
    }
}
