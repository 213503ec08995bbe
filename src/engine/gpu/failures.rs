//! Tests: devices that are lost, have too little memory, or absurd limits.

use crate::engine::cpu;
use crate::engine::gpu::runner::DeviceRunner;
use crate::engine::inputs::PlanInputs;
use crate::error::Error;
use crate::frame::Frame;
use crate::gpu::device::{AdapterKind, Device, to_test_on};
use crate::gpu::fault::{RunFault, watched};
use crate::gpu::limits;
use crate::params::{Scale, ScalingParams, ShapeParams};
use crate::plan::outcome::Outcome;
use crate::plan::{Available, Goal, Plan};
use crate::product::Product;
use crate::scenes::Scene;
use std::thread;
use std::time::{Duration, Instant};

/// The device of this machine, if any, with changed limits.
fn device(change: fn(&mut wgpu::Limits)) -> Option<Device> {
    to_test_on(pollster::block_on(Device::opened(AdapterKind::Any, change)))
}

fn waves(width: usize, height: usize) -> (Plan, Frame) {
    let frame = Scene::waves(width, height).frame;
    let shape = ShapeParams {
        scale: Scale::Iterations(4),
        ..ShapeParams::default()
    };
    let available = Available::in_frame(&frame);
    let plan = Plan::new(Goal::Display, available, shape, ScalingParams::default()).unwrap();
    (plan, frame)
}

#[track_caller]
fn assert_is_of_the_cpu(found: &Outcome, plan: &Plan, frame: &Frame) {
    let expected = cpu::run(plan, frame).unwrap().color.unwrap();
    let found: Vec<_> = found.products().collect();
    let [(Product::Picture, found)] = &found[..] else {
        panic!("a picture, and nothing else")
    };
    let apart = Product::Picture.difference(found, &[&expected.r, &expected.g, &expected.b]);
    assert!(apart <= Product::Picture.tolerance(), "off by {apart:e}");
}

/// Asserts that an error is one line naming the failure, the device and the remedy.
#[track_caller]
fn assert_tells(error: &Error, runner: &DeviceRunner, what: &str) {
    let line = error.to_string();
    assert!(matches!(error, Error::Gpu { .. }), "{line}");
    assert!(line.starts_with(&runner.device().name()), "{line}");
    assert!(
        line.contains(what) && line.contains("--backend cpu"),
        "{line}"
    );
    assert_eq!(line.lines().count(), 1, "{line}");
}

#[test]
fn after_a_loss_every_run_is_an_error_at_once() {
    let Some(device) = device(|_| ()) else { return };
    let runner = DeviceRunner::new(device);
    let (plan, frame) = waves(90, 70);
    assert_is_of_the_cpu(
        &runner
            .execute(&plan, &frame, PlanInputs::default())
            .unwrap(),
        &plan,
        &frame,
    );
    runner.device().lose();
    for _ in 0..3 {
        let start = Instant::now();
        let error = runner
            .execute(&plan, &frame, PlanInputs::default())
            .unwrap_err();
        assert_tells(&error, &runner, "was lost (destroyed)");
        assert!(start.elapsed() < Duration::from_secs(2));
        assert!(runner.device().is_lost());
    }
}

#[test]
fn a_loss_in_the_middle_of_a_run_ends_it() {
    let (plan, frame) = waves(300, 200);
    for delay_ms in [0, 1, 3, 10, 30, 60] {
        let Some(device) = device(|_| ()) else { return };
        let runner = DeviceRunner::new(device);
        let runs = thread::scope(|scope| {
            let runner = &runner;
            scope.spawn(move || {
                thread::sleep(Duration::from_millis(delay_ms));
                runner.device().lose();
            });
            let runs = (0..10_000).map(|_| runner.execute(&plan, &frame, PlanInputs::default()));
            let mut ended = Vec::new();
            for run in runs {
                let is_lost = run.is_err();
                ended.push(run);
                if is_lost {
                    break;
                }
            }
            ended
        });
        for run in &runs {
            match run {
                Ok(outcome) => assert_is_of_the_cpu(outcome, &plan, &frame),
                Err(error) => assert_tells(error, &runner, "was lost"),
            }
        }
        assert!(runs.last().unwrap().is_err());
        assert!(
            runner
                .execute(&plan, &frame, PlanInputs::default())
                .is_err()
        );
    }
}

