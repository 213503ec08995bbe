//! Which layer, read in which way, leads from a frame to the one before: the one along which both frames show the same.
//!
//! At pixels spread over the frame, normals, depth and luminance are compared to those of the previous frame at the place
//! given by each pair of channels under each convention. True motion explains the frame better than a still picture or a
//! still world, and better than any other reading of the same channels. If none does, nothing is concluded.

use super::{MotionConvention, MotionLayers};
use crate::frame::{Frame, Mask, Plane, Vector2Planes, Vector3Planes, Window};
use rayon::prelude::*;

/// Pixels that are compared, about.
const PIXELS: usize = 8_000;
/// Two ways that end nearer than this, in pixels, are one.
const ONE_WAY: f32 = 0.5;
/// Fewest pixels at which two ways must differ to be told apart.
const FEWEST: usize = 24;
/// A way must leave less than this share of what another leaves unexplained.
const CLEARLY: f64 = 0.85;
/// A way that leaves more than this unexplained, 0..1, leads elsewhere, however little better than others it is.
const MOST_LEFT: f64 = 0.3;
/// Ways that leave nearly as little as the best are as good: a name, or what is usual, decides between pairs of channels.
const AS_GOOD: f64 = 1.1;
/// How much a relative difference of depth counts: one of a tenth is as none of the same surface.
const DEPTH_WEIGHT: f32 = 10.0;

/// Data kept from a frame for comparison with the next.
#[derive(Debug, Clone)]
pub struct FrameBefore {
    window: Window,
    mask: Mask,
    normal: Vector3Planes,
    depth: Option<Plane>,
    luminance: Option<Plane>,
}

impl FrameBefore {
    /// Copies the data from `frame`.
    pub fn of(frame: &Frame) -> Self {
        Self {
            window: frame.data_window,
            mask: frame.mask.clone(),
            normal: frame.normal.clone(),
            depth: frame.depth.clone(),
            luminance: luminance(frame),
        }
    }
}

fn luminance(frame: &Frame) -> Option<Plane> {
    let (color, weights) = (frame.color.as_ref()?, frame.luminance_weights());
    let [width, height] = [color.r.width(), color.r.height()];
    let at = |x, y| crate::frame::luminance(color.at(x, y), weights);
    Some(Plane::from_fn(width, height, at))
}

/// Verdict on layers of motion from two frames.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionVerdict {
    /// The pair and its convention that lead from one to the other.
    pub(super) found: Option<(usize, MotionConvention)>,
    /// Whether no other reading of the pair leads to the same places: other frames need not be judged.
    pub is_settled: bool,
    /// Whether nothing moved that could tell anything.
    pub is_still: bool,
    /// The conclusion, in words.
    pub conclusion: String,
    /// The numbers behind the conclusion.
    pub evidence: String,
    /// The flags that read the layer so; `None` where none was found.
    pub flags: Option<String>,
}

impl MotionVerdict {
    /// Whether a layer was found to lead to the frame before.
    pub fn is_found(&self) -> bool {
        self.found.is_some()
    }
}

/// A way back to the frame before.
struct WayBack {
    pair: usize,
    convention: MotionConvention,
    /// In pixels, y up, at each pixel that is compared.
    back: Vec<[f32; 2]>,
    /// Residual there, 0..1.
    left: Vec<f32>,
}

pub(super) fn judge(
    layers: &MotionLayers,
    now: &Frame,
    before: &FrameBefore,
    steps: u32,
    still: Option<&Vector2Planes>,
) -> MotionVerdict {
    let scene = FramePair::of(now, before);
    let times = steps as f32;
    let mut ways: Vec<WayBack> = layers
        .pairs
        .iter()
        .enumerate()
        .flat_map(|(pair, _)| MotionConvention::all().map(move |convention| (pair, convention)))
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(pair, convention)| {
            let stored = &layers.pairs[pair];
            let back = scene.at.iter().map(|&[x, y]| {
                let stored = [stored.x.at(x, y), stored.y.at(x, y)];
                convention.back(stored, layers.display).map(|c| times * c)
            });
            scene.way(pair, convention, back.collect())
        })
        .collect();
    let is_known = |back: &[f32; 2]| back[0].hypot(back[1]) < Vector2Planes::AWAY;
    ways.retain(|way| way.back.iter().any(is_known));
    let stands = scene.way(0, MotionConvention::BACK, vec![[0.0; 2]; scene.at.len()]);
    let world = still.map(|come| {
        let at = scene.at.iter();
        let back = at.map(|&[x, y]| [-come.x.at(x, y), -come.y.at(x, y)]);
        scene.way(0, MotionConvention::BACK, back.collect())
    });
    verdict(layers, &ways, &stands, world.as_ref())
}

