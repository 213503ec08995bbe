//! Lobes, light groups and ambient occlusion: scaled one by one, on scenes made for it.

use crate::common::lobes::*;
use crate::prelude::*;
use relievo::light::radiance_scaling::scaling;
use relievo::shape::curvature::{mapped_curvature, mapped_curvature_toward};

const WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Parameters with nothing chosen from the frame.
fn fixed() -> ScalingParams {
    given(20.0, 1.5)
}

fn scaled(scaling: f32) -> ScalingParams {
    ScalingParams { scaling, ..fixed() }
}

fn plan(frame: &Frame, params: ScalingParams) -> Plan {
    let available = Available::in_frame(frame);
    Plan::new(Goal::Enhance, available, ShapeParams::default(), params).unwrap()
}

fn run(frame: &Frame, params: ScalingParams) -> Outcome {
    cpu::run(&plan(frame, params), frame).unwrap()
}

/// The enhanced picture, and the mapped curvature it was scaled by.
fn enhanced(frame: &Frame, params: ScalingParams) -> (ColorPlanes, Plane) {
    let outcome = run(frame, params);
    let gain = outcome.gain.unwrap();
    let trace = outcome.shape.trace.unwrap();
    let kappa = trace.map(|t| mapped_curvature(t, gain));
    (outcome.color.unwrap(), kappa)
}

fn bits(color: &ColorPlanes) -> Vec<u32> {
    channels(color).map(crate::common::bits).concat()
}

/// Parameters with magnitudes for ambient, diffuse and specular light, where they are given.
fn by_term(magnitudes: [Option<f32>; 3]) -> ScalingParams {
    let mut params = fixed();
    [
        params.scaling_ambient,
        params.scaling_diffuse,
        params.scaling_specular,
    ] = magnitudes;
    params
}

/// Expects a sample to be what it should be but for rounding.
#[track_caller]
fn is(found: f32, expected: f32, of: f32, what: &str) {
    near(found, expected, 2e-6 * f64::from(of.max(1.0)), what);
}

#[test]
fn a_magnitude_of_0_runs_nothing_in_every_mode() {
    let none = scaled(0.0);
    let lobes = scene();
    let mut whole = lobes.clone();
    whole.light.lobes.clear();
    let mut groups = lobes.clone();
    groups.light.groups.push(group("key", 1.0, &[Vec3::Z]));
    let mut occlusion = whole.clone();
    occlusion.light.occlusion = Some(Plane::filled(WIDTH, HEIGHT, 0.5));
    let by_term = by_term([Some(0.0); 3]);
    for frame in [&lobes, &whole, &groups, &occlusion] {
        assert!(plan(frame, none).stages().is_empty());
    }
    // By terms: the picture as a whole is not a term, and is still scaled.
    for frame in [&lobes, &groups] {
        assert!(plan(frame, by_term).stages().is_empty());
    }
    assert!(plan(&whole, by_term).runs("radiance-scaling"));
}

#[test]
fn a_lobe_without_light_changes_no_bit() {
    let mut frame = scene();
    let picture = frame.color.as_mut().unwrap();
    picture.r.samples_mut()[3] = -0.0;
    picture.g.samples_mut()[4] = -0.25;
    frame.light.lobes[1].direct = Some(color(|_, _, _| 0.0));
    let params = by_term([None, Some(0.0), None]);
    assert!(plan(&frame, params).runs("light-lobes"));
    let (made, _) = enhanced(&frame, params);
    assert_eq!(bits(&made), bits(frame.color.as_ref().unwrap()));
}

#[test]
fn each_lobe_is_scaled_by_its_own_light_and_magnitude() {
    let frame = scene();
    let picture = frame.color.as_ref().unwrap();
    for (diffuse, specular) in [(1.5, 0.0), (0.0, 0.7), (0.8, 2.0)] {
        let (made, kappa) = enhanced(&frame, by_term([None, Some(diffuse), Some(specular)]));
        let mut changed = 0;
        for (x, y) in places(WIDTH, HEIGHT) {
            let sigma = |lobe: &LobeLayers, magnitude: f32| {
                let luminance: f32 = (0..3).map(|i| WEIGHTS[i] * light(lobe, i, x, y)).sum();
                scaling(luminance / 1.5, magnitude * kappa.at(x, y), 0.25)
            };
            let [d, s] = [&frame.light.lobes[0], &frame.light.lobes[1]];
            let (sigma_d, sigma_s) = (sigma(d, diffuse), sigma(s, specular));
            for i in 0..3 {
                // out = picture + (sigma_d - 1) diffuse + (sigma_s - 1) specular; uncovered as it was.
                let (before, after) = (channels(picture)[i].at(x, y), channels(&made)[i].at(x, y));
                let [d, s] = [d, s].map(|lobe| radiance(lobe, i, x, y));
                let change = (sigma_d - 1.0) * d + (sigma_s - 1.0) * s;
                let change = if frame.mask.at(x, y) { change } else { 0.0 };
                is(after, before + change, before, "scaled");
                changed += usize::from((after - before).abs() > 0.01);
            }
        }
        assert!(changed > 300, "only {changed} samples changed");
    }
}

