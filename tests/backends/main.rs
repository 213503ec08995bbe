//! Every product on every backend: the same scenes on the CPU and on the GPU, within one table of tolerances.

#[path = "../common/mod.rs"]
mod common;

mod command;
mod contours;
mod directions;
mod drawing;
mod hostile;
mod kernels;
mod numbers;
mod products;
mod relight;

use crate::common::cpu;
use relievo::engine::gpu::{self, AdapterKind, Device};
use relievo::engine::{Outcome, PlanInputs};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::params::{ScalingParams, ShapeParams};
use relievo::plan::{Available, Goal, Plan};
use relievo::product::Product;
use relievo::scenes::{ExactScene, Surface};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Runs a test on the shared device, one at a time; without a device prints a notice once.
fn on_gpu(test: impl FnOnce(&gpu::DeviceRunner)) {
    static RUNNER: OnceLock<Option<Mutex<gpu::DeviceRunner>>> = OnceLock::new();
    let runner = RUNNER.get_or_init(|| match Device::open(AdapterKind::Any) {
        Ok(device) => {
            println!("on {}", device.name());
            Some(Mutex::new(gpu::DeviceRunner::new(device)))
        }
        Err(error) => {
            // Fails on a machine that requires a device.
            assert!(std::env::var_os("RELIEVO_NEEDS_GPU").is_none(), "{error}");
            println!("SKIPPED: {error}");
            None
        }
    });
    if let Some(runner) = runner {
        test(&runner.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

fn plan(goal: Goal, frame: &Frame, shape: ShapeParams, scaling: ScalingParams) -> Plan {
    Plan::new(goal, Available::in_frame(frame), shape, scaling).unwrap()
}

/// Asserts that both backends give the same result for a frame, and prints their difference.
#[track_caller]
fn assert_same(name: &str, runner: &gpu::DeviceRunner, plan: &Plan, frame: &Frame) {
    let expected = cpu::run(plan, frame).unwrap();
    let found = runner.execute(plan, frame, PlanInputs::default()).unwrap();
    let layers = plan.wants(Product::MappedCurvature);
    assert_alike(name, &found, &expected, |product| {
        (layers != (product == Product::Picture)).then(|| product.tolerance())
    });
}

/// Asserts that outcomes agree in the products that have a tolerance.
#[track_caller]
fn assert_alike(
    name: &str,
    found: &Outcome,
    expected: &Outcome,
    tolerance: impl Fn(Product) -> Option<f64>,
) {
    for (name, found, expected) in [
        ("gain", found.gain, expected.gain),
        ("white level", found.white_level, expected.white_level),
        (
            "gain of the environment",
            found.environment_gain,
            expected.environment_gain,
        ),
    ] {
        let apart = match (found, expected) {
            (Some(f), Some(e)) => (f / e - 1.0).abs(),
            (f, e) if f == e => 0.0,
            _ => f32::INFINITY,
        };
        assert!(apart < 1e-5, "{name} {found:?}, not {expected:?}");
    }
    let found: Vec<_> = found.products().collect();
    let mut worst: Vec<(Product, f64)> = Vec::new();
    let wanted = |product: &Product| tolerance(*product).is_some();
    for (product, expected) in expected.products().filter(|(product, _)| wanted(product)) {
        let mut same = found.iter().filter(|(other, _)| *other == product);
        let count = worst.iter().filter(|(other, _)| *other == product).count();
        let (_, found) = same.nth(count).unwrap_or_else(|| {
            panic!("{name}: {product:?} is missing");
        });
        worst.push((product, product.difference(found, &expected)));
    }
    for (product, apart) in worst {
        let allowed = tolerance(product).unwrap();
        println!("{name}: {product:?} {apart:.1e} of {allowed:.0e}");
        assert!(apart <= allowed, "{name}: {product:?} is off by {apart:e}");
    }
}

/// Waves seen from near, with a picture.
fn waves(width: usize, height: usize) -> Frame {
    let scene = ExactScene::orthographic(Surface::sine_relief(3.0, 24.0, 0.4), 30.0, 20.0);
    with_color(scene.in_perspective().frame(width, height))
}

fn with_color(mut frame: Frame) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let plane = |k: f32| {
        Plane::from_fn(width, height, |x, y| {
            let wave = (0.13 * x as f32 + 0.07 * k * y as f32).sin();
            0.4 + 0.3 * wave + 0.1 * k
        })
    };
    frame.color = Some(ColorPlanes {
        r: plane(1.0),
        g: plane(2.0),
        b: plane(3.0),
    });
    frame
}
