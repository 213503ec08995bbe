//! Cost of enhancement: render times at equal samples, in turns.

use super::enhancement::{Bounces, Enhancement};
use super::path::{Direct, Tracing};
use super::render::Job;
use super::stage::{self, Setting};
use super::{MAX_BOUNCES, the_urn};
use relievo::params::Magnitude;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

const SIZE: [usize; 2] = [320, 240];
const SAMPLES: u32 = 8;

/// The kinds compared. The second repeats the first, for the noise. The third does all the work without effect: same
/// rays as plain, so the difference is the arithmetic; warped paths take other routes, with their cost.
fn kinds() -> [(&'static str, Enhancement); 6] {
    let kind = |warp, scale| Enhancement {
        warp,
        scale,
        ..Enhancement::default()
    };
    let idle = Enhancement {
        warping: 0.0,
        scaling: [Magnitude::of_both(0.0); 2],
        ..kind(Bounces::First, Bounces::First)
    };
    [
        ("plain", kind(Bounces::None, Bounces::None)),
        ("plain, once more", kind(Bounces::None, Bounces::None)),
        ("warped and scaled by 0, first bounce", idle),
        ("warped, first bounce", kind(Bounces::First, Bounces::None)),
        ("scaled, first bounce", kind(Bounces::None, Bounces::First)),
        ("scaled, all bounces", kind(Bounces::None, Bounces::All)),
    ]
}

/// Times of every kind, and their ratios to plain in the same round.
pub(crate) fn table(rounds: usize) -> String {
    let scene = stage::scene(Setting::Mirrors, the_urn());
    let kinds = kinds();
    let mut times = vec![Vec::new(); kinds.len()];
    // The first round warms up.
    for round in 0..=rounds {
        for turn in 0..kinds.len() {
            // Each round begins with another kind, so that none is always first.
            let kind = (turn + round) % kinds.len();
            let job = Job {
                scene: &scene,
                camera: stage::camera(Setting::Mirrors, SIZE),
                tracing: Tracing {
                    enhancement: kinds[kind].1.clone(),
                    direct: Direct::Both,
                    max_bounces: MAX_BOUNCES,
                },
                samples: SAMPLES,
                seed: round as u32,
            };
            let start = Instant::now();
            black_box(job.pixels());
            if round > 0 {
                times[kind].push(start.elapsed().as_secs_f64());
            }
        }
    }
    let [width, height] = SIZE;
    let mut text = format!(
        "{width}x{height}, {SAMPLES} paths per pixel, {rounds} rounds, {} threads\n\n\
         | light | median s | fastest s | over plain, median of rounds | quartiles |\n|---|---|---|---|---|\n",
        rayon::current_num_threads()
    );
    for ((name, _), of_kind) in kinds.iter().zip(&times) {
        let over: Vec<f64> = of_kind
            .iter()
            .zip(&times[0])
            .map(|(t, p)| t / p - 1.0)
            .collect();
        let percent = |share| 100.0 * quantile(&over, share);
        let written = writeln!(
            text,
            "| {name} | {:.3} | {:.3} | {:+.1} % | {:+.1} to {:+.1} % |",
            quantile(of_kind, 0.5),
            quantile(of_kind, 0.0),
            percent(0.5),
            percent(0.25),
            percent(0.75),
        );
        written.expect("text grows");
    }
    text
}

/// The quantile for this share, to the nearest value.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[(share * (sorted.len() - 1) as f64).round() as usize]
}

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quantiles_are_values() {
        let values = [4.0, 1.0, 3.0, 2.0, 5.0];
        assert_eq!(
            [0.0, 0.25, 0.5, 1.0].map(|q| quantile(&values, q)),
            [1.0, 2.0, 3.0, 5.0]
        );
    }
}
