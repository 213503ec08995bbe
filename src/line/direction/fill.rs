//! Directions for pixels that have none of their own: their neighbours', in waves.

use crate::frame::rows::ROWS_PER_TASK;
use crate::frame::{Mask, Plane, Vector2Planes};
use crate::line::direction::{EDGE_MARGIN_PX, PLANE_MARGIN_PX, SURFACE_MARGIN_PX, mean_direction};
use crate::line::direction_field::setting::REST_REACH_PX;
use crate::shape::conductance::face_conductance;
use glam::Vec2;
use rayon::prelude::*;

/// Fills in every covered pixel whose direction is 0: with the mean of its neighbours' known directions, wave after
/// wave, so that the time is linear in the pixels filled. With every wave the mean turns toward the fixed direction,
/// which pixels no wave reaches get directly.
///
/// First the open pixels, each from neighbours across open faces: nothing crosses an edge. On a plane, where `flat` is
/// not 0, they have turned fully after [`PLANE_MARGIN_PX`], so that a wall is not a patchwork of its rims' directions;
/// elsewhere after [`SURFACE_MARGIN_PX`], so that a flat spot follows its surroundings. Then the pixels on edges,
/// conductance 0, from any neighbours, within [`EDGE_MARGIN_PX`].
pub(crate) fn fill(
    directions: &mut Vector2Planes,
    conductance: &Plane,
    flat: &Plane,
    mask: &Mask,
    fixed: impl Fn(usize, usize) -> Vec2 + Sync,
) {
    let width = mask.width();
    let fixed = |i: usize| fixed(i % width, i / width);
    let is_flat = |i: &PixelIndex| flat.samples()[*i as usize] != 0.0;
    let turned = |i: usize, mean: Vec2, wave: usize, margin_px: usize| {
        let share = wave as f32 / margin_px as f32;
        let fixed = fixed(i);
        mean_direction([(1.0 - share, mean), (share, fixed)]).unwrap_or(fixed)
    };
    let mut field = FilledField { directions, width };
    let is_open = |i: &PixelIndex| conductance.samples()[*i as usize] > 0.0;
    let (open, closed): (Vec<_>, Vec<_>) = field.lacking(mask).into_iter().partition(is_open);
    let through_faces = |from: usize, to: usize| {
        let c = conductance.samples();
        face_conductance(c[from], c[to])
    };
    field.spread(
        PLANE_MARGIN_PX,
        open.clone(),
        through_faces,
        |i, mean, wave| match flat.samples()[i] != 0.0 {
            true => turned(i, mean, wave, PLANE_MARGIN_PX),
            false => mean,
        },
    );
    let on_planes: Vec<_> = open.iter().copied().filter(is_flat).collect();
    field.fix(&on_planes, fixed);
    let waiting = field.without(&open);
    field.spread(
        SURFACE_MARGIN_PX,
        waiting,
        through_faces,
        |i, mean, wave| turned(i, mean, wave, SURFACE_MARGIN_PX),
    );
    field.fix(&open, fixed);
    field.spread(
        EDGE_MARGIN_PX,
        closed.clone(),
        |_, _| 1.0,
        |i, mean, wave| turned(i, mean, wave, EDGE_MARGIN_PX),
    );
    field.fix(&closed, fixed);
}

/// Fills in the covered pixels without a direction from any neighbours, wave after wave, up to [`REST_REACH_PX`]; with the
/// `fixed` direction beyond.
pub(crate) fn fill_rest(
    directions: &mut Vector2Planes,
    mask: &Mask,
    fixed: impl Fn(usize, usize) -> Vec2 + Sync,
) {
    let width = mask.width();
    let mut field = FilledField { directions, width };
    let lacking = field.lacking(mask);
    field.spread(
        REST_REACH_PX,
        lacking.clone(),
        |_, _| 1.0,
        |_, mean, _| mean,
    );
    field.fix(&lacking, |i| fixed(i % width, i / width));
}

/// The number of a pixel, row by row: lists of them are as long as pictures.
type PixelIndex = u32;

struct FilledField<'a> {
    directions: &'a mut Vector2Planes,
    width: usize,
}

