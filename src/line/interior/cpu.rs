//! Interior lines of a frame: measured, followed, chosen, joined.

use crate::frame::memory::Memory;
use crate::frame::{Frame, Mask, Plane};
use crate::line::background::Backdrop;
use crate::line::contours::behind::Occluders;
use crate::line::contours::gaps::close_gaps;
use crate::line::contours::ground::{Ground, Onward};
use crate::line::contours::log_depth;
use crate::line::contours::network::Line;
use crate::line::contours::{Contour, ContourKind, DepthRange};
use crate::line::drawing::Drawn;
use crate::line::interior::chains::chains;
use crate::line::interior::choice::{Interior, Roughness, chosen, shortest};
use crate::line::interior::crests::{Crest, FormRims, suggestive, valleys_and_ridges};
use crate::line::interior::drawn::Pen;
use crate::line::interior::facing::Viewer;
use crate::line::interior::fade::by_strength;
use crate::line::interior::level::FormLevel;
use crate::line::interior::shadows::shadows;
use crate::line::interior::sizes::Sizes;
use crate::line::turning::curvature;
use crate::params::{InteriorParams, LineLevels, RunOptions};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Scale of suggestive contours, as a multiple of that of valleys and ridges.
const SUGGESTIVE_SCALE: f32 = 1.5;

/// The scale at which lines still have to exist, as a multiple of their own.
const PERSISTENCE_SCALE: f32 = 2.5;

/// Distance of ridges from rims, as a multiple of that of other lines: normals that do not spread beyond a rim turn
/// fastest at some distance from it, all around any ball.
const RIDGE_MARGIN: f32 = 1.4;

/// Lines are extended to a contour up to this many margins away, and as straight ahead as this cosine.
const JOIN_REACH: f32 = 1.5;
const JOIN_AHEAD: f32 = 0.7;

/// Lines, and the levels their widths were fitted to.
pub(crate) type Found = (Vec<Contour>, Option<[f32; LineLevels::COUNT]>);

/// The lines inside the surfaces that are drawn, in addition to their contours. In a sequence,
/// where it `fades` them, their widths begin at 0.
pub(crate) fn interior(
    drawn: &Drawn,
    (contours, background): (&[Contour], Option<&Backdrop>),
    params: &InteriorParams,
    fades: bool,
    options: &RunOptions,
    memory: &Memory,
) -> Found {
    let frame = drawn.frame;
    let silhouette = drawn.silhouette.expect("lines keep away from silhouettes");
    let sizes = Sizes::of(frame, params, fades);
    let level = FormLevel::of(frame, silhouette, sizes.factor);
    if level.frame.mask.count() == 0 {
        return (Vec::new(), None);
    }
    let scales = [sizes.sigma, SUGGESTIVE_SCALE * sizes.sigma];
    let normals = level.diffused(&scales, options, memory);
    let mut lines = found(frame, &level, &normals, params, &sizes, (options, memory));
    if memory.is_cancelled() {
        return (Vec::new(), None);
    }
    if let Some(background) = background {
        background.leave_blank(&mut lines, |interior| &interior.line, sizes.factor as f32);
    }
    count_beyond(&mut lines, contours, frame, &level.frame.mask, &sizes);
    let lines = selected(lines, contours, &level.frame.mask, &sizes);
    joined_and_drawn(lines, contours, frame, &normals[0], params, &sizes)
}

/// All lines of all kinds that belong to the form, in pixels of the level.
fn found(
    frame: &Frame,
    level: &FormLevel,
    normals: &[Plane<Vec3>],
    params: &InteriorParams,
    sizes: &Sizes,
    (options, memory): (&RunOptions, &Memory),
) -> Vec<Interior> {
    if memory.is_cancelled() {
        return Vec::new();
    }
    let [rims, ridge_rims] =
        [1.0, RIDGE_MARGIN].map(|share| FormRims::new(level, share * sizes.margin));
    let viewer = Viewer::of(frame, sizes.factor);
    let mask = &level.frame.mask;
    let fine = curvature(&normals[0], mask);
    let [valleys, mut ridges] = valleys_and_ridges(&normals[0], &fine, [&rims, &ridge_rims], sizes);
    if !params.has_ridges() {
        ridges.clear();
    }
    let turned = suggestive(
        &normals[1],
        SUGGESTIVE_SCALE * sizes.sigma,
        &viewer,
        &rims,
        sizes,
    );
    let shadows = match params.has_shadows() {
        true => shadows(frame, level, &fine, &rims, sizes, options, memory),
        false => Vec::new(),
    };
    // Half the size, and the remaining scale at that size.
    let left = sizes.sigma * (PERSISTENCE_SCALE * PERSISTENCE_SCALE - 1.0).sqrt();
    let halved = level.halved(&normals[0]);
    let coarse = halved.diffused(&[0.5 * left], options, memory);
    if memory.is_cancelled() {
        return Vec::new();
    }
    let coarse = curvature(&coarse[0], &halved.frame.mask);
    let size = [mask.width(), mask.height()];
    let roughness = Roughness::of(&fine, &coarse, &halved.frame.mask, sizes);
    let of = |kind: ContourKind, crests: &[Crest]| -> Vec<Interior> {
        let lines = chains(crests, size, shortest(kind, sizes), sizes).into_iter();
        let long = lines.filter(|(line, _)| line.length() >= shortest(kind, sizes));
        let formed = long.filter_map(|(line, fade)| {
            let times = match kind {
                ContourKind::Shadow => f32::INFINITY,
                _ => roughness.formed(&line),
            };
            let fade = if sizes.fades {
                fade * by_strength(times)
            } else {
                fade
            };
            (times >= 1.0).then_some(Interior {
                kind,
                line,
                fade,
                beyond: 0.0,
            })
        });
        formed.collect()
    };
    let all = [
        (ContourKind::Valley, &valleys),
        (ContourKind::Ridge, &ridges),
        (ContourKind::Suggestive, &turned),
        (ContourKind::Shadow, &shadows),
    ];
    all.par_iter()
        .flat_map_iter(|(kind, crests)| of(*kind, crests))
        .collect()
}

