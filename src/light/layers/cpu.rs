//! Radiance scaling of the light layers of a frame: all terms of a row in turn, rows in parallel.

use crate::frame::memory::Memory;
use crate::frame::rows::ROWS_PER_TASK;
use crate::frame::{ColorPlanes, Frame, Plane, SymmetricPlanes, parallel_rows};
use crate::kernel::simd::wide;
use crate::light::layers;
use crate::light::layers::terms::LightTerm;
use crate::light::layers::{ColorRow, LobeRow, TermScaling};
use crate::params::ScalingParams;
use rayon::prelude::*;

/// The curvature used for scaling.
#[derive(Clone, Copy)]
pub(crate) struct Curvature<'a> {
    pub(crate) trace: &'a Plane,
    /// The full Hessian, if the direction of light matters.
    pub(crate) hessian: Option<&'a SymmetricPlanes>,
    pub(crate) gain: f32,
}

/// Rows in place of absent layers.
pub(crate) struct Absent {
    zeros: Vec<f32>,
    ones: Vec<f32>,
}

impl Absent {
    pub(crate) fn new(width: usize) -> Self {
        Self {
            zeros: vec![0.0; width],
            ones: vec![1.0; width],
        }
    }
}

impl LightTerm<'_> {
    fn row<'b>(&'b self, y: usize, absent: &'b Absent) -> LobeRow<'b> {
        let row = |planes: Option<&'b ColorPlanes>, absent: &'b [f32]| match planes {
            Some(planes) => color_row(planes, y),
            None => [absent; 3],
        };
        LobeRow {
            direct: row(self.direct, &absent.zeros),
            indirect: row(self.indirect, &absent.zeros),
            color: row(self.color, &absent.ones),
            albedo: row(self.albedo, &absent.ones),
        }
    }

    /// The luminance of this light at a pixel; `None` where there is none.
    pub(crate) fn lit<'b>(
        &'b self,
        weights: [f32; 3],
        absent: &'b Absent,
    ) -> impl Fn(usize, usize) -> Option<f32> + Sync + 'b {
        move |x, y| {
            let luminance = self.row(y, absent).luminance(x, weights);
            (luminance > 0.0).then_some(luminance)
        }
    }
}

