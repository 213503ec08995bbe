//! Height from normals: the surface whose slopes are nearest to those that the normals say.
//!
//! Across each face between two pixels the height should change by the mean of their slopes. The least-squares height,
//! faces weighted by their conductance so that it may jump at silhouettes and creases, solves Poisson's equation: here by
//! conjugate gradients with multigrid. Depth, where there is any, pulls the height at low frequencies: the normals hold
//! its detail, depth its overall shape (Nehab, Rusinkiewicz, Davis, Ramamoorthi, *Efficiently Combining Positions and
//! Normals for Precise 3D Geometry*, SIGGRAPH 2005).

mod cpu;
mod faces;
mod multigrid;
pub(crate) mod stage;

use crate::frame::{Mask, Plane};
use crate::plan::Plan;
use faces::Faces;
use multigrid::{GridLevel, cycle, dot};
use rayon::prelude::*;

/// Its name among the stages, in timings and in a session.
const NAME: &str = "height";

/// Whether the height goes on across edges: what casts shadows does, or letters would come loose from their ground.
fn goes_over_edges(plan: &Plan) -> bool {
    let relighting = plan.relighting();
    relighting.is_some_and(|relighting| relighting.casts_from_normals())
}

/// Changes of the height from each pixel to the next one to the right, and to the next one below; 0 outside the mask.
pub(crate) struct HeightSlopes {
    pub(crate) x: Plane,
    pub(crate) y: Plane,
}

/// The height wanted.
pub(crate) struct Problem<'a> {
    pub(crate) slopes: &'a HeightSlopes,
    pub(crate) conductance: &'a Plane,
    pub(crate) mask: &'a Mask,
    /// Whether left and right borders continue each other, and top and bottom.
    pub(crate) wraps: [bool; 2],
    /// Heights to be near to, and the distance in pixels over which normals alone count; 0 heights for none.
    pub(crate) near: Option<(&'a Plane, f32)>,
    /// Largest error in relation to that of no height at all, in the energy of slopes.
    pub(crate) tolerance: f32,
}

/// More rounds are not worth their time: with half of all faces closed at random 40 do.
const MOST_ROUNDS: usize = 200;

/// The height in pixels, 0 outside the mask, without depth with mean 0 over each connected surface; and the rounds of
/// conjugate gradients that it took.
pub(crate) fn solve(problem: &Problem) -> (Plane, usize) {
    let &Problem {
        slopes,
        mask,
        wraps,
        near,
        ..
    } = problem;
    let faces = Faces::new(problem.conductance, mask, wraps);
    let mut changes = FaceChanges::of(slopes, &faces);
    let Some((depth, length_px)) = near else {
        let islands = Islands::of(&faces, mask);
        let right = changes.divergence(&faces);
        drop(changes);
        let (mut height, rounds) = conjugate_gradients(
            GridLevel::all(faces, None),
            right,
            problem.tolerance,
            islands.are_one(mask),
        );
        islands.level(&mut height);
        return (height, rounds);
    };
    // What is wanted beyond the depth is small: single precision is enough for it.
    changes.subtract(&FaceChanges::between(depth));
    let pull = length_px.max(1.0).powi(-2);
    let pull = mask.plane().map(|covered| if covered { pull } else { 0.0 });
    let right = changes.divergence(&faces);
    drop(changes);
    let (mut height, rounds) = conjugate_gradients(
        GridLevel::all(faces, Some(pull)),
        right,
        problem.tolerance,
        false,
    );
    height.each_with(depth, |height, depth| *height += depth);
    (height, rounds)
}

