//! How long the stages of a frame took, and --timings.

use crate::engine::outcome::Outcome;
use crate::frame::Window;
use crate::io::Loaded;
use std::time::Duration;

/// The making of normals where files hold none.
pub(super) const NORMALS: &str = "normals";

/// How long the stages of a frame took.
pub(super) struct Timings {
    /// Columns and rows.
    size: [usize; 2],
    /// Pixels that show a surface.
    pub(super) covered: usize,
    pub(super) stages: Vec<(&'static str, Duration)>,
    /// The number of blocks that diffusion left out, and of all.
    pub(super) left_out: [usize; 2],
}

impl Timings {
    /// Of a frame that took so long to read, with its normals where they were made.
    pub(super) fn of(loaded: &Loaded, read: Duration) -> Self {
        let frame = &loaded.frame;
        let mut timings = Self {
            covered: frame.mask.count(),
            ..Self::of_window(frame.data_window)
        };
        let made = loaded.normals_made;
        timings.add("read", read.saturating_sub(made.unwrap_or_default()));
        if let Some(made) = made {
            timings.add(NORMALS, made);
        }
        timings
    }

    /// Of a frame that comes part by part.
    pub(super) fn of_window(window: Window) -> Self {
        Self {
            size: [window.width(), window.height()],
            covered: 0,
            stages: Vec::new(),
            left_out: [0; 2],
        }
    }

    /// Adds what a stage took to what it took before.
    pub(super) fn add(&mut self, name: &'static str, took: Duration) {
        match self.stages.iter_mut().find(|(known, _)| *known == name) {
            Some((_, time)) => *time += took,
            None => self.stages.push((name, took)),
        }
    }

    /// Adds all stages of a run.
    pub(super) fn add_all(&mut self, outcome: &Outcome) {
        let stages = outcome.timings.iter();
        stages.for_each(|&(name, took)| self.add(name, took));
        for (sum, count) in self.left_out.iter_mut().zip(outcome.left_out) {
            *sum += count;
        }
    }

    pub(super) fn json(&self, total: Duration) -> String {
        let seconds = |d: Duration| d.as_secs_f64();
        let stages = self.stages.iter();
        let stages: Vec<_> = stages
            .map(|&(name, time)| serde_json::json!({ "stage": name, "seconds": seconds(time) }))
            .collect();
        let summary = serde_json::json!({
            "width": self.size[0],
            "height": self.size[1],
            "covered_pixels": self.covered,
            "threads": rayon::current_num_threads(),
            "stages": stages,
            "diffusion_blocks": self.left_out[1],
            "diffusion_blocks_left_out": self.left_out[0],
            "total_seconds": seconds(total),
        });
        format!("{summary:#}\n")
    }
}
