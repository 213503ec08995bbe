//! Lines through crests: bands of pixels thinned to lines one pixel wide.

use crate::line::contours::lattice::{Lattice, NodePath, STEPS};
use crate::line::contours::network::{self, Line, Spot};
use crate::line::contours::smoothing::Smoothing;
use crate::line::interior::crests::Crest;
use glam::Vec2;

/// The smooth lines through crests, and the pixels of `corners` between them, which are on a grid of this size in row order;
/// `log_depth` gives that at a pixel.
pub(in crate::line) fn lines(
    crests: &[Crest],
    corners: &[u32],
    [width, height]: [usize; 2],
    log_depth: impl Fn(u32) -> f32,
    smoothing: Smoothing,
) -> Vec<Line> {
    let pixels: Vec<u32> = crests.iter().map(|crest| crest.pixel).collect();
    let bands = Bands {
        width,
        height,
        pixels: &pixels,
    };
    let ridges = bands.ridges(corners);
    let crest_at = |pixel: u32| {
        let found = crests.binary_search_by_key(&pixel, |crest| crest.pixel);
        found.ok().map(|i| crests[i])
    };
    let spot = |pixel: u32| {
        // Where an edge between pixels has crests on both its sides, it is amid those that are left and those that are not.
        let beside = bands.all_beside(pixel).into_iter().flatten();
        let is_gone = |&there: &u32| smoothing.is_stepped && ridges.degree(there) == 0;
        let gone = beside.map(|there| there as u32).filter(is_gone);
        let gone: Vec<Crest> = gone.filter_map(crest_at).collect();
        let amid = gone.iter().map(|crest| crest.at).sum::<Vec2>() / gone.len().max(1) as f32;
        // None at a corner, or in a gap.
        let own = crest_at(pixel);
        let at = own.map_or(bands.centre(pixel), |crest| crest.at);
        let of_gone = || gone.iter().map(|crest| crest.strength).fold(0.0, f32::max);
        Spot {
            at: if gone.is_empty() {
                at
            } else {
                at.midpoint(amid)
            },
            strength: own.map_or_else(of_gone, |crest| crest.strength),
            log_depth: log_depth(pixel),
            is_beside: false,
        }
    };
    let spots = |path: &NodePath| {
        let last = path.nodes.len() - 1;
        let is_junction = |i: usize| (i == 0 || i == last) && ridges.degree(path.nodes[i]) > 2;
        let inner = path.nodes.iter().enumerate();
        let inner = inner.filter(|&(i, _)| path.closed || !is_junction(i));
        inner.map(|(_, &pixel)| spot(pixel)).collect()
    };
    network::lines(&ridges, |pixel| bands.centre(pixel), spots, RIM, smoothing)
}

/// Pixels in bands.
struct Bands<'a> {
    width: usize,
    height: usize,
    /// The pixels, in order.
    pixels: &'a [u32],
}

