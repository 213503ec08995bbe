//! A carved urn by formula: something with relief of every kind, none of it from elsewhere.

use super::mesh::Mesh;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Half of its section, from the middle of the hollow over the lip and down to the middle of the foot: distance from
/// the axis, and height. It is 2 tall.
const SECTION: [[f32; 2]; 27] = [
    [0.0, 1.58],
    [0.16, 1.585],
    [0.27, 1.66],
    [0.31, 1.78],
    [0.39, 1.90],
    [0.46, 1.965],
    [0.51, 1.985],
    [0.53, 1.96],
    [0.50, 1.92],
    [0.41, 1.82],
    [0.36, 1.70],
    [0.40, 1.60],
    [0.56, 1.52],
    [0.70, 1.40],
    [0.765, 1.24],
    [0.76, 1.06],
    [0.68, 0.86],
    [0.54, 0.66],
    [0.36, 0.48],
    [0.22, 0.38],
    [0.185, 0.30],
    [0.21, 0.22],
    [0.34, 0.14],
    [0.43, 0.085],
    [0.45, 0.04],
    [0.43, 0.0],
    [0.0, 0.0],
];

/// The urn, of this many columns around and rows along its section.
pub(crate) fn urn(columns: usize, rows: usize) -> Mesh {
    let section = even_section(rows);
    let mut points = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        let (before, after) = (
            section[row.saturating_sub(1)],
            section[(row + 1).min(rows - 1)],
        );
        let along = (after - before).normalize_or(Vec2::X);
        // The section runs counterclockwise with the axis on its left, so outward is to its left.
        let outward = -along.perp();
        let at = section[row];
        // No relief inside the lip.
        let carved = at.y < 1.99 && along.y < 0.3 && at.x > 0.1;
        for column in 0..columns {
            let turns = column as f32 / columns as f32;
            let relief = if carved { relief(turns, at.y) } else { 0.0 };
            let Vec2 { x: across, y } = at + relief * outward;
            let (sin, cos) = (TAU * turns).sin_cos();
            points.push(Vec3::new(across * cos, y, across * sin));
        }
    }
    Mesh::grid(points, columns, true)
}

/// Points evenly spaced along the section, on a smooth curve through the given ones.
fn even_section(count: usize) -> Vec<Vec2> {
    const FINE: usize = 64;
    let point = |i: isize| Vec2::from(SECTION[i.clamp(0, SECTION.len() as isize - 1) as usize]);
    let mut fine = vec![point(0)];
    for i in 0..SECTION.len() as isize - 1 {
        let [a, b, c, d] = [point(i - 1), point(i), point(i + 1), point(i + 2)];
        for step in 1..=FINE {
            let t = step as f32 / FINE as f32;
            // Catmull and Rom's spline.
            let cubic = (b - c) * 3.0 + d - a;
            let square = a * 2.0 - b * 5.0 + c * 4.0 - d;
            fine.push(b + 0.5 * t * ((c - a) + t * (square + t * cubic)));
        }
    }
    let mut lengths = vec![0.0];
    for pair in fine.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
    }
    let whole = lengths[lengths.len() - 1];
    let mut place = 0;
    let at = |i: usize| {
        let wanted = whole * i as f32 / (count - 1) as f32;
        while place + 2 < fine.len() && lengths[place + 1] < wanted {
            place += 1;
        }
        let share = (wanted - lengths[place]) / (lengths[place + 1] - lengths[place]);
        let on_axis = fine[place].lerp(fine[place + 1], share.clamp(0.0, 1.0));
        Vec2::new(on_axis.x.max(0.0), on_axis.y)
    };
    (0..count).map(at).collect()
}

