//! Directions for pixels that have none of their own: their neighbours', in waves.

use super::constants::{CLOSED_COUNT, LIST_GROUPS, OPEN_COUNT};
use super::kernels::Kernel;
use super::normal_rays::{Found, STAGE};
use super::run::Run;
use super::sight::lines;
use super::uniforms::SpreadParams;
use crate::backend::surface_rays::RaySetting;
use crate::frame::Frame;
use crate::line::direction::{EDGE_MARGIN_PX, PLANE_MARGIN_PX, SURFACE_MARGIN_PX};

/// Waves over pixels of one kind, and after them the fixed direction.
struct Round {
    /// Which of the lists, and where its length stands.
    count: u32,
    waves: usize,
    /// Whether planes alone turn to the fixed direction and take it in the end.
    is_of_planes: bool,
}

/// The rounds, in order: see the file of the same name of the CPU.
const ROUNDS: [Round; 3] = [
    Round {
        count: OPEN_COUNT,
        waves: PLANE_MARGIN_PX,
        is_of_planes: true,
    },
    Round {
        count: OPEN_COUNT,
        waves: SURFACE_MARGIN_PX,
        is_of_planes: false,
    },
    Round {
        count: CLOSED_COUNT,
        waves: EDGE_MARGIN_PX,
        is_of_planes: false,
    },
];

/// Where the length stands of the list that a wave makes for the next one.
const fn count_after(wave: u32) -> u32 {
    CLOSED_COUNT + wave
}

impl Run<'_> {
    /// Lengths of the lists of pixels, all 0: the two of what lacks a direction, and one after each wave.
    pub(super) fn fill_counts(&mut self) -> wgpu::Buffer {
        let waves: u32 = ROUNDS.iter().map(|round| round.waves as u32 + 1).sum();
        let counts = self.take(4 * u64::from(count_after(waves) + 1));
        self.recorder.clear(&counts);
        counts
    }

    /// The directions that were found, and others where there was none.
    pub(super) fn fill_directions(
        &mut self,
        frame: &Frame,
        setting: &RaySetting,
        conductance: &wgpu::Buffer,
        found: Found,
        counts: wgpu::Buffer,
    ) -> [wgpu::Buffer; 2] {
        let Found {
            directions: [x, y],
            filled,
            marks,
            lacking,
        } = found;
        let [normal_x, normal_y, normal_z] = self.surface.normal.clone();
        let plane = self.surface.plane_bytes();
        let fronts = [(); 2].map(|()| self.take(plane));
        let line = lines(frame, &setting.sight);
        let mut wave = 0;
        for round in &ROUNDS {
            for number in 1..=round.waves + 1 {
                wave += 1;
                let is_first = number == 1;
                let is_fixed = number > round.waves;
                let is_of_all = is_first || is_fixed;
                let turned = (number as f32 / round.waves as f32).min(1.0);
                let params = SpreadParams {
                    width: self.surface.size[0],
                    height: self.surface.size[1],
                    line_x: line.first[0],
                    line_x_step: line.step[0],
                    line_y: line.first[1],
                    line_y_step: line.step[1],
                    pixel_shape: setting.sight.pixel_shape() as f32,
                    wave,
                    list_count: match is_of_all {
                        true => round.count,
                        false => count_after(wave - 1),
                    },
                    next_count: count_after(wave),
                    flat_share: turned,
                    share: if round.is_of_planes { 0.0 } else { turned },
                };
                let [last, next] = [wave - 1, wave].map(|wave| &fronts[wave as usize % 2]);
                let list = if is_of_all {
                    &lacking[round.count as usize]
                } else {
                    last
                };
                let switches = [
                    ("THROUGH_FACES", round.count == OPEN_COUNT),
                    ("IS_FIXED", is_fixed),
                ];
                self.recorder.dispatch(
                    STAGE,
                    (Kernel::SpreadDirections, &switches),
                    &params,
                    &[
                        conductance,
                        &normal_x,
                        &normal_y,
                        &normal_z,
                        list,
                        next,
                        &counts,
                        &x,
                        &y,
                        &filled,
                        &marks,
                    ],
                    [LIST_GROUPS, 1],
                );
            }
        }
        let used = [filled, marks, counts].into_iter();
        self.buffers.take_back(used.chain(lacking).chain(fronts));
        [x, y]
    }
}
