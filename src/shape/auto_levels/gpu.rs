//! The gain of curvature, chosen by the CPU from planes read back.

use crate::plan::execution::Execution;
use crate::plan::recording::Recording;

/// Has the CPU choose the gain of curvature, with the planes it depends on if that is left open.
pub(crate) fn with_trace(run: &mut Recording, choose: fn(&mut Execution)) {
    if run.plan.chooses_gain() {
        let [trace, conductance] = ["trace", "conductance"].map(|name| run.plane(name));
        let [trace, conductance] = run.read_planes([&trace, &conductance]);
        let of_host = &mut run.host.made.outcome.shape;
        (of_host.trace, of_host.conductance) = (Some(trace), Some(conductance));
    }
    run.choose(choose);
    let of_host = &mut run.host.made.outcome.shape;
    (of_host.trace, of_host.conductance) = (None, None);
}

#[cfg(test)]
mod tests {
    use crate::engine::cpu;
    use crate::engine::gpu::runner::DeviceRunner;
    use crate::engine::inputs::PlanInputs;
    use crate::frame::{ColorPlanes, Frame, Plane};
    use crate::gpu::device::{AdapterKind, Device, to_test_on};
    use crate::params::{ScalingParams, ShapeParams};
    use crate::plan::{Available, Goal, Plan};
    use crate::scenes::Scene;

    /// 1.1 million pixels, of which one in nine is looked at. Curvature lies in six rows of ten: its sample falls short and
    /// is taken once more.
    #[test]
    fn large_pictures_are_sampled_as_on_the_cpu() {
        let Some(device) = to_test_on(Device::open(AdapterKind::Any)) else {
            return;
        };
        let (width, height) = (1100, 1000);
        let mut frame: Frame = Scene::waves(width, height).frame;
        for (plane, flat) in [
            (&mut frame.normal.x, 0.0),
            (&mut frame.normal.y, 0.0),
            (&mut frame.normal.z, 1.0),
        ] {
            plane.samples_mut()[600 * width..].fill(flat);
        }
        let channel = |hue: f32| {
            Plane::from_fn(width, height, |x, y| {
                hue * (0.5 + 0.4 * ((x * x + 7 * y) as f32 / 9e3).sin())
            })
        };
        let [r, g, b] = [0.9, 0.7, 0.5].map(channel);
        frame.color = Some(ColorPlanes { r, g, b });
        let available = Available::in_frame(&frame);
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let plan = Plan::new(Goal::Enhance, available, shape, scaling).unwrap();
        let host = cpu::Runner::default();
        let expected = host.execute(&plan, &frame, PlanInputs::default()).unwrap();
        let runner = DeviceRunner::new(device);
        let whole = runner
            .execute(&plan, &frame, PlanInputs::default())
            .unwrap();
        // The traces of both differ by rounding, their sums of three products hardly.
        for (found, expected, allowed) in [
            (whole.gain, expected.gain, 1e-4),
            (whole.white_level, expected.white_level, 1e-6),
        ] {
            let off = found.unwrap() / expected.unwrap() - 1.0;
            assert!(off.abs() <= allowed, "{found:?} {expected:?}");
        }
    }
}
