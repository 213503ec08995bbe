//! The list of cases: everything that could break shape analysis, followed by those of light and drawings.

use super::case::{case, cases};
use super::frames::{
    ball, cylinder, random, through_a_file, with_conductance, with_depth, with_normals,
};
use super::{Case, Expected, judged};
use crate::frame::{Frame, Plane};
use crate::params::{Scale, ShapeParams, Solver};
use crate::report::scenes::frames::{gentle, masked, noise, relief, rough};
use glam::Vec3;

use Expected::{Bounded, Refused, Warned};

/// All cases, in the order of the report.
pub(crate) fn all() -> Vec<Case> {
    let groups = [
        normal_cases(),
        depth_cases(),
        conductance_cases(),
        size_cases(),
        time_cases(),
        rim_cases(),
        super::light_cases::all(),
        super::drawing_cases::all(),
    ];
    groups.into_iter().flatten().collect()
}

/// A frame passed directly to the backend.
fn straight(
    name: &'static str,
    done: &'static str,
    shape: ShapeParams,
    frame: impl Fn() -> Frame + 'static,
) -> Case {
    case(name, done, Bounded, move || judged(&frame(), shape, &[]))
}

/// Normals and depth through an EXR file, like a renderer's.
fn from_file(
    name: &'static str,
    done: &'static str,
    expected: Expected,
    frame: impl Fn() -> Frame + 'static,
) -> Case {
    case(name, done, expected, move || {
        let loaded = through_a_file(&frame())?;
        judged(&loaded.frame, steep(), &loaded.warnings)
    })
}

/// The viewer's height field, the most fragile setting.
fn steep() -> ShapeParams {
    ShapeParams {
        foreshortening: 1.0,
        ..ShapeParams::default()
    }
}

fn scaled(scale: Scale) -> ShapeParams {
    ShapeParams { scale, ..steep() }
}

fn of_time(time: f32) -> ShapeParams {
    scaled(Scale::Sigma((2.0 * time).sqrt()))
}

/// Every seventh pixel's normal is replaced.
fn some(bad: Vec3) -> impl Fn() -> Frame {
    move || {
        with_normals(|x, y| {
            if (x + 3 * y) % 7 == 0 {
                bad
            } else {
                gentle(x, y)
            }
        })
    }
}

fn normal_cases() -> Vec<Case> {
    let every =
        |scale: fn(usize, usize) -> f32| move || with_normals(|x, y| scale(x, y) * gentle(x, y));
    cases! {
        from_file("n_z = 0", "normals across the line of sight, every seventh", Bounded,
            some(Vec3::new(0.6, 0.8, 0.0)));
        from_file("n_z < 0", "normals away from the viewer, every seventh", Bounded,
            some(Vec3::new(0.6, 0.0, -0.8)));
        straight("normals all ways", "random unit normals, the far side too", steep(), random(29, 23));
        from_file("normals of length 0", "every seventh: left out of the mask", Bounded, some(Vec3::ZERO));
        from_file("NaN normals", "every seventh: left out of the mask", Bounded, some(Vec3::NAN));
        from_file("infinite normals", "every seventh: left out of the mask", Bounded,
            some(Vec3::new(f32::INFINITY, 0.0, 1.0)));
        from_file("no normal at all", "every one NaN", Warned, || with_normals(|_, _| Vec3::NAN));
        from_file("lengths of .98 to 1.02", "as half floats and filters leave them", Bounded,
            every(|x, y| 0.98 + 0.04 * noise(x, y, 1)));
        straight("the same, not renormalised", "straight into the kernels", steep(),
            every(|x, y| 0.98 + 0.04 * noise(x, y, 1)));
        from_file("8-bit normals", "rounded to 2/255", Bounded,
            || with_normals(|x, y| (gentle(x, y) * 127.5 + 127.5).round() / 127.5 - 1.0));
        straight("planar everywhere", "one normal: no curvature", steep(),
            || with_normals(|_, _| Vec3::new(0.6, 0.0, 0.8)));
        straight("umbilic everywhere", "a ball: no direction", ShapeParams::default(), || ball(0.05));
        straight("parabolic everywhere", "a tilted cylinder", steep(), cylinder);
    }
}

