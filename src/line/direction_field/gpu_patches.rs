//! The patches of a frame: its surfaces cell by cell, each linked to its continuations.

use crate::engine::gpu::bindings::Bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::sight::{lines, step_at_unit_depth};
use crate::frame::Frame;
use crate::line::direction_field::gpu_kernels::{
    DirectionParams, FIND_PATCHES, FIND_RUNS, FindPatchesBuffers, FindRunsBuffers, LINK_PATCHES,
    LinkPatchesBuffers, RUN_CELLS,
};
use crate::line::direction_field::setting::FieldSetting;
use crate::params::FieldParams;
use crate::plan::Plan;
use crate::quantile::quantile;
use crate::shape::edges::SilhouetteSource;

/// Bytes of a patch, and of its sums along one axis.
const PATCH_BYTES: u64 = 32;
const SUMS_BYTES: u64 = 64;

/// Name in timings of the whole field of directions.
pub(crate) const STAGE: &str = "direction-field";

/// The patches of a frame, and how they hang together.
pub(crate) struct Patches {
    pub(crate) params: DirectionParams,
    pub(crate) held: wgpu::Buffer,
    pub(crate) further: wgpu::Buffer,
    pub(crate) all: wgpu::Buffer,
    pub(crate) depths: wgpu::Buffer,
    /// The median depth, if the radius depends on it.
    pub(crate) median: Option<f32>,
    pub(crate) links: wgpu::Buffer,
    /// Across and down.
    pub(crate) runs: [wgpu::Buffer; 2],
    pub(crate) sums: [wgpu::Buffer; 2],
}

impl Patches {
    /// Number of patches there is room for.
    pub(crate) fn count(&self) -> u64 {
        slots(&self.params)
    }

    /// All of its buffers except the number of further patches.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        [self.held, self.all, self.depths, self.links]
            .into_iter()
            .chain(self.runs)
            .chain(self.sums)
    }
}

/// Number of patches there is room for.
fn slots(params: &DirectionParams) -> u64 {
    u64::from(params.columns) * u64::from(params.rows) + u64::from(params.room)
}

/// Bytes of the largest buffer needed for the field of a frame.
pub(crate) fn largest_buffer(params: &FieldParams, frame: &Frame) -> u64 {
    let grid = Grid::new(params, frame);
    SUMS_BYTES * (grid.cells() + u64::from(grid.room))
}

/// The cells of a frame. They are at multiples of their size in the picture's coordinates.
struct Grid {
    cut: [u32; 2],
    columns: u32,
    rows: u32,
    /// Room for patches after the first ones of all cells.
    room: u32,
}

impl Grid {
    fn new(params: &FieldParams, frame: &Frame) -> Self {
        let (window, cell_px) = (frame.data_window, params.cell_px);
        let cut = [window.x0, window.y0].map(|c| c.rem_euclid(cell_px as i32) as u32);
        let size = [frame.mask.width(), frame.mask.height()].map(|side| side as u32);
        let [columns, rows] = [0, 1].map(|axis| (size[axis] + cut[axis]).div_ceil(cell_px));
        Self {
            cut,
            columns,
            rows,
            // Cells of one pixel hold one patch.
            room: if cell_px > 1 { columns * rows } else { 0 },
        }
    }

    fn cells(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }
}

fn direction_params(
    setting: &FieldSetting,
    params: &FieldParams,
    frame: &Frame,
) -> DirectionParams {
    let grid = Grid::new(params, frame);
    let (line, apart) = (
        lines(frame, &setting.sight),
        step_at_unit_depth(frame, &setting.sight),
    );
    let [fixed_x, fixed_y] = setting
        .fixed
        .map_or([0.0; 2], |[first, _]| first.to_array());
    DirectionParams {
        width: frame.mask.width() as u32,
        height: frame.mask.height() as u32,
        cell_px: params.cell_px,
        cut_x: grid.cut[0],
        cut_y: grid.cut[1],
        columns: grid.columns,
        rows: grid.rows,
        room: grid.room,
        axis: 0,
        reach: 0.0,
        median: 1.0,
        line_x: line.first[0],
        line_x_step: line.step[0],
        line_y: line.first[1],
        line_y_step: line.step[1],
        apart_x_step: apart[0],
        apart_y_step: apart[1],
        pixel_shape: setting.sight.pixel_shape() as f32,
        per_pixel: setting.pixels.recip() as f32,
        doubt: setting.doubt as f32,
        family: 0,
        order: 0,
        is_fixed: u32::from(setting.fixed.is_some()),
        fixed_x,
        fixed_y,
    }
}

