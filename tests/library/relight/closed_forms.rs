//! Scenes whose light is known: furnaces, planes, mirrors, spheres, environments of one direction.

use super::{Asked, covered, lights, sky, surroundings, torus, torus_in_perspective};
use crate::prelude::*;
use relievo::light::light_samples::light_disc;
use relievo::light::lit_sphere::LitSphere;

fn constant() -> Environment {
    Environment::from_fn(64, 32, |_, _| [0.7, 0.7, 0.7])
}

fn largest_error(
    color: &ColorPlanes,
    frame: &Frame,
    expected: impl Fn(usize, usize) -> f64,
) -> f64 {
    let error = |(x, y)| (f64::from(color.r.at(x, y)) - expected(x, y)).abs();
    largest(covered(&frame.mask).map(error))
}

#[test]
fn a_furnace_shows_itself() {
    // Constant radiance L: a white diffuse surface, a mirror and glass all show L; Phong's lobe of exponent
    // 32, 1 at its brightest, adds the integral of cos^32 / pi over a hemisphere: 2/33 of it.
    let frame = torus_in_perspective();
    let cases = [
        (Material::Lambert, 0.7),
        (Material::Mirror, 0.7),
        (Material::Glass, 0.7),
        (Material::Phong, 0.7 * (1.0 + 2.0 / 33.0)),
    ];
    for (material, expected) in cases {
        let asked = Asked::of(material, Method::Plain);
        let asked = asked.in_environment(constant(), SampleCount::Fixed(0));
        let error = largest_error(&asked.color(&frame), &frame, |_, _| expected);
        assert!(error < 2e-6, "{material:?}: {error:.1e}");
    }
    let thin = Asked::of(Material::Glass, Method::Plain);
    let mut thin = thin.in_environment(constant(), SampleCount::Auto);
    thin.relight.material.thin = true;
    let error = largest_error(&thin.color(&frame), &frame, |_, _| 0.7);
    assert!(error < 2e-6, "thin glass: {error:.1e}");
}

#[test]
fn light_without_bounds_is_warped_alike_from_both_sides() {
    // Equation 1 looks the environment up at W(l) for even directions l; equation 2 uses lights l' and the Jacobian of
    // W^-1. Both are sums for one integral: they converge as N grows.
    let frame = torus();
    let made = |warp_by, samples| {
        let asked = Asked::of(Material::Lambert, Method::Warp);
        let mut asked = asked.in_environment(sky(), SampleCount::Fixed(samples));
        asked.relight.warp_by = warp_by;
        asked.color(&frame)
    };
    let plain = Asked::of(Material::Lambert, Method::Plain);
    let plain = plain
        .in_environment(sky(), SampleCount::Fixed(4096))
        .color(&frame);
    let mean_difference = |a: &ColorPlanes, b: &ColorPlanes| {
        let apart = |(x, y)| f64::from((a.r.at(x, y) - b.r.at(x, y)).abs());
        covered(&frame.mask).map(apart).sum::<f64>() / frame.mask.count() as f64
    };
    let differences = [64, 512, 4096].map(|samples| {
        let both = [WarpBy::Lookups, WarpBy::Lights].map(|by| made(by, samples));
        mean_difference(&both[0], &both[1])
    });
    let effect = mean_difference(&made(WarpBy::Lights, 4096), &plain);
    // Both keep to the hemisphere of the normal by a hard edge, so the order is 1/2 to 1 in N.
    assert!(differences[1] < 0.5 * differences[0] && differences[2] < 0.5 * differences[1]);
    assert!(differences[2] < 0.1 * effect, "{differences:?} {effect}");
}

#[test]
fn prefiltered_light_is_what_many_lights_make() {
    let frame = torus();
    let [prefiltered, sampled] = [0, 16_384].map(|samples| {
        let asked = Asked::of(Material::Lambert, Method::Plain);
        asked
            .in_environment(sky(), SampleCount::Fixed(samples))
            .color(&frame)
    });
    let error = largest_error(&prefiltered, &frame, |x, y| sampled.r.at(x, y).into());
    let most = largest(covered(&frame.mask).map(|(x, y)| sampled.r.at(x, y).into()));
    assert!(error < 0.01 * most, "{error} of {most}");
}