fn depth_cases() -> Vec<Case> {
    let constant = |depth: f32| move || with_depth(move |_, _| depth);
    let half = |depth: f32| {
        move || with_depth(move |x, y| if x < 14 { depth } else { 5.0 + 0.01 * y as f32 })
    };
    cases! {
        from_file("constant depth", "7 everywhere", Bounded, constant(7.0));
        from_file("depth inf", "on the left half: background", Bounded, half(f32::INFINITY));
        from_file("depth NaN", "on the left half: background", Bounded, half(f32::NAN));
        from_file("depth 1e10", "on the left half: background", Bounded, half(1e10));
        from_file("depth 65504", "on the left half: background", Bounded, half(65504.0));
        from_file("depth 0", "on the left half: background", Bounded, half(0.0));
        from_file("negative depth", "on the left half: background", Bounded, half(-5.0));
        from_file("background everywhere", "depth 1e10 in every pixel", Warned, constant(1e10));
        from_file("depth 1e-6 to 1e6", "both in one frame, side by side", Warned,
            || with_depth(|x, y| 10.0_f32.powf(12.0 * noise(x, y, 2) - 6.0)));
    }
}

fn conductance_cases() -> Vec<Case> {
    let wide = of_time(200.0);
    let diamond = || {
        let inside = |x: usize, y: usize| x.abs_diff(14) + y.abs_diff(11) < 9;
        masked(
            with_normals(|x, y| if inside(x, y) { rough(x, y) } else { Vec3::NAN }),
            inside,
        )
    };
    cases! {
        straight("conductance 1 to 0", "in one pixel, t = 200", wide, || with_conductance(|x, _| x < 14));
        straight("checkerboard conductance", "1 and 0 in turn, t = 200", wide,
            || with_conductance(|x, y| (x + y) % 2 == 0));
        straight("a closed ring", "conductance 0 around open pixels, t = 200", wide,
            || with_conductance(|x, y| x.abs_diff(14).max(y.abs_diff(11)) != 6));
        straight("everything an edge", "no conductance at all", wide, || with_conductance(|_, _| false));
        straight("NaN beside an edge", "normals outside the mask NaN, 200 steps", scaled(Scale::Iterations(200)),
            diamond);
    }
}

fn size_cases() -> Vec<Case> {
    cases! {
        straight("empty mask", "no pixel covered", steep(), || masked(relief(29, 23), |_, _| false));
        straight("one-pixel mask", "one pixel covered", steep(),
            || masked(relief(29, 23), |x, y| (x, y) == (14, 11)));
        straight("checkerboard mask", "every other pixel covered", steep(),
            || masked(relief(29, 23), |x, y| (x + y) % 2 == 0));
        straight("1x1", "one pixel in all", steep(), random(1, 1));
        straight("1xN", "a column of 37 pixels", steep(), random(1, 37));
        straight("Nx1", "a row of 37 pixels", steep(), random(37, 1));
        straight("2x2", "four pixels", steep(), random(2, 2));
        straight("65535x3", "as wide as frames come", steep(), random(65535, 3));
        straight("3x65535", "as tall as frames come", steep(), random(3, 65535));
    }
}

