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

use crate::common::{cpu, poisoned};
use relievo::engine::gpu::{self, AdapterKind, Device};
use relievo::engine::{Outcome, PlanInputs};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::params::{Params, ShapeParams};
use relievo::plan::{Available, Goal, Plan};
use relievo::product::Product;
use relievo::scenes::frames::masked;
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

const GOALS: [Goal; 3] = [Goal::LAYERS, Goal::Display, Goal::Enhance];

fn plan(goal: Goal, frame: &Frame, params: &Params) -> Plan {
    let available = Available::in_frame(frame);
    Plan::new(goal, available, params.shape, params.scaling).unwrap()
}

/// The parameters with a changed shape.
fn with_shape(change: impl FnOnce(&mut ShapeParams)) -> Params {
    let mut params = Params::default();
    change(&mut params.shape);
    params
}

/// What the device and what the CPU makes of a plan.
#[track_caller]
fn outcomes(
    runner: &gpu::DeviceRunner,
    plan: &Plan,
    frame: &Frame,
    inputs: PlanInputs,
) -> [Outcome; 2] {
    let found = runner.execute(plan, frame, inputs).unwrap();
    [found, cpu::execute(plan, frame, inputs).unwrap()]
}

/// Asserts that both backends give the same result for a frame and each goal, and prints their difference.
#[track_caller]
fn assert_same(
    name: &str,
    runner: &gpu::DeviceRunner,
    goals: &[Goal],
    frame: &Frame,
    params: &Params,
) {
    for goal in goals {
        let plan = plan(*goal, frame, params);
        let [found, expected] = outcomes(runner, &plan, frame, PlanInputs::default());
        let layers = plan.wants(Product::MappedCurvature);
        let is_wanted = |product| layers != (product == Product::Picture);
        assert_alike(&format!("{name}, {goal:?}"), &found, &expected, is_wanted);
    }
}

/// Asserts that outcomes agree in some products, each within its own tolerance.
#[track_caller]
fn assert_alike(name: &str, found: &Outcome, expected: &Outcome, is: impl Fn(Product) -> bool) {
    assert_within(name, found, expected, |product| {
        is(product).then(|| product.tolerance())
    });
}

/// Asserts that outcomes agree in the products that have a tolerance.
#[track_caller]
fn assert_within(
    name: &str,
    found: &Outcome,
    expected: &Outcome,
    tolerance: impl Fn(Product) -> Option<f64>,
) {
    let numbers = |of: &Outcome| [of.gain, of.white_level, of.environment_gain];
    let what = ["gain", "white level", "gain of the environment"];
    for ((what, found), expected) in what.iter().zip(numbers(found)).zip(numbers(expected)) {
        let apart = match (found, expected) {
            (Some(f), Some(e)) => (f / e - 1.0).abs(),
            (f, e) if f == e => 0.0,
            _ => f32::INFINITY,
        };
        assert!(apart < 1e-5, "{name}: {what} {found:?}, not {expected:?}");
    }
    let found: Vec<_> = found.products().collect();
    let mut worst: Vec<(Product, f64)> = Vec::new();
    for (product, expected) in expected.products() {
        if tolerance(product).is_none() {
            continue;
        }
        let mut same = found.iter().filter(|(other, _)| *other == product);
        let count = worst.iter().filter(|(other, _)| *other == product).count();
        let (_, found) = same
            .nth(count)
            .unwrap_or_else(|| panic!("{name}: {product:?} is missing"));
        worst.push((product, product.difference(found, &expected)));
    }
    for (product, apart) in worst {
        let allowed = tolerance(product).unwrap();
        println!("{name}: {product:?} {apart:.1e} of {allowed:.0e}");
        assert!(apart <= allowed, "{name}: {product:?} is off by {apart:e}");
    }
}

/// Asserts that colours agree where they are no ordinary numbers, too: by 1e-5 of themselves, or where both are below
/// `least`.
#[track_caller]
fn assert_same_colors(name: &str, [found, expected]: [Outcome; 2], least: f32) {
    let planes = |outcome: Outcome| {
        let ColorPlanes { r, g, b } = outcome.color.unwrap();
        [r, g, b].map(Plane::into_samples).concat()
    };
    for (f, e) in planes(found).into_iter().zip(planes(expected)) {
        let same = f == e || f.is_nan() && e.is_nan() || (f - e).abs() < 1e-5 * e.abs();
        let both = f.abs().max(e.abs());
        assert!(same || both < least, "{name}: {f:e}, not {e:e}");
    }
}

/// The frame covered only where `covered` is true, and these values elsewhere.
fn covered_where(frame: &Frame, covers: Covers, poison: f32) -> Frame {
    let covered = |x, y| frame.mask.at(x, y) && covers(x, y);
    poisoned(&masked(frame.clone(), covered), poison)
}

type Covers = fn(usize, usize) -> bool;

/// Parts of a frame that may be covered.
const MASKS: [(&str, Covers); 6] = [
    ("nothing", |_, _| false),
    ("one pixel", |x, y| x == 20 && y == 9),
    ("another", |x, y| x == 30 && y == 44),
    ("speckled", |x, y| !(x * 7 + y * 13).is_multiple_of(5)),
    ("sparse", |x, y| !(x * 7 + y * 13).is_multiple_of(41)),
    ("squares", |x, y| (x / 20 + y / 20).is_multiple_of(2)),
];

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
    let [r, g, b] = [1.0, 2.0, 3.0].map(plane);
    frame.color = Some(ColorPlanes { r, g, b });
    frame
}