#[test]
fn after_a_buffer_that_was_refused_smaller_runs_work() {
    let small = |limits: &mut wgpu::Limits| limits.max_buffer_size = 64 << 10;
    let Some(mut device) = device(small) else {
        return;
    };
    // Pretends that the device reported no limit.
    device.plane_bytes = u64::MAX;
    let runner = DeviceRunner::new(device);
    let (large_plan, large) = waves(200, 100);
    let (plan, frame) = waves(60, 50);
    for _ in 0..2 {
        let error = runner
            .execute(&large_plan, &large, PlanInputs::default())
            .unwrap_err();
        assert_tells(&error, &runner, "65536");
        // Buffers returned while recording include some that were never created.
        assert!(runner.buffers.is_empty());
        assert_is_of_the_cpu(
            &runner
                .execute(&plan, &frame, PlanInputs::default())
                .unwrap(),
            &plan,
            &frame,
        );
    }
}

#[test]
fn a_buffer_larger_than_memory_is_a_want_of_memory_and_harms_no_later_run() {
    let Some(device) = device(|_| ()) else { return };
    let runner = DeviceRunner::new(device);
    let (plan, frame) = waves(64, 50);
    let device = runner.device();
    let size = device.device.limits().max_buffer_size;
    let asked = watched(device, || {
        let _unused = device.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: size - size % 4,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        Ok(())
    });
    println!("{size} bytes: {asked:?}");
    match asked {
        Err(RunFault::TooLarge(error)) => assert_tells(&error, &runner, "has too little memory"),
        Err(other) => panic!("{other:?}"),
        // There is enough memory.
        Ok(()) => {}
    }
    assert!(!runner.device().is_lost());
    assert_is_of_the_cpu(
        &runner
            .execute(&plan, &frame, PlanInputs::default())
            .unwrap(),
        &plan,
        &frame,
    );
}

#[test]
fn pictures_beyond_the_limits_are_refused() {
    let few = |limits: &mut wgpu::Limits| limits.max_compute_workgroups_per_dimension = 1024;
    let Some(device) = device(few) else { return };
    let [columns, rows] = limits::most_pixels(1024).map(|most| most as usize);
    let runner = DeviceRunner::new(device.limited_to(8 * 2 * columns as u64));
    for [width, height] in [[3, rows], [columns, 2]] {
        let (plan, frame) = waves(width, height);
        let made = runner.execute(&plan, &frame, PlanInputs::default());
        assert_is_of_the_cpu(&made.unwrap(), &plan, &frame);
    }
    for [width, height] in [[3, rows + 1], [columns + 1, 1], [columns, 3]] {
        let (plan, frame) = waves(width, height);
        let made = runner.execute(&plan, &frame, PlanInputs::default());
        let what = format!("cannot hold a picture of {width}x{height}");
        assert_tells(&made.unwrap_err(), &runner, &what);
    }
}

#[test]
fn a_device_that_lacks_what_kernels_take_is_not_opened() {
    let weak = |limits: &mut wgpu::Limits| limits.max_compute_workgroup_storage_size = 1024;
    // A rejected device is not opened either.
    let opened = Device::opened(AdapterKind::Any, weak);
    let error = pollster::block_on(opened).unwrap_err();
    let line = error.to_string();
    let is_none = line.contains("no adapter");
    assert!(matches!(error, Error::NoGpu { .. }), "{line}");
    assert!(
        is_none || line.contains("takes 1024 bytes of workgroup memory"),
        "{line}"
    );
}