impl Bands<'_> {
    /// Column and row of a pixel.
    #[inline]
    fn place(&self, pixel: u32) -> [usize; 2] {
        // A division of 32 bits takes half the time of one of 64.
        let width = self.width as u32;
        [pixel % width, pixel / width].map(|i| i as usize)
    }

    /// The pixel a step away.
    #[inline]
    fn beside(&self, pixel: u32, [dx, dy]: [i32; 2]) -> Option<usize> {
        let [x, y] = self.place(pixel);
        let (x, y) = (
            x.checked_add_signed(dx as isize)?,
            y.checked_add_signed(dy as isize)?,
        );
        (x < self.width && y < self.height).then_some(y * self.width + x)
    }

    /// The pixels all steps away, in their order.
    fn all_beside(&self, pixel: u32) -> [Option<usize>; STEPS.len()] {
        STEPS.map(|step| self.beside(pixel, step))
    }

    /// The middle of a pixel, in picture coordinates.
    fn centre(&self, pixel: u32) -> Vec2 {
        let [x, y] = self.place(pixel);
        Vec2::new(x as f32 + 0.5, y as f32 + 0.5)
    }

    /// The lines that the bands are thinned to, connected as the bands are: pixels are removed as long as that neither
    /// breaks a line nor shortens one that is a pixel wide.
    fn ridges(&self, corners: &[u32]) -> Lattice {
        let mut left = Left {
            bands: self,
            around: vec![0; self.width * self.height],
        };
        let mut waiting = self.gaps();
        waiting.extend(corners);
        for &pixel in self.pixels.iter().chain(&waiting) {
            left.set(pixel, true);
        }
        // Crests are thinned last: lines go through them.
        left.thin(&mut waiting);
        waiting.extend(self.pixels);
        left.thin(&mut waiting);
        // The remainder is wider than any edge, or the whole picture: it need not be centred.
        while left.take(&mut waiting, |_, _| true) {}
        waiting.sort_unstable();
        let links = waiting.iter().flat_map(|&pixel| {
            let bits = left.around[pixel as usize];
            // Each link once: along the first half of the steps. A diagonal step only if there is no way around it.
            (0..4).filter_map(move |step| {
                let set = |i: usize| bits >> (i % 8) & 1 == 1;
                let around = step % 2 == 1 && (set(step + 7) || set(step + 1));
                (set(step) && !around).then_some((pixel, step))
            })
        });
        Lattice::new(self.width, self.height, links)
    }

    /// The pixels between bands that run so closely side by side that one line serves both.
    fn gaps(&self) -> Vec<u32> {
        let mut is_band = vec![false; self.width * self.height];
        for &pixel in self.pixels {
            is_band[pixel as usize] = true;
        }
        let mut gaps = Vec::new();
        for &pixel in self.pixels {
            let [x, y] = self.place(pixel);
            for (beyond, step) in [(self.width - 1 - x, 1), (self.height - 1 - y, self.width)] {
                let ahead = |i: usize| pixel as usize + i * step;
                let reach = beyond.min(WIDEST_GAP + 1);
                let wide = (1..=reach).find(|&i| is_band[ahead(i)]).unwrap_or(1);
                gaps.extend((1..wide).map(|i| ahead(i) as u32));
            }
        }
        gaps.sort_unstable();
        gaps.dedup();
        gaps
    }
}

/// What is left of bands that are being thinned.
struct Left<'a> {
    bands: &'a Bands<'a>,
    /// Eight bits for every pixel of the picture, one per step: whether its neighbour is left.
    around: Vec<u8>,
}

impl Left<'_> {
    /// Adds or removes a pixel.
    #[inline]
    fn set(&mut self, pixel: u32, is_left: bool) {
        for (i, there) in self.bands.all_beside(pixel).into_iter().enumerate() {
            if let Some(there) = there {
                let back = 1 << ((i + 4) % 8);
                let around = &mut self.around[there];
                *around = if is_left {
                    *around | back
                } else {
                    *around & !back
                };
            }
        }
    }

    /// Removes pixels layer by layer, from each of the four sides in turn: a line two pixels wide loses one side, not
    /// its length.
    fn thin(&mut self, waiting: &mut Vec<u32>) {
        let bands = self.bands;
        for _ in 0..MOST_LAYERS {
            let before = waiting.len();
            // From below, the right, above and the left. A band continues beyond the picture.
            for side in [2, 0, 6, 4] {
                self.take(waiting, |pixel, around| {
                    around >> side & 1 == 0 && bands.beside(pixel, STEPS[side]).is_some()
                });
            }
            if waiting.len() == before {
                break;
            }
        }
    }

    /// Removes, one after the other, those of the waiting pixels that currently can be removed and are not needed;
    /// returns whether there were any. `may_go` is told a pixel and what is left around it.
    fn take(&mut self, waiting: &mut Vec<u32>, may_go: impl Fn(u32, u8) -> bool) -> bool {
        let before = waiting.len();
        let layer = waiting
            .iter()
            .map(|&pixel| may_go(pixel, self.around[pixel as usize]));
        let layer: Vec<bool> = layer.collect();
        let mut layer = layer.into_iter();
        waiting.retain(|&pixel| {
            let may_go = layer.next() == Some(true);
            let goes = may_go && IS_SPARE[usize::from(self.around[pixel as usize])];
            if goes {
                self.set(pixel, false);
            }
            !goes
        });
        before > waiting.len()
    }
}

