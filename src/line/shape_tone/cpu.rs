//! Tone over the frame: cells, what spreads among them, percentiles, and back to pixels.

use super::background::{behind_subject, left_out, plainness, quieter};
use super::levels::{self, Ranks, SHARES, Scales, Scatter};
use super::{CLEAR_TURN, activity, key_stops, raised, seen_tone, stops};
use crate::frame::memory::Memory;
use crate::frame::percentile::percentile;
use crate::frame::rows::map_covered;
use crate::frame::{ColorPlanes, Frame, Mask, Plane, Vector2Planes, luminance};
use crate::line::background::Backdrop;
use crate::line::density::LEAST_ALPHA;
use crate::line::grid::{Grid, cell_px};
use crate::params::{self, RunOptions, ToneLevels, ToneParams};
use crate::shape::curvature::mapped_curvature;
use crate::shape::diffusion::cpu::diffusion;
use crate::shape::diffusion::medium::Medium;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use glam::Vec3;

/// Widths as shares of the picture's size: smoothing of normals before their turn is measured, smoothing of brightness,
/// surroundings for local contrast, and surroundings that decide whether there is shape.
const TURN_SHARE: f32 = 1.0 / 300.0;
const SMOOTH_SHARE: f32 = 1.0 / 280.0;
const AROUND_SHARE: f32 = 1.0 / 14.0;
const ACTIVITY_SHARE: f32 = 1.0 / 60.0;

/// The least smoothing of brightness, in cells.
const LEAST_SMOOTHING: f32 = 1.2;

/// Turn of the normal, in radians over the picture's size, that halves the smoothing of brightness.
const SHARP_TURN: f32 = 18.0;

/// How many cells are one where surroundings are found.
const COARSE: usize = 4;

/// Perceived tone is linear light to the power of one over this.
const SEEN_GAMMA: f32 = 2.2;

/// Error of what spreads, relative to its largest value.
const TOLERANCE: f64 = 1e-3;

/// The weight of an edge in the mean of a coarse cell.
const CLOSED: f32 = 1e-3;

/// How much a place counts for ranks that tells nothing of shape.
const PLAIN_WEIGHT: f32 = 0.01;

/// The inputs of tone.
pub(crate) struct ToneOf<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) conductance: &'a Plane,
    pub(crate) silhouette: Option<&'a Plane>,
    /// The trace of the Hessian, and the gain of its mapping.
    pub(crate) curvature: (&'a Plane, f32),
    /// The picture, if there is one.
    pub(crate) picture: Option<&'a ColorPlanes>,
    /// Toward the key light.
    pub(crate) to_key: Vec3,
    pub(crate) params: &'a ToneParams,
    /// The planes behind the subject, if it has some.
    pub(crate) background: Option<&'a Backdrop>,
    /// Whether they were looked for.
    pub(crate) seeks_planes: bool,
}

/// The optical density, -ln of the share of light that is left, of the tone of every cell.
pub(crate) struct CellDensities {
    grid: Grid,
    density: Plane,
    /// The levels that tones were fit to, as [`ToneLevels::Given`](crate::params::ToneLevels::Given) has them.
    pub(crate) levels: [f32; ToneLevels::COUNT],
}

impl CellDensities {
    /// The same of every covered pixel, 0 elsewhere.
    pub(crate) fn of_pixels(&self, mask: &Mask, memory: &Memory) -> Plane {
        let [pixels] = map_covered(mask, memory, |y| {
            let row = self.grid.row(&self.density, y, mask);
            move |x| [row[x]]
        });
        pixels
    }
}

/// The density of the tone of what is shown.
pub(crate) fn densities(shown: &ToneOf, options: &RunOptions, memory: &Memory) -> CellDensities {
    let (mask, size) = (&shown.frame.mask, shown.frame.display_window.size_px());
    let step = cell_px(size);
    let cells = Cells {
        grid: Grid::new(mask, step),
        size: size / step as f32,
        options,
        memory: &memory.at_other_size(),
    };
    let seen = cells.seen(shown);
    let (density, levels) = cells.density(&seen, shown);
    CellDensities {
        grid: cells.grid,
        density,
        levels,
    }
}

