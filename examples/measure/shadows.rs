//! Cast shadows over waves whose height the normals tell alone: times, and errors against rays over the waves themselves.

use crate::common::light_from;
use crate::{CHECKED, Case, Outcomes, Parts, plan, some_covered};
use glam::{DVec2, DVec3};
use relievo::engine::Outcome;
use relievo::frame::Frame;
use relievo::light::light_samples::light_disc;
use relievo::params::{Material, Method, RelightParams, SampleCount, Shadows};
use relievo::plan::Goal;
use relievo::scenes::Scene;
use relievo::scenes::light_reference::white;
use std::rc::Rc;

const PARTS: Parts = &[
    ("height", &["height"]),
    ("shadows", &["shadows"]),
    ("light", &["relight"]),
];

/// Azimuth and elevation of the lamp, in degrees. Slopes of the waves reach 26 degrees.
const LAMP_DEG: [f32; 2] = [150.0, 12.0];

/// Points of a lamp that rays go to.
const RAYS: usize = 64;

/// Pixels between two points of a ray.
const STEP: f64 = 0.05;

/// A lamp that is a point, and one of the default width.
pub(crate) fn cases(width: usize, height: usize) -> Outcomes<Vec<Case>> {
    let frame = Rc::new(Frame {
        depth: None,
        ..Scene::waves(width, height).frame
    });
    let [azimuth, elevation] = LAMP_DEG;
    let light = light_from(azimuth, elevation);
    let to_light = light.directional[0].to_light;
    let default = RelightParams::default().light_size;
    let of_size = |size: f32| {
        let params = RelightParams {
            shadows: Shadows::On,
            light_size: size,
            shadow_fill: 0.0,
            ..white(Material::Lambert, Method::Plain, SampleCount::Auto)
        };
        let plan = plan(Goal::Relight(params), &frame, &light)?;
        let rays = match size > 0.0 {
            true => light_disc(to_light, 0.5 * size.to_radians(), RAYS),
            false => vec![to_light],
        };
        let rays: Vec<DVec3> = rays.iter().map(|to| to.as_dvec3()).collect();
        let lit = frame.clone();
        let judge = move |outcome: &Outcome| {
            let error = mean_error(&lit, outcome, to_light.as_dvec3(), &rays);
            Ok(format!("{error:.1e}"))
        };
        let name = format!("shadows of a lamp {size} degrees wide");
        Ok(Case::new(name, &frame, plan, &light, PARTS, judge))
    };
    [0.0, default].into_iter().map(of_size).collect()
}

/// The mean error of the share of the lamp that arrives.
fn mean_error(frame: &Frame, outcome: &Outcome, to_light: DVec3, rays: &[DVec3]) -> f64 {
    let color = outcome.color.as_ref().expect("light makes a picture");
    let (mut sum, mut count) = (0.0, 0);
    for [x, y] in some_covered(&frame.mask, CHECKED) {
        let cosine = frame.normal.at(x, y).dot(to_light);
        // Away from the border, beyond which the waves go on.
        let reach = (2.0 * Scene::HEIGHT / to_light.z * to_light.truncate().length()) as usize + 1;
        let [width, height] = [frame.mask.width(), frame.mask.height()];
        let is_inside = x >= reach && x + reach < width && y >= reach && y + reach < height;
        if cosine < 0.05 || !is_inside {
            continue;
        }
        let found = f64::from(color.g.at(x, y)) / cosine;
        let free = rays.iter().filter(|to| is_free([x, y], **to)).count();
        sum += (found - free as f64 / rays.len() as f64).abs();
        count += 1;
    }
    sum / f64::from(count.max(1))
}

/// Whether a ray from the waves at this pixel leaves them.
fn is_free([x, y]: [usize; 2], to: DVec3) -> bool {
    let height =
        |at: DVec2| Scene::HEIGHT * (Scene::WAVE * at.x).cos() * (Scene::WAVE * at.y).cos();
    let from = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
    let (ground, rise) = (to.truncate().length(), to.z);
    let step = DVec2::new(to.x, -to.y) / ground * STEP;
    let own = height(from);
    let mut t = 1;
    loop {
        let at = own + f64::from(t) * STEP * rise / ground;
        if at >= Scene::HEIGHT {
            return true;
        }
        if height(from + f64::from(t) * step) > at {
            return false;
        }
        t += 1;
    }
}
