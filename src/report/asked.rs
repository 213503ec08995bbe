//! The subject of a report: a frame, and the extent of the measurements.

use crate::frame::{Frame, Mask};
use crate::params::ShapeParams;
use crate::report::surface::Surface;
use crate::report::timing::Effort;
use crate::untrusted::Untrusted;
use serde::Serialize;
use std::fmt::{self, Display};

/// Extent of the measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// All scales, scenes of 480x360.
    Full,
    /// The given scale and one more, scenes of 320x240, fewer runs.
    Quick,
}

/// The frame measured by some rows, or the part of it.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct On {
    pub name: String,
    pub width: usize,
    pub height: usize,
    /// Number of pixels that show a surface.
    pub covered: usize,
}

impl On {
    pub(super) fn new(name: &str, mask: &Mask) -> Self {
        Self {
            name: name.into(),
            width: mask.width(),
            height: mask.height(),
            covered: mask.count(),
        }
    }
}

/// Name and size.
impl Display for On {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Untrusted(&self.name);
        write!(f, "{name}, {}x{}", self.width, self.height)
    }
}

impl On {
    /// Name and size as text of Markdown.
    pub(super) fn markdown(&self) -> String {
        let name = Untrusted(&self.name).markdown();
        format!("{name}, {}x{}", self.width, self.height)
    }
}

/// The frame of a report, and how to measure it.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub(crate) name: &'a str,
    pub(crate) frame: &'a Frame,
    /// The surface that it was made from.
    pub(crate) surface: &'a Surface,
    pub(crate) shape: ShapeParams,
    pub(crate) extent: Extent,
    /// Whether what is not of the frame is measured too: exact scenes, light, drawings, mirrors, stiff cases.
    pub(crate) beyond: bool,
    /// Called with the name of the next measurement.
    pub(crate) progress: &'a dyn Fn(&str),
}

impl Asked<'_> {
    pub(super) fn progress(&self, next: &str) {
        (self.progress)(&format!("{}: {next}", self.name));
    }

    /// Number of runs per measurement.
    pub(super) fn effort(&self) -> Effort {
        match self.extent {
            Extent::Full => Effort::new(7, 250),
            Extent::Quick => Effort::new(5, 150),
        }
    }
}
