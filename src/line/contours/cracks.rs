//! The cracks between pixels that silhouettes pass.

use crate::frame::gap::of_frame::Gaps;
use crate::frame::rows::ROWS_PER_TASK;
use crate::frame::{Frame, Plane};
use crate::line::contours::crack::{border_offset, sharpened, spread_offset, unexplained_jump};
use crate::line::contours::lattice::Lattice;
use crate::line::contours::network::Spot;
use crate::line::contours::{log_depth_of, strength_of_gap};
use crate::params::{ShapeParams, SoftThreshold};
use glam::Vec2;
use rayon::prelude::*;

/// Steps of the lattice of pixel corners: a crack between two rows runs right, one between two columns down.
pub(crate) const RIGHT: usize = 0;
pub(crate) const DOWN: usize = 2;

/// Share of a jump that the map has to step by across the crack, once mixtures are parted.
const LEAST_STEP: f32 = 0.5;

/// A crack that a silhouette passes through.
pub(crate) struct Crack {
    /// Its upper or left corner.
    pub(crate) corner: u32,
    pub(crate) step: usize,
    pub(crate) spot: Spot,
}

/// The search for cracks.
pub(crate) struct Finder<'a> {
    frame: &'a Frame,
    map: Option<JumpsIn<'a>>,
}

/// What jumps at silhouettes.
enum JumpsIn<'a> {
    Depth(&'a Plane, Box<Gaps<'a>>),
    /// An occlusion map, and the size of its jumps.
    Occlusion(&'a Plane, SoftThreshold),
}

impl JumpsIn<'_> {
    fn plane(&self) -> &Plane {
        match self {
            Self::Depth(plane, _) | Self::Occlusion(plane, _) => plane,
        }
    }
}

/// A pixel, possibly beyond the picture.
type PixelAt = [i64; 2];

impl<'a> Finder<'a> {
    pub(crate) fn new(frame: &'a Frame, shape: &ShapeParams) -> Self {
        let depth = frame.depth.as_ref().map(|plane| {
            let gaps = Gaps::new(frame, plane, shape.silhouette);
            JumpsIn::Depth(plane, Box::new(gaps))
        });
        let occlusion = frame.occlusion.as_ref();
        let occlusion =
            occlusion.map(|plane| JumpsIn::Occlusion(plane, shape.occlusion_silhouette));
        Self {
            frame,
            map: depth.or(occlusion),
        }
    }

    /// The cracks that silhouettes pass where pixels beside them have a weight, by corner and step.
    pub(crate) fn cracks(&self, weight: &Plane) -> Vec<Crack> {
        let rows = (0..self.frame.mask.height() + 1).into_par_iter();
        let rows = rows.with_min_len(ROWS_PER_TASK);
        rows.flat_map_iter(|y| self.cracks_of_row(weight, y))
            .collect()
    }

    /// Cracks to the right of and below the corners of a row. Only pixels within two of a silhouette have a weight: of an
    /// edge that a filter spread, those of its largest gap.
    fn cracks_of_row(&self, weight: &Plane, y: usize) -> Vec<Crack> {
        let (width, height) = (weight.width(), weight.height());
        let none = vec![0.0; width];
        let rows = [-2, -1, 0, 1].map(|i| {
            let inside = y.checked_add_signed(i).filter(|&y| y < height);
            inside.map_or(&none[..], |y| weight.row(y))
        });
        let here = rows[2];
        let mut found = Vec::new();
        for x in 0..width {
            let columns = x.saturating_sub(2)..(x + 2).min(width);
            let passed = [
                (RIGHT, rows.iter().any(|row| row[x] > 0.0)),
                (DOWN, here[columns].iter().any(|&weight| weight > 0.0)),
            ];
            for (step, _) in passed.into_iter().filter(|(_, is_marked)| *is_marked) {
                let corner = (y * (width + 1) + x) as u32;
                let spot = self.spot(Across::leaving([x, y], step));
                found.extend(spot.map(|spot| Crack { corner, step, spot }));
            }
        }
        found
    }

