//! Silhouettes: the cracks between pixels that they pass, and the lines along these.

use super::smoothing;
use crate::fast_math::ln;
use crate::frame::{Frame, Plane, Projection, SightLines};
use crate::line::contours::strength_of_jump;
use crate::line::crack::{Across, border_offset, sharpened, spread_offset, unexplained_jump};
use crate::line::lattice::{Lattice, Path};
use crate::line::network::{self, Line, Spot};
use crate::params::{ContourParams, ShapeParams, SoftThreshold};
use crate::plan::Available;
use glam::{DVec2, DVec3, Vec2};
use rayon::prelude::*;

/// Steps of the lattice of pixel corners: a crack between two rows runs right, one between two columns down.
const RIGHT: usize = 0;
const DOWN: usize = 2;

/// How far beside an edge a line through middles of cracks lies: half a pixel, and a little more where the
/// edge bends.
const STEP_PX: f32 = 0.6;

/// Branches with fewer cracks than this are noise.
const SHORTEST_BRANCH: usize = 4;

/// A crack that a silhouette passes through.
struct Crack {
    /// Its upper or left corner.
    corner: u32,
    step: usize,
    spot: Spot,
}

/// The lines along all silhouettes.
pub(super) fn lines(
    weight: &Plane,
    frame: &Frame,
    shape: &ShapeParams,
    params: &ContourParams,
) -> Vec<Line> {
    let (width, height) = (frame.mask.width() + 1, frame.mask.height() + 1);
    let finder = Finder::new(weight, frame, shape);
    let cracks: Vec<Vec<Crack>> = (0..height)
        .into_par_iter()
        .with_min_len(8)
        .map(|y| finder.cracks(y))
        .collect();
    let cracks: Vec<Crack> = cracks.into_iter().flatten().collect();
    if cracks.is_empty() {
        return Vec::new();
    }
    let lattice = Lattice::new(width, height, cracks.iter().map(|c| (c.corner, c.step)));
    let place = |corner: u32| {
        let [x, y] = lattice.place(corner);
        Vec2::new(x as f32, y as f32)
    };
    let spot_between = |a: u32, b: u32| {
        let (corner, step) = (a.min(b), if a.abs_diff(b) == 1 { RIGHT } else { DOWN });
        let found = cracks.binary_search_by_key(&(corner, step), |c| (c.corner, c.step));
        cracks[found.expect("links are cracks")].spot
    };
    let spots = |path: &Path| {
        let pairs = path
            .nodes
            .windows(2)
            .map(|pair| spot_between(pair[0], pair[1]));
        let (first, last) = (path.nodes[0], path.nodes[path.nodes.len() - 1]);
        let closing = path.closed.then(|| spot_between(last, first));
        pairs.chain(closing).collect()
    };
    let smoothing = smoothing(params, STEP_PX);
    network::lines(&lattice, place, spots, SHORTEST_BRANCH, smoothing)
}

/// What jumps at silhouettes, and how far.
struct Map<'a> {
    plane: &'a Plane,
    is_depth: bool,
    threshold: SoftThreshold,
}

struct Finder<'a> {
    frame: &'a Frame,
    weight: &'a Plane,
    map: Option<Map<'a>>,
    /// The sight lines, where depth is known along them.
    sight: Option<(SightLines, bool)>,
}

/// A pixel, possibly beyond the picture.
type Pixel = [i64; 2];

impl<'a> Finder<'a> {
    fn new(weight: &'a Plane, frame: &'a Frame, shape: &ShapeParams) -> Self {
        let depth = frame.depth.as_ref().map(|plane| Map {
            plane,
            is_depth: true,
            threshold: shape.silhouette,
        });
        let occlusion = frame.occlusion.as_ref().map(|plane| Map {
            plane,
            is_depth: false,
            threshold: shape.occlusion_silhouette,
        });
        let projection = frame.camera.map(|camera| camera.projection);
        let knows = Available::in_frame(frame).positions;
        let is_perspective = |p: Projection| matches!(p, Projection::Perspective { .. });
        Self {
            frame,
            weight,
            map: depth.or(occlusion),
            sight: projection
                .filter(|_| knows)
                .map(|p| (SightLines::new(p), is_perspective(p))),
        }
    }

