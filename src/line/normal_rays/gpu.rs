//! Directions of the surface's own curvature, from its normal rays.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::recording::Recording;
use crate::engine::gpu::sight::{SIGHT_LINES, is_eye_far, lines, starts, step_at_unit_depth};
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::{F32, I32};
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::error::Result;
use crate::frame::{DepthKind, Frame, Vector2Planes};
use crate::line::normal_rays::cpu::filled;
use crate::line::normal_rays::setting::{RaySetting, STEP_GROWTH};
use crate::line::normal_rays::{CERTAINTY, MIN_COSINE, MIN_SINE, PLANAR_TURN, UMBILIC};
use crate::plan::Plan;
use crate::product::Product;
use crate::shape::edges::SilhouetteSource;

/// The curvature of a surface from the normals beside one.
pub(crate) const NORMAL_RAY: Wgsl = wgsl!(
    "normal_ray.wgsl",
    [
        ("MIN_COSINE", F32(MIN_COSINE as f32)),
        ("MIN_SINE", F32(MIN_SINE as f32))
    ]
);

uniforms! {
    /// Uniforms of `normal_rays.wgsl`.
    RayParams {
        width: u32,
        height: u32,
        /// The direction of sight lines, scaled to z = -1: at the first column and row, and its increment per column
        /// and row.
        line_x: f32,
        line_x_step: f32,
        line_y: f32,
        line_y_step: f32,
        /// Distance between the starts of adjacent pixels' sight lines, and between points at a depth of 1 on them.
        start_x_step: f32,
        start_y_step: f32,
        apart_x_step: f32,
        apart_y_step: f32,
        /// Height of a pixel over its width.
        pixel_shape: f32,
        /// Deviations of a component of a normal, and of a point as a share of its depth.
        normal_noise: f32,
        offset_noise: f32,
        /// The least and the greatest step, in pixels.
        first_step: i32,
        most_step: i32,
    }
}

bindings! {
    NormalRaysBuffers {
        covered: &[u32], conductance: &[f32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32],
        /// Any buffer where points are taken from normals.
        depth: &[f32], direction_x: &mut [f32], direction_y: &mut [f32],
        /// 1 where the surface is a plane.
        planar: &mut [f32],
    }
}

/// Directions of curvature from normal rays.
pub(crate) static NORMAL_RAYS: Kernel = Kernel::new::<RayParams, NormalRaysBuffers>(
    "NormalRays",
    &[
        SIGHT_LINES,
        NORMAL_RAY,
        wgsl!(
            "normal_rays.wgsl",
            [
                ("STEP_GROWTH", I32(STEP_GROWTH as i32)),
                ("PLANAR_TURN", F32(PLANAR_TURN as f32)),
                ("ALIKE", F32(UMBILIC as f32)),
                ("CERTAINTY", F32(CERTAINTY as f32))
            ]
        ),
    ],
);

/// Name in timings of rays, and of filling gaps between their directions.
const STAGE: &str = "normal-rays";

/// Finds the surface's own curvature directions, if they are requested as a product.
pub(crate) fn follow_rays(run: &mut Recording) {
    if run.plan.wants(Product::Direction) {
        let shape = run.made.shape.as_ref();
        let shape = shape.expect("directions are planned with their edges");
        let conductance = shape.conductance.clone();
        run.made.directions = Some(run.normal_rays(run.plan, run.frame, &conductance));
    }
}

/// Gives pixels without a direction those of their neighbours, which spread from pixel to pixel: on the CPU.
pub(crate) fn fill_gaps(run: &mut Recording) -> Result<()> {
    let Some(found) = run.made.directions.take() else {
        return Ok(());
    };
    let [x, y, flat] = run.read_planes(found.each_ref());
    run.buffers.recycle(found);
    let (frame, host) = (run.frame, &mut run.host);
    let conductance = host.outcome.shape.conductance.take();
    let conductance = conductance.expect("directions are planned with their edges");
    let directions = host.timed(STAGE, || {
        filled(Vector2Planes { x, y }, &flat, frame, &conductance)
    });
    let shape = &mut host.outcome.shape;
    (shape.conductance, shape.direction) = (Some(conductance), Some(directions));
    Ok(())
}

impl Recording<'_> {
    /// Directions of the surface's own curvature, 0 where rays give none: x, y, and whether the surface is a plane.
    fn normal_rays(
        &mut self,
        plan: &Plan,
        frame: &Frame,
        conductance: &wgpu::Buffer,
    ) -> [wgpu::Buffer; 3] {
        let setting = RaySetting::new(plan, frame);
        let depth = setting.depth.map(|plane| {
            match SilhouetteSource::of(plan) == SilhouetteSource::Depth {
                true => self.surface.map.clone().expect("silhouettes are of depth"),
                false => self.uploaded(plane.samples()),
            }
        });
        let plane = self.surface.plane_bytes();
        let found = [(); 3].map(|()| self.take(plane));
        let [direction_x, direction_y, planar] = found.each_ref();
        let covered = self.surface.covered.clone();
        let [normal_x, normal_y, normal_z] = self.surface.normal.clone();
        let switches = [
            ("HAS_DEPTH", depth.is_some()),
            ("IS_PARALLEL", is_eye_far(frame)),
            ("DEPTH_ALONG_RAY", frame.source.depth_kind == DepthKind::Ray),
        ];
        self.recorder.over_pixels(
            STAGE,
            (&NORMAL_RAYS, &switches),
            &ray_params(frame, &setting),
            &NormalRaysBuffers {
                covered: &covered,
                conductance,
                normal_x: &normal_x,
                normal_y: &normal_y,
                normal_z: &normal_z,
                depth: depth.as_ref().unwrap_or(&normal_x),
                direction_x,
                direction_y,
                planar,
            },
            self.surface.size,
        );
        found
    }
}

fn ray_params(frame: &Frame, setting: &RaySetting) -> RayParams {
    let line = lines(frame, &setting.sight);
    let (start, apart) = (starts(frame), step_at_unit_depth(frame, &setting.sight));
    let [first_step, most_step] = setting.steps_px.map(|step| step as i32);
    RayParams {
        width: frame.mask.width() as u32,
        height: frame.mask.height() as u32,
        line_x: line.first[0],
        line_x_step: line.step[0],
        line_y: line.first[1],
        line_y_step: line.step[1],
        start_x_step: start.step[0],
        start_y_step: start.step[1],
        apart_x_step: apart[0],
        apart_y_step: apart[1],
        pixel_shape: setting.sight.pixel_shape() as f32,
        normal_noise: setting.normal_noise as f32,
        offset_noise: setting.offset_noise as f32,
        first_step,
        most_step,
    }
}