    fn inside(&self, [x, y]: PixelAt) -> Option<[usize; 2]> {
        let mask = &self.frame.mask;
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < mask.width() && y < mask.height()).then_some([x, y])
    }

    fn is_covered(&self, pixel: PixelAt) -> bool {
        self.inside(pixel)
            .is_some_and(|[x, y]| self.frame.mask.at(x, y))
    }

    /// The logarithm of depth of a covered pixel, 0 where depth is unknown.
    fn log_depth(&self, pixel: PixelAt) -> f32 {
        let pixel = self
            .inside(pixel)
            .map(|[x, y]| y * self.frame.mask.width() + x);
        let log = pixel.and_then(|pixel| log_depth_of(self.frame, pixel));
        log.unwrap_or(0.0)
    }

    /// The silhouette through a crack, if there is one.
    fn spot(&self, crack: Across) -> Option<Spot> {
        self.inside(crack.pixel(0))?;
        self.inside(crack.pixel(1))?;
        match [0, 1].map(|i| self.is_covered(crack.pixel(i))) {
            [false, false] => None,
            [true, true] => self.jump(&crack),
            [first, _] => Some(self.border(&crack, first)),
        }
    }

    /// The border of coverage, which the pixel before the crack is within if it is the `first`.
    fn border(&self, crack: &Across, first: bool) -> Spot {
        let beyond = |i: i64| crack.pixel(if first { i } else { 1 - i });
        let offset = self.coverage_offset(beyond);
        Spot {
            at: crack.place(if first { offset } else { -offset }),
            strength: 1.0,
            log_depth: self.log_depth(beyond(0)),
            is_beside: false,
        }
    }

    /// Offset of the edge beyond the crack by alpha, 0 without alpha; `beyond(0)` is covered, `beyond(1)` is not.
    fn coverage_offset(&self, beyond: impl Fn(i64) -> PixelAt) -> f32 {
        let Some(alpha) = &self.frame.alpha else {
            return 0.0;
        };
        let at = |i: i64| self.inside(beyond(i)).map_or(0.0, |[x, y]| alpha.at(x, y));
        border_offset([at(-1), at(0), at(1), at(2)])
    }

    /// Cracks that lead from an end of a line to the end beside it: where a filter spread an edge that runs
    /// almost along rows, or columns, the steps between them are too gentle to be distinguished from slopes.
    pub(crate) fn risers(&self, lattice: &Lattice) -> Vec<Crack> {
        let linked = lattice.linked.iter().copied();
        let ends = linked.filter(|&corner| lattice.degree(corner) == 1);
        let pairs = ends.flat_map(|corner| [RIGHT, DOWN].map(|step| (corner, step)));
        let beside = |(corner, step): &(u32, usize)| {
            let to = lattice.neighbour(*corner, *step);
            to.is_some_and(|to| lattice.degree(to) == 1)
        };
        pairs
            .filter(beside)
            .filter_map(|(corner, step)| {
                let crack = Across::leaving(lattice.place(corner), step);
                let spot = self.riser(&crack)?;
                Some(Crack { corner, step, spot })
            })
            .collect()
    }

    /// The map at a pixel that is covered.
    fn value(&self, pixel: PixelAt) -> Option<f32> {
        let [x, y] = self.inside(pixel)?;
        let value = self.map.as_ref()?.plane().at(x, y);
        (self.frame.mask.at(x, y) && value.is_finite()).then_some(value)
    }

    /// The map at a pixel, parted from what a filter mixed into it.
    fn sharp(&self, [x, y]: PixelAt) -> Option<f32> {
        let around = (0..9).filter_map(|j| self.value([x + j % 3 - 1, y + j / 3 - 1]));
        Some(sharpened(self.value([x, y])?, around))
    }

    /// The spot of a crack across which depth steps by enough once mixtures are parted.
    fn riser(&self, crack: &Across) -> Option<Spot> {
        let pixels = [crack.pixel(0), crack.pixel(1)];
        let sharp = [self.sharp(pixels[0])?, self.sharp(pixels[1])?];
        let raw = [self.value(pixels[0])?, self.value(pixels[1])?];
        let (size, least) = match self.map.as_ref()? {
            JumpsIn::Depth(_, gaps) => {
                let scale = &gaps.scale;
                (scale.jump_px(sharp, crack.direction()), scale.threshold.lo)
            }
            JumpsIn::Occlusion(_, threshold) => ((sharp[1] - sharp[0]).abs(), threshold.lo),
        };
        (size > least).then(|| self.jump_spot(crack, size, spread_offset(raw, sharp)))
    }

    /// The spot of a jump of this size: of a gap in pixels, or of an occlusion map.
    fn jump_spot(&self, crack: &Across, size: f32, offset: f32) -> Spot {
        Spot {
            at: crack.place(offset),
            strength: match &self.map {
                Some(JumpsIn::Depth(_, gaps)) => strength_of_gap(size / gaps.scale.side),
                _ => size.min(1.0),
            },
            log_depth: self
                .log_depth(crack.pixel(0))
                .min(self.log_depth(crack.pixel(1))),
            is_beside: self.is_beside_border(crack),
        }
    }

    /// The silhouette between two covered pixels.
    fn jump(&self, crack: &Across) -> Option<Spot> {
        let samples = [-2, -1, 0, 1, 2, 3].map(|i| self.value(crack.pixel(i)));
        let jump = unexplained_jump(&samples);
        let size = match self.map.as_ref()? {
            JumpsIn::Depth(_, gaps) => {
                gaps.seen_after(self.inside(crack.pixel(0))?, crack.direction())?
            }
            JumpsIn::Occlusion(_, threshold) => Some(jump).filter(|&jump| jump > threshold.lo)?,
        };
        let raw = [samples[2]?, samples[3]?];
        let sharp = [self.sharp(crack.pixel(0))?, self.sharp(crack.pixel(1))?];
        let step = (sharp[1] - sharp[0]).abs();
        (step >= LEAST_STEP * jump).then(|| self.jump_spot(crack, size, spread_offset(raw, sharp)))
    }

    /// Whether the border of coverage is so close that its own line suffices.
    fn is_beside_border(&self, crack: &Across) -> bool {
        let is_bare = |pixel| self.inside(pixel).is_some() && !self.is_covered(pixel);
        [-2, -1, 2, 3].iter().any(|&i| is_bare(crack.pixel(i)))
    }
}

/// The crack behind a pixel along an axis.
struct Across {
    pixel: PixelAt,
    axis: PixelAt,
}

impl Across {
    /// The crack along a lattice step from the corner at these coordinates.
    fn leaving(corner: [usize; 2], step: usize) -> Self {
        let [x, y] = corner.map(|v| v as i64);
        match step {
            RIGHT => Self {
                pixel: [x, y - 1],
                axis: [0, 1],
            },
            _ => Self {
                pixel: [x - 1, y],
                axis: [1, 0],
            },
        }
    }

    /// The pixel at the offset `i` behind the one before the crack.
    fn pixel(&self, i: i64) -> PixelAt {
        [
            self.pixel[0] + i * self.axis[0],
            self.pixel[1] + i * self.axis[1],
        ]
    }

    /// The axis across it: 0 to the right, 1 downward.
    fn direction(&self) -> usize {
        self.axis[1] as usize
    }

    /// The place so far behind the middle of the crack.
    fn place(&self, offset: f32) -> Vec2 {
        let vector = |[x, y]: PixelAt| Vec2::new(x as f32, y as f32);
        vector(self.pixel) + Vec2::splat(0.5) + (0.5 + offset) * vector(self.axis)
    }
}
