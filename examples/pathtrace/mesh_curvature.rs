//! The curvature of a mesh at its corners.
//!
//! Over a triangle the normal turns linearly, by as much as its corners' normals differ: that is the shape
//! operator of the face, by least squares over its three sides (S. Rusinkiewicz: Estimating Curvatures and Their
//! Derivatives on Triangle Meshes, 3DPVT 2004). Changes: operators are kept as matrices of space, so that those of
//! neighbouring faces are averaged as they are and no frame has to be turned into another.

use glam::{Mat3, Vec3};

/// Turn of the unit normal for a step along the surface, at every corner: positive if convex, 1/R on a ball. Smoothed
/// over neighbours `smoothing` times.
pub(crate) fn turns_of_normals(
    positions: &[Vec3],
    normals: &[Vec3],
    faces: &[[u32; 3]],
    smoothing: usize,
) -> Vec<Mat3> {
    let of_faces = faces.iter().map(|face| {
        let corners = face.map(|i| positions[i as usize]);
        let area = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .length();
        (turn_over(corners, face.map(|i| normals[i as usize])), area)
    });
    let mut turns = averaged(of_faces, faces, normals);
    for _ in 0..smoothing {
        let means = faces.iter().map(|face| {
            let [a, b, c] = face.map(|i| turns[i as usize]);
            ((a + b + c) * (1.0 / 3.0), 1.0)
        });
        turns = averaged(means, faces, normals);
    }
    turns
}

/// The weighted mean of the operators of the faces around each corner, along its tangents.
fn averaged(
    of_faces: impl Iterator<Item = (Mat3, f32)>,
    faces: &[[u32; 3]],
    normals: &[Vec3],
) -> Vec<Mat3> {
    let mut sums = vec![(Mat3::ZERO, 0.0); normals.len()];
    for ((turn, weight), face) in of_faces.zip(faces) {
        for &corner in face {
            let (sum, weights) = &mut sums[corner as usize];
            *sum += turn * weight;
            *weights += weight;
        }
    }
    let tangential = |((sum, weights), normal): ((Mat3, f32), &Vec3)| {
        let tangents = Mat3::IDENTITY - outer(*normal, *normal);
        let unit = if weights > 0.0 { 1.0 / weights } else { 0.0 };
        tangents * (sum * unit) * tangents
    };
    sums.into_iter().zip(normals).map(tangential).collect()
}

/// The symmetric operator [a b; b c] in the tangents of a triangle that best maps its sides to the differences of its
/// normals, in the least-squares sense. 0 for collinear sides.
fn turn_over(corners: [Vec3; 3], normals: [Vec3; 3]) -> Mat3 {
    let side = |i: usize| corners[(i + 2) % 3] - corners[(i + 1) % 3];
    let Some(u) = side(0).try_normalize() else {
        return Mat3::ZERO;
    };
    let Some(normal) = side(0).cross(side(1)).try_normalize() else {
        return Mat3::ZERO;
    };
    let v = normal.cross(u);
    // Each side (x, y) requires a x + b y = du and b x + c y = dv of (a, b, c); these are the normal equations.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    let mut right = Vec3::ZERO;
    for i in 0..3 {
        let [x, y] = [u, v].map(|axis| axis.dot(side(i)));
        let turned = normals[(i + 2) % 3] - normals[(i + 1) % 3];
        let [du, dv] = [u, v].map(|axis| axis.dot(turned));
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        right += Vec3::new(x * du, y * du + x * dv, y * dv);
    }
    let equations = Mat3::from_cols(
        Vec3::new(xx, xy, 0.0),
        Vec3::new(xy, xx + yy, xy),
        Vec3::new(0.0, xy, yy),
    );
    let [a, b, c] = (equations.inverse() * right).to_array();
    let turn = outer(u, u) * a + (outer(u, v) + outer(v, u)) * b + outer(v, v) * c;
    if turn.is_finite() { turn } else { Mat3::ZERO }
}

/// `a b^T`.
pub(crate) fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
mod tests {
    use crate::mesh::Mesh;
    use glam::Vec3;
    use std::f32::consts::{PI, TAU};

    /// A torus about y.
    fn torus(large: f32, small: f32, columns: usize, rows: usize) -> Mesh {
        let points = (0..=rows).flat_map(|row| {
            (0..columns).map(move |column| {
                let [(s, c), (sv, cv)] =
                    [column as f32 / columns as f32, -(row as f32) / rows as f32]
                        .map(|turns| (TAU * turns).sin_cos());
                let across = large + small * cv;
                Vec3::new(across * c, small * sv, across * s)
            })
        });
        Mesh::grid(points.collect(), columns, true)
    }

    #[test]
    fn a_torus_has_both_its_curvatures() {
        // Around the tube 1/r; about the axis cos v / (R + r cos v): convex outside, concave inside. Smoothing averages
        // operators rotated by 3 degrees against each other, which costs about tan^2 of it, 0.3 %, a pass.
        let (large, small, columns, rows) = (1.0, 0.4, 240, 120);
        let mesh = torus(large, small, columns, rows);
        for row in 4..rows - 4 {
            let corner = row * columns + 17;
            let position = mesh.positions[corner];
            let cv = (TAU * row as f32 / rows as f32).cos();
            let around = Vec3::new(-position.z, 0.0, position.x).normalize();
            let along = mesh.normals[corner].cross(around);
            let turn = mesh.turns[corner];
            let found = [along.dot(turn * along), around.dot(turn * around)];
            let expected = [1.0 / small, cv / (large + small * cv)];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 0.006 * 2.5,
                    "row {row}: {found}, not {expected}"
                );
            }
            assert!((turn * mesh.normals[corner]).length() < 1e-5);
            assert!(along.dot(turn * around).abs() < 0.02);
        }
    }

    #[test]
    fn normals_point_outward_and_a_ball_is_convex() {
        let points = (1..40).flat_map(|row| {
            (0..80).map(move |column| {
                let (s, c) = (PI * row as f32 / 40.0).sin_cos();
                let (sin, cos) = (TAU * column as f32 / 80.0).sin_cos();
                2.0 * Vec3::new(s * cos, c, s * sin)
            })
        });
        let ball = Mesh::grid(points.collect(), 80, true);
        for row in 5..30 {
            let corner = row * 80 + 3;
            let (normal, position) = (ball.normals[corner], ball.positions[corner]);
            assert!(normal.dot(position) > 1.99, "{normal}");
            let turn = ball.turns[corner];
            let tangent = normal.any_orthonormal_vector();
            assert!((tangent.dot(turn * tangent) - 0.5).abs() < 0.01, "{turn}");
        }
    }
}
