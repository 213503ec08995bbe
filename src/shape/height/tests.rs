use super::*;
use std::f64::consts::TAU;

/// Slopes of the height `f`, by central differences of 1e-4 pixels in double precision.
fn slopes_of(size: [usize; 2], f: impl Fn(f64, f64) -> f64) -> HeightSlopes {
    const H: f64 = 1e-4;
    let [width, height] = size;
    HeightSlopes {
        x: Plane::from_fn(width, height, |x, y| {
            let (x, y) = (x as f64, y as f64);
            ((f(x + H, y) - f(x - H, y)) / (2.0 * H)) as f32
        }),
        y: Plane::from_fn(width, height, |x, y| {
            let (x, y) = (x as f64, y as f64);
            ((f(x, y + H) - f(x, y - H)) / (2.0 * H)) as f32
        }),
    }
}

/// A height.
type Surface = fn(f64, f64) -> f64;

/// Some pixels.
type Part = fn(usize, usize) -> bool;

struct Case {
    slopes: HeightSlopes,
    conductance: Plane,
    mask: Mask,
    wraps: [bool; 2],
}

impl Case {
    fn open(size: [usize; 2], wraps: [bool; 2], f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            slopes: slopes_of(size, f),
            conductance: Plane::filled(size[0], size[1], 1.0),
            mask: Mask::full(size[0], size[1]),
            wraps,
        }
    }

    fn solved(&self) -> (Plane, usize) {
        solve(&Problem {
            slopes: &self.slopes,
            conductance: &self.conductance,
            mask: &self.mask,
            wraps: self.wraps,
            near: None,
            tolerance: 1e-5,
        })
    }
}

/// Largest error of `found` against `f` over the mask, both with mean 0, in relation to the range of `f`.
fn error_of(found: &Plane, mask: &Mask, f: impl Fn(f64, f64) -> f64) -> f64 {
    let pixels = (0..mask.height()).flat_map(|y| mask.runs(y).flatten().map(move |x| (x, y)));
    let pixels: Vec<_> = pixels.collect();
    let mean = |of: &dyn Fn(usize, usize) -> f64| {
        pixels.iter().map(|&(x, y)| of(x, y)).sum::<f64>() / pixels.len() as f64
    };
    let exact = |x: usize, y: usize| f(x as f64, y as f64);
    let own = |x: usize, y: usize| f64::from(found.at(x, y));
    let (mean_exact, mean_own) = (mean(&exact), mean(&own));
    let values = pixels.iter().map(|&(x, y)| exact(x, y));
    let range = values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min);
    let errors = pixels
        .iter()
        .map(|&(x, y)| (own(x, y) - mean_own - exact(x, y) + mean_exact).abs());
    errors.fold(0.0, f64::max) / range
}

/// Halving the pixel quarters the error; at 200 pixels it is below a thousandth of the height. A unit of `shape` has n
/// pixels, the picture `size(n)`.
fn is_second_order(
    name: &str,
    wraps: [bool; 2],
    size: impl Fn(f64) -> [usize; 2],
    shape: impl Fn(f64, f64) -> f64,
) {
    let errors = [25.0, 50.0, 100.0, 200.0].map(|n| {
        let height = |x: f64, y: f64| n * shape(x / n, y / n);
        let case = Case::open(size(n), wraps, height);
        error_of(&case.solved().0, &case.mask, height)
    });
    assert!(errors[3] < 1e-3, "{name} {errors:?}");
    let order = (errors[0] / errors[2].max(1e-5)).log2() / 2.0;
    assert!(order > 1.7 || errors[0] < 1e-4, "{name} {order} {errors:?}");
}

/// Waves that continue each other across the borders that wrap, on a slope across those that do not.
#[test]
fn borders_of_a_tile_are_second_order() {
    for wraps in [[true; 2], [true, false], [false, true]] {
        let [slope_x, slope_y] = wraps.map(|wraps| if wraps { 0.0 } else { 0.3 });
        let waves = |x: f64, y: f64| {
            let (u, v) = (TAU * x, TAU * y / 0.6);
            let waves = 0.1 * u.sin() * (v + 1.0).cos() + 0.05 * (2.0 * u - v).cos();
            waves + slope_x * x + slope_y * y
        };
        let size = |n: f64| [n, 0.6 * n].map(|length| length.round() as usize);
        is_second_order(&format!("{wraps:?}"), wraps, size, waves);
    }
}