    /// The cracks that leave the corners of lattice row `y` to the right and down.
    fn cracks(&self, y: usize) -> Vec<Crack> {
        let mut found = Vec::new();
        let mask = &self.frame.mask;
        let y = y as i64;
        let rows = [y - 1, y].map(|row| self.weights(row));
        let spans = [y - 1, y].map(|row| match usize::try_from(row) {
            Ok(row) if row < mask.height() => mask.span(row),
            _ => 0..0,
        });
        let [above, here] = &spans;
        let columns = match (above.is_empty(), here.is_empty()) {
            (true, true) => return found,
            (true, false) => here.clone(),
            (false, true) => above.clone(),
            (false, false) => above.start.min(here.start)..above.end.max(here.end),
        };
        let marked = |row: &[f32], x: i64| {
            usize::try_from(x).is_ok_and(|x| row.get(x).is_some_and(|&w| w > 0.0))
        };
        // Most blocks hold no silhouette at all.
        const BLOCK: usize = 64;
        for start in columns.clone().step_by(BLOCK) {
            let end = (start + BLOCK).min(columns.end);
            let holds = |row: &&[f32]| {
                let part = row
                    .get(start.saturating_sub(1)..end.min(row.len()))
                    .unwrap_or(&[]);
                part.iter().fold(false, |any, &w| any | (w > 0.0))
            };
            if !rows.iter().any(holds) {
                continue;
            }
            // One more at the end of the span: the crack behind its last pixel.
            let end = if end == columns.end { end + 1 } else { end };
            for x in start as i64..end as i64 {
                let corner = (y * (mask.width() as i64 + 1) + x) as u32;
                if marked(rows[0], x) || marked(rows[1], x) {
                    let spot = self.spot([x, y - 1], [0, 1]);
                    found.extend(spot.map(|spot| Crack {
                        corner,
                        step: RIGHT,
                        spot,
                    }));
                }
                if marked(rows[1], x - 1) || marked(rows[1], x) {
                    let spot = self.spot([x - 1, y], [1, 0]);
                    found.extend(spot.map(|spot| Crack {
                        corner,
                        step: DOWN,
                        spot,
                    }));
                }
            }
        }
        found
    }

    fn weights(&self, y: i64) -> &[f32] {
        match usize::try_from(y) {
            Ok(y) if y < self.weight.height() => self.weight.row(y),
            _ => &[],
        }
    }

