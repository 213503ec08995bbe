//! Diffusion of the gradient: several sweeps at a time in workgroup memory.

use crate::gpu::constants::{REGION, REGION_GROUP_ROWS, ROWS_PER_INVOCATION, SWEEPS_PER_PASS};
use crate::gpu::kernels::Kernel;
use crate::gpu::uniforms::uniforms;
use crate::gpu::wgsl::Number::U32;
use crate::gpu::wgsl::{Wgsl, wgsl};
use crate::plan::recording::{NOWHERE, Recording};
use crate::shape::diffusion::importance::ImportanceLevels;
use crate::shape::diffusion::sweeps::{Readout, Recurrence};

/// The conductance of the face between two pixels.
pub(crate) const FACE_CONDUCTANCE: Wgsl = wgsl!("../face_conductance.wgsl");

/// The flux between pixels, and the update of a sweep.
const FLUX: Wgsl = wgsl!("flux.wgsl");

uniforms! {
    /// Uniforms of `diffusion.wgsl`.
    DiffusionParams {
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

/// Several sweeps in the memory of a workgroup.
pub(crate) static DIFFUSION: Kernel = Kernel::new::<DiffusionParams>(
    "Diffusion",
    // The last term and the one before, and weights of the terms, for all levels of importance together.
    "last, earlier: vec2<f32>; conductance, term_weights: f32; levels?, covered: u32; \
     next_last, next_earlier, sums: mut vec2<f32>",
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

/// Diffuses the gradient, or keeps it if there are no sweeps.
pub(crate) fn diffuse(run: &mut Recording) {
    let plan = run.plan;
    let gradient = run.plane("gradient");
    let sweeps = plan.sweeps();
    let all = sweeps.count();
    let importance = ImportanceLevels::of(run.frame, sweeps);
    if let Some(levels) = &importance {
        let numbers = levels.plane.map(|level| f32::from_bits(level.into()));
        run.upload_as("levels", Some(&numbers));
    }
    // The number of sweeps of each result, and the weights of its terms.
    let sums: Vec<(usize, Vec<f32>)> = match (&sweeps.readout, &importance) {
        // Each scale separately: on a device sweeps cost less than memory for several sums.
        (Readout::Sums(sums), _) => sums
            .iter()
            .map(|sum| (sum.len() - 1, sum.clone()))
            .collect(),
        (Readout::ByImportance(_), Some(levels)) => {
            let weights = levels.weights.iter();
            let weights = weights.flat_map(|of_term| of_term[..levels.count].to_vec());
            vec![(all, weights.collect())]
        }
        _ => vec![(all, vec![0.0]); 1 + plan.more_px.len()],
    };
    let diffused = sums.iter().map(|(count, weights)| match count {
        0 => run.copy_of(&gradient),
        _ => run.swept(&gradient, (*count, weights), importance.as_ref()),
    });
    let mut diffused = diffused.collect::<Vec<_>>().into_iter();
    run.put("gradient", diffused.next().expect("one at least"));
    run.more_gradients = diffused.collect();
}

impl Recording<'_> {
    /// The gradient after `count` sweeps, or the sum of their terms, weighted by these `levels` of importance.
    fn swept(
        &mut self,
        gradient: &wgpu::Buffer,
        (count, weights): (usize, &[f32]),
        levels: Option<&ImportanceLevels>,
    ) -> wgpu::Buffer {
        let [width, height] = self.size;
        let whole = self.host.frame.data_window;
        let (tile, wraps) = match self.plan.tile {
            Some(tile) => (tile.window.relative_to(whole), tile.wraps),
            None => (whole.relative_to(whole), [false; 2]),
        };
        let by_level = levels.is_some();
        let (is_expansion, time_step) = match self.plan.sweeps().recurrence {
            Recurrence::Explicit(time_step) => (false, time_step),
            Recurrence::Chebyshev => (true, 0.0),
        };
        let is_summed = is_expansion || by_level;
        let taken = |is_used: bool| match is_used {
            true => self.take_plane(2),
            false => self.take(NOWHERE),
        };
        let last = [(); 2].map(|()| taken(true));
        let earlier = [(); 2].map(|()| taken(is_expansion));
        let sums = taken(is_summed);
        let term_weights = self.uploaded(weights);
        let level_count = levels.map_or(1, |levels| levels.count as u32);
        let switches = [("IS_EXPANSION", is_expansion), ("BY_LEVEL", by_level)];
        let passes = count.div_ceil(SWEEPS_PER_PASS);
        for pass in 0..passes {
            let first = pass * SWEEPS_PER_PASS;
            let sweeps = SWEEPS_PER_PASS.min(count - first) as u32;
            let params = DiffusionParams {
                sweeps,
                first_term: first as u32,
                is_final: u32::from(pass + 1 == passes),
                level_count,
                time_step,
                tile_x: tile.x0 as u32,
                tile_y: tile.y0 as u32,
                tile_width: tile.width() as u32,
                tile_height: tile.height() as u32,
                wraps_x: wraps[0].into(),
                wraps_y: wraps[1].into(),
            };
            // Output of one pass is input of the next.
            let (from, to) = ((pass + 1) % 2, pass % 2);
            let start = (pass == 0).then_some(gradient);
            let before = start.or((!is_expansion).then_some(gradient));
            let named = [
                ("last", start.unwrap_or(&last[from])),
                ("earlier", before.unwrap_or(&earlier[from])),
                ("term_weights", &term_weights),
                ("next_last", &last[to]),
                ("next_earlier", &earlier[to]),
                ("sums", &sums),
            ];
            let [columns, rows] = REGION.map(|side| side - 2 * sweeps);
            let groups = [width.div_ceil(columns), height.div_ceil(rows)];
            let kernel: (&Kernel, &[_]) = (&DIFFUSION, &switches);
            self.dispatch("diffusion", kernel, &params, &named, groups);
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
