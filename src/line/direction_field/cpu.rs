//! The field of stroke directions ([LA] section 6.1): curvature patch by patch, averaged over surfaces,
//! and brought back to pixels.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::simd::Simd;
use crate::frame::{Frame, Vector2Planes};
use crate::line::direction::fill::fill_rest;
use crate::line::direction_field::between_patches::BetweenPatches;
use crate::line::direction_field::chains::CrossKernel;
use crate::line::direction_field::forms::{LANES, Lanes, Neighbourhoods, PatchSource, Tensors};
use crate::line::direction_field::patches::{Patch, Patches};
use crate::line::direction_field::setting::{
    FACING, FALLBACK, FAR, FORM_REACH, FREE, FieldSetting, NEAR, SURROUNDING_PASSES, SURROUNDINGS,
};
use crate::line::direction_field::{CurvatureTensor, Weighted, calm, doubled};
use crate::line::normal_rays::upright_tangents;
use crate::params::{FieldParams, StrokeDirections};
use crate::plan::Plan;
use crate::quantile::quantile;
use glam::{DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// One field for each of the directions wanted: unit directions in the picture, x right, y up, 0 outside the mask.
/// Nonzero `given` directions are followed as they are.
pub(crate) fn stroke_fields(
    plan: &Plan,
    params: &FieldParams,
    directions: StrokeDirections,
    frame: &Frame,
    patches: &Patches,
    given: Option<&[Vector2Planes]>,
    memory: &Memory,
) -> Vec<Vector2Planes> {
    let field = Field::new(plan, params, frame, patches);
    match directions {
        StrokeDirections::Max => field.found([0], given, memory).into(),
        StrokeDirections::Min => field.found([1], given, memory).into(),
        StrokeDirections::Both => field.found([0, 1], given, memory).into(),
    }
}

struct Field<'a> {
    params: &'a FieldParams,
    frame: &'a Frame,
    patches: &'a Patches,
    setting: FieldSetting,
}

/// A patch with unknown curvature.
const NO_FORM: Weighted = [0.0, 0.0, 0.0, 1.0];

impl<'a> Field<'a> {
    fn new(plan: &Plan, params: &'a FieldParams, frame: &'a Frame, patches: &'a Patches) -> Self {
        Self {
            params,
            frame,
            patches,
            setting: FieldSetting::new(plan, params, frame),
        }
    }

    /// The fields of these families: 0 follows the larger curvature, 1 the lesser.
    fn found<const N: usize>(
        &self,
        families: [usize; N],
        given: Option<&[Vector2Planes]>,
        memory: &Memory,
    ) -> [Vector2Planes; N] {
        let cross = CrossKernel::new(self.patches);
        let forms = self.forms(&cross);
        let mut led = self.calmed(self.doubled(&forms, families), &cross);
        for (order, given) in given.into_iter().flatten().enumerate() {
            self.follow(&mut led, given, order);
        }
        self.settle(&mut led);
        let between = BetweenPatches {
            patches: self.patches,
            mask: &self.frame.mask,
            doubled: &led,
        };
        let (mut found, lacking) = between.all(memory);
        let each = found.par_iter_mut().zip(&lacking).enumerate();
        each.for_each(|(order, (found, lacking))| {
            fill_rest(found, lacking, |x, y| {
                let at = self.frame.data_window.middle(x, y);
                self.fallback(at, self.frame.normal.at(x, y), order)
            });
        });
        found
    }