#[test]
fn ambient_light_has_a_magnitude_of_its_own_where_it_is_given() {
    let frame = scene();
    let params = by_term([Some(2.0), Some(0.0), Some(0.0)]);
    let (made, kappa) = enhanced(&frame, params);
    let picture = frame.color.as_ref().unwrap();
    let mut lobe = frame.light.lobes[0].clone();
    lobe.direct = None;
    for (x, y) in covered(&frame.mask) {
        let luminance: f32 = (0..3).map(|i| WEIGHTS[i] * light(&lobe, i, x, y)).sum();
        let sigma = scaling(luminance / 1.5, 2.0 * kappa.at(x, y), 0.25);
        let expected = picture.g.at(x, y) + (sigma - 1.0) * radiance(&lobe, 1, x, y);
        is(made.g.at(x, y), expected, 1.0, "ambient");
    }
    // An occlusion layer is in that light already; without it, the whole picture is scaled by it.
    let mut occluded = frame.clone();
    occluded.light.occlusion = Some(Plane::from_fn(WIDTH, HEIGHT, |x, _| 0.2 + x as f32 / 80.0));
    assert!(!plan(&occluded, params).runs("ambient-occlusion"));
    occluded.light.lobes.clear();
    let alone = ScalingParams {
        scaling: 0.0,
        ..params
    };
    let (made, kappa) = enhanced(&occluded, alone);
    for (x, y) in covered(&frame.mask) {
        let open = 0.2 + x as f32 / 80.0;
        let expected = picture.b.at(x, y) * scaling(open, 2.0 * kappa.at(x, y), 0.25);
        is(made.b.at(x, y), expected, 1.0, "occlusion");
    }
}

#[test]
fn a_picture_of_occlusion_has_a_white_of_1() {
    let mut frame = scene();
    frame.light = default_but(|light: &mut LightLayers| light.picture_is_occlusion = true);
    let auto = ScalingParams {
        white_level: Adaptive::Auto,
        ..fixed()
    };
    let outcome = run(&frame, auto);
    assert_eq!(outcome.white_level, Some(1.0));
    let ambient = ScalingParams {
        scaling: 0.0,
        scaling_ambient: Some(1.0),
        ..auto
    };
    let [ambient, own] = [run(&frame, ambient), outcome].map(|made| bits(&made.color.unwrap()));
    assert_eq!(ambient, own);
}

#[test]
fn bad_light_gives_finite_pictures() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1e30] {
        let spoiled = |planes: &ColorPlanes| {
            color(|i, x, y| match (x + y) % 4 {
                0 => bad,
                _ => channels(planes)[i].at(x, y),
            })
        };
        for layer in 0..3 {
            let mut frame = scene();
            let lobe = &mut frame.light.lobes[0];
            lobe.albedo = Some(color(|_, _, _| 0.5));
            let spoil = [&mut lobe.direct, &mut lobe.color, &mut lobe.albedo];
            for (i, planes) in spoil.into_iter().enumerate() {
                let change = |p| if i == layer { spoiled(&p) } else { p };
                *planes = planes.take().map(change);
            }
            frame.light.groups.clear();
            for white_level in [Adaptive::Auto, Adaptive::Fixed(1e-30)] {
                let params = ScalingParams {
                    white_level,
                    ..scaled(50.0)
                };
                let (made, _) = enhanced(&frame, params);
                let mut samples = channels(&made).into_iter().flat_map(|p| p.samples());
                assert!(samples.all(|s| s.is_finite()), "layer {layer} with {bad}");
            }
        }
    }
}

fn group(name: &str, strength: f32, to_light: &[Vec3]) -> LightGroup {
    LightGroup {
        name: name.into(),
        light: color(|i, x, _| strength * (0.5 + 0.1 * i as f32) * (1.0 + x as f32 / 100.0)),
        to_light: to_light.iter().map(|l| l.normalize()).collect(),
    }
}