#[test]
fn a_plane_shows_the_sine_of_the_elevation() {
    let plane = ExactScene::orthographic(Surface::plane(DVec3::Z), 16.0, 16.0);
    let frame = plane.frame(32, 32);
    for elevation in [5.0_f32, 30.0, 90.0] {
        let mut asked = Asked::of(Material::Lambert, Method::Both);
        asked.light = lights(&[direction_of(217.0, elevation)]);
        let expected = f64::from(elevation.to_radians().sin());
        // A plane has no curvature: no method changes it.
        assert!(largest_error(&asked.color(&frame), &frame, |_, _| expected) < 1e-6);
    }
}

#[test]
fn azimuth_runs_against_the_clock_from_the_right() {
    for (azimuth, expected) in [(0.0, Vec3::X), (90.0, Vec3::Y), (180.0, Vec3::NEG_X)] {
        assert!(direction_of(azimuth, 0.0).distance(expected) < 1e-6);
    }
    assert!(direction_of(30.0, 90.0).distance(Vec3::Z) < 1e-6);
}

#[test]
fn a_mirror_shows_the_environment_where_the_view_is_thrown() {
    let frame = torus_in_perspective();
    let environment = sky();
    let asked = Asked::of(Material::Mirror, Method::Plain).in_environment(sky(), SampleCount::Auto);
    let color = asked.color(&frame);
    let projection = frame.camera.unwrap().projection;
    let error = largest_error(&color, &frame, |x, y| {
        let n = frame.normal.at(x, y);
        let eye = projection.to_eye(x as f64 + 0.5, y as f64 + 0.5);
        let eye = eye.extend(1.0).normalize();
        let r = 2.0 * n.dot(eye) * n - eye;
        environment.radiance(r.as_vec3().to_array())[0].into()
    });
    assert!(error < 1e-4, "{error:.1e}");
}

/// Mirrors compare what they show with its median. Of parallel sight lines a mirror ball throws an equal share in every
/// direction, and heights on a sphere are even: half of the pixels show less than 2 of light of 2 + 1.8 y, whatever its
/// sun. A ball of radius r is convex by a trace of -2 / r, which a gain of r / 2 maps to tanh 1 = 0.7616. So the median
/// itself has intensity 1/2, of which the scaling at 1/4 makes `(e^-k + 3) / (1 + 3 e^-k)` = 3.4669 / 2.4007 = 1.4441,
/// and light of a third of it has intensity 1/4 and stays. Compared with the sun, all of it would darken by e^-k.
#[test]
fn a_mirror_ball_is_brighter_where_it_shows_more_than_a_third_of_the_median() {
    let sky = |sun: f32| {
        let sky = surroundings(512, |[_, y, _]| [2.0 + 1.8 * y; 3]);
        let sunny = |x, y| match (x, y) {
            (100, 100) => [sun; 3],
            _ => sky.pixel(x, y),
        };
        Environment::from_fn(512, 256, sunny)
    };
    let ball = ExactScene::orthographic(Surface::ball(40.0), 48.0, 48.0);
    let frame = ball.frame(96, 96);
    let shown = |environment: Environment| {
        let asked = Asked::of(Material::Mirror, Method::Scale);
        let mut asked = asked.in_environment(environment, SampleCount::Auto);
        asked.scaling.curvature_gain = Adaptive::Fixed(20.0);
        asked.color(&frame)
    };
    let (calm, sunny) = (shown(sky(2.0)), shown(sky(1e6)));
    let (mut checked, kappa) = (0, 1.0_f64.tanh());
    for (x, y) in covered(&frame.mask) {
        let (nx, ny) = ((x as f64 - 47.5) / 40.0, (47.5 - y as f64) / 40.0);
        // Away from the rim, which diffusion leaves as it is.
        if nx.hypot(ny) > 0.8 {
            continue;
        }
        let nz = (1.0 - nx * nx - ny * ny).sqrt();
        let light = 2.0 + 1.8 * 2.0 * nz * ny;
        let intensity = light / (light + 2.0);
        let (low, high, e) = (0.25 * (1.0 - intensity), 0.75 * intensity, (-kappa).exp());
        let expected = light * (e * low + high) / (low + e * high);
        let found = f64::from(calm.r.at(x, y));
        near(found, expected, 0.01 * expected, format_args!("{x}, {y}"));
        // The sun shows in the few pixels that look at its texel, and changes no other by a grey level.
        let moved = f64::from(sunny.r.at(x, y)) / found - 1.0;
        let is_kept = moved.abs() < 1.0 / 255.0;
        checked += usize::from(is_kept);
        assert!(is_kept || moved > 10.0, "{x}, {y}: {moved}");
    }
    assert!(checked > 3_000, "{checked}");
}