fn time_cases() -> Vec<Case> {
    let explicit = |time_step: f32, count: u32| ShapeParams {
        solver: Solver::Explicit,
        scale: Scale::Iterations(count),
        time_step,
        ..ShapeParams::default()
    };
    let tolerant = |tolerance| ShapeParams {
        tolerance,
        ..of_time(50.0)
    };
    let refused = |name, done, shape: ShapeParams| {
        case(name, done, Refused, move || {
            judged(&relief(29, 23), shape, &[])
        })
    };
    cases! {
        straight("t = 0", "sigma 0 px", of_time(0.0), random(29, 23));
        straight("t = 1e5", "sigma 447 px on 29x23", of_time(1e5), random(29, 23));
        straight("t = 1e4 explicit", "50,000 steps of 0.2 on 7x5",
            ShapeParams { solver: Solver::Explicit, ..scaled(Scale::Iterations(50_000)) }, random(7, 5));
        straight("the largest sigma", "4096 px", scaled(Scale::Sigma(4096.0)), random(7, 5));
        straight("huge N", "ten million steps, by expansion", scaled(Scale::Iterations(10_000_000)), random(7, 5));
        straight("dt at the limit", "a checkerboard, 60 explicit steps of 0.25: it turns round and hardly decays",
            explicit(0.25, 60), checkerboard);
        refused("dt above the limit", "a checkerboard would grow a hundredfold in 60 steps of 0.26",
            explicit(0.26, 60));
        refused("dt just above it", "0.25 and one bit", explicit(0.25_f32.next_up(), 60));
        refused("t = 1e5 explicit", "500,000 steps: more than anybody waits for", explicit(0.2, 500_000));
        refused("dt 1", "explicit steps of 1", explicit(1.0, 1));
        refused("dt NaN", "explicit steps of NaN", explicit(f32::NAN, 1));
        refused("dt 0", "explicit steps of 0", explicit(0.0, 1));
        refused("sigma past 4096 px", "5000 px", scaled(Scale::Sigma(5000.0)));
        refused("negative sigma", "-1 px", scaled(Scale::Sigma(-1.0)));
        straight("tolerance 1e-9", "beyond single precision: rounding is what stays", tolerant(1e-9),
            random(29, 23));
        straight("tolerance 1", "hardly an expansion at all", tolerant(1.0), random(29, 23));
        refused("tolerance 0", "no degree would do", tolerant(0.0));
        refused("tolerance NaN", "neither would this", tolerant(f32::NAN));
    }
}

/// The stiffest possible field: slopes that reverse from pixel to pixel.
fn checkerboard() -> Frame {
    // 23 degrees from pixel to pixel: not a crease.
    let frame = with_normals(|x, y| {
        let side = if (x + y) % 2 == 0 { 0.2 } else { -0.2 };
        Vec3::new(side, 0.0, 0.96_f32.sqrt())
    });
    Frame {
        depth: Some(Plane::filled(29, 23, 5.0)),
        ..frame
    }
}

fn rim_cases() -> Vec<Case> {
    let of = |foreshortening: f32, min_nz: f32| ShapeParams {
        foreshortening,
        min_nz,
        ..of_time(5.0)
    };
    let grazing = || with_normals(|x, y| Vec3::new(1.0, 0.0, 1e-30 * (x + y) as f32));
    cases! {
        straight("f = 0, min_nz 1e-3", "random normals", of(0.0, 1e-3), random(29, 23));
        straight("f = 0, min_nz 1", "random normals", of(0.0, 1.0), random(29, 23));
        straight("f = 1, min_nz 1e-3", "slopes up to 1000", of(1.0, 1e-3), random(29, 23));
        straight("f = 1, min_nz 1", "the floor above every normal", of(1.0, 1.0), random(29, 23));
        straight("f = 4, min_nz 1e-3", "slopes up to 1e12", of(4.0, 1e-3), random(29, 23));
        straight("f = 4, min_nz 1", "the floor above every normal", of(4.0, 1.0), random(29, 23));
        straight("grazing everywhere", "n_z of 1e-30, f = 4, min_nz 1e-3", of(4.0, 1e-3), grazing);
        case("f = 5", "past the range", Refused, move || judged(&relief(5, 5), of(5.0, 0.05), &[]));
        case("min_nz 0", "no floor: slopes without end", Refused, move || judged(&relief(5, 5), of(1.0, 0.0), &[]));
    }
}
