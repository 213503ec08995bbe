//! What a command makes of a frame in memory: the steps of the command line between reading and writing.

use super::{FrameSeen, FrameWork, Results};
use crate::engine::{Engine, PlanInputs, Run};
use crate::error::Result;
use crate::frame::{Frame, SpecularScene};
use crate::io::colorspace::Chromaticities;
use crate::io::output::page::text_of;
use crate::io::output::picture::Displayed;
use crate::light::lights::Illumination;
use std::borrow::Cow;

/// A command and all that it is run on.
#[derive(Clone, Copy)]
pub(crate) struct Making<'a> {
    pub(crate) work: &'a dyn FrameWork,
    pub(crate) light: &'a Illumination,
    pub(crate) frame: &'a Frame,
    /// The scene seen in mirrors and lenses.
    pub(crate) specular: Option<&'a SpecularScene>,
    pub(crate) is_in_sequence: bool,
}

impl<'a> Making<'a> {
    /// Its frame, as it was read.
    pub(crate) fn seen(&self) -> FrameSeen<'a, 'a> {
        FrameSeen {
            is_specular: self.specular.is_some(),
            is_in_sequence: self.is_in_sequence,
            ..FrameSeen::new(self.frame, self.light)
        }
    }

    /// Runs the command.
    ///
    /// # Errors
    /// As [`Engine::run`]; [`crate::Error::BadParameter`] for settings that the frame does not allow.
    pub(crate) fn run(&self, engine: &Engine, run: &Run) -> Result<Results> {
        let work = self.work;
        let times = work.times(self.frame, self.specular.is_some(), !self.is_in_sequence)?;
        let scene = self.specular.filter(|_| times != 1.0);
        let scene = scene.map(|scene| run.install(|| scene.enlarged(self.frame, times)));
        let frame = match times == 1.0 {
            true => Cow::Borrowed(self.frame),
            false => Cow::Owned(run.enlarged(self.frame, times)?),
        };
        let (frame, art_map) = (&*frame, work.art_map()?);
        let mut made = work.begin(&work.reading(self.light)?.0, frame)?;
        let mut seen = FrameSeen {
            frame,
            times,
            ..self.seen()
        };
        for plan in work.plans(&mut seen)? {
            let inputs = PlanInputs {
                specular: scene.as_ref().or(self.specular),
                art_map: art_map.as_ref(),
                ..PlanInputs::lit_by(&seen.light)
            };
            let outcome = engine.execute(&plan, frame, inputs, run)?;
            engine.recycle(work.take(&mut made, &plan, outcome));
        }
        made.outcome.mix(frame, times, &work.args().flags.params);
        // The tone of a drawing is no picture, and a plan with nothing to do leaves the frame's.
        let color = match work
            .picture(frame, &made.outcome)
            .map(|p| p.printed().color)
        {
            Some(Cow::Borrowed(_)) if made.outcome.color.is_some() => None,
            color => color.map(Cow::into_owned),
        };
        made.outcome.color = color.or(made.outcome.color.take());
        if let Some(args) = work.maps() {
            for map in args.made(&made.maps, frame) {
                made.planes.extend(map?.named());
            }
        }
        let lines = work.lines(frame, &made.outcome);
        made.svg = lines.map(|lines| text_of(&lines)).transpose()?;
        Ok(made)
    }

    /// The picture as a PNG would hold it, and the exposure that was chosen for it; `None` where layers were made.
    pub(crate) fn shown(
        &self,
        made: &'a Results,
        primaries: Option<Chromaticities>,
    ) -> Option<(Displayed<'a>, Option<f32>)> {
        let params = &self.work.args().flags.params;
        let picture = self.work.picture(self.frame, &made.outcome)?;
        let exposure = picture.exposure(&params.display, &self.frame.mask);
        let shown = params.displayed(self.frame, primaries, picture, 8, exposure);
        Some((shown, exposure))
    }
}