#[test]
fn open_borders_are_second_order() {
    let shapes: [(&str, Surface); 3] = [
        ("cap", |x, y| {
            (1.6 - (x - 0.5).powi(2) - (y - 0.4).powi(2)).sqrt()
        }),
        ("waves", |x, y| {
            0.1 * (7.0 * x).sin() * (5.0 * y + 1.0).cos()
        }),
        ("saddle", |x, y| x * x - 0.7 * y * y + 0.2 * x),
    ];
    for (name, shape) in shapes {
        let size = |n: f64| [n as usize, (0.8 * n) as usize + 1];
        is_second_order(name, [false; 2], size, shape);
    }
}

/// A cone bends sharply in a point, a roof in a line: exact where the ridge lies between two columns. Elsewhere samples
/// do not tell where within a pixel it lies: there the height is off by up to half a pixel times the change of slope.
#[test]
fn cones_and_roofs_keep_their_height() {
    let cone = |x: f64, y: f64| -0.8 * (x - 210.3).hypot(y - 209.8);
    let between = |x: f64, _: f64| -0.9 * (x - 30.5).abs();
    let cone: (Surface, _, _) = (cone, [420, 421], 1e-3);
    for (shape, size, tolerance) in [cone, (between, [64, 40], 1e-5)] {
        let case = Case::open(size, [false; 2], shape);
        let error = error_of(&case.solved().0, &case.mask, shape);
        assert!(error < tolerance, "{size:?} {error:e}");
    }
}

/// Islands, a hole, walls with a gap and a closed one: nothing leaks, and each surface has its own mean.
#[test]
fn masks_and_edges_part_surfaces() {
    let shape = |x: f64, y: f64| 8.0 * (x / 15.0).sin() + 0.03 * y * y / 10.0;
    let mut case = Case::open([120, 100], [false; 2], shape);
    let ring = |x: usize, y: usize| (x as f64 - 85.0).hypot(y as f64 - 40.0);
    case.mask = Mask::new(Plane::from_fn(120, 100, |x, y| {
        x < 50 && !(20..30).contains(&y) || ring(x, y) < 30.0 && ring(x, y) > 12.0
    }));
    // Left of column 25 the surface stands 40 pixels higher: a step, closed by its edge.
    case.conductance = Plane::from_fn(120, 100, |x, y| match (x, y) {
        (24 | 25, 30..) => 0.0,
        _ => 1.0,
    });
    let (found, rounds) = case.solved();
    let parts: [(&str, Part); 4] = [
        ("above", |x, y| x < 50 && y < 20),
        ("left", |x, y| x < 24 && y >= 30),
        ("right", |x, y| (26..50).contains(&x) && y >= 30),
        ("ring", |x, _| x > 52),
    ];
    for (name, part) in parts {
        let mask = Mask::new(Plane::from_fn(120, 100, |x, y| {
            part(x, y) && case.mask.at(x, y)
        }));
        let error = error_of(&found, &mask, shape);
        assert!(error < 1e-3, "{name}: {error:e}");
        let pixels = (0..100).flat_map(|y| mask.runs(y).flatten().map(move |x| (x, y)));
        let sum: f64 = pixels.map(|(x, y)| f64::from(found.at(x, y))).sum();
        assert!((sum / mask.count() as f64).abs() < 1e-3, "{name}");
    }
    assert!(rounds < 40, "{rounds}");
}

