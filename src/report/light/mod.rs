//! Light: error against time for the number of samples of an environment, for both equations of light warping and for
//! prefiltered maps; errors and times of the elementary functions; cost by number of lights.
//!
//! Everything uses one environment given by a formula ([`environment()`]), without files or randomness. The reference
//! is a picture under `REFERENCE_LIGHTS` evenly spread lights ([LW] equation 2 for warping), itself checked against
//! double precision ([`super::light_reference`]).

pub(crate) mod cost;
pub(crate) mod functions;
pub(crate) mod lit;
pub(crate) mod samples;

use super::asked::{Asked, Extent, On};
use super::compare::covered;
use super::scenes::Scene;
use super::scenes::environment::{ENVIRONMENT, environment};
use super::timing::Effort;
use crate::Result;
use crate::frame::{Frame, Window};
use crate::params::ShapeParams;
use lit::LitFrame;
use serde::Serialize;

/// Number of lights of the reference.
pub(crate) const REFERENCE_LIGHTS: usize = 16_384;

/// Invisible difference: one 8-bit step of the luminance that shows as white.
pub(crate) const ENOUGH: f64 = 1.0 / 255.0;

/// Results of one frame.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Subject {
    /// The part that was lit, around the centre of the covered pixels.
    #[serde(flatten)]
    pub on: On,
    /// Whether it is the frame, not a scene.
    #[serde(skip)]
    pub is_frame: bool,
    pub samples: Vec<samples::Sweep>,
    pub equations: Vec<samples::Equations>,
    pub prefiltered: Vec<samples::Prefiltered>,
}

/// All measurements of light.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct LightReport {
    pub environment: &'static str,
    /// The frame, and in a full report a scene.
    pub subjects: Vec<Subject>,
    pub functions: Vec<functions::FunctionRow>,
    pub cost: cost::Cost,
}

/// Measures light on `frame`, called `name`.
pub(crate) fn run(asked: &Asked) -> Result<LightReport> {
    let Asked {
        name,
        frame,
        shape,
        extent,
        progress,
        ..
    } = *asked;
    let (most, effort) = match extent {
        Extent::Full => ([128, 96], Effort::new(5, 150)),
        Extent::Quick => ([80, 60], Effort::new(3, 20)),
    };
    let environment = environment();
    let most_lookups = match extent {
        Extent::Full => 4096,
        Extent::Quick => 256,
    };
    let part = middle(frame, most);
    let bench = LitFrame::new(&part, shape, &environment, effort);
    let mut subjects = vec![subject(name, &bench, most_lookups, progress)?];
    let (width, height) = super::scene_size(extent);
    let waves = Scene::waves(width, height).frame;
    if extent == Extent::Full {
        let waves = middle(&waves, most);
        let shape = ShapeParams::default();
        let bench = LitFrame::new(&waves, shape, &environment, effort);
        subjects.push(Subject {
            is_frame: false,
            ..subject("waves", &bench, 1024, progress)?
        });
    }
    progress("light: elementary functions");
    let functions = functions::measured(extent);
    progress("light: number of lights");
    let cost = cost::measured(&waves, &environment, effort)?;
    Ok(LightReport {
        environment: ENVIRONMENT,
        subjects,
        functions,
        cost,
    })
}

fn subject(
    name: &str,
    bench: &LitFrame,
    most_lookups: u32,
    progress: &dyn Fn(&str),
) -> Result<Subject> {
    progress(&format!("{name}: samples of an environment"));
    let references = lit::References::new(bench)?;
    let samples = samples::sweeps(bench, &references)?;
    progress(&format!("{name}: both equations of light warping"));
    let equations = samples::equations(bench, &references, &samples, most_lookups)?;
    progress(&format!("{name}: prefiltered light"));
    let prefiltered = samples::prefiltered(bench, &references)?;
    Ok(Subject {
        on: On::new(name, &bench.frame.mask),
        is_frame: true,
        samples,
        equations,
        prefiltered,
    })
}

/// At most `most` columns and rows of `frame` around the centre of the covered pixels, without pictures: surfaces are
/// white.
pub(super) fn middle(frame: &Frame, most: [usize; 2]) -> Frame {
    let (mask, data) = (&frame.mask, frame.data_window);
    let [mut sum_x, mut sum_y] = [0, 0];
    for [x, y] in covered(mask) {
        (sum_x, sum_y) = (sum_x + x, sum_y + y);
    }
    let count = mask.count().max(1);
    let start = |sum: usize, size: usize, part: usize| {
        (sum / count).saturating_sub(part / 2).min(size - part) as i32
    };
    let (width, height) = (mask.width().min(most[0]), mask.height().min(most[1]));
    let x0 = data.x0 + start(sum_x, mask.width(), width);
    let y0 = data.y0 + start(sum_y, mask.height(), height);
    Frame {
        color: None,
        albedo: None,
        alpha: None,
        importance: None,
        ..frame.crop(Window::at(x0, y0, width, height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_that_of_what_is_covered() {
        // A ball around 240, 180 fills 0.9 of 360, so a central part of 100 by 80 is fully covered.
        let frame = Scene::ball(480, 360).frame;
        let part = middle(&frame, [100, 80]);
        assert_eq!((part.mask.width(), part.mask.height()), (100, 80));
        assert_eq!(part.mask.count(), 8000);
        // Its centre is at 240.3, 179.8: in pixel 239.8, 179.3 in pixel-centre coordinates.
        assert_eq!((part.data_window.x0, part.data_window.y0), (189, 139));
        let whole = middle(&frame, [1000, 1000]);
        assert_eq!(whole.mask.count(), frame.mask.count());
    }

    #[test]
    fn the_environment_has_a_sun_and_a_side() {
        let map = environment();
        let at = |d: [f32; 3]| map.radiance(d)[1];
        assert!(at([-0.5, 0.6, 0.62]) > 60.0 && at([0.6, 0.5, 0.62]) > 1.0);
        assert!(at([0.0, -1.0, 0.0]) < 0.2);
        // Its power over pi is 1.5 to 3: the sun's 2 pi 80 0.05^2 is 1.26 of it before the division.
        let power = map.power()[1] / std::f64::consts::PI;
        assert!((1.0..3.0).contains(&power), "{power}");
    }
}
