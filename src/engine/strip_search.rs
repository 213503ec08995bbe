//! Choices from a whole picture that is processed in strips.

use crate::engine::cpu::Runner;
use crate::engine::cpu::runner::{Passage, RunFrame};
use crate::error::Result;
use crate::frame::{Extent, Frame, Window};
use crate::plan::Plan;
use crate::plan::execution::{Execution, RunInputs, StripRows};
use crate::plan::search::{Search, Settle};
use crate::plan::stage::Stage;
use crate::plan::watch::Watch;
use crate::product::Product;
use std::collections::VecDeque;
use std::ops::Range;

/// A search for what stages choose from the whole picture. All strips are passed from top to bottom, again and again: once to
/// survey them, then once or twice for percentiles.
pub(crate) struct StripSearch<'a> {
    runner: &'a Runner,
    plan: &'a Plan,
    whole: Window,
    extent: Extent,
    /// Whether the extent is known.
    is_surveyed: bool,
    searches: Vec<Box<dyn Search>>,
}

/// What was chosen.
#[derive(Default)]
pub(crate) struct Choices(Vec<Settle>);

impl<'a> StripSearch<'a> {
    /// Looks that most pictures take.
    #[cfg(feature = "cli")]
    pub(crate) const USUAL_LOOKS: usize = 2;

    /// What `plan` leaves open in a picture of this window, by strips of which `pass` passes all.
    ///
    /// # Errors
    /// Those of `pass`.
    pub(crate) fn choices(
        runner: &'a Runner,
        plan: &'a Plan,
        whole: Window,
        mut pass: impl FnMut(&mut Self) -> Result<()>,
    ) -> Result<Choices> {
        let stages = plan.stages.iter();
        let mut search = Self {
            runner,
            plan,
            whole,
            extent: Extent::default(),
            is_surveyed: false,
            searches: stages.filter_map(|stage| (stage.chooses)(plan)).collect(),
        };
        let mut is_open = !search.searches.is_empty();
        while is_open {
            pass(&mut search)?;
            is_open = search.next_look();
        }
        let found = search.searches.into_iter().map(|search| search.found());
        Ok(Choices(found.collect()))
    }

    /// Takes in the rows `rows` of a strip, counted within it; the other rows are margin.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    ///
    /// # Panics
    /// If the plan is for a drawing.
    pub(crate) fn look(&mut self, strip: &Frame, rows: Range<usize>) -> Result<()> {
        let (runner, plan, inputs) = (self.runner, self.plan, RunInputs::default());
        assert!(plan.drawing.is_none(), "a drawing takes the picture whole");
        let top = strip.data_window.relative_to(self.whole).y0 as usize;
        let mut open: Vec<_> = self.searches.iter_mut().collect();
        let mut stages = Vec::new();
        if self.is_surveyed {
            open.retain_mut(|search| search.is_open());
            stages = making(plan, open.iter().flat_map(|search| search.takes(plan)));
        } else {
            self.extent.add(&strip.mask, rows.clone(), top);
        }
        let passage = Passage::new(runner, plan, inputs, Watch::default());
        let made = passage.go(RunFrame::Shared(strip), &stages)?;
        let mut run = Execution {
            strip: Some(StripRows {
                rows,
                top,
                whole: [self.whole.width(), self.whole.height()],
            }),
            made,
            ..Execution::new(runner, plan, strip, inputs)
        };
        for search in open {
            match self.is_surveyed {
                true => search.look(&mut run),
                false => search.survey(&run),
            }
        }
        runner.recycle(run.made.outcome);
        Ok(())
    }

    /// Ends a look, and returns whether all strips have to be passed again.
    fn next_look(&mut self) -> bool {
        let searches = self.searches.iter_mut();
        let mut samples: Vec<_> = searches.flat_map(|search| search.samples()).collect();
        for sample in &mut samples {
            match self.is_surveyed {
                true => sample.end_look(),
                false => sample.begin(&self.extent),
            }
        }
        self.is_surveyed = true;
        samples.iter().any(|sample| sample.is_open())
    }
}

/// The stages that make these products, and what they take, in order.
fn making(plan: &Plan, wanted: impl Iterator<Item = Product>) -> Vec<&'static Stage> {
    let (mut wanted, mut making): (Vec<_>, _) = (wanted.collect(), VecDeque::new());
    for stage in plan.stages.iter().rev() {
        if stage.gives().any(|product| wanted.contains(&product)) {
            wanted.extend((stage.takes)(plan));
            making.push_front(*stage);
        }
    }
    making.into()
}

impl Choices {
    /// Fixes in a plan what it leaves open.
    pub(crate) fn settle(&self, plan: &mut Plan) {
        self.0.iter().for_each(|settle| settle(plan));
    }
}
