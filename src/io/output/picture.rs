//! The picture of a result, and what a display has of it.

use super::rec709::{converted, rec709_from};
use crate::frame::{ColorPlanes, Frame, Mask, Plane};
use crate::io::colorspace::Chromaticities;
use crate::io::picture::{Bright, Brightness, Display, Picture, ViewTransform};
use crate::line::bilevel::bilevel;
use crate::line::paper::on_paper;
use crate::params::{DisplayParams, DisplayView, Exposure, Highlights, Ink, Params};
use crate::plan::outcome::Outcome;
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
    /// The frame's picture, enhanced. A plan with nothing to do leaves it unchanged.
    pub(crate) fn enhanced(frame: &'a Frame, outcome: &'a Outcome) -> Option<Self> {
        let before = frame.color.as_ref();
        Some(Self {
            color: Cow::Borrowed(outcome.color.as_ref().or(before)?),
            before,
            like: None,
            form: Form::Light,
        })
    }

    /// The surface in new light. It is derived from the frame's own picture where only a share of it is blended in, overall
    /// or per pixel.
    pub(crate) fn relit(frame: &'a Frame, outcome: &'a Outcome, params: &Params) -> Option<Self> {
        let is_mixed = params.mix != 1.0 || frame.strength.is_some();
        Some(Self {
            color: Cow::Borrowed(outcome.color.as_ref()?),
            before: frame.color.as_ref().filter(|_| is_mixed),
            like: frame.color.as_ref().filter(|_| outcome.takes_picture),
            form: Form::Light,
        })
    }

    /// The curvature display, whose colours are those of a screen already.
    pub(crate) fn curvature(frame: &Frame, outcome: &'a Outcome, params: &Params) -> Option<Self> {
        let form = Form::Shown {
            grey: false,
            bits: 8,
            dpi: params.dpi(frame.pixel_aspect),
            transform: ViewTransform::None,
        };
        let color = Cow::Borrowed(outcome.color.as_ref()?);
        Some(Self::shown(color, form))
    }

    /// The drawing on its paper, of pixels `pixel_aspect` times as wide as high.
    pub(crate) fn drawn(outcome: &'a Outcome, params: &Params, pixel_aspect: f32) -> Option<Self> {
        let strokes = params.line.strokes;
        let is_bilevel = strokes.ink == Ink::Bilevel;
        let has_size = params.size.is_some() || strokes.dpi.is_some();
        let dpi = strokes.print_dpi();
        let form = Form::Shown {
            grey: true,
            bits: if is_bilevel { 1 } else { 8 },
            dpi: (is_bilevel || has_size).then_some([dpi / pixel_aspect, dpi]),
            transform: transform(params.display.view_transform),
        };
        let color = match &outcome.drawing {
            Some(drawing) => Cow::Owned(on_paper(&drawing.layers())),
            None => Cow::Borrowed(outcome.color.as_ref()?),
        };
        Some(Self::shown(color, form))
    }

    /// Colours of something other than light.
    pub(crate) fn shown(color: Cow<'a, ColorPlanes>, form: Form) -> Self {
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
                color: Cow::Owned(ColorPlanes::grey(bilevel(&self.color.r))),
                ..self
            },
            _ => self,
        }
    }

    /// Whether the exposure is still to be chosen: AgX and Filmic have room for bright light, and linear numbers stay.
    pub(crate) fn leaves_exposure(&self, display: &DisplayParams) -> bool {
        let (exposure, view) = (display.exposure, display.view_transform);
        exposure == Exposure::Auto
            && matches!(view, DisplayView::Standard | DisplayView::Srgb)
            && self.before.is_none()
            && self.form == Form::Light
    }

    /// Automatic exposure in stops for this surface; `None` where it is given.
    pub(crate) fn exposure(&self, display: &DisplayParams, mask: &Mask) -> Option<f32> {
        self.leaves_exposure(display).then(|| {
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
    display: DisplayParams,
    exposure: f32,
}

#[cfg(feature = "cli")]
impl Displayed<'_> {
    /// The picture that it was derived from.
    pub(crate) fn before(&self) -> Option<&ColorPlanes> {
        self.before.as_deref()
    }

    /// Whether it shows linear light.
    pub(crate) fn is_light(&self) -> bool {
        self.form == Form::Light
    }
}

impl Displayed<'_> {
    /// As it goes to a file or a screen.
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
        let bright = match (
            self.display.view_transform,
            self.display.highlights,
            &self.before,
        ) {
            (DisplayView::Agx, ..) => Bright::Agx,
            (DisplayView::Filmic, ..) => Bright::Filmic,
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
            ..Picture::of(&self.color, transform(self.display.view_transform))
        }
    }
}

/// The encoding of values for a display.
fn transform(view: DisplayView) -> ViewTransform {
    match view {
        DisplayView::None => ViewTransform::None,
        _ => ViewTransform::Srgb,
    }
}

impl Params {
    /// Pixels per inch as given, across and down, of pixels so many times as wide as high.
    pub(crate) fn dpi(&self, pixel_aspect: f32) -> Option<[f32; 2]> {
        let dpi = self.line.strokes.dpi?;
        Some([dpi / pixel_aspect, dpi])
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
        let is_linear = self.display.view_transform == DisplayView::None;
        let turn = primaries.and_then(rec709_from);
        let turn = turn.filter(|_| !is_linear && made.form == Form::Light);
        let turned = |color: Cow<'a, ColorPlanes>| match turn {
            Some(matrix) => Cow::Owned(converted(&color, matrix)),
            None => color,
        };
        let exposure = match self.display.exposure {
            Exposure::Auto => chosen.unwrap_or(0.0),
            Exposure::Stops(stops) => stops,
        };
        Displayed {
            color: turned(made.color),
            before: made.before.map(|before| turned(Cow::Borrowed(before))),
            alpha: frame.alpha.as_ref(),
            form: made.form,
            bits,
            dpi: self.dpi(frame.pixel_aspect),
            display: self.display,
            exposure,
        }
    }
}
