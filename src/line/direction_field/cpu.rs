//! The field of stroke directions ([LA] section 6.1): curvature patch by patch, averaged over surfaces,
//! and brought back to pixels.

use crate::frame::{Frame, Vector2Planes};
use crate::kernel::memory::Memory;
use crate::kernel::quantile::quantile;
use crate::kernel::simd::wide;
use crate::line::direction::fill::fill_rest;
use crate::line::direction_field::between_patches::BetweenPatches;
use crate::line::direction_field::chains::CrossKernel;
use crate::line::direction_field::directions::{self, Averaged, Source};
use crate::line::direction_field::forms;
use crate::line::direction_field::forms::{LANES, Lanes, Neighbourhoods, PatchSource, Tensors};
use crate::line::direction_field::patches::{Patch, Patches};
use crate::line::direction_field::setting::{
    FAR, FORM_REACH, FieldSetting, NEAR, SURROUNDING_PASSES, SURROUNDINGS,
};
use crate::line::direction_field::{Weighted, doubled};
use crate::params::{FieldParams, StrokeDirections};
use crate::plan::Plan;
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

    /// The directions of patches, doubled and calmed. What leads to them takes as much memory as some planes, and goes.
    fn led<const N: usize>(&self, families: [usize; N]) -> Vec<[[f32; 2]; N]> {
        let cross = CrossKernel::new(self.patches);
        let lines = self.lines();
        let forms = self.forms(&cross, &lines);
        self.calmed(self.doubled(&forms, &lines, families), &cross)
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

    /// What distinguishes the sight lines of patches.
    fn lines(&self) -> Vec<[f64; 2]> {
        let all = self.patches.all.par_iter().with_min_len(PATCHES_PER_TASK);
        all.map(|patch| self.setting.sight.across_and_up(patch.at.x, patch.at.y))
            .collect()
    }

    /// The curvature of every patch, per pixel, averaged nearby.
    fn forms(&self, cross: &CrossKernel, lines: &[[f64; 2]]) -> Vec<[Weighted; 1]> {
        let (all, sight) = (&self.patches.all, &self.setting.sight);
        let source = PatchSource {
            is_perspective: sight.is_perspective(),
            step_px: self.params.cell_px.into(),
            pixels: self.setting.pixels,
        };
        let mut forms = vec![[NO_FORM]; all.len()];
        let tasks = forms.par_chunks_mut(PATCHES_PER_TASK).enumerate();
        tasks.for_each_init(
            || (Neighbourhoods::default(), Tensors::default()),
            |(around, found), (task, forms)| {
                for (i, forms) in forms.chunks_mut(LANES).enumerate() {
                    for lane in 0..forms.len() {
                        let patch = task * PATCHES_PER_TASK + i * LANES + lane;
                        self.look_around(around, lane, patch, lines);
                    }
                    wide!(forms::patch_tensors(found, around, &source));
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
        lines: &[[f64; 2]],
        families: [usize; N],
    ) -> Vec<[Weighted; N]> {
        let (all, sight) = (&self.patches.all, &self.setting.sight);
        let source = Source {
            is_perspective: sight.is_perspective(),
            pixel_shape: sight.pixel_shape(),
            doubt: self.setting.doubt,
            families,
        };
        let mut doubled = vec![[NO_FORM; N]; all.len()];
        let tasks = doubled.par_chunks_mut(PATCHES_PER_TASK).enumerate();
        tasks.for_each_init(
            || (directions::Lanes::default(), [[[0.0; LANES]; 3]; N]),
            |(patches, found), (task, doubled)| {
                for (i, doubled) in doubled.chunks_mut(LANES).enumerate() {
                    let first = task * PATCHES_PER_TASK + i * LANES;
                    let these = first..first + doubled.len();
                    let own = all[these.clone()].iter().zip(&lines[these.clone()]);
                    for (lane, ((patch, line), form)) in own.zip(&forms[these]).enumerate() {
                        self.take(patches, lane, patch, line, form);
                    }
                    wide!(directions::patch_directions(found, patches, &source));
                    for (lane, doubled) in doubled.iter_mut().enumerate() {
                        for (doubled, [x, y, sure]) in doubled.iter_mut().zip(&*found) {
                            *doubled = [x[lane], y[lane], sure[lane], 1.0];
                        }
                    }
                }
            },
        );
        doubled
    }

    /// Takes a patch and its curvature into a lane.
    #[inline]
    fn take<const N: usize>(
        &self,
        lanes: &mut directions::Lanes<N>,
        lane: usize,
        patch: &Patch,
        line: &[f64; 2],
        [form]: &[Weighted; 1],
    ) {
        for (axis, &n) in lanes.normal.iter_mut().zip(patch.normal.as_ref()) {
            axis[lane] = n;
        }
        (lanes.line[0][lane], lanes.line[1][lane]) = (line[0], line[1]);
        for (to, &from) in lanes.form.iter_mut().zip(form) {
            to[lane] = from;
        }
        for (order, [x, y]) in lanes.fallback.iter_mut().enumerate() {
            let fallback = doubled(self.fallback(patch.at, patch.normal, order));
            (x[lane], y[lane]) = (fallback.x, fallback.y);
        }
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
        let mut calmed = vec![[[0.0; 2]; N]; found.len()];
        let parts = calmed.par_chunks_mut(LANES).with_min_len(BUNDLES_PER_TASK);
        let pairs = found.par_chunks(LANES).zip(around.par_chunks(LANES));
        parts.zip(pairs).for_each(|(calmed, (own, around))| {
            for order in 0..N {
                let (mut averaged, mut out) = (Averaged::default(), [[0.0; LANES]; 2]);
                for (lane, (own, around)) in own.iter().zip(around).enumerate() {
                    for (to, from) in averaged.own.iter_mut().zip(own[order]) {
                        to[lane] = from;
                    }
                    for (to, from) in averaged.around.iter_mut().zip(around[order]) {
                        to[lane] = from;
                    }
                }
                wide!(directions::calm_patches(&mut out, &averaged));
                for (lane, calmed) in calmed.iter_mut().enumerate() {
                    calmed[order] = [out[0][lane], out[1][lane]];
                }
            }
        });
        calmed
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
        let settle = |(bundle, settled): (usize, &mut [[[f32; 2]; N]])| {
            let first = bundle * LANES;
            for order in 0..N {
                let [mut directions, mut fallback] = [[[0.0; LANES]; 2]; 2];
                for (lane, settled) in settled.iter().enumerate() {
                    let patch = &self.patches.all[first + lane];
                    let last = doubled(self.fallback(patch.at, patch.normal, order));
                    [directions[0][lane], directions[1][lane]] = settled[order];
                    (fallback[0][lane], fallback[1][lane]) = (last.x, last.y);
                }
                wide!(directions::settle_patches(&mut directions, &fallback));
                for (lane, settled) in settled.iter_mut().enumerate() {
                    settled[order] = [directions[0][lane], directions[1][lane]];
                }
            }
            for (i, settled) in settled.iter_mut().enumerate() {
                if self.patches.is_speck(first + i) {
                    *settled = [[0.0; 2]; N];
                }
            }
        };
        doubled_directions
            .par_chunks_mut(LANES)
            .with_min_len(BUNDLES_PER_TASK)
            .enumerate()
            .for_each(settle);
    }
}

/// Fewest patches per task.
const PATCHES_PER_TASK: usize = 1024;

/// The same in bundles of lanes.
const BUNDLES_PER_TASK: usize = PATCHES_PER_TASK / LANES;
