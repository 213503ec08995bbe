//! Dots over the frame.

use super::dark_dots::{covered, mended};
use super::room::fitted;
use super::settled::settled;
use super::spread::{DotDensity, diffused, spaced};
use super::{Dot, LaidDot};
use crate::frame::memory::Memory;
use crate::frame::{Frame, Plane};
use crate::line::carried::Carrier;
use crate::line::density::{coverage_at, keep_inside};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::tone::Densities;
use crate::params::{Stroke, StrokeParams};
use glam::Vec2;
use rayon::prelude::*;

/// Dots as drawn, as they are carried on, and their coverage.
pub(crate) struct Stippled {
    pub(crate) dots: Vec<Dot>,
    pub(crate) laid: Vec<LaidDot>,
    pub(crate) covered: Plane,
}

/// The dots of a tone. In a sequence those of the previous frame stay on the surface.
pub(crate) fn stippled(
    densities: &Densities,
    params: &StrokeParams,
    resolution_factor: f32,
    sequence: Option<SequenceInputs>,
    frame: &Frame,
    memory: &Memory,
) -> Stippled {
    let radius = radius_of(&params.stroke(resolution_factor));
    let ink = densities.mapped(frame, memory, |_| |_, density| coverage_at(density));
    let field = DotDensity::new(&ink, radius);
    let (laid, dots) = carried_on(&field, params.seed, sequence, frame, memory)
        .unwrap_or_else(|| laid_anew(&field, params.seed, memory));
    let dots = mended(dots, radius, &ink, memory);
    let mut covered = covered(&dots, [ink.width(), ink.height()]);
    memory.recycle([ink]);
    keep_inside(&mut covered, &frame.mask);
    Stippled {
        dots,
        laid,
        covered,
    }
}

/// Radius of the smallest dots, in pixels: smaller ones turn everything grey.
const LEAST_RADIUS: f32 = 0.3;

/// Radius of a whole dot, in pixels.
fn radius_of(stroke: &Stroke) -> f32 {
    (0.5 * stroke.width_px).max(LEAST_RADIUS)
}

/// Dots in a pixel where all is black.
#[cfg(feature = "cli")]
pub(crate) fn most_dots_per_px(stroke: &Stroke) -> f32 {
    super::spread::laid(1.0) / (std::f32::consts::PI * radius_of(stroke) * radius_of(stroke))
}

/// Dots that begin with this frame, and their sizes.
fn laid_anew(field: &DotDensity, seed: u64, memory: &Memory) -> (Vec<LaidDot>, Vec<Dot>) {
    let laid = |at: Vec2| LaidDot {
        at,
        share: 1.0,
        is_going: false,
    };
    let dot = |at: Vec2| Dot {
        at,
        radius: field.radius,
    };
    let places = spaced(diffused(field, seed, memory), 0, field, memory);
    places.into_iter().map(|at| (laid(at), dot(at))).unzip()
}

/// The dots that continue those of the previous frame, and their sizes, if any of these is still visible.
fn carried_on(
    field: &DotDensity,
    seed: u64,
    sequence: Option<SequenceInputs>,
    frame: &Frame,
    memory: &Memory,
) -> Option<(Vec<LaidDot>, Vec<Dot>)> {
    let (before, carrier) = Carrier::of(sequence, frame)?;
    let here = |dot: &LaidDot| {
        let at = carrier.carried(dot.at)?;
        Some(LaidDot { at, ..*dot })
    };
    let carried: Vec<LaidDot> = before.dots.par_iter().filter_map(here).collect();
    if carried.is_empty() {
        return None;
    }
    let was_seen = before.seen_before(frame, carrier.motion);
    let mut laid = settled(&carried, field, &was_seen, seed, memory);
    let dots = fitted(&mut laid, field);
    Some((laid, dots))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::cancel::CancelToken;

    fn dots(ink: &Plane, radius: f32, seed: u64, memory: &Memory) -> Vec<Dot> {
        let (_, dots) = laid_anew(&DotDensity::new(ink, radius), seed, memory);
        mended(dots, radius, ink, memory)
    }

    #[test]
    fn dots_cover_the_ink_that_is_wanted() {
        for ink in [0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97] {
            for radius in [0.4, 1.0, 2.5] {
                let plane = Plane::filled(200, 200, ink);
                let drawn = covered(&dots(&plane, radius, 1, &Memory::default()), [200, 200]);
                let mean = drawn.samples().iter().sum::<f32>() / 4e4;
                assert!((mean - ink).abs() < 0.02, "{ink} by {radius}: {mean}");
            }
        }
    }

    #[test]
    fn dots_lie_apart() {
        // A dot of radius 1 has pi/0.2 pixels: the root of that is 3.96, and in a hexagonal order all were 4.26 apart. At
        // random some of a thousand nearly meet.
        let dots = dots(&Plane::filled(150, 150, 0.2), 1.0, 1, &Memory::default());
        let nearest = |dot: &Dot| {
            let others = dots.iter().filter(|other| other.at != dot.at);
            let distances = others.map(|other| other.at.distance(dot.at));
            distances.fold(f32::INFINITY, f32::min)
        };
        let mut distances: Vec<f32> = dots.iter().map(nearest).collect();
        distances.sort_by(f32::total_cmp);
        let [least, median] = [distances[0], distances[distances.len() / 2]];
        assert!(
            least > 0.5 * 3.96 && median > 0.8 * 3.96,
            "{least} {median}"
        );
    }

    #[test]
    fn no_dots_are_laid_once_a_run_is_cancelled() {
        let token = CancelToken::new();
        let memory = Memory::default().for_run(Some(&token));
        let ink = Plane::filled(50, 50, 0.5);
        assert!(!dots(&ink, 1.0, 1, &memory).is_empty());
        token.cancel();
        assert!(dots(&ink, 1.0, 1, &memory).is_empty());
    }

    #[test]
    fn dots_are_the_same_for_a_seed_and_none_lie_on_white_paper() {
        let ink = Plane::from_fn(90, 60, |x, _| if x < 45 { f32::NAN } else { 0.4 });
        let by = |threads: usize, seed| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| dots(&ink, 0.8, seed, &Memory::default()))
        };
        assert_eq!(by(1, 1), by(3, 1));
        assert_ne!(by(1, 1), by(1, 2));
        assert!(by(1, 1).iter().all(|dot| dot.at.x >= 45.0));
    }
}
