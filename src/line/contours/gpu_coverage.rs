//! Coverage of every pixel by lines along edges.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::constants::GROUP;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::{F32, U32};
use crate::engine::gpu::wgsl::wgsl;
use crate::frame::Frame;
use crate::line::contours::coverage::Piece;
use crate::line::contours::round_stroke::RoundStroke;
use crate::line::paper;
use crate::line::paper::spread_seed;

uniforms! {
    /// Uniforms of `line_coverage.wgsl`.
    LineCoverageParams {
        width: u32,
        height: u32,
        /// Coordinates of the first pixel.
        x0: i32,
        y0: i32,
        /// Seed of the grain, if there is any.
        seed_low: u32,
        seed_high: u32,
    }
}

bindings! {
    LineCoverageBuffers {
        /// Start of each tile's pieces in their list, and the end of the last.
        tile_starts: &[u32], tile_pieces: &[u32], pieces: &[Piece],
        /// The line of each piece.
        lines: &[u32], covered_by_lines: &mut [f32],
    }
}

/// The coverage of each pixel by lines.
pub(crate) static LINE_COVERAGE: Kernel = Kernel::new::<LineCoverageParams, LineCoverageBuffers>(
    "LineCoverage",
    &[
        wgsl!("round_stroke.wgsl"),
        wgsl!(
            "../paper.wgsl",
            [
                ("HASH_ROUNDS", U32(paper::HASH_ROUNDS)),
                ("HASH_FACTOR_LOW", U32(paper::HASH_FACTOR as u32)),
                ("HASH_FACTOR_HIGH", U32((paper::HASH_FACTOR >> 32) as u32)),
                ("GRAIN_HERE", F32(paper::HERE)),
                ("GRAIN_BESIDE", F32(paper::BESIDE)),
                ("GRAIN_SPREAD", F32(paper::SPREAD)),
                ("GRIP", F32(paper::GRIP)),
                ("LIGHTEST_BLACK", F32(paper::LIGHTEST_BLACK))
            ]
        ),
        wgsl!("line_coverage.wgsl"),
    ],
);

/// The pieces of lines by the tile they reach; each tile is a workgroup's.
struct Tiles {
    /// Start of each tile's pieces in `pieces`, and the end of the last.
    starts: Vec<u32>,
    pieces: Vec<u32>,
}

impl Tiles {
    /// The tiles of a picture of this size.
    fn new(pieces: &[Piece], size: [u32; 2]) -> Self {
        let size = [0, 1].map(|axis| size[axis].div_ceil(GROUP[axis]));
        let reached = |piece: &RoundStroke| {
            // Casts saturate outside the picture.
            let tiles = |axis: usize, [first, last]: [f32; 2]| {
                let side = GROUP[axis] as f32;
                let end = ((last / side).floor() + 1.0) as u32;
                (first / side).floor() as u32..end.min(size[axis])
            };
            let columns = tiles(0, piece.across());
            let rows = tiles(1, piece.rows());
            rows.flat_map(move |row| columns.clone().map(move |column| row * size[0] + column))
        };
        let mut starts = vec![0; (size[0] * size[1] + 1) as usize];
        for tile in pieces.iter().flat_map(|(_, piece)| reached(piece)) {
            starts[tile as usize + 1] += 1;
        }
        for tile in 1..starts.len() {
            starts[tile] += starts[tile - 1];
        }
        let mut next = starts.clone();
        let mut by_tile = vec![0; starts[starts.len() - 1] as usize];
        for (number, (_, piece)) in (0..).zip(pieces) {
            for tile in reached(piece) {
                let place = &mut next[tile as usize];
                by_tile[*place as usize] = number;
                *place += 1;
            }
        }
        Self {
            starts,
            pieces: by_tile,
        }
    }
}

impl Run<'_> {
    /// Coverage of every pixel by pieces of lines, also outside the mask: in ink, or in graphite on paper with a grain
    /// of this seed. Pieces of one line count once where they meet; lines, each with contiguous pieces, lie side by
    /// side.
    pub(crate) fn covered_by_lines(
        &mut self,
        frame: &Frame,
        pieces: &[Piece],
        grain: Option<u64>,
    ) -> wgpu::Buffer {
        let [width, height] = self.surface.size;
        let tiles = Tiles::new(pieces, [width, height]);
        let (mut lines, mut numbers): (Vec<u32>, Vec<[f32; 8]>) = pieces
            .iter()
            .map(|(line, piece)| (*line, piece.numbers()))
            .unzip();
        // A kernel needs at least one; a dummy is in no tile.
        lines.resize(pieces.len().max(1), 0);
        numbers.resize(pieces.len().max(1), [0.0; 8]);
        let starts = self.uploaded_bytes(bytemuck::cast_slice(&tiles.starts));
        let by_tile = self.uploaded_bytes(bytemuck::cast_slice(&tiles.pieces));
        let numbers = self.uploaded(numbers.as_flattened());
        let lines = self.uploaded_bytes(bytemuck::cast_slice(&lines));
        let covered = self.take(self.surface.plane_bytes());
        let seed = grain.map_or(0, spread_seed);
        self.recorder.over_pixels(
            "contours",
            (&LINE_COVERAGE, &[("IN_GRAPHITE", grain.is_some())]),
            &LineCoverageParams {
                width,
                height,
                x0: frame.data_window.x0,
                y0: frame.data_window.y0,
                seed_low: seed as u32,
                seed_high: (seed >> 32) as u32,
            },
            &LineCoverageBuffers {
                tile_starts: &starts,
                tile_pieces: &by_tile,
                pieces: &numbers,
                lines: &lines,
                covered_by_lines: &covered,
            },
            [width, height],
        );
        covered
    }
}
