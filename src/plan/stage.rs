//! What a stage says of itself, where it is at home: all that plans, executors and memory know of it.

use crate::engine::cpu::run::Run;
#[cfg(feature = "gpu")]
use crate::engine::gpu::run::Run as DeviceRun;
#[cfg(feature = "gpu")]
use crate::error::Result;
use crate::plan::Plan;
use crate::product::Product;

/// What runs as one: a pass over the frame, or several that belong together.
pub(crate) struct Stage {
    /// Its name in timings.
    pub(crate) name: &'static str,
    /// What is decided of it, in the order of execution.
    pub(crate) steps: &'static [Step],
    /// Whether it runs where none of its steps says so.
    pub(crate) also_runs: fn(&Plan) -> bool,
    /// What it takes of what others give, where it runs.
    pub(crate) takes: fn(&Plan) -> Vec<Product>,
    /// How far, in pixels, a sample of these reaches.
    pub(crate) reach_px: fn(&Plan) -> usize,
    /// Parameters that its result depends on, in words that are equal where they are.
    pub(crate) depends_on: fn(&Plan) -> String,
    /// Does it on the CPU.
    pub(crate) cpu: fn(&mut Run),
    /// Records it for a device.
    #[cfg(feature = "gpu")]
    pub(crate) gpu: fn(&mut DeviceRun),
    /// What the CPU does of it while the device works on what all stages have recorded.
    #[cfg(feature = "gpu")]
    pub(crate) beside_gpu: Option<fn(&mut DeviceRun) -> Result<()>>,
    /// What of it a device cannot do, in a few words.
    #[cfg(feature = "gpu")]
    pub(crate) gpu_lacks: fn(&Plan) -> Option<&'static str>,
}

impl Stage {
    /// A stage that takes no plane of the descriptor, and reaches nowhere.
    pub(crate) const DEFAULT: Self = Self {
        name: "",
        steps: &[],
        also_runs: |_| false,
        takes: |_| Vec::new(),
        reach_px: |_| 0,
        depends_on: |_| String::new(),
        cpu: |_| (),
        #[cfg(feature = "gpu")]
        gpu: |_| (),
        #[cfg(feature = "gpu")]
        beside_gpu: None,
        #[cfg(feature = "gpu")]
        gpu_lacks: |_| None,
    };

    /// What its steps give.
    pub(crate) fn gives(&self) -> impl Iterator<Item = Product> + use<'_> {
        self.steps.iter().flat_map(|step| step.gives).copied()
    }
}

/// What is kept or left out for a reason of its own.
pub(crate) struct Step {
    /// Its name, as `--explain` prints it.
    pub(crate) name: &'static str,
    /// What it gives, or has a part in.
    pub(crate) gives: &'static [Product],
    /// Whether it runs, and why.
    pub(crate) decide: fn(&Plan) -> Verdict,
}

/// Whether a step runs, and why in a few words.
pub(crate) enum Verdict {
    Runs(String),
    LeftOut(String),
}

impl Verdict {
    pub(crate) fn runs(why: impl Into<String>) -> Self {
        Self::Runs(why.into())
    }

    pub(crate) fn left_out(why: impl Into<String>) -> Self {
        Self::LeftOut(why.into())
    }
}

impl Plan {
    /// The verdict on a step of shape, or one that takes it, that is left out: where nothing is asked of shape, why that
    /// is so.
    pub(crate) fn left_out(&self, why: impl Into<String>) -> Verdict {
        Verdict::LeftOut(self.no_shape.map_or_else(|| why.into(), String::from))
    }
}