/// Counts the parts of lines of a kind that pass behind something as one line each.
fn count_beyond(
    lines: &mut [Interior],
    contours: &[Contour],
    frame: &Frame,
    mask: &Mask,
    sizes: &Sizes,
) {
    if frame.depth.is_none() {
        return;
    }
    let factor = sizes.factor as f32;
    let points =
        |contour: &Contour| -> Vec<Vec2> { contour.points.iter().map(|&at| at / factor).collect() };
    let outlines = contours.iter().map(points);
    let occluders = Occluders {
        outlines: &Ground::of_points(outlines, [mask.width(), mask.height()], 1),
        frame,
        factor,
        unit_px: 1.0,
    };
    for same in lines.chunk_by_mut(|a, b| a.kind == b.kind) {
        let own: Vec<Line> = same.iter().map(|line| line.line.clone()).collect();
        for (line, beyond) in same.iter_mut().zip(occluders.lengths_beyond(&own)) {
            line.beyond = beyond;
        }
    }
}

fn selected(
    lines: Vec<Interior>,
    contours: &[Contour],
    mask: &Mask,
    sizes: &Sizes,
) -> Vec<Interior> {
    let drawn = contours.iter().flat_map(|contour| &contour.points);
    let drawn = drawn.map(|&point| point / sizes.factor as f32);
    let longest = sizes.budget * (mask.count() as f32).sqrt();
    chosen(lines, drawn, [mask.width(), mask.height()], longest, sizes)
}

/// The lines in pixels of the frame, led on to each other and to contours, with their widths.
fn joined_and_drawn(
    lines: Vec<Interior>,
    contours: &[Contour],
    frame: &Frame,
    normals: &Plane<Vec3>,
    params: &InteriorParams,
    sizes: &Sizes,
) -> Found {
    let factor = sizes.factor as f32;
    let looks: Vec<_> = lines.iter().map(|line| (line.kind, line.fade)).collect();
    let mut lines: Vec<Line> = lines.into_iter().map(|line| line.line).collect();
    for (i, line) in lines.iter_mut().enumerate() {
        line.part = i;
        for spot in &mut line.spots {
            spot.at *= factor;
            spot.log_depth = log_depth(frame, spot.at).unwrap_or(0.0);
        }
    }
    let size = [frame.mask.width(), frame.mask.height()];
    let contours = contours.iter().map(|contour| &contour.points);
    let ground = Ground::of_points(contours, size, 1);
    close_gaps(&mut lines, factor * sizes.gap, Some(&ground));
    let occluders = Occluders {
        outlines: &ground,
        frame,
        factor: 1.0,
        unit_px: factor,
    };
    occluders.unite(&mut lines);
    let aside = (factor * JOIN_REACH * sizes.margin).floor() + 1.0;
    let onward = Onward {
        ahead: aside,
        aside,
        straight: JOIN_AHEAD,
        are_own: false,
    };
    ground.join_ends(&mut lines, onward);
    let own = Ground::of_points(lines.iter().map(Line::points), size, 1);
    let onto_own = Onward {
        aside: 0.0,
        are_own: true,
        ..onward
    };
    own.join_ends(&mut lines, onto_own);
    let levels = match params.levels {
        LineLevels::Auto => levels_of(&lines),
        LineLevels::Given(levels) => levels,
    };
    let pen = Pen::new(factor * sizes.picture, params, levels, sizes);
    let drawn = lines.par_iter().zip(looks).map(|(line, look)| {
        let normal = |i: usize| normals.nearest(line.spots[i].at / factor);
        pen.contour(look, line, params, normal)
    });
    let drawn: Vec<Contour> = drawn.collect();
    let levels = (!drawn.is_empty()).then_some(levels);
    (drawn, levels)
}

/// The levels that widths are fit to, from the lines of one picture.
fn levels_of(lines: &[Line]) -> [f32; LineLevels::COUNT] {
    let DepthRange { near, far } = DepthRange::of(lines);
    [strongest(lines), near, far]
}

/// The strength that one spot in seven exceeds.
fn strongest(lines: &[Line]) -> f32 {
    let spots = lines.iter().flat_map(|line| &line.spots);
    let mut strengths: Vec<f32> = spots.map(|spot| spot.strength).collect();
    if strengths.is_empty() {
        return 1.0;
    }
    let rank = strengths.len() * 85 / 100;
    *strengths.select_nth_unstable_by(rank, f32::total_cmp).1
}