impl FilledField<'_> {
    fn at(&self, i: usize) -> Vec2 {
        let Vector2Planes { x, y } = &self.directions;
        Vec2::new(x.samples()[i], y.samples()[i])
    }

    fn set_all(&mut self, found: &[(PixelIndex, Vec2)]) {
        let Vector2Planes { x, y } = &mut *self.directions;
        let (x, y) = (x.samples_mut(), y.samples_mut());
        for &(i, direction) in found {
            [x[i as usize], y[i as usize]] = direction.to_array();
        }
    }

    fn lacks(&self, i: usize) -> bool {
        self.at(i) == Vec2::ZERO
    }

    /// The covered pixels whose direction is 0, in order.
    fn lacking(&self, mask: &Mask) -> Vec<PixelIndex> {
        let rows = (0..mask.height())
            .into_par_iter()
            .with_min_len(ROWS_PER_TASK);
        let rows = rows.flat_map_iter(|y| {
            let of_row = mask.runs(y).flatten().map(move |x| y * self.width + x);
            of_row.filter(|&i| self.lacks(i)).map(|i| i as PixelIndex)
        });
        rows.collect()
    }

    /// The pixels left, right, above and below.
    fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, count) = (self.width, self.directions.x.samples().len());
        // Pixels are numbered in fewer bits: half the time.
        let x = (i as PixelIndex % width as PixelIndex) as usize;
        let sides = [
            (x > 0).then(|| i - 1),
            (x + 1 < width).then(|| i + 1),
            i.checked_sub(width),
            (i + width < count).then(|| i + width),
        ];
        sides.into_iter().flatten()
    }

    /// The mean direction of the neighbours that have one, weighted by the path from them.
    fn mean_around(&self, i: usize, weight: impl Fn(usize, usize) -> f32) -> Option<Vec2> {
        let weighted = self.neighbours(i).map(|j| (weight(j, i), self.at(j)));
        // Chosen, not skipped: which of them counts cannot be predicted.
        mean_direction(weighted.map(|(weight, t)| {
            let counts = (weight > 0.0) & ((t.x != 0.0) | (t.y != 0.0));
            let chosen = |v: f32| if counts { v } else { 0.0 };
            (chosen(weight), Vec2::new(chosen(t.x), chosen(t.y)))
        }))
    }

    /// Those of `pixels` that lack a direction.
    fn without(&self, pixels: &[PixelIndex]) -> Vec<PixelIndex> {
        let lacking = pixels.iter().copied();
        lacking.filter(|&i| self.lacks(i as usize)).collect()
    }

    /// Fills the pixels that wait for a direction from their neighbours in at most this many `waves`; `settle` turns
    /// the mean and the wave's number into a direction. Each wave sees only earlier waves, so the order within a wave
    /// does not matter.
    fn spread(
        &mut self,
        waves: usize,
        mut wave: Vec<PixelIndex>,
        weight: impl Fn(usize, usize) -> f32 + Sync,
        settle: impl Fn(usize, Vec2, usize) -> Vec2 + Sync,
    ) {
        let mut waiting = vec![false; self.directions.x.samples().len()];
        for &i in &wave {
            waiting[i as usize] = true;
        }
        for number in 1..=waves {
            let found: Vec<(PixelIndex, Vec2)> = wave
                .par_iter()
                .with_min_len(PIXELS_PER_TASK)
                .filter_map(|&pixel| {
                    let i = pixel as usize;
                    Some((pixel, settle(i, self.mean_around(i, &weight)?, number)))
                })
                .collect();
            if found.is_empty() {
                break;
            }
            self.set_all(&found);
            for &(i, _) in &found {
                waiting[i as usize] = false;
            }
            wave = self.beyond(&found, &waiting);
        }
    }

    /// The waiting pixels beside those just filled, each once.
    fn beyond(&self, filled: &[(PixelIndex, Vec2)], waiting: &[bool]) -> Vec<PixelIndex> {
        let mut next: Vec<PixelIndex> = filled
            .iter()
            .flat_map(|&(i, _)| self.neighbours(i as usize))
            .filter(|&i| waiting[i])
            .map(|i| i as PixelIndex)
            .collect();
        next.sort_unstable();
        next.dedup();
        next
    }

    /// Gives those of `pixels` that lack a direction the fixed one.
    fn fix(&mut self, pixels: &[PixelIndex], fixed: impl Fn(usize) -> Vec2 + Sync) {
        let found: Vec<(PixelIndex, Vec2)> = pixels
            .par_iter()
            .with_min_len(PIXELS_PER_TASK)
            .filter(|&&i| self.lacks(i as usize))
            .map(|&i| (i, fixed(i as usize)))
            .collect();
        self.set_all(&found);
    }
}

/// Fewest pixels per task.
const PIXELS_PER_TASK: usize = 1024;
