//! Contours: what their lines cover of every pixel.

use super::kernels::{GROUP, Kernel};
use super::run::Run;
use super::uniforms::ContourParams;
use crate::frame::Frame;
use crate::line::contours::round_stroke::RoundStroke;
use crate::line::paper::spread_seed;

/// The pieces of lines by the tiles that they reach, each of a workgroup.
struct Tiles {
    /// Where the pieces of each tile begin in `pieces`, and where the last end.
    starts: Vec<u32>,
    pieces: Vec<u32>,
}

impl Tiles {
    /// The tiles of a picture of this size, or of a strip whose first row is `top`.
    fn new(pieces: &[RoundStroke], size: [u32; 2], top: usize) -> Self {
        let size = [0, 1].map(|axis| size[axis].div_ceil(GROUP[axis]));
        let reached = |piece: &RoundStroke| {
            // Casts of what lies outside saturate.
            let tiles = |axis: usize, [first, last]: [f32; 2]| {
                let side = GROUP[axis] as f32;
                let end = ((last / side).floor() + 1.0) as u32;
                (first / side).floor() as u32..end.min(size[axis])
            };
            let columns = tiles(0, piece.across());
            let rows = tiles(1, piece.rows().map(|y| y - top as f32));
            rows.flat_map(move |row| columns.clone().map(move |column| row * size[0] + column))
        };
        let mut starts = vec![0; (size[0] * size[1] + 1) as usize];
        for tile in pieces.iter().flat_map(reached) {
            starts[tile as usize + 1] += 1;
        }
        for tile in 1..starts.len() {
            starts[tile] += starts[tile - 1];
        }
        let mut next = starts.clone();
        let mut by_tile = vec![0; starts[starts.len() - 1] as usize];
        for (number, piece) in (0..).zip(pieces) {
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
    /// What pieces of lines cover of every pixel, also outside the mask; in graphite, with the seed of its grain, or
    /// in ink. The first row of a strip is the row `top` of the picture that lines were found in.
    pub(super) fn covered_by_lines(
        &mut self,
        frame: &Frame,
        top: usize,
        pieces: &[RoundStroke],
        graphite: Option<u64>,
    ) -> wgpu::Buffer {
        let [width, height] = self.surface.size;
        let tiles = Tiles::new(pieces, [width, height], top);
        let mut numbers: Vec<[f32; 8]> = pieces.iter().map(RoundStroke::numbers).collect();
        // A kernel is given one at the least, of which no tile knows.
        numbers.resize(pieces.len().max(1), [0.0; 8]);
        let starts = self.hold_bytes(bytemuck::cast_slice(&tiles.starts));
        let by_tile = self.hold_bytes(bytemuck::cast_slice(&tiles.pieces));
        let numbers = self.hold(numbers.as_flattened());
        let covered = self.take(self.surface.plane_bytes());
        let seed = spread_seed(graphite.unwrap_or(0));
        self.recorder.over_pixels(
            "contours",
            (Kernel::Contours, &[("IN_GRAPHITE", graphite.is_some())]),
            &ContourParams {
                width,
                height,
                x0: frame.data_window.x0,
                y0: frame.data_window.y0,
                top: top as u32,
                seed_low: seed as u32,
                seed_high: (seed >> 32) as u32,
            },
            &[&starts, &by_tile, &numbers, &covered],
            [width, height],
        );
        covered
    }
}