#[test]
fn a_sphere_lit_by_a_light_shows_what_the_light_does() {
    // A picture of a white ball under light from (-0.6, 0.6, 0.53), 400 px wide.
    let l = Vec3::new(-0.6, 0.6, 0.53).normalize();
    let ball = Plane::from_fn(400, 400, |x, y| {
        let [x, y] = [x, y].map(|at| (at as f32 + 0.5) / 200.0 - 1.0);
        let y = -y;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        Vec3::new(x, y, z).normalize().dot(l).max(0.0)
    });
    let sphere = LitSphere::new(ColorPlanes::grey(ball));
    let frame = torus();
    let by_light = Asked::of(Material::Lambert, Method::Plain).color(&frame);
    let mut asked = Asked::of(Material::Lambert, Method::Plain);
    asked.light = Illumination::default();
    asked.light.lit_spheres.push(sphere.clone());
    let by_sphere = asked.color(&frame);
    // Beside the rim the ball turns quickly from pixel to pixel.
    for (x, y) in covered(&frame.mask).filter(|&(x, y)| frame.normal.z.at(x, y) > 0.3) {
        let [by_light, by_sphere] = [&by_light, &by_sphere].map(|color| color.r.at(x, y));
        near(by_sphere, by_light, 0.02, format_args!("{x}, {y}"));
    }
    // Two equal spheres are one.
    asked.light.lit_spheres = vec![sphere.clone(), sphere];
    assert_eq!(asked.color(&frame).r, by_sphere.r);
}

#[test]
fn an_area_light_far_smaller_than_the_lobes_is_one_light() {
    let frame = torus();
    let center = Vec3::new(-0.6, 0.6, 0.53).normalize();
    let one = Asked::of(Material::Phong, Method::Both);
    let mut area = one.clone();
    area.light = lights(&light_disc(center, 0.5_f32.to_radians(), 16));
    for light in &mut area.light.directional {
        light.intensity = [1.0 / 16.0; 3];
    }
    let (one, area) = (one.color(&frame), area.color(&frame));
    let error = largest_error(&area, &frame, |x, y| one.r.at(x, y).into());
    // The terminator is half a degree wide now: 0.9 % of a cosine.
    assert!(error < 0.02 && error > 0.0, "{error}");
}

#[test]
fn an_estimated_albedo_is_flat_where_the_picture_was_shaded_flat() {
    // The scene's picture: grey 0.5 under some ambient and one light.
    let frame = torus();
    let shade = |x: usize, y: usize| {
        let n = &frame.normal;
        0.3 + 0.1 * n.x.at(x, y) + 0.2 * n.y.at(x, y) + 0.2 * n.z.at(x, y)
    };
    // Two stripes of paint, 0.8 and 0.4.
    let paint = |x: usize| if (x / 8).is_multiple_of(2) { 0.8 } else { 0.4 };
    let plane = Plane::from_fn(97, 94, |x, y| paint(x) * shade(x, y));
    let painted = Frame {
        color: Some(ColorPlanes::grey(plane)),
        ..frame.clone()
    };
    let mut asked = Asked::of(Material::Lambert, Method::Plain);
    asked.relight.albedo = AlbedoSource::Estimate;
    let (mut least, mut most) = ([f32::MAX; 2], [0.0_f32; 2]);
    let lit = asked.color(&painted);
    let bare = Asked::of(Material::Lambert, Method::Plain).color(&painted);
    for (x, y) in covered(&painted.mask).filter(|&(x, y)| bare.r.at(x, y) > 0.05) {
        let albedo = lit.r.at(x, y) / bare.r.at(x, y);
        let stripe = x / 8 % 2;
        least[stripe] = least[stripe].min(albedo);
        most[stripe] = most[stripe].max(albedo);
    }
    // Within a tenth of 0.8 and 0.4, though half of the paint was dark.
    for (stripe, expected) in [0.8, 0.4].into_iter().enumerate() {
        let is_flat = least[stripe] > 0.9 * expected && most[stripe] < 1.1 * expected;
        assert!(is_flat, "{least:?} {most:?}");
    }
}