/// How far the changes of `height` are from those wanted: for each pixel the length of the difference, the root mean
/// square over its faces in x and y.
pub(crate) fn residual(problem: &Problem, height: &Plane) -> Plane {
    let faces = Faces::new(problem.conductance, problem.mask, problem.wraps);
    let mut missed = FaceChanges::of(problem.slopes, &faces);
    missed.subtract(&FaceChanges::between(height));
    let (width, rows) = (height.width(), height.height());
    let mean = |weights: [f32; 2], missed: [f32; 2]| {
        let sum = weights[0] + weights[1];
        let squares = weights[0] * missed[0] * missed[0] + weights[1] * missed[1] * missed[1];
        if sum > 0.0 { squares / sum } else { 0.0 }
    };
    Plane::of_pixels(width, rows, |x, y| {
        let (before, above) = ((x + width - 1) % width, (y + rows - 1) % rows);
        let across = [&faces.x, &missed.x].map(|p| [p.at(before, y), p.at(x, y)]);
        let down = [&faces.y, &missed.y].map(|p| [p.at(x, above), p.at(x, y)]);
        (mean(across[0], across[1]) + mean(down[0], down[1])).sqrt()
    })
}

/// Changes across the faces to the right of and below each pixel.
struct FaceChanges {
    x: Plane,
    y: Plane,
}

impl FaceChanges {
    /// The means of the slopes beside each face; the second-order rule.
    fn of(slopes: &HeightSlopes, faces: &Faces) -> Self {
        let (width, height) = (slopes.x.width(), slopes.x.height());
        let x = Plane::of_pixels(width, height, |x, y| match faces.x.at(x, y) > 0.0 {
            true => 0.5 * (slopes.x.at(x, y) + slopes.x.at((x + 1) % width, y)),
            false => 0.0,
        });
        let y = Plane::of_pixels(width, height, |x, y| match faces.y.at(x, y) > 0.0 {
            true => 0.5 * (slopes.y.at(x, y) + slopes.y.at(x, (y + 1) % height)),
            false => 0.0,
        });
        Self { x, y }
    }

    /// Those of a height.
    fn between(heights: &Plane) -> Self {
        let (width, height) = (heights.width(), heights.height());
        let x = Plane::of_pixels(width, height, |x, y| {
            heights.at((x + 1) % width, y) - heights.at(x, y)
        });
        let y = Plane::of_pixels(width, height, |x, y| {
            heights.at(x, (y + 1) % height) - heights.at(x, y)
        });
        Self { x, y }
    }

    fn subtract(&mut self, other: &Self) {
        for (plane, other) in [(&mut self.x, &other.x), (&mut self.y, &other.y)] {
            plane.each_with(other, |own, other| *own -= other);
        }
    }

    /// What flows into each pixel: the equation's right-hand side.
    fn divergence(&self, faces: &Faces) -> Plane {
        let (width, height) = (self.x.width(), self.x.height());
        let mut sums = Plane::filled(width, height, 0.0);
        sums.each_row(|y, row| {
            let above = (y + height - 1) % height;
            let [across, right] = [&self.x, &faces.x].map(|plane| plane.row(y));
            let [down, below] = [&self.y, &faces.y].map(|plane| plane.row(y));
            let [from, up] = [&self.y, &faces.y].map(|plane| plane.row(above));
            for (x, sum) in row.iter_mut().enumerate() {
                let before = (x + width - 1) % width;
                *sum = (right[before] * across[before] - right[x] * across[x])
                    + (up[x] * from[x] - below[x] * down[x]);
            }
        });
        sums
    }
}

/// Solves the equation of the first level by conjugate gradients, preconditioned by a cycle over all.
///
/// Where nothing pulls the height it is known up to a constant, and rounding adds one to the residual: it is taken off
/// again. A round that no longer brings the height nearer is the last: single precision holds no more.
fn conjugate_gradients(
    mut levels: Vec<GridLevel>,
    right: Plane,
    tolerance: f32,
    is_free: bool,
) -> (Plane, usize) {
    let (width, rows) = (right.width(), right.height());
    let empty = || Plane::filled(width, rows, 0.0);
    let (mut height, mut residual) = (empty(), right);
    let (mut correction, mut image) = (empty(), empty());
    cycle(&mut levels, &residual, &mut correction);
    let mut direction = correction.clone();
    let mut energy = product(&residual, &correction);
    let enough = energy * f64::from(tolerance).powi(2);
    let mut rounds = 0;
    while energy > enough && energy > 0.0 && rounds < MOST_ROUNDS {
        rounds += 1;
        let Some(level) = levels.first() else {
            break;
        };
        let curvature = level.applied(&direction, &mut image);
        if curvature.is_nan() || curvature <= 0.0 {
            break;
        }
        let step = (energy / curvature) as f32;
        add(&mut height, step, &direction);
        add(&mut residual, -step, &image);
        if is_free {
            center(&mut residual);
        }
        cycle(&mut levels, &residual, &mut correction);
        let next = product(&residual, &correction);
        if next.is_nan() || next >= energy {
            break;
        }
        let kept = (next / energy) as f32;
        energy = next;
        direction.each_with(&correction, |direction, correction| {
            *direction = kept * *direction + correction;
        });
    }
    (height, rounds)
}