/// A line that ends within this many pixels of the border of the picture continues beyond it.
const RIM: usize = 2;

/// Bands at most this many pixels apart are one.
const WIDEST_GAP: usize = 2;

/// Layers that are taken from all sides: enough for bands of twice as many pixels.
const MOST_LAYERS: usize = 6;

/// Whether a pixel with these remaining neighbours is neither needed for a line's length nor to connect them.
const IS_SPARE: [bool; 256] = {
    let mut is_spare = [false; 256];
    let mut bits = 0;
    while bits < is_spare.len() {
        is_spare[bits] = bits.count_ones() >= 2 && is_simple(bits);
        bits += 1;
    }
    is_spare
};

/// Whether a pixel with these remaining neighbours can be removed without separating them or opening a hole: its
/// 8-connectivity number (Yokoi) is 1.
const fn is_simple(bits: usize) -> bool {
    let (mut number, mut side) = (0, 0);
    while side < 8 {
        let free = [
            (bits >> side) & 1 == 0,
            (bits >> (side + 1)) & 1 == 0,
            (bits >> ((side + 2) % 8)) & 1 == 0,
        ];
        if free[0] && !(free[1] && free[2]) {
            number += 1;
        }
        side += 2;
    }
    number == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ridges_of(width: usize, height: usize, weight: &[f32]) -> Vec<u32> {
        let pixels: Vec<u32> = (0..weight.len() as u32)
            .filter(|&i| weight[i as usize] > 0.0)
            .collect();
        let bands = Bands {
            width,
            height,
            pixels: &pixels,
        };
        bands.ridges(&[]).linked
    }

    #[test]
    fn a_band_becomes_a_line_along_its_middle() {
        // Three rows of five.
        let weight: Vec<f32> = (0..100)
            .map(|i| [0.0, 1.0, 1.0, 1.0, 0.0][i / 20])
            .collect();
        let left = ridges_of(20, 5, &weight);
        let in_middle = left.iter().all(|&i| (40..60).contains(&i));
        assert!(left.len() >= 18 && in_middle, "{left:?}");
    }

    #[test]
    fn bands_side_by_side_are_one_line() {
        // Rows 2 and 3, and rows 6 and 7: the two rows between them are filled, and one line runs in the middle. At the
        // ends it may split.
        let weight: Vec<f32> = (0..600)
            .map(|i| [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0][i / 60])
            .collect();
        let left = ridges_of(60, 10, &weight);
        let inner: Vec<u32> = left
            .into_iter()
            .filter(|i| (15..45).contains(&(i % 60)))
            .collect();
        let in_middle = inner.iter().all(|&i| i / 60 == 4 || i / 60 == 5);
        assert!(inner.len() == 30 && in_middle, "{inner:?}");
    }

    #[test]
    fn rings_stay_closed_and_full_planes_end() {
        let ring: Vec<f32> = (0..15 * 15)
            .map(|i| {
                let (dx, dy) = (f64::from(i % 15) - 7.0, f64::from(i / 15) - 7.0);
                f32::from(u8::from((dx.hypot(dy) - 5.0).abs() < 1.3))
            })
            .collect();
        let pixels: Vec<u32> = (0..225).filter(|&i| ring[i as usize] > 0.0).collect();
        let bands = Bands {
            width: 15,
            height: 15,
            pixels: &pixels,
        };
        let paths = bands.ridges(&[]).paths();
        // Once around; a corner may leave a stub.
        let around = |path: &&NodePath| path.closed || path.nodes.first() == path.nodes.last();
        let rings: Vec<_> = paths.iter().filter(around).collect();
        assert!(rings.len() == 1 && rings[0].nodes.len() > 20, "{paths:?}");
        let stubs = paths.iter().filter(|path| !around(path));
        assert!(stubs.map(|path| path.nodes.len()).sum::<usize>() <= 3);
        assert!(ridges_of(40, 30, &[1.0; 1200]).len() < 200);
        assert!(ridges_of(1, 1, &[1.0]).is_empty());
    }
}