/// The luminance of the surface in a row of the picture; 0 where it has none.
fn luminances<'a>(shown: &ToneOf<'a>, y: usize) -> impl Fn(usize) -> f32 + use<'a> {
    let weights = shown.frame.luminance_weights();
    let rows = shown.picture;
    let rows = rows.map(|color| [&color.r, &color.g, &color.b].map(|plane| plane.row(y)));
    let alpha = shown.frame.alpha.as_ref().map(|alpha| alpha.row(y));
    move |x| {
        // Mapping an array is not inlined.
        let found = rows.map(|[r, g, b]| luminance([r[x], g[x], b[x]], weights));
        let alpha = alpha.map_or(1.0, |row| row[x]);
        let found = found.map(|found| found / alpha.clamp(LEAST_ALPHA, 1.0));
        found.filter(|&found| found > 0.0).unwrap_or(0.0)
    }
}

pub(super) struct Cells<'a> {
    pub(super) grid: Grid,
    /// The picture's size, the root of its area, in cells.
    pub(super) size: f32,
    options: &'a RunOptions,
    pub(super) memory: &'a Memory,
}

/// The surface and its picture, as means over cells; edges are the strongest of each cell.
pub(super) struct CellMeans {
    /// Normals, of any length.
    pub(super) normal: [Plane; 3],
    /// Conductance of silhouettes alone, and of all edges.
    pub(super) before: Plane,
    conductance: Plane,
    /// Trace of the Hessian.
    trace: Plane,
    /// Luminance of the picture; 0 where there is none.
    luminance: Plane,
}

