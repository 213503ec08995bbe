//! Outlines of lines of varying width with round ends.

use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Smallest distance of points that follow each other.
const LEAST_STEP: f32 = 0.1;

/// Largest deviation of a corner from an arc.
const SAG: f32 = 1.0;

/// The outline of a line by its points and half its width at each, to be filled where it winds around a place at least
/// once: the left rim of its way there and back, with arcs about its ends and outer corners.
///
/// Where a corner is tighter than the line is wide, the inner rim goes by the corner's middle. Every piece is then
/// wound around in the same direction, and overlaps of pieces never cancel.
pub(super) fn outline(mut line: Vec<Vec3>) -> Vec<Vec3> {
    line.dedup_by(|b, a| a.truncate().distance(b.truncate()) < LEAST_STEP);
    if let [at] = line[..] {
        line.push(at + LEAST_STEP * Vec3::X);
    }
    let last = line.len().saturating_sub(1);
    let at = |i: usize| line[(i % (2 * last)).min(2 * last - i % (2 * last))];
    let mut rim = Vec::new();
    for i in 0..2 * last {
        let pieces = [i + 2 * last - 1, i].map(|i| piece(at(i), at(i + 1)));
        join(&mut rim, at(i), pieces, i % last == 0);
    }
    rim
}

/// The unit vector from the middle of a piece to its left rim, perpendicular to the rim, and the piece's length. The rim
/// touches circles of both its radii: over a length l it leans by asin((r1 - r0) / l).
fn piece(from: Vec3, to: Vec3) -> (Vec2, f32) {
    let length = from.truncate().distance(to.truncate());
    let step = (to - from) / length;
    let (along, growth) = (step.truncate(), step.z.clamp(-1.0, 1.0));
    let left = (1.0 - growth * growth).sqrt() * along.perp() - growth * along;
    (left, length)
}

/// Appends the left rim where two pieces meet.
fn join(rim: &mut Vec<Vec3>, middle: Vec3, pieces: [(Vec2, f32); 2], is_end: bool) {
    let (at, radius) = (middle.truncate().extend(0.0), middle.z);
    let [(before, length), (after, next)] = pieces;
    let turn = before.perp_dot(after).atan2(before.dot(after));
    // The rim goes around an end clockwise, as around any corner that it is on the outer side of.
    let turn = match is_end {
        true => -(-turn).rem_euclid(TAU),
        false => turn,
    };
    let corner = |left: Vec2| at + (radius * left).extend(0.0);
    if turn > 0.0 && radius * turn > length.min(next) {
        rim.extend([corner(before), at, corner(after)]);
        return;
    }
    let step = 2.0 * (1.0 - SAG / radius.max(SAG)).acos();
    let steps = (-turn / step).ceil().max(1.0);
    // Corners lie outside the arc, so that the straight rims between arcs are at their distance.
    let angle = turn / steps;
    let farther = (0.5 * angle).abs().min(1.0).cos().recip();
    rim.extend((0..steps as u32).map(|i| {
        let turned = Vec2::from_angle(angle * (i as f32 + 0.5));
        corner(farther * turned.rotate(before))
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    /// Area of the polygon, positive if wound around as [`outline`] does.
    fn area(rim: &[Vec3]) -> f32 {
        let next = rim.iter().cycle().skip(1);
        -0.5 * rim
            .iter()
            .zip(next)
            .map(|(a, b)| a.cross(*b).z)
            .sum::<f32>()
    }

    /// How often the polygon winds around a place.
    fn winding(rim: &[Vec3], at: Vec2) -> i32 {
        let next = rim.iter().cycle().skip(1);
        let turns = rim.iter().zip(next).map(|(a, b)| {
            let (a, b) = (a.truncate() - at, b.truncate() - at);
            a.perp_dot(b).atan2(a.dot(b))
        });
        (turns.sum::<f32>() / TAU).round() as i32
    }

    #[test]
    fn a_straight_line_of_growing_width_has_the_area_between_its_circles() {
        // Radii 20 and 60 at 1000 from each other: the rims lean by p = asin(0.04). Between the touching points are two
        // trapezoids of height 1000 cos p and sides 20 and 60, beyond them sectors of pi - 2 p and pi + 2 p:
        // (20 + 60) 1000 cos p + 20^2 (pi/2 - p) + 60^2 (pi/2 + p).
        let lean = 0.04_f32.asin();
        let sectors = 400.0 * (0.5 * PI - lean) + 3600.0 * (0.5 * PI + lean);
        let expected = 80_000.0 * lean.cos() + sectors;
        for count in [2, 3, 41] {
            let share = |i: i32| i as f32 / (count - 1) as f32;
            let line = (0..count)
                .map(|i| Vec3::new(0.0, 0.0, 20.0) + share(i) * Vec3::new(600.0, 800.0, 40.0));
            let found = area(&outline(line.collect()));
            // Corners are up to 1 outside the arcs, 250 long: on average a third of that.
            let beyond = found - expected;
            assert!(
                (0.0..100.0).contains(&beyond),
                "{count}: {found} of {expected}"
            );
        }
    }

    #[test]
    fn a_point_is_a_disc() {
        let middle = Vec3::new(50.0, 50.0, 40.0);
        let rim = outline(vec![middle; 3]);
        let mut radii = rim
            .iter()
            .map(|at| at.truncate().distance(middle.truncate()));
        assert!(rim.len() > 8 && radii.all(|radius| (39.8..41.1).contains(&radius)));
        assert!(outline(vec![]).is_empty());
    }

    #[test]
    fn curls_and_corners_tighter_than_their_width_have_no_holes() {
        // A ring of radius 20 and half width 30 covers the disc of radius 50.
        let at = |i: i32| (20.0 * Vec2::from_angle(i as f32 / 41.0 * TAU)).extend(30.0);
        for direction in [1, -1] {
            let rim = outline((0..=41).map(|i| at(direction * i)).collect());
            for i in 0..200 {
                let inside = 0.245 * i as f32 * Vec2::from_angle(i as f32);
                assert!(winding(&rim, inside) < 0, "{inside}");
            }
            assert!(rim.iter().all(|at| at.length() < 51.1));
        }
        // A hairpin: there and back beside itself.
        let pin = [[0.0, 0.0, 30.0], [400.0, 0.0, 30.0], [0.0, 10.0, 30.0]];
        let rim = outline(pin.map(Vec3::from).to_vec());
        for x in 0..400 {
            for y in [-29.0, -15.0, 0.0, 5.0, 29.0] {
                let at = Vec2::new(x as f32, y);
                assert!(winding(&rim, at) < 0, "{at}");
            }
        }
    }
}