/// The picture with its lobes scaled separately.
pub(crate) fn scale_lobes(
    terms: &[LightTerm],
    whites: &[(&'static str, f32)],
    frame: &Frame,
    params: &ScalingParams,
    curvature: Curvature,
    memory: &Memory,
) -> ColorPlanes {
    let absent = Absent::new(frame.mask.width());
    let weights = frame.luminance_weights();
    let scalings: Vec<_> = terms
        .iter()
        .zip(whites)
        .map(|(term, &(_, white))| TermScaling {
            magnitude: term.magnitude,
            invariant_point: params.invariant_point,
            white,
            weights,
        })
        .collect();
    changed(frame, memory, |y, scratch| {
        let trace = curvature.trace.row(y);
        wide!(layers::kappa_row(&mut scratch.kappa, trace, curvature.gain));
        for (term, by) in terms.iter().zip(&scalings) {
            let row = term.row(y, &absent);
            wide!(layers::lobe_sigma_row(
                &mut scratch.sigma,
                &row,
                &scratch.kappa,
                by
            ));
            scratch.add_changes([row.direct, row.indirect, row.color]);
        }
    })
}

/// The picture with its light groups scaled by the directions of their lights.
pub(crate) fn scale_groups(
    frame: &Frame,
    params: &ScalingParams,
    curvature: Curvature,
    memory: &Memory,
) -> ColorPlanes {
    let absent = Absent::new(frame.mask.width());
    let by = TermScaling {
        magnitude: params.magnitudes().diffuse,
        invariant_point: params.invariant_point,
        white: 1.0,
        weights: frame.luminance_weights(),
    };
    let normal = [&frame.normal.x, &frame.normal.y, &frame.normal.z];
    changed(frame, memory, |y, scratch| {
        let normal = normal.map(|plane| plane.row(y));
        if curvature.hessian.is_none() {
            wide!(layers::kappa_row(
                &mut scratch.kappa,
                curvature.trace.row(y),
                curvature.gain
            ));
        }
        for group in &frame.light.groups {
            scratch.plain.fill(0.0);
            scratch.scaled.fill(0.0);
            for to_light in &group.to_light {
                if let Some(hessian) = curvature.hessian {
                    let hessian = [&hessian.xx, &hessian.xy, &hessian.yy].map(|plane| plane.row(y));
                    let l_xy = [to_light.x, to_light.y];
                    let kappa = &mut scratch.kappa;
                    wide!(layers::kappa_toward_row(
                        kappa,
                        hessian,
                        l_xy,
                        curvature.gain,
                        params.anisotropy
                    ));
                }
                let (plain, scaled) = (&mut scratch.plain, &mut scratch.scaled);
                let to_light = to_light.to_array();
                wide!(layers::add_direction_row(
                    plain,
                    scaled,
                    normal,
                    to_light,
                    &scratch.kappa,
                    &by
                ));
            }
            wide!(layers::group_sigma_row(
                &mut scratch.sigma,
                &scratch.plain,
                &scratch.scaled
            ));
            let (zeros, ones) = ([&absent.zeros[..]; 3], [&absent.ones[..]; 3]);
            scratch.add_changes([color_row(&group.light, y), zeros, ones]);
        }
    })
}

/// Rows for one task, kept in the cache.
struct LayerRows {
    kappa: Vec<f32>,
    sigma: Vec<f32>,
    /// Sums over the directions of a group: of n.l, and of scaled n.l.
    plain: Vec<f32>,
    scaled: Vec<f32>,
    /// Change of each channel by the terms so far, and their light.
    change: [Vec<f32>; 3],
    layered: [Vec<f32>; 3],
}

impl LayerRows {
    fn new(width: usize) -> Self {
        let row = || vec![0.0; width];
        Self {
            kappa: row(),
            sigma: row(),
            plain: row(),
            scaled: row(),
            change: [row(), row(), row()],
            layered: [row(), row(), row()],
        }
    }

    /// Adds the change of a light by `sigma`: direct, indirect and the colour of both.
    fn add_changes(&mut self, light: [ColorRow; 3]) {
        for (i, (change, layered)) in self.change.iter_mut().zip(&mut self.layered).enumerate() {
            wide!(layers::add_change_row(
                change,
                layered,
                light.map(|row| row[i]),
                &self.sigma
            ));
        }
    }
}

/// The picture with the changes gathered per row by `add(y, scratch)`.
fn changed(
    frame: &Frame,
    memory: &Memory,
    add: impl Fn(usize, &mut LayerRows) + Sync,
) -> ColorPlanes {
    let mask = &frame.mask;
    let color = frame.color.as_ref().expect("scaling needs a picture");
    let [r, g, b] = [(); 3].map(|()| memory.plane(mask));
    let mut made = ColorPlanes { r, g, b };
    parallel_rows([&mut made.r, &mut made.g, &mut made.b])
        .with_min_len(ROWS_PER_TASK)
        .for_each_init(
            || LayerRows::new(mask.width()),
            |scratch, (y, rows)| {
                let from = color_row(color, y);
                if mask.span(y).is_empty() {
                    for (out, from) in rows.into_iter().zip(from) {
                        out.copy_from_slice(from);
                    }
                    return;
                }
                for sum in scratch.change.iter_mut().chain(&mut scratch.layered) {
                    sum.fill(0.0);
                }
                add(y, scratch);
                for (i, out) in rows.into_iter().enumerate() {
                    let (change, layered) = (&scratch.change[i], &scratch.layered[i]);
                    wide!(layers::changed_row(
                        out,
                        from[i],
                        change,
                        layered,
                        mask.row(y)
                    ));
                }
            },
        );
    made
}

fn color_row(color: &ColorPlanes, y: usize) -> ColorRow<'_> {
    [&color.r, &color.g, &color.b].map(|plane| plane.row(y))
}