    fn inside(&self, [x, y]: Pixel) -> Option<[usize; 2]> {
        let mask = &self.frame.mask;
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < mask.width() && y < mask.height()).then_some([x, y])
    }

    fn is_covered(&self, pixel: Pixel) -> bool {
        self.inside(pixel)
            .is_some_and(|[x, y]| self.frame.mask.at(x, y))
    }

    /// The logarithm of depth of a covered pixel, 0 where depth is unknown.
    fn log_depth(&self, pixel: Pixel) -> f32 {
        let depth = self.frame.depth.as_ref();
        let at = self
            .inside(pixel)
            .zip(depth)
            .map(|([x, y], depth)| ln(depth.at(x, y)));
        at.filter(|log| log.is_finite()).unwrap_or(0.0)
    }

    /// The map where covered.
    fn value(&self, map: &Map, pixel: Pixel) -> Option<f32> {
        let [x, y] = self
            .inside(pixel)
            .filter(|&[x, y]| self.frame.mask.at(x, y))?;
        let value = map.plane.at(x, y);
        let value = if map.is_depth { ln(value) } else { value };
        value.is_finite().then_some(value)
    }

    /// The silhouette through the crack behind `pixel` along `axis`, if there is one.
    fn spot(&self, pixel: Pixel, axis: Pixel) -> Option<Spot> {
        let along = |i: i64| [pixel[0] + i * axis[0], pixel[1] + i * axis[1]];
        let axis = Vec2::new(axis[0] as f32, axis[1] as f32);
        let middle = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5) + 0.5 * axis;
        self.inside(pixel)?;
        self.inside(along(1))?;
        match [self.is_covered(pixel), self.is_covered(along(1))] {
            [false, false] => None,
            [true, true] => self.jump(along, middle, axis),
            [first, _] => {
                let beyond = |i: i64| if first { along(i) } else { along(1 - i) };
                let outward = if first { axis } else { -axis };
                Some(Spot {
                    at: middle + self.coverage_offset(beyond) * outward,
                    strength: 1.0,
                    log_depth: self.log_depth(beyond(0)),
                })
            }
        }
    }

    /// Where the edge lies beyond the crack, if alpha tells; `beyond(0)` is covered, `beyond(1)` is not.
    fn coverage_offset(&self, beyond: impl Fn(i64) -> Pixel) -> f32 {
        let Some(alpha) = &self.frame.alpha else {
            return 0.0;
        };
        let at = |i: i64| self.inside(beyond(i)).map_or(0.0, |[x, y]| alpha.at(x, y));
        border_offset([at(-1), at(0), at(1), at(2)])
    }

    /// The silhouette between two covered pixels.
    fn jump(&self, along: impl Fn(i64) -> Pixel, middle: Vec2, axis: Vec2) -> Option<Spot> {
        let map = self.map.as_ref()?;
        let across: Across = [-2, -1, 0, 1, 2, 3].map(|i| self.value(map, along(i)));
        let jump = unexplained_jump(&across);
        let least = map.threshold.lo;
        // Beside the border the border's own line is enough.
        let is_beside_border = [-2, -1, 2, 3]
            .iter()
            .any(|&i| self.inside(along(i)).is_some() && !self.is_covered(along(i)));
        if jump <= least || is_beside_border {
            return None;
        }
        let raw = [across[2]?, across[3]?];
        let sharp = [
            self.sharp(map, along(0), raw[0]),
            self.sharp(map, along(1), raw[1]),
        ];
        let step = sharp[1] - sharp[0];
        if step.abs() < 0.5 * jump {
            return None;
        }
        let jump = match map.is_depth {
            true => jump.min(self.unexplained_by_normals(along(0), along(1), step)),
            false => jump,
        };
        if jump <= least {
            return None;
        }
        Some(Spot {
            at: middle + spread_offset(raw, sharp) * axis,
            strength: if map.is_depth {
                strength_of_jump(jump)
            } else {
                jump.min(1.0)
            },
            log_depth: self.log_depth(along(0)).min(self.log_depth(along(1))),
        })
    }

    fn sharp(&self, map: &Map, pixel: Pixel, value: f32) -> f32 {
        let around =
            (0..9).filter_map(|i| self.value(map, [pixel[0] + i % 3 - 1, pixel[1] + i / 3 - 1]));
        sharpened(value, around)
    }

    /// By how much the logarithm of depth steps from one pixel to the next beyond what a smooth surface with
    /// their normals would.
    fn unexplained_by_normals(&self, from: Pixel, to: Pixel, step: f32) -> f32 {
        let smooth = || {
            let (sight, is_perspective) = self.sight.as_ref()?;
            let ([x, y], [to_x, to_y]) = (self.inside(from)?, self.inside(to)?);
            let window = self.frame.data_window;
            let at = |x: usize, y: usize| {
                DVec2::new(
                    f64::from(window.x0) + x as f64 + 0.5,
                    f64::from(window.y0) + y as f64 + 0.5,
                )
            };
            let normal = &self.frame.normal;
            let n = |x, y| {
                DVec3::new(
                    normal.x.at(x, y).into(),
                    normal.y.at(x, y).into(),
                    normal.z.at(x, y).into(),
                )
            };
            let offset = sight.step(at(x, y), n(x, y), at(to_x, to_y), n(to_x, to_y))?;
            let unit = match is_perspective {
                true => 1.0,
                false => f64::from(self.frame.depth.as_ref()?.at(x, y)),
            };
            let ratio = 1.0 - offset.z / unit;
            (ratio > 0.0).then(|| ratio.ln() as f32)
        };
        smooth().map_or(step.abs(), |smooth| (step - smooth).abs())
    }
}
