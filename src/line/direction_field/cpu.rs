//! The field of stroke directions ([LA] section 6.1): curvature patch by patch, averaged over surfaces,
//! and brought back to pixels.

use crate::frame::memory::Memory;
use crate::frame::{Frame, Vector2Planes};
use crate::kernel::quantile::quantile;
use crate::line::background::Backdrop;
use crate::line::carried::Carrier;
use crate::line::direction::fill::fill_rest;
use crate::line::direction_field::between_patches::BetweenPatches;
use crate::line::direction_field::chains::CrossKernel;
use crate::line::direction_field::directions::{SeenPatch, settled};
use crate::line::direction_field::patches::{Patch, Patches};
use crate::line::direction_field::setting::{
    FAR, FORM_REACH, FieldSetting, NEAR, SURROUNDING_PASSES, SURROUNDINGS,
};
use crate::line::direction_field::{CurvatureTensor, Weighted, calm, doubled};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::params::{FieldParams, StrokeDirections};
use crate::plan::Plan;
use glam::{DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// One field for each of the directions wanted: unit directions in the picture, x right, y up, 0 outside the mask.
/// Nonzero `given` directions are followed as they are. In a `sequence` directions of the frame before are the fallback, and
/// stay where nothing moves.
pub(crate) fn stroke_fields(
    plan: &Plan,
    params: &FieldParams,
    directions: StrokeDirections,
    frame: &Frame,
    patches: &Patches,
    (given, background, sequence): (
        Option<&[Vector2Planes]>,
        Option<&Backdrop>,
        Option<SequenceInputs>,
    ),
    memory: &Memory,
) -> Vec<Vector2Planes> {
    let before = Carrier::of(sequence, frame);
    let carried = before.iter().flat_map(|(before, carrier)| {
        let fields = before.directions.iter();
        fields.map(|field| carrier.directions(field, memory))
    });
    let field = FieldFound {
        params,
        frame,
        patches,
        background,
        carried: carried.collect(),
        setting: FieldSetting::new(plan, params, frame),
    };
    let mut found: Vec<_> = match directions {
        StrokeDirections::Max => field.found([0], given, memory).into(),
        StrokeDirections::Min => field.found([1], given, memory).into(),
        StrokeDirections::Both => field.found([0, 1], given, memory).into(),
    };
    if let Some((_, carrier)) = &before {
        let both = found.iter_mut().zip(&field.carried);
        both.for_each(|(found, carried)| carrier.keep_still(found, carried));
    }
    found
}

struct FieldFound<'a> {
    params: &'a FieldParams,
    frame: &'a Frame,
    patches: &'a Patches,
    /// Planes in which directions are level.
    background: Option<&'a Backdrop>,
    /// The directions of the frame before.
    carried: Vec<Vector2Planes>,
    setting: FieldSetting,
}

/// A patch with unknown curvature.
const NO_FORM: Weighted = [0.0, 0.0, 0.0, 1.0];

