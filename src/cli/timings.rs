//! How long the stages of a frame took, and --timings.

use crate::frame::Window;
use crate::io::Loaded;
use crate::io::picture::Whites;
use crate::plan::outcome::Outcome;
use std::time::Duration;

/// The making of normals where files hold none.
pub(super) const NORMALS: &str = "normals";

/// How long the stages of a frame took.
pub(super) struct FrameTimings {
    /// Columns and rows.
    size: [usize; 2],
    /// Pixels that show a surface.
    pub(super) covered: usize,
    pub(super) stages: Vec<(&'static str, Duration)>,
    /// The number of blocks that diffusion left out, and of all.
    left_out: [usize; 2],
    /// Whether pixels that show several surfaces were looked for, and there are none.
    is_sharp: bool,
}

impl FrameTimings {
    /// Of a frame that took so long to read, with its normals where they were made.
    pub(super) fn of(loaded: &Loaded, read: Duration) -> Self {
        let frame = &loaded.frame;
        let mut timings = Self {
            covered: frame.mask.count(),
            is_sharp: loaded.is_sharp,
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
            is_sharp: false,
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

    /// What had nothing to do, each with the count that proves it, in a picture with these whites.
    pub(super) fn idle(&self, whites: Whites) -> Vec<(&'static str, String)> {
        let ([still, blocks], pixels) = (self.left_out, self.covered);
        let rows = [
            (
                still > 0,
                "diffusion",
                format!("nothing flows in {still} of {blocks} blocks"),
            ),
            (
                self.is_sharp,
                "fade",
                format!("0 of {pixels} pixels show several surfaces"),
            ),
            (
                whites.compressed == Some(0),
                "highlights",
                format!(
                    "0 of {} pixels are bright enough to be compressed",
                    whites.of
                ),
            ),
        ];
        let rows = rows.into_iter().filter(|(is_idle, ..)| *is_idle);
        rows.map(|(_, pass, count)| (pass, count)).collect()
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