fn verdict(
    layers: &MotionLayers,
    ways: &[WayBack],
    stands: &WayBack,
    world: Option<&WayBack>,
) -> MotionVerdict {
    let undecided = |is_still, evidence: String| MotionVerdict {
        found: None,
        is_settled: false,
        is_still,
        conclusion: "no layer that is known to lead to the frame before".into(),
        evidence,
        flags: None,
    };
    let Some(least) = ways.iter().map(WayBack::mean).min_by(f64::total_cmp) else {
        return undecided(true, "nothing can be compared".into());
    };
    let is_named = |way: &&WayBack| layers.pairs[way.pair].by_name == Some(way.convention);
    let is_good = |way: &&WayBack| way.mean() <= AS_GOOD * least;
    let best = ways.iter().filter(is_good).find(is_named);
    let best = best.or_else(|| ways.iter().find(|way| way.mean() == least));
    let Some(best) = best else {
        return undecided(true, "nothing can be compared".into());
    };
    let label = &layers.pairs[best.pair].label;
    if let Err((is_still, mut why)) = beats_stillness(best, label, stands, world) {
        if layers.pairs[best.pair].has_third && !is_still {
            why += "; three numbers may be motion in world space, which is not read: render it in pixels of the picture";
        }
        return undecided(is_still, why);
    }
    let rivals = ways.iter().filter(|way| way.pair == best.pair);
    let mut is_settled = true;
    let mut nearest: Option<(f64, f64, MotionConvention)> = None;
    for rival in rivals.filter(|way| way.convention != best.convention) {
        match best.against(rival) {
            None => is_settled = false,
            Some((own, its)) if nearest.is_none_or(|(a, b, _)| own * b > a * its) => {
                nearest = Some((own, its, rival.convention));
            }
            Some(_) => {}
        }
    }
    if let Some((own, its, other)) = nearest.filter(|(own, its, _)| *own >= CLEARLY * its) {
        let why = format!(
            "{label} leads {} ({own:.3} left) about as well as {other} ({its:.3} left)",
            best.convention
        );
        return undecided(false, why);
    }
    let than_still = best.against(stands).map_or(String::new(), |(own, its)| {
        format!("where it moves {own:.3} of what the frame shows are left unexplained, {its:.3} by standing still")
    });
    let than_other = nearest.map_or(String::new(), |(own, its, other)| {
        format!("; the next reading, {other}, {its:.3} where this leaves {own:.3}")
    });
    MotionVerdict {
        found: Some((best.pair, best.convention)),
        is_settled,
        is_still: false,
        conclusion: format!("{label}, {}", best.convention),
        evidence: than_still + &than_other,
        flags: Some(layers.flags(best.pair, best.convention)),
    }
}

/// Whether `best`, of the layer called `label`, explains the frame, and better than a still picture or a still world; else
/// whether nothing moves, and why not.
fn beats_stillness(
    best: &WayBack,
    label: &str,
    stands: &WayBack,
    world: Option<&WayBack>,
) -> std::result::Result<(), (bool, String)> {
    let convention = best.convention;
    let Some((own, its)) = best.against(stands) else {
        return Err((true, format!("{label} moves hardly anything")));
    };
    if own > MOST_LEFT {
        let why =
            format!("{label}, {convention}, leaves {own:.3} of what the frame shows unexplained");
        return Err((false, why));
    }
    let as_well = |what: &str, own: f64, its: f64| {
        let why = format!(
            "{what} that stands still explains the frame as well: of what it shows {its:.3} are left, {own:.3} along {label}, \
             {convention}"
        );
        Err((false, why))
    };
    if own >= CLEARLY * its {
        return as_well("a picture", own, its);
    }
    // Where the surface moves as a world that stands still does, the two are one.
    match world.and_then(|world| best.against(world)) {
        Some((own, its)) if own >= CLEARLY * its => as_well("a world", own, its),
        _ => Ok(()),
    }
}

impl WayBack {
    /// Mean residual, 0..1.
    fn mean(&self) -> f64 {
        let sum: f64 = self.left.iter().map(|&left| f64::from(left)).sum();
        sum / self.left.len().max(1) as f64
    }

