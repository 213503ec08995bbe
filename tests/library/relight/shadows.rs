//! Shadows of a sun against those of a path tracer, over heights and over depth.

use super::{Asked, lights, surroundings};
use crate::common::exr;
use crate::common::files::load;
use crate::common::program::fixture;
use crate::prelude::*;

/// What arrives at each pixel of a sun `width_deg` wide.
fn arrives(frame: &Frame, elevation_deg: f32, width_deg: f32) -> Vec<f32> {
    let lit = |shadows| {
        let asked = Asked::of(Material::Lambert, Method::Plain).with(|asked| {
            asked.light = lights(&[direction_of(150.0, elevation_deg)]);
            asked.relight.shadows = shadows;
            asked.relight.light_size = width_deg;
            asked.relight.shadow_fill = 0.0;
        });
        asked.color(frame).g
    };
    let (shadowed, open) = (lit(Shadows::On), lit(Shadows::Off));
    let pairs = shadowed.samples().iter().zip(open.samples());
    // Of what the surface faces by more than a degree.
    let share = |(a, b): (&f32, &f32)| if *b > 0.02 { a / b } else { f32::NAN };
    pairs.map(share).collect()
}

/// The overlap of both shadows: pixels in both over pixels in either, among those that face the sun.
fn overlap(found: &[f32], file: &str, channel: &str) -> f64 {
    let truth = exr::channel(&fixture(file), channel);
    let pairs = found.iter().zip(truth.samples());
    let [mut both, mut either] = [0, 0];
    for (found, &truth) in pairs.filter(|(found, truth)| !found.is_nan() && **truth >= 0.0) {
        let dark = [*found < 0.5, truth < 0.5];
        both += usize::from(dark == [true; 2]);
        either += usize::from(dark != [false; 2]);
    }
    f64::from(both as u32) / f64::from(either as u32)
}

/// The suns of the truth: their channels, elevations and widths in degrees.
const SUNS: [(&str, f32, f32); 3] = [("hard", 25.0, 0.0), ("soft", 25.0, 8.0), ("low", 12.0, 0.0)];

fn overlaps_by(least: f64, frame: &Frame, file: &str) {
    for (channel, elevation, width) in SUNS {
        let found = overlap(&arrives(frame, elevation, width), file, channel);
        assert!(found >= least, "{file}, {channel}: {found}");
    }
}

#[test]
fn heights_cast_the_shadows_of_a_path_tracer() {
    overlaps_by(0.94, &relief(), "relief.exr");
}

#[test]
fn a_bust_in_depth_casts_the_shadows_of_a_path_tracer() {
    let frame = load(fixture("bust.exr"), |inputs, needs| {
        inputs.camera = Some(fixture("bust.camera.json"));
        needs.projection = true;
    });
    let frame = frame.frame;
    // What the head hides of itself has to be guessed.
    overlaps_by(0.85, &frame, "bust.shadows.exr");
}

fn relief() -> Frame {
    let relief = load(fixture("relief.exr"), |inputs, _| {
        inputs.depth = Some("height.Y".into());
        inputs.depth_kind = Some(StoredDepth::Height);
    });
    relief.frame
}

/// The light of an environment is hidden as that of its texels is, each a sun with shadows of its own.
#[test]
fn horizons_hide_the_light_of_an_environment() {
    let frame = relief().crop(Window::at(60, 40, 160, 120));
    // A sun of three texels, a lamp of one with most of the light, and an even sky.
    let sunset = |[x, y, z]: [f32; 3]| {
        let toward = 0.7 * x + 0.3 * y + 0.648 * z;
        [1.0 + 60.0 * toward.max(0.0).powi(64); 3]
    };
    let lamp = |[x, y, z]: [f32; 3]| {
        let toward = -0.8 * x + 0.4 * y + 0.447 * z;
        [1.0 + 1500.0 * toward.max(0.0).powi(600); 3]
    };
    for (name, map) in [
        ("sunset", surroundings(40, sunset)),
        ("lamp", surroundings(40, lamp)),
        ("even", surroundings(40, |_| [1.0; 3])),
    ] {
        let suns = places(map.width(), map.height()).map(|(x, y)| {
            let share = (map.solid_angle(y) / std::f64::consts::PI) as f32;
            DirectionalLight {
                to_light: map.direction(x, y),
                intensity: map.pixel(x, y).map(|radiance| share * radiance),
            }
        });
        let suns = suns.collect();
        let asked = Asked::of(Material::Lambert, Method::Plain).with(|asked| {
            asked.relight.light_size = 0.0;
            asked.relight.shadow_fill = 0.0;
        });
        let exact = asked.clone().with(|asked| {
            asked.relight.shadows = Shadows::On;
            asked.light = Illumination::default();
            asked.light.directional = suns;
        });
        let by_horizons = |shadows| {
            let mut asked = asked.clone().in_environment(map.clone(), SampleCount::Auto);
            asked.relight.sky_shadows = shadows;
            asked.color(&frame).g
        };
        let exact = exact.color(&frame).g;
        let error = |shadows| levels_apart(&exact, &by_horizons(shadows));
        let [open, hidden] = [Shadows::Off, Shadows::On].map(error);
        assert!(open[1] > 30.0, "{name}: {open:?}");
        assert!(hidden[0] < 1.5 && hidden[1] < 10.0, "{name}: {hidden:?}");
    }
}

/// Highlights of samples are hidden as those of lights that stand for the same environment.
#[test]
fn horizons_hide_the_highlights_of_an_environment() {
    let frame = relief().crop(Window::at(60, 40, 160, 120));
    let low = |[_, _, z]: [f32; 3]| [if z < 0.5 { 1.0 } else { 0.05 }; 3];
    let by = |samples, shadows| {
        let asked = Asked::of(Material::AshikhminShirley, Method::Plain).with(|asked| {
            asked.relight.material.diffuse_gain = 0.0;
            asked.relight.material.ambient = 0.0;
            asked.relight.material.coat = [4.0; 2];
            asked.relight.sky_shadows = shadows;
        });
        let asked = asked.in_environment(surroundings(40, low), samples);
        asked.color(&frame).g
    };
    let lights = by(SampleCount::Fixed(1500), Shadows::On);
    let open = levels_apart(&lights, &by(SampleCount::Auto, Shadows::Off));
    let hidden = levels_apart(&lights, &by(SampleCount::Auto, Shadows::On));
    // Samples alone are allowed 4 levels.
    assert!(open[1] > 40.0, "{open:?}");
    assert!(hidden[0] < 4.0 && hidden[1] < 10.0, "{hidden:?}");
}

/// The mean and the 99th percentile of the difference in grey levels, where 95 % of the truth are below 0.8.
fn levels_apart(truth: &Plane, found: &Plane) -> [f32; 2] {
    let nth = |mut values: Vec<f32>, share: f32| {
        values.sort_by(f32::total_cmp);
        values[(share * (values.len() - 1) as f32) as usize]
    };
    let white = nth(truth.samples().to_vec(), 0.95) / 0.8;
    let shown = |v: &f32| 255.0 * (v / white).clamp(0.0, 1.0).powf(1.0 / 2.2);
    let pairs = truth.samples().iter().zip(found.samples());
    let apart: Vec<f32> = pairs.map(|(a, b)| (shown(a) - shown(b)).abs()).collect();
    let mean = apart.iter().sum::<f32>() / apart.len() as f32;
    [mean, nth(apart, 0.99)]
}