#[test]
fn a_shadow_keeps_its_edge_where_light_groups_are_scaled() {
    let to_light = [Vec3::new(-1.0, 0.5, 1.0), Vec3::new(-0.8, 0.9, 1.0)];
    let lit = |shadow: f32| {
        let mut frame = scene();
        let mut key = group("key", 1.0, &to_light);
        let share = |x: usize| if x < WIDTH / 2 { shadow } else { 1.0 };
        key.light = color(|i, x, y| share(x) * channels(&key.light)[i].at(x, y));
        frame.color = Some(key.light.clone());
        frame.light.lobes.clear();
        frame.light.groups.push(key);
        frame
    };
    let factors = |frame: &Frame| {
        let (made, _) = enhanced(frame, fixed());
        let picture = frame.color.as_ref().unwrap();
        let ratio = |(a, b): (&f32, &f32)| a / b;
        let samples = made.g.samples().iter().zip(picture.g.samples());
        samples.map(ratio).collect::<Vec<f32>>()
    };
    let most_apart = |a: Vec<f32>, b: Vec<f32>| {
        let apart = a.iter().zip(&b).map(|(a, b)| (a / b - 1.0).abs());
        apart.fold(0.0, f32::max)
    };
    let (open, shadowed) = (lit(1.0), lit(0.15));
    let factors_open = factors(&open);
    let is_scaled = factors_open.iter().any(|f| (f - 1.0).abs() > 0.2);
    assert!(is_scaled, "nothing is scaled");
    let apart = most_apart(factors_open, factors(&shadowed));
    assert!(apart < 1e-6, "the shadow is scaled by {apart} otherwise");
    // The picture as a whole treats the shadow as dark shading.
    let whole = |mut frame: Frame| {
        frame.light.groups.clear();
        factors(&frame)
    };
    assert!(most_apart(whole(open), whole(shadowed)) > 0.1);
}

#[test]
fn what_no_group_covers_stays() {
    let mut frame = scene();
    let key = group("key", 0.3, &[Vec3::new(1.0, 0.0, 1.0)]);
    let below = [Vec3::new(0.0, -1.0, 0.2), Vec3::new(0.0, 0.0, -1.0)];
    let fill = group("fill", 0.1, &below);
    let env = color(|_, _, y| 0.05 + y as f32 / 100.0);
    frame.color = Some(color(|i, x, y| {
        let sum = [&key.light, &fill.light, &env];
        sum.map(|c| channels(c)[i].at(x, y)).iter().sum()
    }));
    frame.light.groups = vec![key, fill];
    // Groups go before lobes.
    let planned = plan(&frame, fixed());
    assert!(planned.runs("light-groups") && !planned.runs("light-lobes"));
    let (made, kappa) = enhanced(&frame, fixed());
    for (x, y) in covered(&frame.mask) {
        let n = normal_at(&frame, x, y);
        let scaled = |group: &LightGroup| {
            let cosines = group.to_light.iter().map(|l| l.dot(n).max(0.0));
            let sum: f32 = cosines.clone().sum();
            let scaled = cosines.map(|d| d * scaling(d, kappa.at(x, y), 0.25));
            let scaled: f32 = scaled.sum();
            let sigma = if sum > 0.0 { scaled / sum } else { 1.0 };
            sigma * group.light.r.at(x, y)
        };
        let expected: f32 = frame.light.groups.iter().map(scaled).sum::<f32>() + env.r.at(x, y);
        is(made.r.at(x, y), expected, 1.0, "groups");
    }
}

#[test]
fn anisotropy_takes_the_curvature_along_the_light() {
    let mut frame = scene();
    let to_light = Vec3::new(1.0, 0.3, 0.8).normalize();
    frame.light.groups = vec![group("key", 0.3, &[to_light])];
    let params = ScalingParams {
        anisotropy: 0.8,
        ..fixed()
    };
    let planned = plan(&frame, params);
    assert!(planned.runs("hessian") && !planned.runs("curvatures"));
    // Without it the trace is enough.
    assert!(!plan(&frame, fixed()).runs("hessian"));
    let outcome = run(&frame, params);
    let (made, hessian) = (outcome.color.unwrap(), outcome.shape.hessian.unwrap());
    let mut differ = 0;
    for (x, y) in covered(&frame.mask) {
        let h = [&hessian.xx, &hessian.xy, &hessian.yy].map(|p| p.at(x, y));
        let d = to_light.dot(normal_at(&frame, x, y)).max(0.0);
        let kappa = mapped_curvature_toward(h, [to_light.x, to_light.y], 20.0, 0.8);
        let light = frame.light.groups[0].light.r.at(x, y);
        let before = frame.color.as_ref().unwrap().r.at(x, y);
        // The group holds more light than this picture has: it gets the picture's share.
        let share = (before / light).min(1.0);
        let expected = before + share * (scaling(d, kappa, 0.25) - 1.0) * light;
        is(made.r.at(x, y), expected, 1.0, "along the light");
        differ += usize::from((kappa - mapped_curvature(h[0] + h[2], 20.0)).abs() > 0.05);
    }
    assert!(differ > 100, "it matters at {differ} pixels only");
}

#[test]
fn a_mirrored_frame_gives_the_mirrored_picture() {
    let frame = scene();
    let (made, _) = enhanced(&frame, fixed());
    let (mirrored, _) = enhanced(&crate::common::mirrored(&frame), fixed());
    for (x, y) in places(WIDTH, HEIGHT) {
        let found = mirrored.g.at(WIDTH - 1 - x, y);
        is(found, made.g.at(x, y), 1.0, "mirrored");
    }
}
