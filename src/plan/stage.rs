//! The description of a stage, shared by plans, executors and caches.

#[cfg(feature = "gpu")]
use crate::error::Result;
use crate::plan::Plan;
use crate::plan::execution::Execution;
#[cfg(feature = "gpu")]
use crate::plan::recording::Recording;
use crate::plan::search::Search;
use crate::product::Product;

/// A stage: one pass over the frame, or several that belong together.
pub(crate) struct Stage {
    /// Its name in timings.
    pub(crate) name: &'static str,
    /// What it is for.
    pub(crate) makes: Makes,
    /// Its steps in the order of execution, each decided separately.
    pub(crate) steps: &'static [Step],
    /// Whether it runs even if none of its steps do.
    pub(crate) also_runs: fn(&Plan) -> bool,
    /// Products of other stages that it reads when it runs.
    pub(crate) takes: fn(&Plan) -> Vec<Product>,
    /// How far, in pixels, samples of those products reach.
    pub(crate) reach_px: fn(&Plan) -> usize,
    /// Whether rows of its results take nothing but those rows of what it reads, with its reach, and the mask.
    #[cfg_attr(
        not(feature = "cli"),
        expect(dead_code, reason = "the command line alone writes layers by rows")
    )]
    pub(crate) by_rows: bool,
    /// Whether it reads the lengths that the normals of the frame had.
    pub(crate) reads_lengths: bool,
    /// Whether it reads the normals of the frame.
    pub(crate) reads_normals: bool,
    /// Whether one that does makes its results in their memory, if no other stage after the first reads them.
    pub(crate) takes_normals: fn(&Plan) -> bool,
    /// Whether one that does reads the depth of the frame too.
    pub(crate) reads_depth: fn(&Plan) -> bool,
    /// A key of the parameters its result depends on: equal keys, equal results.
    pub(crate) depends_on: fn(&Plan) -> String,
    /// What it chooses from the whole picture, where that is left open.
    pub(crate) chooses: fn(&Plan) -> Option<Box<dyn Search>>,
    /// Runs it on the CPU.
    pub(crate) cpu: fn(&mut Execution),
    /// Records it on a device; without, the CPU runs it when its turn comes.
    #[cfg(feature = "gpu")]
    pub(crate) gpu: Option<fn(&mut Recording)>,
    /// Where a device has its products once all stages are recorded.
    #[cfg(feature = "gpu")]
    pub(crate) gpu_planes: &'static [DevicePlanes],
    /// What follows once all that the device has recorded is read back; of a stage that records nothing, in place of its CPU
    /// pass.
    #[cfg(feature = "gpu")]
    pub(crate) after_gpu: Option<fn(&mut Recording) -> Result<()>>,
    /// What the device implementation does not support, in a few words.
    #[cfg(feature = "gpu")]
    pub(crate) gpu_lacks: fn(&Plan) -> Option<&'static str>,
}

impl std::fmt::Debug for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl Stage {
    /// A stage that reads no plane of the descriptor and has reach 0.
    pub(crate) const DEFAULT: Self = Self {
        name: "",
        makes: Makes::Shape,
        steps: &[],
        also_runs: |_| false,
        takes: |_| Vec::new(),
        reach_px: |_| 0,
        by_rows: false,
        reads_lengths: false,
        reads_normals: true,
        takes_normals: |_| false,
        reads_depth: |_| true,
        depends_on: |_| String::new(),
        chooses: |_| None,
        cpu: |_| (),
        #[cfg(feature = "gpu")]
        gpu: None,
        #[cfg(feature = "gpu")]
        gpu_planes: &[],
        #[cfg(feature = "gpu")]
        after_gpu: None,
        #[cfg(feature = "gpu")]
        gpu_lacks: |_| None,
    };

    /// The products of its steps.
    pub(crate) fn gives(&self) -> impl Iterator<Item = Product> + use<'_> {
        self.steps.iter().flat_map(|step| step.gives).copied()
    }
}

/// Planes that hold products, by their names; with fewer planes than the products have, each pixel has several numbers.
#[cfg(feature = "gpu")]
pub(crate) type DevicePlanes = (&'static [Product], &'static [&'static str]);

/// What a stage is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Makes {
    /// The shape.
    Shape,
    /// A picture.
    Picture,
    /// A drawing of it.
    Drawing,
}

/// A part of a stage, kept or dropped for its own reason.
pub(crate) struct Step {
    /// Its name, as `--explain` prints it.
    pub(crate) name: &'static str,
    /// The products that it makes or contributes to.
    pub(crate) gives: &'static [Product],
    /// Whether it runs, and why.
    pub(crate) decide: fn(&Plan) -> Verdict,
}

/// A step by its name, the products that it makes, and whether it runs.
pub(crate) const fn step(
    name: &'static str,
    gives: &'static [Product],
    decide: fn(&Plan) -> Verdict,
) -> Step {
    Step {
        name,
        gives,
        decide,
    }
}

/// Whether a step runs, and the reason in a few words.
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
    /// Verdict on a dropped step that finds or uses shape: the reason why no shape is needed, if so, else `why`.
    pub(crate) fn left_out(&self, why: impl Into<String>) -> Verdict {
        Verdict::LeftOut(self.no_shape.map_or_else(|| why.into(), String::from))
    }
}