    /// Mean residuals of this and of `rival` where they differ; `None` if they hardly do.
    fn against(&self, rival: &Self) -> Option<(f64, f64)> {
        let (mut own, mut its, mut count) = (0.0, 0.0, 0);
        for i in 0..self.back.len() {
            let [a, b] = [self.back[i], rival.back[i]];
            let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
            // NaN counts as different.
            if apart > ONE_WAY || apart.is_nan() {
                own += f64::from(self.left[i]);
                its += f64::from(rival.left[i]);
                count += 1;
            }
        }
        (count >= FEWEST).then(|| (own / count as f64, its / count as f64))
    }
}

/// Two frames, and where they are compared.
struct FramePair<'a> {
    now: &'a Frame,
    before: &'a FrameBefore,
    luminance: Option<Plane>,
    /// Column and row of the covered pixels that are compared.
    at: Vec<[usize; 2]>,
}

impl<'a> FramePair<'a> {
    fn of(now: &'a Frame, before: &'a FrameBefore) -> Self {
        Self {
            now,
            before,
            luminance: luminance(now).filter(|_| before.luminance.is_some()),
            at: now.mask.sample(PIXELS).map(|(x, y)| [x, y]).collect(),
        }
    }

    fn way(&self, pair: usize, convention: MotionConvention, back: Vec<[f32; 2]>) -> WayBack {
        let ways = self.at.iter().zip(&back);
        let left = ways.map(|(&at, &back)| self.left(at, back));
        WayBack {
            pair,
            convention,
            left: left.collect(),
            back,
        }
    }

    /// How unlike a pixel is to where it was `back`, 0..1.
    fn left(&self, [x, y]: [usize; 2], back: [f32; 2]) -> f32 {
        let (now, before) = (self.now, self.before);
        let column = (now.data_window.x0 - before.window.x0) as f32 + x as f32 + back[0];
        let row = (now.data_window.y0 - before.window.y0) as f32 + y as f32 - back[1];
        let Some(taps) = taps(column, row, &before.mask) else {
            return 1.0;
        };
        let mean =
            |plane: &Plane| -> f32 { taps.iter().map(|&(x, y, w)| w * plane.at(x, y)).sum() };
        let normal = now.normal.at(x, y).as_vec3();
        let was = [&before.normal.x, &before.normal.y, &before.normal.z].map(mean);
        let mut left = (normal - glam::Vec3::from(was)).length();
        if let (Some(depth), Some(was)) = (&now.depth, &before.depth) {
            let (depth, was) = (depth.at(x, y), mean(was));
            left += (DEPTH_WEIGHT * (depth - was).abs()
                / depth.abs().max(was.abs()).max(f32::MIN_POSITIVE))
            .min(1.0);
        }
        if let (Some(luminance), Some(was)) = (&self.luminance, &before.luminance) {
            let (light, was) = (luminance.at(x, y), mean(was));
            left += (light - was).abs() / (light.abs() + was.abs()).max(f32::MIN_POSITIVE);
        }
        // A maximum with NaN is the other number.
        if left.is_nan() { 1.0 } else { left.min(1.0) }
    }
}

/// The four pixels around a place, with their shares; `None` outside the picture and where they are not covered.
fn taps(column: f32, row: f32, mask: &Mask) -> Option<[(usize, usize, f32); 4]> {
    let (width, height) = (mask.width(), mask.height());
    let is_inside =
        column > -0.5 && row > -0.5 && column < width as f32 - 0.5 && row < height as f32 - 0.5;
    if !is_inside {
        return None;
    }
    let (left, top) = (column.floor(), row.floor());
    let (u, v) = (column - left, row - top);
    let clamped = |at: f32, most: usize| (at.max(0.0) as usize).min(most - 1);
    let tap = |dx: f32, dy: f32, share: f32| {
        (clamped(left + dx, width), clamped(top + dy, height), share)
    };
    let taps = [
        tap(0.0, 0.0, (1.0 - u) * (1.0 - v)),
        tap(1.0, 0.0, u * (1.0 - v)),
        tap(0.0, 1.0, (1.0 - u) * v),
        tap(1.0, 1.0, u * v),
    ];
    let covered = taps.iter().filter(|(x, y, _)| mask.at(*x, *y));
    let covered: f32 = covered.map(|tap| tap.2).sum();
    if covered < 0.5 {
        return None;
    }
    Some(taps.map(|(x, y, share)| match mask.at(x, y) {
        true => (x, y, share / covered),
        false => (x, y, 0.0),
    }))
}
