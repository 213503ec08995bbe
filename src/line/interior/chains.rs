//! Chains: lines through crests that hang together and are plain somewhere.

use crate::line::contours::lattice::STEPS;
use crate::line::contours::network::{Line, Spot};
use crate::line::contours::polyline::Smoothing;
use crate::line::contours::ridge::Bands;
use crate::line::interior::crests::Crest;
use crate::line::interior::fade::supports;
use crate::line::interior::sizes::Sizes;

/// Largest deviation of crests from a line, and the number on either side over which they are smoothed.
const SMOOTHING: Smoothing = Smoothing {
    tolerance_px: 0.7,
    reach: 5,
};

/// The lines through crests of one kind, each with its share of the full width; the crests are on a grid of `width` by
/// `height` pixels in row order. Crests above the first threshold form networks; each network kept exceeds the second
/// threshold somewhere, and is about as long as `shortest` pixels.
pub(super) fn chains(
    crests: &[Crest],
    [width, height]: [usize; 2],
    shortest: f32,
    sizes: &Sizes,
) -> Vec<(Line, f32)> {
    let thresholds = sizes.thresholds;
    // A line aslant has a crest for the root of two of its length.
    let fewest = (shortest * std::f32::consts::FRAC_1_SQRT_2) as usize;
    let crests = plain(crests, [width, height], thresholds[1], fewest);
    if crests.is_empty() {
        return Vec::new();
    }
    let mut weight = vec![0.0; width * height];
    for crest in &crests {
        weight[crest.pixel as usize] = (0.5 * crest.strength / thresholds[1]).clamp(0.01, 1.0);
    }
    let pixels: Vec<u32> = crests.iter().map(|crest| crest.pixel).collect();
    let bands = Bands {
        width,
        height,
        pixels: &pixels,
        weight: &weight,
    };
    let spot = |pixel: u32| {
        let found = pixels.binary_search(&pixel).ok().map(|i| crests[i]);
        Spot {
            at: found.map_or(bands.centre(pixel), |crest| crest.at),
            strength: found.map_or(0.0, |crest| crest.strength),
            log_depth: 0.0,
            is_beside: false,
        }
    };
    let lines = bands.lines(spot, SMOOTHING);
    let fades = match sizes.fades {
        true => fades(&lines, &crests, [width, height], thresholds),
        false => vec![1.0; lines.len()],
    };
    lines.into_iter().zip(fades).collect()
}

/// The share of its width that each line is drawn with, by the support that its crests have.
fn fades(lines: &[Line], crests: &[Crest], size: [usize; 2], thresholds: [f32; 2]) -> Vec<f32> {
    let beside = |crest: &Crest| beside(crests, crest, size).collect();
    let supports = supports(crests, thresholds, beside);
    let of_line = |line: &Line| {
        let own = line.spots.iter().filter_map(|spot| {
            let [x, y] = [spot.at.x as i32, spot.at.y as i32];
            number(crests, [x, y], size).map(|i| supports[i])
        });
        own.fold(0.0, f32::max)
    };
    lines.iter().map(of_line).collect()
}

/// The number of the crest of a pixel, if it has one.
fn number(crests: &[Crest], [x, y]: [i32; 2], [width, height]: [usize; 2]) -> Option<usize> {
    let is_inside = x >= 0 && y >= 0 && (x as usize) < width && (y as usize) < height;
    let pixel = is_inside.then(|| y as usize * width + x as usize)?;
    crests
        .binary_search_by_key(&(pixel as u32), |crest| crest.pixel)
        .ok()
}

/// The numbers of the crests around one.
fn beside(crests: &[Crest], crest: &Crest, size: [usize; 2]) -> impl Iterator<Item = usize> {
    let pixel = crest.pixel as usize;
    let (x, y) = ((pixel % size[0]) as i32, (pixel / size[0]) as i32);
    let around = STEPS.iter();
    around.filter_map(move |[dx, dy]| number(crests, [x + dx, y + dy], size))
}

/// A pixel without a crest, or one whose crest has been looked at.
const NO_CREST: u32 = u32::MAX;

/// Connected sets of crests, of at least `fewest`, with one at least as strong as `strength`.
fn plain(crests: &[Crest], size: [usize; 2], strength: f32, fewest: usize) -> Vec<Crest> {
    let [width, height] = size;
    // One column and row more on every side: all pixels have eight around them.
    let place = |pixel: usize| (pixel / width + 1) * (width + 2) + pixel % width + 1;
    let mut waiting = vec![NO_CREST; (width + 2) * (height + 2)];
    for (i, crest) in (0..).zip(crests) {
        waiting[place(crest.pixel as usize)] = i;
    }
    let mut kept = Vec::new();
    for start in 0..crests.len() {
        let own = place(crests[start].pixel as usize);
        if waiting[own] == NO_CREST || crests[start].strength < strength {
            continue;
        }
        waiting[own] = NO_CREST;
        let (first, mut next) = (kept.len(), kept.len());
        kept.push(start);
        while next < kept.len() {
            let own = place(crests[kept[next]].pixel as usize);
            for [dx, dy] in STEPS {
                let step = dy as isize * (width as isize + 2) + dx as isize;
                let there = &mut waiting[own.wrapping_add_signed(step)];
                if *there != NO_CREST {
                    kept.push(std::mem::replace(there, NO_CREST) as usize);
                }
            }
            next += 1;
        }
        if kept.len() - first < fewest {
            kept.truncate(first);
        }
    }
    kept.sort_unstable();
    kept.into_iter().map(|i| crests[i]).collect()
}
