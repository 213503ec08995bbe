//! The sizes of dots that were not placed for their tone, by the room that each has.

use super::spread::{DotDensity, by_cell};
use super::{Dot, LaidDot};
use glam::Vec2;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Distance over which dots share room, as a multiple of that wanted between them.
const REACH: f32 = 2.0;

/// Limits of a dot's radius, as multiples of that of a whole one.
const LIMITS: [f32; 2] = [0.6, 1.25];

/// Points around a dot at which its tone is taken.
const AROUND: usize = 8;

/// The dots, each large enough to ink its share of the paper around it. Where ink is short, those that are coming are
/// made larger first.
pub(super) fn fitted(dots: &mut [LaidDot], field: &DotDensity) -> Vec<Dot> {
    let crowding = crowdings(dots, field);
    for (dot, crowding) in dots.iter_mut().zip(crowding) {
        if !dot.is_going && crowding < 1.0 {
            dot.share = (dot.share / crowding).min(1.0);
        }
    }
    let fitted = dots.iter().zip(crowdings(dots, field));
    let fitted = fitted.map(|(dot, crowding)| {
        let room = crowding.sqrt().recip().clamp(LIMITS[0], LIMITS[1]);
        Dot {
            at: dot.at,
            radius: field.radius * dot.share.sqrt() * room,
        }
    });
    fitted.collect()
}

/// For each dot the sum of the shares of dots near it, over that wanted there.
fn crowdings(dots: &[LaidDot], field: &DotDensity) -> Vec<f32> {
    let places: Vec<Vec2> = dots.iter().map(|dot| dot.at).collect();
    let cells = by_cell(&places, field);
    let around: [Vec2; AROUND] =
        std::array::from_fn(|i| Vec2::from_angle(i as f32 * 2.0 * PI / AROUND as f32));
    let of = |&at: &Vec2| {
        let reach = REACH * field.apart(at)?;
        let there = cells.near(at, reach).map(|other| {
            let share = other.at.distance_squared(at) / (reach * reach);
            (1.0 - share) * dots[other.line as usize].share
        });
        // The weight 1 - (d/reach)^2 sums up to pi reach^2/2, half of it within 0.54 reach.
        let densities = around.iter().map(|way| field.at(at + 0.54 * reach * way));
        let density = 0.5 * (field.at(at) + densities.sum::<f32>() / AROUND as f32);
        Some(there.sum::<f32>() / (density * 0.5 * PI * reach * reach))
    };
    places.par_iter().map(|at| of(at).unwrap_or(1.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    /// Mean radius away from the border of dots in a square order, these shares of whole ones in turn, where they are so
    /// many times the number wanted.
    fn mean_radius(times: f32, shares: [f32; 2]) -> f32 {
        // Dots of radius 1 for ink of 0.2: one in pi/0.2 pixels.
        let ink = Plane::filled(200, 200, 0.2);
        let apart = (PI / 0.2 / times).sqrt();
        let count = (200.0 / apart) as usize;
        let at = |i: usize| (Vec2::new((i % count) as f32, (i / count) as f32) + 0.5) * apart;
        let dot = |i: usize| LaidDot {
            at: at(i),
            share: shares[(i % count + i / count) % 2],
            is_going: false,
        };
        let mut dots: Vec<LaidDot> = (0..count * count).map(dot).collect();
        let dots = fitted(&mut dots, &DotDensity::new(&ink, 1.0));
        let is_inner = |dot: &&Dot| (dot.at - 100.0).abs().max_element() < 80.0;
        let radii: Vec<f32> = dots.iter().filter(is_inner).map(|dot| dot.radius).collect();
        radii.iter().sum::<f32>() / radii.len() as f32
    }

    #[test]
    fn dots_ink_their_share_of_the_paper() {
        // As many areas as there are dots wanted: 1/sqrt(0.8) = 1.118, 1/sqrt(1.5) = 0.816. Sums over a few dots are up to
        // a twentieth off.
        for (times, expected) in [(1.0, 1.0), (0.8, 1.118), (1.5, 0.816)] {
            let mean = mean_radius(times, [1.0; 2]);
            assert!((mean - expected).abs() < 0.05, "{mean} for {times}");
        }
    }

    #[test]
    fn dots_that_come_grow_where_ink_is_short() {
        // All a quarter: all become whole. One in two a half: together 0.75 of what is wanted, so that halves become 2/3 and
        // the rest of the ink comes from all: with shares of 0.833 in the mean, all are 1/sqrt(0.833) = 1.095 times as wide;
        // (1 + sqrt(2/3))/2 * 1.095 = 0.995.
        for (shares, expected) in [([0.25; 2], 1.0), ([1.0, 0.5], 0.995)] {
            let mean = mean_radius(1.0, shares);
            assert!((mean - expected).abs() < 0.05, "{mean} for {shares:?}");
        }
    }
}