impl Run<'_> {
    /// Records a kernel over all patches, or over the cells.
    pub(crate) fn over_cells(
        &mut self,
        kernel: (&Kernel, &[(&'static str, bool)]),
        params: &DirectionParams,
        buffers: &impl Bindings,
    ) {
        let cells = [params.columns, params.rows];
        self.recorder
            .over_pixels(STAGE, kernel, params, buffers, cells);
    }

    /// Records a kernel over the runs along one axis.
    pub(crate) fn over_runs(
        &mut self,
        kernel: &Kernel,
        params: &DirectionParams,
        buffers: &impl Bindings,
    ) {
        let DirectionParams { columns, rows, .. } = *params;
        let runs = match params.axis {
            0 => [columns.div_ceil(RUN_CELLS), rows],
            _ => [rows.div_ceil(RUN_CELLS), columns],
        };
        self.recorder
            .over_pixels(STAGE, (kernel, &[]), params, buffers, runs);
    }

    /// The patches of the frame.
    pub(crate) fn patches(
        &mut self,
        plan: &Plan,
        field: &FieldParams,
        setting: &FieldSetting,
        frame: &Frame,
        conductance: &wgpu::Buffer,
    ) -> Patches {
        let params = direction_params(setting, field, frame);
        let (cells, count) = (
            u64::from(params.columns) * u64::from(params.rows),
            slots(&params),
        );
        let depth = frame.depth.as_ref().filter(|_| setting.is_by_depth);
        let depth =
            depth.map(
                |plane| match SilhouetteSource::of(plan) == SilhouetteSource::Depth {
                    true => self.surface.map.clone().expect("silhouettes are of depth"),
                    false => self.uploaded(plane.samples()),
                },
            );
        let mut found = Patches {
            held: self.take(8 * cells),
            further: self.take(4),
            all: self.take(PATCH_BYTES * count),
            depths: self.take(4 * count),
            median: None,
            links: self.take(16 * count),
            runs: [(); 2].map(|()| self.take(16 * count)),
            sums: [(); 2].map(|()| self.take(SUMS_BYTES * count)),
            params,
        };
        self.recorder.clear(&found.further);
        // Depth stays clear where no patch is found.
        self.recorder.clear(&found.depths);
        let [x, y, z] = self.surface.normal.clone();
        self.over_cells(
            (&FIND_PATCHES, &[("HAS_DEPTH", depth.is_some())]),
            &params,
            &FindPatchesBuffers {
                conductance,
                normal_x: &x,
                normal_y: &y,
                normal_z: &z,
                depth: depth.as_ref().unwrap_or(&x),
                held: &found.held,
                patches: &found.all,
                depths: &found.depths,
                further: &found.further,
            },
        );
        self.over_cells(
            (&LINK_PATCHES, &[]),
            &params,
            &LinkPatchesBuffers {
                held: &found.held,
                patches: &found.all,
                links: &found.links,
            },
        );
        for (axis, runs) in (0..).zip(&found.runs) {
            let along = DirectionParams { axis, ..params };
            self.over_runs(
                &FIND_RUNS,
                &along,
                &FindRunsBuffers {
                    held: &found.held,
                    links: &found.links,
                    runs,
                },
            );
        }
        if depth.is_some() {
            let depths = self.read([&found.depths]).concat();
            let is_depth = |depth: &f32| *depth > 0.0 && depth.is_finite();
            let mut depths: Vec<f32> = depths.into_iter().filter(is_depth).collect();
            found.median = Some(quantile(&mut depths, 0.5, f32::total_cmp).unwrap_or(1.0));
        }
        found
    }
}