impl Cells<'_> {
    fn seen(&self, shown: &ToneOf) -> CellMeans {
        let ToneOf { frame, .. } = shown;
        let normal = &frame.normal;
        let [nx, ny, nz, trace, luminance] = self.grid.means(&frame.mask, self.memory, |y| {
            let [nx, ny, nz] = [&normal.x, &normal.y, &normal.z].map(|plane| plane.row(y));
            let (trace, luminance) = (shown.curvature.0.row(y), luminances(shown, y));
            move |x| [nx[x], ny[x], nz[x], trace[x], luminance(x)]
        });
        CellMeans {
            normal: [nx, ny, nz],
            before: self.before(shown.silhouette),
            conductance: self.grid.least(shown.conductance),
            trace,
            luminance,
        }
    }

    /// Openness between silhouettes. An edge closes every cell that it enters: in a mean, one that is two pixels wide and
    /// falls half into each of two cells would leave both half open.
    fn before(&self, silhouette: Option<&Plane>) -> Plane {
        let mask = &self.grid.mask;
        let most = silhouette.map(|silhouette| self.grid.most(silhouette));
        let [before] = map_covered(mask, self.memory, |y| {
            let most = most.as_ref().map(|most| most.row(y));
            move |x| [1.0 - most.map_or(0.0, |most| most[x])]
        });
        before
    }

    fn density(&self, seen: &CellMeans, shown: &ToneOf) -> (Plane, [f32; ToneLevels::COUNT]) {
        let (scales, ranks) = levels::given(shown.params.levels).unzip();
        let turn = self.turn(seen, TURN_SHARE);
        let (brightness, scales) = self.brightness(seen, shown, &turn, scales);
        let conductance = &seen.conductance;
        let (around, contrast) = self.around(&brightness, conductance);
        let mut active = self.activity(&turn, conductance);
        let mask = &self.grid.mask;
        let cut = match shown.background {
            Some(_) => None,
            None => self.cut_into_grain(seen, &turn),
        };
        if let Some(cut) = &cut {
            active.each_with(cut, |active, cut| *active *= cut);
        }
        let [balanced] = map_covered(mask, self.memory, |y| {
            let (brightness, around) = (brightness.row(y), around.row(y));
            let (active, contrast) = (active.row(y), contrast.row(y));
            move |x| {
                let detail = brightness[x] - around[x];
                [around[x] + detail * raised(contrast[x], active[x])]
            }
        });
        let ranks = ranks.unwrap_or_else(|| ranks_of(&balanced, &active, mask));
        let plain = match cut {
            Some(cut) => Some(cut.map(|cut| 1.0 - cut)),
            None if shown.seeks_planes => None,
            None => Some(plainness(mask, self.size, &turn, &active, conductance)),
        };
        let left_out = left_out(shown.params.background);
        let [mut ink] = map_covered(mask, self.memory, |y| {
            let (row, ranks) = (balanced.row(y), &ranks);
            let plain = plain.as_ref().map(|plain| plain.row(y));
            move |x| {
                let tone = seen_tone(ranks.rank(row[x]), ranks.place(row[x]));
                let plain = plain.map_or(0.0, |plain| plain[x]);
                [1.0 - quieter(tone, left_out * plain).powf(SEEN_GAMMA)]
            }
        });
        if let Some(background) = shown.background {
            let spread = |ink, open: &Plane, sigma| {
                let zero = self.memory.plane(mask);
                self.spread(Vector2Planes { x: ink, y: zero }, open, sigma)
                    .x
            };
            let is_blank = shown.params.background == params::Background::None;
            ink = behind_subject(ink, background, is_blank, spread);
        }
        let density = ink.map(|ink| -(1.0 - ink).ln());
        (density, levels::as_numbers(&scales, &ranks))
    }

    /// By how much normals, smoothed by a `share` of the picture's size, turn from cell to cell at the most, in radians over
    /// that size: the largest singular value of their derivative (Judd, Durand, Adelson 2007).
    pub(super) fn turn(&self, seen: &CellMeans, share: f32) -> Plane {
        let (mask, open) = (&self.grid.mask, &seen.before);
        let [x, y, z] = seen.normal.clone();
        let sigma = (self.size * share).max(1.0);
        let zero = self.memory.plane(mask);
        let xy = self.spread(Vector2Planes { x, y }, open, sigma);
        let z = self.spread(Vector2Planes { x: z, y: zero }, open, sigma).x;
        let units = map_covered(mask, self.memory, |row| {
            let [x, y, z] = [&xy.x, &xy.y, &z].map(|plane| plane.row(row));
            move |i| Vec3::new(x[i], y[i], z[i]).normalize_or_zero().to_array()
        });
        let [nx, ny, nz] = units.each_ref().map(|plane| plane.samples());
        let (width, height) = (mask.width(), mask.height());
        let covered = mask.plane().samples();
        let normal = |x: usize, y: usize| {
            let i = y.wrapping_mul(width).wrapping_add(x);
            let is_covered = x < width && y < height && covered[i];
            is_covered.then(|| Vec3::new(nx[i], ny[i], nz[i]))
        };
        let [turn] = map_covered(mask, self.memory, |y| {
            let open = open.row(y);
            move |x| {
                let here = normal(x, y).unwrap_or_default();
                let across = slope(normal(x.wrapping_sub(1), y), here, normal(x + 1, y));
                let down = slope(normal(x, y.wrapping_sub(1)), here, normal(x, y + 1));
                let (a, b, c) = (
                    across.length_squared(),
                    across.dot(down),
                    down.length_squared(),
                );
                let half = 0.5 * (a - c);
                let largest = 0.5 * (a + c) + (half * half + b * b).sqrt();
                // Across an edge nothing turns.
                [open[x] * largest.sqrt() * self.size]
            }
        });
        turn
    }

    /// The brightness of cells about that of the whole, of the picture and in the key light.
    fn brightness(
        &self,
        seen: &CellMeans,
        shown: &ToneOf,
        turn: &Plane,
        given: Option<Scales>,
    ) -> (Plane, Scales) {
        let (mask, gain) = (&self.grid.mask, shown.curvature.1);
        let median = match given {
            Some(scales) => scales.median,
            None => {
                let luminance = |x, y| Some(seen.luminance.at(x, y));
                percentile(mask, 50, luminance).unwrap_or(1.0)
            }
        };
        let median = if median > 0.0 { median } else { 1.0 };
        let [picture, key, smooth] = map_covered(mask, self.memory, |y| {
            let [nx, ny, nz] = seen.normal.each_ref().map(|plane| plane.row(y));
            let (trace, luminance) = (seen.trace.row(y), seen.luminance.row(y));
            let (conductance, turn) = (seen.conductance.row(y), turn.row(y));
            move |x| {
                let normal = Vec3::new(nx[x], ny[x], nz[x]).normalize_or_zero();
                let kappa = mapped_curvature(trace[x], gain);
                [
                    stops(luminance[x], median),
                    key_stops(normal.dot(shown.to_key), kappa),
                    conductance[x] / (1.0 + (turn[x] / SHARP_TURN).powi(2)),
                ]
            }
        });
        let sigma = (self.size * SMOOTH_SHARE).max(LEAST_SMOOTHING);
        let both = self.spread(Vector2Planes { x: picture, y: key }, &smooth, sigma);
        let scales = given.unwrap_or_else(|| Scales {
            median,
            picture: spread_of(&both.x, mask),
            key: spread_of(&both.y, mask),
        });
        let share = match shown.picture {
            Some(_) => shown.params.key_share,
            None => 1.0,
        };
        let [mixed] = map_covered(mask, self.memory, |y| {
            let (picture, key) = (both.x.row(y), both.y.row(y));
            move |x| {
                let picture = scales.picture.standard(picture[x]);
                [picture + share * (scales.key.standard(key[x]) - picture)]
            }
        });
        (mixed, scales)
    }

    /// The brightness around cells, within surfaces, and how far cells are from it in the root mean square.
    fn around(&self, brightness: &Plane, conductance: &Plane) -> (Plane, Plane) {
        let (mask, coarse) = (&self.grid.mask, self.coarse());
        let [mean, square, open] = coarse.grid.means(mask, coarse.memory, |y| {
            let (brightness, conductance) = (brightness.row(y), conductance.row(y));
            move |x| {
                let (value, open) = (brightness[x], conductance[x].max(CLOSED));
                [open * value, open * value * value, open]
            }
        });
        let of_open = |sum: &Plane| {
            let [mean] = map_covered(&coarse.grid.mask, coarse.memory, |y| {
                let (sum, open) = (sum.row(y), open.row(y));
                move |x| [sum[x] / open[x]]
            });
            mean
        };
        let (mean, square) = (of_open(&mean), of_open(&square));
        let open = coarse.grid.least(conductance);
        let sigma = coarse.size * AROUND_SHARE;
        let found = coarse.spread(Vector2Planes { x: mean, y: square }, &open, sigma);
        let [around, contrast] = map_covered(mask, self.memory, |y| {
            let [mean, square] = [&found.x, &found.y].map(|plane| coarse.grid.row(plane, y, mask));
            move |x| {
                let (mean, square) = (mean[x], square[x]);
                [mean, (square - mean * mean).max(0.0).sqrt()]
            }
        });
        (around, contrast)
    }

    /// How much the surroundings of cells tell of shape.
    fn activity(&self, turn: &Plane, conductance: &Plane) -> Plane {
        let (mask, coarse) = (&self.grid.mask, self.coarse());
        let [turn] = coarse.grid.means(mask, coarse.memory, |y| {
            let turn = turn.row(y);
            move |x| [turn[x].min(CLEAR_TURN) / CLEAR_TURN]
        });
        let open = coarse.grid.least(conductance);
        let zero = coarse.memory.plane(&coarse.grid.mask);
        let sigma = coarse.size * ACTIVITY_SHARE;
        let found = coarse
            .spread(Vector2Planes { x: turn, y: zero }, &open, sigma)
            .x;
        let [active] = map_covered(mask, self.memory, |y| {
            let turn = coarse.grid.row(&found, y, mask);
            move |x| [activity(turn[x])]
        });
        active
    }

    /// Cells of which each holds several of these.
    fn coarse(&self) -> Self {
        Self {
            grid: Grid::new(&self.grid.mask, COARSE),
            size: self.size / COARSE as f32,
            ..*self
        }
    }

    /// A field spread by this many cells, as far as they are `open`.
    pub(super) fn spread(&self, field: Vector2Planes, open: &Plane, sigma: f32) -> Vector2Planes {
        let sweeps = DiffusionSchedule::to_sigmas(&[sigma], TOLERANCE);
        let (mask, options) = (&self.grid.mask, self.options);
        let medium = Medium::of_whole(open, mask);
        let mut spread = diffusion(field, medium, &sweeps, options, self.memory).scales;
        spread.pop().expect("one scale is read out")
    }
}

