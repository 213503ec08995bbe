//! The picture of a result, and what a display has of it.

use super::rec709::{converted, rec709_from};
use crate::command::args::{View, WorkArgs};
use crate::engine::outcome::Outcome;
use crate::frame::{ColorPlanes, Frame, Mask, Plane};
use crate::io::colorspace::Chromaticities;
use crate::io::picture::{Bright, Brightness, Display, Picture, ViewTransform};
use crate::light::mixing::mix;
use crate::line::bilevel::bilevel;
use crate::params::{DisplayParams, Exposure, Highlights};
use std::borrow::Cow;

/// A result picture.
#[derive(Debug, Clone)]
pub(crate) struct MadePicture<'a> {
    pub(crate) color: Cow<'a, ColorPlanes>,
    /// The picture it was derived from; `None` where it was lit anew.
    pub(crate) before: Option<&'a ColorPlanes>,
    /// The picture that it is to be as bright as, where its surface was lit anew.
    pub(crate) like: Option<&'a ColorPlanes>,
    pub(crate) form: Form,
}

/// The way that the colours of a picture go to a display.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Form {
    /// Linear light, by exposure and view transform.
    Light,
    /// Colours or grey of something else, as they are.
    Shown {
        grey: bool,
        bits: u8,
        dpi: Option<[f32; 2]>,
        transform: ViewTransform,
    },
}

impl<'a> MadePicture<'a> {
    /// Colours of something other than light.
    pub(super) fn shown(color: Cow<'a, ColorPlanes>, form: Form) -> Self {
        Self {
            color,
            before: None,
            like: None,
            form,
        }
    }

    /// As it is printed: a single bit holds ink that is there or not.
    pub(crate) fn printed(self) -> Self {
        match self.form {
            Form::Shown { bits: 1, .. } => Self {
                color: Cow::Owned(without_grey(&self.color)),
                ..self
            },
            _ => self,
        }
    }

    /// Whether the exposure is still to be chosen: AgX and Filmic have room for bright light, and linear numbers stay.
    pub(crate) fn leaves_exposure(&self, work: &WorkArgs) -> bool {
        work.flags.params.display.exposure == Exposure::Auto
            && work.output.view_transform == View::Standard
            && self.before.is_none()
            && self.form == Form::Light
    }

    /// Automatic exposure in stops for this surface; `None` where it is given.
    pub(crate) fn exposure(&self, work: &WorkArgs, mask: &Mask) -> Option<f32> {
        self.leaves_exposure(work).then(|| {
            let mut brightness = Brightness::default();
            brightness.add(&self.color, self.like, mask, 0..mask.height());
            brightness.exposure()
        })
    }
}

/// A picture as sent to a display, in Rec. 709 primaries.
pub(crate) struct Displayed<'a> {
    color: Cow<'a, ColorPlanes>,
    before: Option<Cow<'a, ColorPlanes>>,
    alpha: Option<&'a Plane>,
    form: Form,
    /// How linear light is stored.
    bits: u8,
    dpi: Option<[f32; 2]>,
    view: View,
    exposure: f32,
    highlights: Highlights,
}

impl Displayed<'_> {
    /// The picture that it was derived from.
    pub(crate) fn before(&self) -> Option<&ColorPlanes> {
        self.before.as_deref()
    }

    /// Whether it shows linear light.
    pub(crate) fn is_light(&self) -> bool {
        self.form == Form::Light
    }

    pub(crate) fn picture(&self) -> Picture<'_> {
        if let Form::Shown {
            grey,
            bits,
            dpi,
            transform,
        } = self.form
        {
            return Picture {
                grey,
                bits,
                dpi,
                ..Picture::of(&self.color, transform)
            };
        }
        let bright = match (self.view, self.highlights, &self.before) {
            (View::Agx, ..) => Bright::Agx,
            (View::Filmic, ..) => Bright::Filmic,
            (_, Highlights::Clip, _) => Bright::Clipped,
            (_, Highlights::Compress, None) => Bright::Compressed,
            (_, Highlights::Compress, Some(before)) => Bright::ChangedFrom(before),
        };
        Picture {
            alpha: self.alpha,
            bits: self.bits,
            dpi: self.dpi,
            display: Display {
                exposure: self.exposure,
                bright,
            },
            ..Picture::of(&self.color, self.view.transform())
        }
    }
}

impl WorkArgs {
    /// Pixels per inch as given, across and down.
    pub(crate) fn dpi(&self, frame: &Frame) -> Option<[f32; 2]> {
        let dpi = self.flags.params.line.strokes.dpi?;
        Some([dpi / frame.pixel_aspect, dpi])
    }

    /// A result for a display, light in so many `bits` and converted from the file's primaries; `chosen` is the exposure
    /// where none was given.
    pub(crate) fn displayed<'a>(
        &self,
        frame: &'a Frame,
        primaries: Option<Chromaticities>,
        made: MadePicture<'a>,
        bits: u8,
        chosen: Option<f32>,
    ) -> Displayed<'a> {
        let made = made.printed();
        let view = self.output.view_transform;
        let turn = primaries.and_then(rec709_from);
        let turn = turn.filter(|_| view != View::None && made.form == Form::Light);
        let turned = |color: Cow<'a, ColorPlanes>| match turn {
            Some(matrix) => Cow::Owned(converted(&color, matrix)),
            None => color,
        };
        let DisplayParams {
            exposure,
            highlights,
        } = self.flags.params.display;
        let exposure = match exposure {
            Exposure::Auto => chosen.unwrap_or(0.0),
            Exposure::Stops(stops) => stops,
        };
        Displayed {
            color: turned(made.color),
            before: made.before.map(|before| turned(Cow::Borrowed(before))),
            alpha: frame.alpha.as_ref(),
            form: made.form,
            bits,
            dpi: self.dpi(frame),
            view,
            exposure,
            highlights,
        }
    }
}

/// Blends the picture made of `frame` with its own by the requested share, overall and per pixel.
pub(super) fn mix_color(work: &WorkArgs, frame: &Frame, outcome: &mut Outcome) {
    if let Some(made) = &mut outcome.color {
        let params = &work.flags.params;
        let before = frame.color.as_ref();
        mix(made, before, frame.strength.as_ref(), params.mix);
        if let Some(confidence) = &frame.confidence {
            let kept = confidence.map(|confidence| 1.0 - params.blur_fade * (1.0 - confidence));
            mix(made, before, Some(&kept), 1.0);
        }
    }
}

/// Ink that is there or not.
fn without_grey(color: &ColorPlanes) -> ColorPlanes {
    let light = bilevel(&color.r);
    ColorPlanes::grey(light)
}
