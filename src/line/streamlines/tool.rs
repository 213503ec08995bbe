//! Drawing tools: the distance and the width of their lines.

use crate::params::{Stroke, Style};

/// A drawing tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Tool {
    /// Lines at distances that follow the tone, a little wider in the dark.
    Nib(Nib),
    /// Evenly spaced lines whose widths follow the tone, pointed at both ends.
    Burin(Burin),
}

/// A pen, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nib {
    /// Width in a middle tone.
    pub width: f32,
    /// Share of that, 0..1, by which it varies with tone.
    pub pressure: f32,
    /// Distance between lines in the lightest tone that is drawn.
    pub widest_spacing: f32,
    /// Longest line.
    pub longest: f32,
}

/// An engraver's tool, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Burin {
    /// Width of the thinnest and of the widest line.
    pub widths: [f32; 2],
    /// Distance between lines; more where the thinnest would be too dark.
    pub spacing: f32,
    /// Longest line.
    pub longest: f32,
}

/// Smallest distance from another line, as a share of that wanted. [JL] finds 0.5 to 0.9: higher values give more and
/// shorter lines.
const TEST: f32 = 0.6;

/// Smallest distance between lines, in widths: closer ones leave no paper and only cost time.
const TOUCHING: f32 = 1.1;

/// Smallest distance between lines, in pixels: the picture has no finer detail.
const CLOSEST: f32 = 1.0;

/// Shortest line of a pen, in widths, and of a burin, in distances.
const SHORTEST: f32 = 4.0;
const SHORTEST_ENGRAVED: f32 = 1.0;

/// Distance between lines in the lightest tone that is drawn over that in a light tone.
const WIDEST: f32 = 4.0;

/// Steps of darkness in which a burin works, from dark to light.
const LEVELS: usize = 8;

/// Least side of a cell of points, in pixels.
const LEAST_SIDE: f32 = 3.0;

impl Tool {
    /// The tool of such strokes.
    pub(crate) fn of(stroke: &Stroke, style: Style) -> Self {
        let widest_spacing = WIDEST * stroke.spacing_px;
        let (width, longest) = (stroke.width_px, stroke.length_px);
        match style {
            Style::Engraving => Self::Burin(Burin {
                widths: [(1.0 - stroke.pressure) * width, width],
                spacing: stroke.spacing_px.max(CLOSEST),
                longest,
            }),
            _ => Self::Nib(Nib {
                width,
                pressure: stroke.pressure,
                widest_spacing,
                longest,
            }),
        }
    }

    /// The distance between lines that cover a share `ink` of the paper.
    #[inline]
    pub(super) fn spacing(&self, ink: f32) -> f32 {
        match self {
            Self::Nib(nib) => {
                // Thin lines in light tones, thick ones in dark tones.
                let width = nib.width * (1.0 + nib.pressure * (2.0 * ink - 1.0));
                let least = (TOUCHING * width).max(CLOSEST);
                (width / ink).clamp(least, nib.widest_spacing.max(least))
            }
            Self::Burin(burin) => {
                (burin.widths[0] / ink).clamp(burin.spacing, WIDEST * burin.spacing)
            }
        }
    }

    /// The distance from another line at which a line ends where `ink` is wanted.
    #[inline]
    pub(super) fn least_distance(&self, ink: f32) -> f32 {
        TEST * self.spacing(ink)
    }

    /// The least distance between lines wherever.
    fn closest(&self) -> f32 {
        match self {
            Self::Nib(_) => (TOUCHING * self.widths()[1]).max(CLOSEST),
            Self::Burin(burin) => burin.spacing,
        }
    }

    /// Distance of points along a line, small enough that no other line passes between them.
    pub(super) fn step(&self) -> f32 {
        let most = match self {
            Self::Nib(_) => 0.8 * TEST,
            Self::Burin(_) => 0.4 * TEST,
        };
        (most * self.closest()).min(match self {
            Self::Nib(_) => 1.0,
            Self::Burin(_) => 2.0,
        })
    }

    /// Points of lines in a pixel where all is black, at most.
    #[cfg(feature = "cli")]
    pub(crate) fn most_points_per_px(&self) -> f32 {
        (self.closest() * self.step()).recip()
    }

    /// The widths it can draw.
    pub(super) fn widths(&self) -> [f32; 2] {
        match self {
            Self::Nib(nib) => {
                [1.0 - nib.pressure, 1.0 + nib.pressure].map(|share| share * nib.width)
            }
            Self::Burin(burin) => burin.widths,
        }
    }

    /// The least ink that is drawn: of the thinnest lines at the widest distance.
    pub(super) fn least_ink(&self) -> f32 {
        let least = match self {
            Self::Nib(nib) => self.widths()[0].max(0.2 * nib.width) / nib.widest_spacing,
            Self::Burin(burin) => {
                burin.widths[0].max(0.02 * burin.spacing) / (WIDEST * burin.spacing)
            }
        };
        least.min(0.5)
    }

    /// The longest line.
    pub(super) fn longest(&self) -> f32 {
        match self {
            Self::Nib(nib) => nib.longest,
            Self::Burin(burin) => burin.longest,
        }
    }

    /// Lines shorter than that are left out.
    pub(super) fn shortest(&self) -> f32 {
        match self {
            Self::Nib(nib) => SHORTEST * nib.width,
            Self::Burin(burin) => SHORTEST_ENGRAVED * burin.spacing,
        }
    }

    /// Pixels between the places where lines are tried.
    pub(super) fn every(&self) -> usize {
        let [least, every] = match self {
            Self::Nib(nib) => [2.0, 0.5 * nib.width],
            Self::Burin(burin) => [1.0, 0.4 * burin.spacing],
        };
        every.max(least) as usize
    }

    /// Room around seeds, as shares of the distance wanted, round by round: when no more lines fit at that distance, a
    /// burin fills gaps beside edges. Up to rounding.
    pub(super) fn rooms(&self) -> &'static [f32] {
        match self {
            Self::Nib(_) => &[0.99],
            Self::Burin(_) => &[0.99, 0.7],
        }
    }

    /// Number of levels of darkness, starting at the darkest.
    pub(super) fn levels(&self) -> usize {
        match self {
            Self::Nib(_) => 1,
            Self::Burin(_) => LEVELS,
        }
    }

    /// The level of darkness of a place where `ink`, 0..1, is wanted: 0 is the lightest.
    #[inline]
    pub(super) fn level(&self, ink: f32) -> usize {
        let levels = self.levels();
        ((ink * levels as f32) as usize).min(levels - 1)
    }

    /// The side of cells of points that finds neighbours soonest.
    pub(super) fn cell_side(&self) -> f32 {
        self.closest().max(LEAST_SIDE)
    }
}
