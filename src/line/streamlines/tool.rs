//! Drawing tools: the distance and the width of their lines.

use crate::params::{Stroke, Style};

/// A drawing tool, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tool {
    /// Width of the thinnest and of the widest line.
    pub(super) widths: [f32; 2],
    /// Width of lines at the distance for their tone, in a middle one, and the share of that by which it varies with tone.
    width: f32,
    pressure: f32,
    /// Least distance between lines, and the same in widths.
    pub(super) least_spacing: f32,
    touching: f32,
    /// Distance between lines in the lightest tone that is drawn, unless they are wider.
    widest_spacing: f32,
    /// The least ink that is drawn: of the thinnest lines at the widest distance.
    pub(super) least_ink: f32,
    /// Distance of points along a line, small enough that no other line passes between them.
    pub(super) step: f32,
    /// Longest and shortest line.
    pub(super) longest: f32,
    pub(super) shortest: f32,
    /// Distance between the places where lines are tried.
    pub(super) every: usize,
    /// Room around seeds, as shares of the distance wanted, round by round: when no more lines fit at that distance, a
    /// burin fills gaps beside edges. Up to rounding.
    pub(super) rooms: &'static [f32],
    /// Number of levels of darkness, starting at the darkest.
    pub(super) levels: usize,
    /// Whether lines swell with the tone, pointed at both ends.
    pub(super) swells: bool,
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
const SHORTEST_ENGRAVED: f32 = 2.0;

/// Distance between lines in the lightest tone that is drawn over that in a light tone.
const WIDEST: f32 = 4.0;

/// Steps of darkness in which a burin works, from dark to light.
const LEVELS: usize = 8;

/// Least side of a cell of points, in pixels.
const LEAST_SIDE: f32 = 3.0;

impl Tool {
    /// The tool of such strokes.
    pub(crate) fn of(stroke: &Stroke, style: Style) -> Self {
        let Stroke {
            width_px: width,
            length_px: longest,
            pressure,
            ..
        } = *stroke;
        match style {
            Style::Engraving => {
                let spacing = stroke.spacing_px.max(CLOSEST);
                Self::burin([(1.0 - pressure) * width, width], spacing, longest)
            }
            _ => Self::pen(width, pressure, WIDEST * stroke.spacing_px, longest),
        }
    }

    /// Lines at distances that follow the tone up to the widest, a little wider in the dark, by a share of their width in
    /// a middle tone.
    pub(super) fn pen(width: f32, pressure: f32, widest_spacing: f32, longest: f32) -> Self {
        let widths = [1.0 - pressure, 1.0 + pressure].map(|share| share * width);
        let closest = (TOUCHING * widths[1]).max(CLOSEST);
        Self {
            widths,
            width,
            pressure,
            least_spacing: CLOSEST,
            touching: TOUCHING,
            widest_spacing,
            least_ink: (widths[0].max(0.2 * width) / widest_spacing).min(0.5),
            step: (0.8 * TEST * closest).min(1.0),
            longest,
            shortest: SHORTEST * width,
            every: (0.5 * width).max(2.0) as usize,
            rooms: &[0.99],
            levels: 1,
            swells: false,
        }
    }

    /// Evenly spaced lines whose widths follow the tone, pointed at both ends; farther apart where the thinnest would be
    /// too dark.
    pub(super) fn burin(widths: [f32; 2], spacing: f32, longest: f32) -> Self {
        let widest_spacing = WIDEST * spacing;
        Self {
            widths,
            width: widths[0],
            pressure: 0.0,
            least_spacing: spacing,
            touching: 0.0,
            widest_spacing,
            least_ink: (widths[0].max(0.02 * spacing) / widest_spacing).min(0.5),
            step: (0.4 * TEST * spacing).min(2.0),
            longest,
            shortest: SHORTEST_ENGRAVED * spacing,
            every: (0.4 * spacing).max(1.0) as usize,
            rooms: &[0.99, 0.7],
            levels: LEVELS,
            swells: true,
        }
    }

    /// The distance between lines that cover a share `ink` of the paper.
    #[inline]
    pub(super) fn spacing(&self, ink: f32) -> f32 {
        // Thin lines in light tones, thick ones in dark tones.
        let width = self.width * (1.0 + self.pressure * (2.0 * ink - 1.0));
        let least = (self.touching * width).max(self.least_spacing);
        (width / ink).clamp(least, self.widest_spacing.max(least))
    }

    /// The distance from another line at which a line ends where `ink` is wanted.
    #[inline]
    pub(super) fn least_distance(&self, ink: f32) -> f32 {
        TEST * self.spacing(ink)
    }

    /// The least distance between lines wherever.
    fn closest(&self) -> f32 {
        (self.touching * self.widths[1]).max(self.least_spacing)
    }

    /// Points of lines in a pixel where all is black, at most.
    #[cfg(feature = "cli")]
    pub(crate) fn most_points_per_px(&self) -> f32 {
        (self.closest() * self.step).recip()
    }

    /// The level of darkness of a place where `ink`, 0..1, is wanted: 0 is the lightest.
    #[inline]
    pub(super) fn level(&self, ink: f32) -> usize {
        ((ink * self.levels as f32) as usize).min(self.levels - 1)
    }

    /// The side of cells of points that finds neighbours soonest.
    pub(super) fn cell_side(&self) -> f32 {
        self.closest().max(LEAST_SIDE)
    }
}
