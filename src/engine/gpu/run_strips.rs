//! Plans on the strips of a picture, with automatic choices from the whole.

use crate::engine::cpu::gpu_support::term_white_levels;
use crate::engine::gpu::constants::{GAIN, WHITE};
use crate::engine::gpu::runner::{Beside, Runner};
use crate::engine::outcome::Outcome;
use crate::engine::tiles::{Strips, strip_of};
use crate::error::Result;
use crate::frame::Frame;
use crate::light::enhancement::Subject;
use crate::light::radiance_scaling::gpu::known_white_level;
use crate::light::white_level::chosen_for;
use crate::params::Adaptive;
use crate::plan::Plan;
use crate::shape::auto_levels::gpu::{Pass, Search, Searching, lattice_over};
use std::ops::Range;

impl Runner {
    /// Runs `plan` on the strips of a frame, with automatic choices from the whole frame.
    pub(crate) fn run_strips(
        &self,
        plan: &Plan,
        frame: &Frame,
        beside: Beside,
        strips: &Strips,
    ) -> Result<Outcome> {
        let mut plan = plan.clone();
        let chosen = self.choose(&plan, frame, beside, strips)?;
        if plan.chooses_gain() {
            plan.scaling.curvature_gain = Adaptive::Fixed(chosen[GAIN as usize]);
        }
        if chosen_for(&plan) == Some(Subject::Picture) {
            plan.scaling.white_level = Adaptive::Fixed(chosen[WHITE as usize]);
        }
        if chosen_for(&plan) == Some(Subject::Lobes) {
            let levels = term_white_levels(frame, &plan.scaling);
            let known = plan.scaling.term_white_levels;
            plan.scaling.term_white_levels = known.or(levels.into_iter());
        }
        let run =
            |strip: &Frame, rows: &Range<usize>| self.run_strip(&plan, strip, beside, rows.clone());
        strips.run(frame, run, drop)
    }

    /// Gain and white level of the whole picture, where they are left open.
    fn choose(
        &self,
        plan: &Plan,
        frame: &Frame,
        beside: Beside,
        strips: &Strips,
    ) -> Result<[f32; 2]> {
        let gain = plan.chooses_gain().then(|| Search::Gain {
            size: [frame.mask.width(), frame.mask.height()],
            factor: plan.resolution_factor as f32,
            most: plan.most_gain(),
        });
        let is_open =
            chosen_for(plan) == Some(Subject::Picture) && known_white_level(plan, frame).is_none();
        let white = is_open.then(|| Search::White(frame.luminance_weights()));
        let searches: Vec<Search> = gain.into_iter().chain(white).collect();
        self.search((plan, frame), beside, &searches, strips)
    }

    /// Results of the searches over the shape and the picture of a frame; 1 where there is no search.
    fn search(
        &self,
        (plan, frame): (&Plan, &Frame),
        beside: Beside,
        searches: &[Search],
        strips: &Strips,
    ) -> Result<[f32; 2]> {
        let mut found = vec![1.0; 2];
        if searches.is_empty() {
            return Ok([1.0; 2]);
        }
        let of_shape = searches.iter().any(|search| !search.is_of_picture());
        let picture = frame.color.as_ref();
        let picture = picture.filter(|_| searches.iter().any(Search::is_of_picture));
        let lattice = lattice_over(&frame.mask);
        let mut searching: Vec<Searching> = Vec::new();
        let mut looks_again = false;
        for pass in Pass::all() {
            if pass.begins_again() && !looks_again {
                break;
            }
            for (takes, gives) in strips.each() {
                strips.check()?;
                let strip = strip_of(frame, &takes);
                let mut run = self.start(plan, &strip, beside);
                let fresh = searches.iter().skip(searching.len());
                let fresh = fresh.map(|&search| Searching::new(&mut run, search, lattice.clone()));
                let fresh: Vec<_> = fresh.collect();
                searching.extend(fresh);
                let shape = of_shape.then(|| run.find_shape());
                let picture = picture.map(|picture| self.upload().rows(picture, &takes));
                let rows = gives.start as u32..gives.end as u32;
                for (search, kind) in searching.iter().zip(searches) {
                    let planes = match (kind.is_of_picture(), &shape, &picture) {
                        (false, Some(shape), _) => shape.of_gain(),
                        (true, _, Some(picture)) => picture.each_ref(),
                        _ => continue,
                    };
                    search.count(&mut run, pass, planes, rows.clone(), takes.start as u32);
                }
                if takes.start + gives.end == frame.mask.height() {
                    let chosen = run.chosen.clone();
                    searching
                        .iter()
                        .for_each(|s| s.narrow(&mut run, pass, &chosen));
                }
                let chosen = run.chosen.clone();
                let states = searching.iter().map(|search| &search.state);
                let wanted: Vec<_> = std::iter::once(&chosen).chain(states).collect();
                let mut read = run.read(&wanted)?.into_iter();
                run.finish();
                found = read.next().expect("what was chosen is read");
                let mut searches = searching.iter().zip(read);
                looks_again = searches.any(|(search, state)| search.looks_again(&state));
                let shape = shape.into_iter().flat_map(|shape| shape.into_buffers());
                self.buffers.recycle(shape);
                self.buffers.recycle_copied(picture.into_iter().flatten());
            }
        }
        let searching = searching.into_iter();
        self.buffers
            .recycle(searching.flat_map(Searching::into_buffers));
        Ok([found[GAIN as usize], found[WHITE as usize]])
    }
}