#[test]
fn coverage_is_multiplied_in_once() {
    // A premultiplied picture of 0.5 under coverage of 0.6: light of 1 from the viewer shows 0.5 n_z, times
    // 0.6, whether the picture is the albedo, or its estimate, 0.8 for all of it.
    let frame = torus();
    let flat = |value: f32| Plane::filled(97, 94, value);
    let thin = Frame {
        color: Some(ColorPlanes::grey(flat(0.3))),
        alpha: Some(flat(0.6)),
        ..frame.clone()
    };
    use AlbedoSource::{Estimate, Picture, White};
    for (source, albedo) in [(Picture, 0.5), (Estimate, 0.8), (White, 1.0)] {
        let mut asked = Asked::of(Material::Lambert, Method::Plain);
        asked.light = lights(&[Vec3::Z]);
        asked.relight.albedo = source;
        let error = largest_error(&asked.color(&thin), &thin, |x, y| {
            0.6 * albedo * f64::from(frame.normal.z.at(x, y))
        });
        assert!(error < 1e-3, "{source:?}: {error}");
    }
}

#[test]
fn corners_get_less_light_from_all_around_however_it_is_summed() {
    // Occlusion of 1/2 everywhere: half of an environment's diffuse light and of even light, and all of a
    // light that has a direction.
    let frame = torus();
    let mut dim = frame.clone();
    dim.light.occlusion = Some(Plane::filled(97, 94, 0.5));
    let ways = [
        (SampleCount::Fixed(0), WarpBy::Auto, Method::Plain),
        (SampleCount::Fixed(33), WarpBy::Auto, Method::Plain),
        (SampleCount::Fixed(33), WarpBy::Lights, Method::Warp),
        (SampleCount::Fixed(33), WarpBy::Lookups, Method::Warp),
    ];
    for (samples, warp_by, method) in ways {
        let mut asked = Asked::of(Material::Lambert, method).in_environment(sky(), samples);
        asked.relight.warp_by = warp_by;
        asked.relight.material.ambient = 0.2;
        let open = asked.color(&frame);
        let error = largest_error(&asked.color(&dim), &dim, |x, y| {
            0.5 * f64::from(open.r.at(x, y))
        });
        assert!(error < 1e-6, "{samples:?} {warp_by:?} {method:?}: {error}");
    }
    let asked = Asked::of(Material::Lambert, Method::Plain);
    assert_eq!(asked.color(&dim).r, asked.color(&frame).r);
}

#[test]
fn the_grain_of_an_occlusion_layer_stays_out_of_the_light() {
    // Two walls that meet in an edge: 4 and 8 tenths of ambient light 1 arrive, and grain of a deviation of .06.
    let (width, height) = (120, 80);
    let share = |x: usize| if x < width / 2 { 0.4 } else { 0.8 };
    let mut state = 1_u32;
    let occlusion = Plane::from_fn(width, height, |x, _| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // Evenly between -1 and 1, of a deviation of 1 / sqrt(3).
        let stray = (state >> 8) as f32 / (1 << 23) as f32 - 1.0;
        share(x) + 0.06 * 3.0_f32.sqrt() * stray
    });
    let side = |x: usize| if x < width / 2 { -0.96 } else { 0.96 };
    let normal = Vector3Planes::from_fn(width, height, |x, _| DVec3::new(side(x), 0.0, 0.28));
    let mut frame = Frame::of_normals(normal, Mask::full(width, height));
    frame.light.occlusion = Some(occlusion);
    let mut asked = Asked::of(Material::Lambert, Method::Plain);
    asked.relight.material.ambient = 1.0;
    asked.light = lights(&[]);
    let color = asked.color(&frame).r;
    let off = |x: usize, y: usize| f64::from(color.at(x, y) - share(x));
    let mean = |at: &dyn Fn(usize) -> bool| {
        let spots = places(width, height).filter(|(x, _)| at(*x));
        let squares: f64 = spots.clone().map(|(x, y)| off(x, y).powi(2)).sum();
        (squares / spots.count() as f64).sqrt()
    };
    // A Gaussian of sigma 3 leaves 1 / (2 sqrt(pi) 3) = .094 of white noise: .0056. The pixels of the edge itself are closed;
    // next to it half of the neighbours are missing, so 1.5 of that. A share from beyond it would be some hundredths.
    let inside = mean(&|x: usize| x.abs_diff(width / 2) > 10 && (10..width - 10).contains(&x));
    let beside = mean(&|x: usize| (2..5).contains(&x.abs_diff(width / 2)));
    assert!((0.004..0.0075).contains(&inside), "{inside}");
    assert!(beside < 0.012, "{beside}");
}