    /// The fallback at a place in the picture, of the first field made or the second.
    fn fallback(&self, at: DVec2, normal: DVec3, order: usize) -> Vec2 {
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

    /// Reach of one pass from each patch, in patches.
    fn reach(&self) -> Vec<f32> {
        let radius = self.params.radius_px * self.setting.cells;
        let all = &self.patches.all;
        if !self.setting.is_by_depth {
            return vec![radius; all.len()];
        }
        let is_known = |depth: f32| depth > 0.0 && depth.is_finite();
        let depths = all.iter().map(|p| p.depth);
        let mut depths: Vec<f32> = depths.filter(|&d| is_known(d)).collect();
        let Some(median) = quantile(&mut depths, 0.5, f32::total_cmp) else {
            return vec![radius; all.len()];
        };
        let reach = |depth: f32| match is_known(depth) {
            true => radius * (median / depth).clamp(FAR, NEAR),
            false => radius,
        };
        all.iter().map(|p| reach(p.depth)).collect()
    }

    /// The curvature of every patch, per pixel, averaged nearby.
    fn forms(&self, cross: &CrossKernel) -> Vec<[Weighted; 1]> {
        let (all, sight, simd) = (&self.patches.all, &self.setting.sight, Simd::widest());
        let source = PatchSource {
            is_perspective: sight.is_perspective(),
            step_px: self.params.cell_px.into(),
            pixels: self.setting.pixels,
        };
        let lines: Vec<[f64; 2]> = all
            .par_iter()
            .with_min_len(PATCHES_PER_TASK)
            .map(|patch| sight.across_and_up(patch.at.x, patch.at.y))
            .collect();
        let mut forms = vec![[NO_FORM]; all.len()];
        let tasks = forms.par_chunks_mut(PATCHES_PER_TASK).enumerate();
        tasks.for_each_init(
            || (Neighbourhoods::default(), Tensors::default()),
            |(around, found), (task, forms)| {
                for (i, forms) in forms.chunks_mut(LANES).enumerate() {
                    for lane in 0..forms.len() {
                        let patch = task * PATCHES_PER_TASK + i * LANES + lane;
                        self.look_around(around, lane, patch, &lines);
                    }
                    simd.patch_tensors(found, around, &source);
                    for (lane, [form]) in forms.iter_mut().enumerate() {
                        *form = [found.x[lane], found.y[lane], found.mean[lane], 1.0];
                    }
                }
            },
        );
        let reach = vec![FORM_REACH * self.setting.cells; all.len()];
        cross.average(&mut forms, &reach, 1);
        forms
    }

    /// Takes a patch and those beside it into a lane.
    #[inline]
    fn look_around(
        &self,
        around: &mut Neighbourhoods,
        lane: usize,
        patch: usize,
        lines: &[[f64; 2]],
    ) {
        let Patches {
            all, across, down, ..
        } = self.patches;
        let take = |lanes: &mut Lanes, i: usize| {
            lanes.is_there[lane] = u8::from(i < all.len());
            if let (Some(patch), Some(line)) = (all.get(i), lines.get(i)) {
                for (axis, &n) in lanes.normal.iter_mut().zip(patch.normal.as_ref()) {
                    axis[lane] = n;
                }
                (lanes.line[0][lane], lanes.line[1][lane]) = (line[0], line[1]);
            }
        };
        take(&mut around.here, patch);
        // Rows run down, y up.
        let beside = [&across.before, &across.after, &down.after, &down.before];
        for (lanes, links) in around.beside.iter_mut().zip(beside) {
            take(lanes, links[patch] as usize);
        }
    }

    /// The directions of patches, of the larger curvature in family 0, of the lesser in 1, in the order of `families`: see
    /// [`calm`].
    fn doubled<const N: usize>(
        &self,
        forms: &[[Weighted; 1]],
        families: [usize; N],
    ) -> Vec<[Weighted; N]> {
        let all = self.patches.all.par_iter().with_min_len(PATCHES_PER_TASK);
        all.zip(forms)
            .map(|(patch, &[[x, y, mean, _]])| {
                let form = CurvatureTensor {
                    deviator: DVec2::new(x.into(), y.into()),
                    mean: mean.into(),
                };
                let directions = self.directions(patch, &form, families);
                let directions = directions.unwrap_or([Vec2::ZERO; N]);
                let flat = form.flatness(self.setting.doubt) as f32;
                let mut found = [NO_FORM; N];
                for (order, own) in directions.into_iter().enumerate() {
                    let fallback = self.fallback(patch.at, patch.normal, order);
                    let sum = own + flat * doubled(fallback);
                    found[order] = [sum.x, sum.y, own.length() + flat, 1.0];
                }
                found
            })
            .collect()
    }

    /// Twice the angles of a patch's own directions, of these families, with their confidence as length.
    fn directions<const N: usize>(
        &self,
        patch: &Patch,
        form: &CurvatureTensor,
        families: [usize; N],
    ) -> Option<[Vec2; N]> {
        let larger = form.larger()?;
        let [a, b] = upright_tangents(patch.normal)?;
        let [x, y] = patch.at.to_array();
        let facing = (self.setting.sight.facing(x, y, patch.normal) / FACING).clamp(0.0, 1.0);
        let sure = form.confidence(self.setting.doubt) * facing.powi(2);
        let direction = |axis: DVec2| {
            let tangent = axis.x * a + axis.y * b;
            let seen = self.setting.sight.picture_direction(x, y, tangent)?;
            Some(sure as f32 * doubled(seen.as_vec2()))
        };
        let axes = [larger, larger.perp()];
        Some(families.map(|family| direction(axes[family]).unwrap_or_default()))
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
        pairs
            .map(|(own, around)| std::array::from_fn(|f| calm(own[f], around[f])))
            .collect()
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
    fn settle<const N: usize>(&self, doubled_directions: &mut [[[f32; 2]; N]]) {
        let settle = |(i, directions): (usize, &mut [[f32; 2]; N])| {
            if self.patches.is_speck(i) {
                *directions = [[0.0; 2]; N];
                return;
            }
            let patch = &self.patches.all[i];
            for (order, z) in directions.iter_mut().enumerate() {
                let last = || doubled(self.fallback(patch.at, patch.normal, order));
                let mut sum = Vec2::from(*z);
                let share = 1.0 - sum.length() / FREE;
                if share > 0.0 {
                    sum += FALLBACK * share * last();
                }
                *z = sum.try_normalize().unwrap_or_else(last).to_array();
            }
        };
        doubled_directions
            .par_iter_mut()
            .with_min_len(PATCHES_PER_TASK)
            .enumerate()
            .for_each(settle);
    }
}

/// Fewest patches per task.
const PATCHES_PER_TASK: usize = 1024;
