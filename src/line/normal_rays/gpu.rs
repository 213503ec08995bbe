//! Directions of the surface's own curvature, from its normal rays.

use crate::error::Result;
use crate::frame::{DepthKind, Frame, Vector2Planes};
use crate::gpu::kernels::Kernel;
use crate::gpu::sight::{SIGHT_LINES, is_eye_far, lines, starts, step_at_unit_depth};
use crate::gpu::uniforms::uniforms;
use crate::gpu::wgsl::Number::{F32, I32};
use crate::gpu::wgsl::{Wgsl, wgsl};
use crate::line::normal_rays::cpu::filled;
use crate::line::normal_rays::setting::{RaySetting, STEP_GROWTH};
use crate::line::normal_rays::{CERTAINTY, MIN_COSINE, MIN_SINE, PLANAR_TURN, UMBILIC};
use crate::plan::recording::Recording;
use crate::product::Product;

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
        /// The direction of sight lines, scaled to z = -1, as [`linear`](crate::gpu::sight::linear) has it.
        line: vec4,
        /// Distance between the starts of adjacent pixels' sight lines, and between points at a depth of 1 on them.
        start_step: vec2,
        apart_step: vec2,
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

/// Directions of curvature from normal rays.
pub(crate) static NORMAL_RAYS: Kernel = Kernel::new::<RayParams>(
    "NormalRays",
    // `planar` is 1 where the surface is a plane.
    "covered: u32; conductance, normal_x, normal_y, normal_z, depth?: f32; \
     direction_x, direction_y, planar: mut f32",
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

/// The planes that the kernel makes.
const FOUND: [&str; 3] = ["direction_x", "direction_y", "planar"];

/// Finds the surface's own curvature directions, if they are requested as a product: 0 where rays give none.
pub(crate) fn follow_rays(run: &mut Recording) {
    let (plan, frame) = (run.plan, run.frame);
    if !plan.wants(Product::Direction) {
        return;
    }
    let setting = RaySetting::new(plan, frame);
    run.upload_as("depth", setting.depth);
    let switches = [
        ("HAS_DEPTH", setting.depth.is_some()),
        ("IS_PARALLEL", is_eye_far(frame)),
        ("DEPTH_ALONG_RAY", frame.source.depth_kind == DepthKind::Ray),
    ];
    let kernel: (&Kernel, &[_]) = (&NORMAL_RAYS, &switches);
    run.over_pixels(STAGE, kernel, &ray_params(frame, &setting), &[]);
}

/// Gives pixels without a direction those of their neighbours, which spread from pixel to pixel: on the CPU.
pub(crate) fn fill_gaps(run: &mut Recording) -> Result<()> {
    if !run.has(FOUND[0]) {
        return Ok(());
    }
    let found = FOUND.map(|name| run.plane(name));
    let [x, y, flat] = run.read_planes(found.each_ref());
    FOUND.iter().for_each(|name| run.drop_plane(name));
    let (frame, host) = (run.frame, &mut run.host);
    let conductance = host.made.outcome.shape.conductance.take();
    let conductance = conductance.expect("directions are planned with their edges");
    let directions = host.timed(STAGE, || {
        filled(Vector2Planes { x, y }, &flat, frame, &conductance)
    });
    let shape = &mut host.made.outcome.shape;
    (shape.conductance, shape.direction) = (Some(conductance), Some(directions));
    Ok(())
}

fn ray_params(frame: &Frame, setting: &RaySetting) -> RayParams {
    let [.., start_x, start_y] = starts(frame);
    let [first_step, most_step] = setting.steps_px.map(|step| step as i32);
    RayParams {
        line: lines(frame, &setting.sight),
        start_step: [start_x, start_y],
        apart_step: step_at_unit_depth(frame, &setting.sight),
        pixel_shape: setting.sight.pixel_shape() as f32,
        normal_noise: setting.normal_noise as f32,
        offset_noise: setting.offset_noise as f32,
        first_step,
        most_step,
    }
}