/// Half the difference between the cells on both sides, by what is covered of them.
#[inline(always)]
fn slope(before: Option<Vec3>, here: Vec3, after: Option<Vec3>) -> Vec3 {
    match (before, after) {
        (Some(before), Some(after)) => 0.5 * (after - before),
        (Some(before), None) => here - before,
        (None, Some(after)) => after - here,
        (None, None) => Vec3::ZERO,
    }
}

fn spread_of(plane: &Plane, mask: &Mask) -> Scatter {
    let at = |percent| percentile(mask, percent, |x, y| Some(plane.at(x, y))).unwrap_or(0.0);
    Scatter {
        middle: at(50),
        width: at(90) - at(10),
    }
}

/// Steps between the least and the greatest value in which ranks are counted.
const BINS: usize = 4096;

/// The ranks of every brightness among those of a picture, counted by how much they tell of shape.
fn ranks_of(brightness: &Plane, active: &Plane, mask: &Mask) -> Ranks {
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for y in 0..mask.height() {
        let row = brightness.row(y);
        let samples = mask.runs(y).flat_map(|run| &row[run]);
        for &value in samples.filter(|value| value.is_finite()) {
            (least, most) = (least.min(value), most.max(value));
        }
    }
    if least > most {
        (least, most) = (0.0, 0.0);
    }
    let per_bin = ((most - least) / BINS as f32).max(f32::MIN_POSITIVE);
    let mut counts = vec![0.0_f64; BINS];
    for y in 0..mask.height() {
        let (row, active) = (brightness.row(y), active.row(y));
        for x in mask.runs(y).flatten() {
            let bin = ((row[x] - least) / per_bin) as usize;
            counts[bin.min(BINS - 1)] += f64::from(PLAIN_WEIGHT + active[x]);
        }
    }
    let all: f64 = counts.iter().sum();
    let mut sum = 0.0;
    // Cumulative counts up to the end of each bin.
    let below: Vec<f64> = counts
        .iter()
        .map(|count| {
            sum += count;
            sum
        })
        .collect();
    Ranks(SHARES.map(|share| {
        let wanted = f64::from(share) * all;
        let bin = below.partition_point(|&below| below < wanted);
        match bin {
            0 => least,
            bin => {
                let bin = bin.min(BINS - 1);
                let part = (wanted - below[bin - 1]) / (below[bin] - below[bin - 1]);
                least + per_bin * (bin as f32 + part.clamp(0.0, 1.0) as f32)
            }
        }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes};
    use crate::line::random::Random;
    use crate::line::shape_tone::key_light;
    use glam::DVec3;

    /// The tone of normals in the key light alone, `closed` columns being edges.
    fn key_tone(normal: Vector3Planes, mask: Mask, closed: std::ops::Range<usize>) -> Plane {
        key_tone_before(params::Background::Strokes, normal, mask, closed)
    }

    fn key_tone_before(
        background: params::Background,
        normal: Vector3Planes,
        mask: Mask,
        closed: std::ops::Range<usize>,
    ) -> Plane {
        let (width, height) = (mask.width(), mask.height());
        let params = ToneParams {
            background,
            ..ToneParams::default()
        };
        let is_closed = |x: usize| closed.contains(&x);
        let shown = ToneOf {
            frame: &Frame::of_normals(normal, mask),
            conductance: &Plane::from_fn(width, height, |x, _| f32::from(!is_closed(x) as u8)),
            silhouette: Some(&Plane::from_fn(width, height, |x, _| {
                f32::from(is_closed(x) as u8)
            })),
            curvature: (&Plane::filled(width, height, 0.0), 1.0),
            picture: None,
            to_key: key_light(),
            params: &params,
            background: None,
            seeks_planes: false,
        };
        let memory = Memory::default();
        let density = densities(&shown, &RunOptions::default(), &memory);
        let density = density.of_pixels(&shown.frame.mask, &memory);
        density.map(|density| (-density / SEEN_GAMMA).exp())
    }

    /// A hemisphere that fills a square of this side, and nothing around it.
    fn ball(side: usize) -> (Vector3Planes, Mask) {
        let at = move |x: usize| (x as f64 + 0.5) / side as f64 * 2.2 - 1.1;
        let normal = Vector3Planes::from_fn(side, side, |x, y| {
            let (x, y) = (at(x), -at(y));
            DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()).normalize()
        });
        let covered = Plane::from_fn(side, side, |x, y| at(x).hypot(at(y)) < 1.0);
        (normal, Mask::new(covered))
    }

    #[test]
    fn a_ball_is_paper_toward_the_key_light_and_dark_away_from_it_at_any_size() {
        // Paper begins at a rank of 0.745: toward the light there is nothing above. The darkest has rank and place 0, and so
        // 0.65 times 0.045, and the shadow side a little more.
        let tones = [120, 240].map(|side| {
            let (normal, mask) = ball(side);
            let tone = key_tone(normal, mask, 0..0);
            let to_key = key_light();
            let at = |x: f32, y: f32| {
                let pixel = |v: f32| ((v + 1.1) / 2.2 * side as f32) as usize;
                tone.at(pixel(x), pixel(-y))
            };
            assert!(at(to_key.x, to_key.y) > 0.99);
            assert!(at(-0.6, 0.6) > 0.99);
            assert!(at(0.65, -0.65) < 0.2);
            [-0.5, 0.0, 0.3, 0.5].map(|v| at(v, -v))
        });
        for (small, large) in tones[0].iter().zip(tones[1]) {
            assert!((small - large).abs() < 0.03, "{tones:?}");
        }
    }

    #[test]
    fn what_was_fit_to_one_picture_holds_for_the_next() {
        // Of the ball half is left: fit anew its tones change, fit to the whole they stay away from the cut.
        let (normal, mask) = ball(160);
        let half = Mask::new(Plane::from_fn(160, 160, |x, y| mask.at(x, y) && x > y));
        let (options, memory) = (RunOptions::default(), Memory::default());
        let flat = Plane::filled(160, 160, 0.0);
        let open = Plane::filled(160, 160, 1.0);
        let found = |mask: &Mask, levels: ToneLevels| {
            let params = ToneParams {
                background: crate::params::Background::Strokes,
                levels,
                ..ToneParams::default()
            };
            let shown = ToneOf {
                frame: &Frame::of_normals(normal.clone(), mask.clone()),
                conductance: &open,
                silhouette: None,
                curvature: (&flat, 1.0),
                picture: None,
                to_key: key_light(),
                params: &params,
                background: None,
                seeks_planes: false,
            };
            let cells = densities(&shown, &options, &memory);
            let density = cells.of_pixels(mask, &memory);
            let tone = density.map(|density| (-density / SEEN_GAMMA).exp());
            (tone, cells.levels)
        };
        let (whole, levels) = found(&mask, ToneLevels::Auto);
        let given = ToneLevels::Given(levels);
        assert_eq!(found(&mask, given), (whole.clone(), levels));
        let off = |tone: &Plane| (tone.at(120, 40) - whole.at(120, 40)).abs();
        let (fit, kept) = (found(&half, ToneLevels::Auto).0, found(&half, given).0);
        assert!(
            off(&kept) < 0.03 && off(&fit) > 2.0 * off(&kept),
            "{} {}",
            off(&kept),
            off(&fit)
        );
    }

    #[test]
    fn stone_is_quieter_than_what_is_cut_into_it() {
        // Grain of single pixels, of which half is left where normals are smoothed by twice as much, and grooves 12 pixels
        // wide with walls of 42 degrees: an eighth of the surface, of which one wall faces away from the key light.
        let tone = |has_grooves: bool| {
            let mut random = Random::new(7);
            let mut grain = || 0.2 * (f64::from(random.unit()) - 0.5);
            let normal = Vector3Planes::from_fn(900, 900, |x, _| {
                let wall = match (has_grooves, x % 96) {
                    (true, 0..6) => 0.9,
                    (true, 6..12) => -0.9,
                    _ => 0.0,
                };
                DVec3::new(wall + grain(), grain(), 1.0).normalize()
            });
            let (plain, mask) = (params::Background::Plain, Mask::full(900, 900));
            let tone = key_tone_before(plain, normal, mask, 0..0);
            let mean = |columns: std::ops::Range<usize>| {
                let at = |y: usize| columns.clone().map(move |x| (x, y));
                let count = 600.0 * columns.len() as f32;
                (150..750)
                    .flat_map(at)
                    .map(|(x, y)| tone.at(x + 384, y))
                    .sum::<f32>()
                    / count
            };
            [mean(1..5), mean(40..80)]
        };
        let ([groove, stone], [_, alone]) = (tone(true), tone(false));
        assert!(stone > 0.9 && groove < 0.4, "{stone} {groove}");
        // Grain alone is what there is to draw.
        assert!(alone < 0.75, "{alone}");
    }

    #[test]
    fn brightness_does_not_cross_an_edge() {
        let normal = Vector3Planes::from_fn(96, 64, |x, _| match x {
            0..48 => DVec3::new(-0.6, 0.0, 0.8),
            _ => DVec3::new(0.6, 0.0, 0.8),
        });
        let tone = key_tone(normal, Mask::full(96, 64), 47..49);
        for side in [0..47, 49..96] {
            let row = &tone.row(20)[side];
            let first = row[0];
            assert!(row.iter().all(|t| (t - first).abs() < 0.02), "{row:?}");
        }
        assert!(tone.at(10, 20) > tone.at(80, 20) + 0.3);
    }

    #[test]
    fn an_edge_half_in_each_of_two_cells_stops_tone() {
        // Cells are 2 pixels wide here, so columns 703 and 704 are half of cells 351 and 352. Were those half open, the two
        // planes would mix over two cells.
        let normal = Vector3Planes::from_fn(1400, 1400, |x, _| match x {
            0..704 => DVec3::new(-0.6, 0.0, 0.8),
            _ => DVec3::new(0.6, 0.0, 0.8),
        });
        let tone = key_tone(normal, Mask::full(1400, 1400), 703..705);
        for side in [600..703, 705..800] {
            let row = &tone.row(700)[side];
            let first = row[0];
            assert!(row.iter().all(|t| (t - first).abs() < 0.02), "{row:?}");
        }
        assert!(tone.at(600, 700) > tone.at(800, 700) + 0.3);
    }

    #[test]
    fn tones_are_finite_whatever_comes() {
        let poison = |x: usize| match x {
            3 => DVec3::NAN,
            5 => DVec3::ZERO,
            7 => DVec3::splat(f64::INFINITY),
            _ => DVec3::Z,
        };
        for (width, height) in [(1, 1), (1, 9), (9, 1), (40, 30)] {
            let normal = || Vector3Planes::from_fn(width, height, |x, _| poison(x));
            for mask in [
                Mask::full(width, height),
                Mask::new(Plane::filled(width, height, false)),
            ] {
                let tone = key_tone(normal(), mask.clone(), 0..0);
                for y in 0..height {
                    let covered = mask.runs(y).flatten().map(|x| tone.at(x, y));
                    covered.for_each(|t| assert!((0.0..=1.0).contains(&t), "{t}"));
                }
            }
        }
    }
}