/// Of slopes that no surface has the nearest surface is found, and what is missed is the part that turns.
#[test]
fn what_no_surface_has_is_left() {
    // A whirl beside a plane: its divergence is 0, so nothing of it is kept.
    let (width, height) = (64, 64);
    let whirl = |x: usize, y: usize| {
        let [u, v] = [x, y].map(|i| TAU * i as f64 / 64.0);
        [0.3 * u.sin() * v.cos(), -0.3 * u.cos() * v.sin()]
    };
    let slopes = HeightSlopes {
        x: Plane::from_fn(width, height, |x, y| whirl(x, y)[0] as f32),
        y: Plane::from_fn(width, height, |x, y| whirl(x, y)[1] as f32),
    };
    let (conductance, mask) = (Plane::filled(width, height, 1.0), Mask::full(width, height));
    let problem = Problem {
        slopes: &slopes,
        conductance: &conductance,
        mask: &mask,
        wraps: [true; 2],
        near: None,
        tolerance: 1e-5,
    };
    let (height, _) = solve(&problem);
    let largest = height.samples().iter().fold(0.0_f32, |m, z| m.max(z.abs()));
    assert!(largest < 1e-5, "{largest}");
    let missed = residual(&problem, &height);
    for (x, y) in [(16, 0), (0, 16), (10, 23)] {
        let [p, q] = whirl(x, y);
        let expected = p.hypot(q) as f32;
        assert!(
            (missed.at(x, y) - expected).abs() < 0.01,
            "{x} {y} {}",
            missed.at(x, y)
        );
    }
}

#[test]
fn ordinary_and_extreme_inputs_end() {
    let of = |size: [usize; 2], wraps, slope: f32, mask: fn(usize, usize) -> bool| {
        let slopes = || {
            Plane::from_fn(size[0], size[1], |x, y| {
                slope * if (x * 7 + y * 13) % 5 < 2 { 1.0 } else { -1.0 }
            })
        };
        let mask = Mask::new(Plane::from_fn(size[0], size[1], mask));
        let conductance = mask.plane().map(|covered| if covered { 1.0 } else { 0.0 });
        let slopes = HeightSlopes {
            x: slopes(),
            y: slopes(),
        };
        let case = Case {
            slopes,
            conductance,
            mask,
            wraps,
        };
        case.solved()
    };
    for wraps in [[false; 2], [true; 2], [true, false]] {
        for size in [[1, 1], [1, 9], [9, 1], [2, 2], [5, 3], [33, 17]] {
            for slope in [0.0, 0.3, 20.0] {
                let full = of(size, wraps, slope, |_, _| true);
                assert!(
                    full.0.samples().iter().all(|z| z.is_finite()),
                    "{size:?} {wraps:?}"
                );
                let none = of(size, wraps, slope, |_, _| false);
                assert!(none.0.samples().iter().all(|&z| z == 0.0));
                let chess = of(size, wraps, slope, |x, y| (x + y) % 2 == 0);
                assert!(chess.0.samples().iter().all(|z| z.is_finite()));
                let holes = of(size, wraps, slope, |x, y| (x * 5 + y * 3) % 7 > 0);
                assert!(holes.1 < 60, "{}", holes.1);
            }
        }
    }
}

/// Depth with a wave of noise, 4 pixels long, over a bowl; normals of the bowl with a bias in slope: the sum of both has
/// neither.
#[test]
fn depth_gives_the_shape_and_normals_the_detail() {
    let bowl = |x: f64, y: f64| 0.01 * ((x - 64.0).powi(2) + (y - 60.0).powi(2));
    let mut case = Case::open([128, 120], [false; 2], bowl);
    case.slopes.x = case.slopes.x.map(|slope| slope + 0.05);
    let depth = Plane::from_fn(128, 120, |x, y| {
        let noise = 0.3 * (TAU * x as f64 / 4.0).sin();
        (1000.0 + bowl(x as f64, y as f64) + noise) as f32
    });
    let (solved, _) = solve(&Problem {
        slopes: &case.slopes,
        conductance: &case.conductance,
        mask: &case.mask,
        wraps: case.wraps,
        near: Some((&depth, 4.0)),
        tolerance: 1e-5,
    });
    let (mut bias, mut rough) = (0.0_f64, 0.0_f64);
    for x in 32..96 {
        let off = |x: usize| f64::from(solved.at(x, 60)) - 1000.0 - bowl(x as f64, 60.0);
        bias += off(x) / 64.0;
        rough = rough.max((off(x) - 0.5 * (off(x - 2) + off(x + 2))).abs());
    }
    // A wave of 4 pixels is held back by 1 / (1 + 4^2 (2 - 2 cos(TAU / 4))) = 1/33; twice that is left of 0.3 beside it.
    assert!(bias.abs() < 0.01 && rough < 0.025, "{bias} {rough}");
}