impl FieldFound<'_> {
    /// The fields of these families: 0 follows the larger curvature, 1 the lesser.
    fn found<const N: usize>(
        &self,
        families: [usize; N],
        given: Option<&[Vector2Planes]>,
        memory: &Memory,
    ) -> [Vector2Planes; N] {
        let mut led = self.led(families);
        for (order, given) in given.into_iter().flatten().enumerate() {
            self.follow(&mut led, given, order);
        }
        self.settle(&mut led);
        let between = BetweenPatches {
            patches: self.patches,
            mask: &self.frame.mask,
            doubled: &led,
        };
        let mut found = between.all(memory);
        let each = found.par_iter_mut().enumerate();
        each.for_each(|(order, found)| {
            fill_rest(found, &self.frame.mask, |x, y| {
                let at = self.frame.data_window.middle(x, y);
                self.fallback(at, self.frame.normal.at(x, y), order)
            });
        });
        found
    }

    /// The directions of patches, doubled and calmed. What leads to them takes as much memory as some planes, and goes.
    fn led<const N: usize>(&self, families: [usize; N]) -> Vec<[[f32; 2]; N]> {
        let cross = CrossKernel::new(self.patches);
        let patches = self.patches.all.par_iter().with_min_len(PATCHES_PER_TASK);
        let seen: Vec<_> = patches
            .map(|patch| SeenPatch::new(patch, &self.setting.sight))
            .collect();
        let forms = self.forms(&cross, &seen);
        self.calmed(self.doubled(&forms, &seen, families), &cross)
    }

    /// The fallback at a place in the picture, of the first field made or the second.
    fn fallback(&self, at: DVec2, normal: DVec3, order: usize) -> Vec2 {
        if let Some(level) = self.level(at, order) {
            return level;
        }
        if let Some(carried) = self.carried.get(order) {
            let at = self.in_frame(at);
            let was = Vec2::new(carried.x.nearest(at), carried.y.nearest(at));
            if was != Vec2::ZERO {
                return was;
            }
        }
        let Some(own) = &self.frame.stroke_fallback else {
            return self.setting.fallback(at.x, at.y, normal, order);
        };
        let window = self.frame.data_window;
        let pixel = |at: f64, from: i32, count: usize| {
            ((at - f64::from(from)).max(0.0) as usize).min(count - 1)
        };
        let x = pixel(at.x, window.x0, window.width());
        let y = pixel(at.y, window.y0, window.height());
        let setting = self.setting.on_object(own.at(x, y));
        setting.fallback(at.x, at.y, normal, order)
    }

    /// The direction at a place in the picture that lies in a plane behind the subject.
    fn level(&self, at: DVec2, order: usize) -> Option<Vec2> {
        let level = self.background?.level(self.in_frame(at))?;
        Some(if order == 0 { level } else { level.perp() })
    }

    /// A place in the picture, in pixels of the frame.
    fn in_frame(&self, at: DVec2) -> Vec2 {
        let window = self.frame.data_window;
        (at - DVec2::new(f64::from(window.x0), f64::from(window.y0))).as_vec2()
    }

    /// Reach of one pass from each patch, in patches.
    fn reach(&self) -> Vec<f32> {
        let radius = self.params.radius_px * self.setting.cells;
        let all = &self.patches.all;
        if !self.setting.is_by_depth {
            return vec![radius; all.len()];
        }
        let is_known = |depth: f32| depth > 0.0 && depth.is_finite();
        // Above 0 the bits of numbers are in their order.
        let known = all.iter().map(|p| p.depth).filter(|&d| is_known(d));
        let mut depths: Vec<u32> = known.map(f32::to_bits).collect();
        let Some(median) = quantile(&mut depths, 0.5, u32::cmp).map(f32::from_bits) else {
            return vec![radius; all.len()];
        };
        let reach = |depth: f32| match is_known(depth) {
            true => radius * (median / depth).clamp(FAR, NEAR),
            false => radius,
        };
        all.iter().map(|p| reach(p.depth)).collect()
    }

    /// The curvature of every patch, per pixel, averaged nearby.
    fn forms(&self, cross: &CrossKernel, seen: &[SeenPatch]) -> Vec<[Weighted; 1]> {
        let Patches { across, down, .. } = self.patches;
        // Rows run down, y up.
        let links = [&across.before, &across.after, &down.after, &down.before];
        let step_px = self.params.cell_px.into();
        let form = |(i, here): (usize, &SeenPatch)| {
            let beside = |side: usize| seen.get(links[side][i] as usize).copied();
            let slopes = here.slopes(beside, step_px);
            let per_pixel = |curvature: f64| (curvature / self.setting.pixels) as f32;
            let tensor = slopes.map(|s| [s.half_difference, s.off, s.mean].map(per_pixel));
            let known =
                tensor.filter(|[x, y, mean]| x.abs() + y.abs() + mean.abs() < f32::INFINITY);
            [known.map_or(NO_FORM, |[x, y, mean]| [x, y, mean, 1.0])]
        };
        let patches = seen.par_iter().with_min_len(PATCHES_PER_TASK);
        let mut forms: Vec<_> = patches.enumerate().map(form).collect();
        let reach = vec![FORM_REACH * self.setting.cells; forms.len()];
        cross.average(&mut forms, &reach, 1);
        forms
    }

    /// The directions of patches, of the larger curvature in family 0, of the lesser in 1, in the order of `families`: see
    /// [`calm`].
    fn doubled<const N: usize>(
        &self,
        forms: &[[Weighted; 1]],
        seen: &[SeenPatch],
        families: [usize; N],
    ) -> Vec<[Weighted; N]> {
        let all = self.patches.all.par_iter().with_min_len(PATCHES_PER_TASK);
        let patches = all.zip(seen).zip(forms);
        let directions = patches.map(|((patch, seen), [form])| {
            let fallback = std::array::from_fn(|order| self.fallback_of(patch, order));
            let form = CurvatureTensor::of(form);
            seen.directions(&form, self.setting.doubt, families, fallback)
        });
        directions.collect()
    }

    /// The fallback of a patch, as twice its angle.
    fn fallback_of(&self, patch: &Patch, order: usize) -> Vec2 {
        doubled(self.fallback(patch.at, patch.normal, order))
    }

    /// Directions averaged in several passes; where they disagree, their surroundings lead.
    fn calmed<const N: usize>(
        &self,
        mut found: Vec<[Weighted; N]>,
        cross: &CrossKernel,
    ) -> Vec<[[f32; 2]; N]> {
        let mut reach = self.reach();
        cross.average(&mut found, &reach, self.params.passes);
        if self.params.passes == 0 {
            let own = found.iter();
            return own.map(|own| own.map(|[x, y, ..]| [x, y])).collect();
        }
        for reach in &mut reach {
            *reach *= SURROUNDINGS;
        }
        let mut around = found.clone();
        cross.average(&mut around, &reach, SURROUNDING_PASSES);
        let pairs = found.par_iter().with_min_len(PATCHES_PER_TASK).zip(&around);
        let calmed = pairs.map(|(own, around)| std::array::from_fn(|n| calm(own[n], around[n])));
        calmed.collect()
    }

    /// Replaces the direction of a patch by the mean of its `given` directions of one field, if there are any.
    fn follow<const N: usize>(
        &self,
        doubled_directions: &mut [[[f32; 2]; N]],
        given: &Vector2Planes,
        order: usize,
    ) {
        let mut sums = vec![Vec3::ZERO; doubled_directions.len()];
        let mask = &self.frame.mask;
        for y in 0..mask.height() {
            let row = given.x.row(y).iter().zip(given.y.row(y)).enumerate();
            for (x, (&across, &up)) in row {
                let direction = Vec2::new(across, up);
                if direction != Vec2::ZERO
                    && let Some(patch) = self.patches.of_pixel(x, y)
                {
                    sums[patch] += doubled(direction).extend(1.0);
                }
            }
        }
        for (own, sum) in doubled_directions.iter_mut().zip(sums) {
            if sum.z > 0.0 {
                own[order] = (sum.truncate() / sum.z).to_array();
            }
        }
    }

    /// Adds the fallback, and makes everything unit; specks become 0.
    fn settle<const N: usize>(&self, directions: &mut [[[f32; 2]; N]]) {
        let all = directions.par_iter_mut().with_min_len(PATCHES_PER_TASK);
        all.enumerate().for_each(|(i, own)| {
            let patch = &self.patches.all[i];
            for (order, own) in own.iter_mut().enumerate() {
                let level = self.level(patch.at, order);
                *own = match (self.patches.is_speck(i), level) {
                    (true, _) => [0.0; 2],
                    (_, Some(level)) => doubled(level).into(),
                    (false, None) => settled((*own).into(), self.fallback_of(patch, order)).into(),
                };
            }
        });
    }
}

/// Fewest patches per task.
const PATCHES_PER_TASK: usize = 1024;