/// Adds `factor` times `other`.
fn add(plane: &mut Plane, factor: f32, other: &Plane) {
    plane.each_with(other, |own, other| *own += factor * other);
}

/// Takes the mean off a plane.
fn center(plane: &mut Plane) {
    let rows = (0..plane.height()).into_par_iter();
    let sums: Vec<f64> = rows
        .map(|y| plane.row(y).iter().map(|&v| f64::from(v)).sum())
        .collect();
    let mean = (sums.iter().sum::<f64>() / plane.samples().len().max(1) as f64) as f32;
    plane.each_row(|_, row| row.iter_mut().for_each(|v| *v -= mean));
}

/// The product of two planes.
fn product(a: &Plane, b: &Plane) -> f64 {
    let sums: Vec<f64> = (0..a.height())
        .into_par_iter()
        .map(|y| dot(a.row(y), b.row(y)))
        .collect();
    sums.iter().sum()
}

/// Connected surfaces, which have no height in relation to each other.
struct Islands {
    /// The number of each pixel's; 0 outside the mask.
    of: Plane<u32>,
    count: usize,
}

impl Islands {
    fn of(faces: &Faces, mask: &Mask) -> Self {
        let (width, height) = (mask.width(), mask.height());
        let mut of = Plane::filled(width, height, 0_u32);
        let (mut count, mut open) = (0, Vec::new());
        for y in 0..height {
            for x in mask.span(y) {
                if !mask.at(x, y) || of.at(x, y) != 0 {
                    continue;
                }
                count += 1;
                let mut reach = |x: usize, y: usize, face: f32, open: &mut Vec<(usize, usize)>| {
                    let own = &mut of.row_mut(y)[x];
                    if face > 0.0 && *own == 0 {
                        *own = count;
                        open.push((x, y));
                    }
                };
                reach(x, y, 1.0, &mut open);
                while let Some((x, y)) = open.pop() {
                    let (before, after) = ((x + width - 1) % width, (x + 1) % width);
                    let (above, below) = ((y + height - 1) % height, (y + 1) % height);
                    reach(before, y, faces.x.at(before, y), &mut open);
                    reach(after, y, faces.x.at(x, y), &mut open);
                    reach(x, above, faces.y.at(x, above), &mut open);
                    reach(x, below, faces.y.at(x, y), &mut open);
                }
            }
        }
        Self {
            of,
            count: count as usize,
        }
    }

    /// Whether they are one, all over the picture.
    fn are_one(&self, mask: &Mask) -> bool {
        self.count == 1 && mask.count() == mask.width() * mask.height()
    }

    /// Subtracts from each surface its mean height.
    fn level(&self, height: &mut Plane) {
        let mut sums = vec![(0.0, 0_u64); self.count + 1];
        for (island, height) in self.of.samples().iter().zip(height.samples()) {
            let (sum, count) = &mut sums[*island as usize];
            *sum += f64::from(*height);
            *count += 1;
        }
        let means = sums
            .iter()
            .map(|&(sum, count)| (sum / count.max(1) as f64) as f32);
        let means: Vec<f32> = means.collect();
        height.each_with(&self.of, |height, island| {
            *height = match island {
                0 => 0.0,
                _ => *height - means[island as usize],
            };
        });
    }
}

#[cfg(test)]
mod tests;