/// Height of the relief, this many turns around and at this height.
fn relief(turns: f32, y: f32) -> f32 {
    let gadroons = 0.045 * rib(turns * 28.0) * within(y, 0.42, 0.86, 0.05);
    let scales = 0.030 * scales(turns * 34.0, (1.36 - y) / 0.052) * within(y, 0.955, 1.355, 0.012);
    let tongues = 0.024 * rib(turns * 40.0) * within(y, 1.44, 1.545, 0.025);
    let neck = 0.012 * rib(turns * 60.0) * within(y, 1.66, 1.85, 0.03);
    let lip = 0.014 * rib(turns * 56.0) * within(y, 1.925, 1.98, 0.02);
    let foot = 0.016 * rib(turns * 44.0 + y * 40.0) * within(y, 0.015, 0.095, 0.015);
    let beads = bead(turns, 72.0, y, 0.905, 0.026) + bead(turns, 64.0, y, 1.398, 0.026);
    let rings = ring(y, 0.868, 0.012)
        + ring(y, 0.942, 0.011)
        + ring(y, 1.366, 0.010)
        + ring(y, 1.430, 0.010)
        + ring(y, 1.60, 0.020)
        + ring(y, 0.305, 0.030)
        + ring(y, 0.125, 0.014);
    gadroons + scales + tongues + neck + lip + foot + beads + rings
}

/// Round ribs side by side, sharp between: 0 to 1, one per unit.
fn rib(x: f32) -> f32 {
    let aside = 2.0 * (x - x.floor()) - 1.0;
    (1.0 - aside * aside).max(0.0).sqrt()
}

/// A round ring at the height `middle`, protruding by half of its height.
fn ring(y: f32, middle: f32, size: f32) -> f32 {
    (size * size - (y - middle).powi(2)).max(0.0).sqrt()
}

/// A row of beads, `count` of them, of radius `size`.
fn bead(turns: f32, count: f32, y: f32, middle: f32, size: f32) -> f32 {
    let aside = (turns * count).rem_euclid(1.0) - 0.5;
    // The rows lie about 0.7 from the axis.
    let across = aside * TAU * 0.72 / count;
    (size * size - across * across - (y - middle).powi(2))
        .max(0.0)
        .sqrt()
}

/// Scales that overlap like tiles of a roof: one per unit of x, rows one unit of `down` apart.
fn scales(x: f32, down: f32) -> f32 {
    let row = down.floor();
    // A point may be covered by its own row and by the end of the one above, which overlaps it.
    let one = |row: f32| {
        let shifted = x + 0.5 * row.rem_euclid(2.0);
        let aside = 2.0 * (shifted - shifted.floor()) - 1.0;
        let along = (down - row) / 1.75;
        // Round at its end, and a keel along its middle.
        let end = (1.0 - aside * aside).max(0.0).sqrt();
        let inside = along <= 0.35 + 0.65 * end;
        let keel = 1.0 - aside.abs().powf(1.5);
        let height = 0.18 + 0.55 * along + 0.27 * keel * (1.0 - 0.4 * along);
        if inside { height } else { 0.0 }
    };
    one(row).max(one(row - 1.0))
}

/// 1 between the heights, 0 beyond, with soft ends of this width inside.
fn within(y: f32, low: f32, high: f32, soft: f32) -> f32 {
    let inside = ((y - low).min(high - y) / soft).clamp(0.0, 1.0);
    0.5 - 0.5 * (PI * inside).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_urn_is_whole_and_faces_outward() {
        let urn = urn(256, 200);
        let closed = urn.positions.iter().all(|p| p.is_finite());
        assert!(closed && urn.turns.iter().all(|turn| turn.is_finite()));
        // The volume by the divergence theorem, as for a solid some 2 tall and half as wide.
        let volume: f32 = urn
            .faces
            .iter()
            .map(|face| {
                let [a, b, c] = face.map(|i| urn.positions[i as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        assert!((1.0..2.5).contains(&volume), "{volume}");
        let height = urn.positions.iter().map(|p| p.y).fold(0.0, f32::max);
        assert!((1.95..2.05).contains(&height), "{height}");
    }
}
