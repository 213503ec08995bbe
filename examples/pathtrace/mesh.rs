//! Triangles with normals and curvature at their corners, on a grid.
//!
//! Over a triangle the normal turns linearly, by as much as its corners' normals differ: that is the shape
//! operator of the face, by least squares over its three sides (S. Rusinkiewicz: Estimating Curvatures and Their
//! Derivatives on Triangle Meshes, 3DPVT 2004). Changes: operators are kept as matrices of space, so that those of
//! neighbouring faces are averaged as they are and no frame has to be turned into another.

use super::geometry::Form;
use glam::{Mat3, Vec3};

/// Curvature is evened out this often over neighbouring corners: enough for the grain of a mesh.
const SMOOTHING: usize = 2;

/// A surface of triangles, counterclockwise seen from outside.
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) faces: Vec<[u32; 3]>,
    /// Unit normals.
    pub(crate) normals: Vec<Vec3>,
    /// Turn of the normal for a step along the surface: its shape operator, in space.
    pub(crate) turns: Vec<Mat3>,
}

impl Mesh {
    /// The surface through these corners. Faces of no area are left out.
    pub(crate) fn new(positions: Vec<Vec3>, mut faces: Vec<[u32; 3]>) -> Self {
        faces.retain(|face| {
            let area = normal_by_area(&positions, face).length_squared();
            area > 0.0 && area.is_finite()
        });
        let mut normals = vec![Vec3::ZERO; positions.len()];
        for face in &faces {
            let normal = normal_by_area(&positions, face);
            for &corner in face {
                normals[corner as usize] += normal;
            }
        }
        let normals: Vec<Vec3> = normals
            .into_iter()
            .map(|n| n.try_normalize().unwrap_or(Vec3::Y))
            .collect();
        let turns = turns_of_normals(&positions, &normals, &faces);
        Self {
            positions,
            faces,
            normals,
            turns,
        }
    }

    /// The surface through a grid of points, `columns` wide; `closed` joins the last column to the first.
    pub(crate) fn grid(points: Vec<Vec3>, columns: usize, closed: bool) -> Self {
        let rows = points.len() / columns;
        let mut faces = Vec::with_capacity(2 * points.len());
        for row in 0..rows.saturating_sub(1) {
            for column in 0..if closed { columns } else { columns - 1 } {
                let next = (column + 1) % columns;
                let at = |row: usize, column: usize| (row * columns + column) as u32;
                let [a, b] = [at(row, column), at(row, next)];
                let [c, d] = [at(row + 1, column), at(row + 1, next)];
                faces.extend([[a, b, d], [a, d, c]]);
            }
        }
        Self::new(points, faces)
    }

    /// A parallelogram.
    pub(crate) fn rectangle(corner: Vec3, [a, b]: [Vec3; 2]) -> Self {
        let corners = vec![corner, corner + a, corner + b, corner + a + b];
        Self::grid(corners, 2, false)
    }

    /// The triangles as forms.
    pub(crate) fn forms(&self) -> impl Iterator<Item = Form> {
        self.faces.iter().enumerate().map(|(face, corners)| {
            let [a, b, c] = corners.map(|i| self.positions[i as usize]);
            Form::Triangle {
                corner: a,
                sides: [b - a, c - a],
                face: face as u32,
            }
        })
    }

    /// Unit normal and its turn on the face, at the weights `uv` of its second and third corner.
    #[inline]
    pub(crate) fn at(&self, face: u32, [u, v]: [f32; 2]) -> (Vec3, Mat3) {
        let corners = self.faces[face as usize].map(|i| i as usize);
        let weights = [1.0 - u - v, u, v];
        let (mut normal, mut turn) = (Vec3::ZERO, Mat3::ZERO);
        for (corner, weight) in corners.into_iter().zip(weights) {
            normal += weight * self.normals[corner];
            turn += self.turns[corner] * weight;
        }
        (normal.normalize_or(self.normals[corners[0]]), turn)
    }
}

/// Twice the area, along the normal.
fn normal_by_area(positions: &[Vec3], face: &[u32; 3]) -> Vec3 {
    let [a, b, c] = face.map(|i| positions[i as usize]);
    (b - a).cross(c - a)
}

/// Turn of the unit normal for a step along the surface, at every corner: positive if convex, 1/R on a ball.
fn turns_of_normals(positions: &[Vec3], normals: &[Vec3], faces: &[[u32; 3]]) -> Vec<Mat3> {
    let of_faces = faces.iter().map(|face| {
        let corners = face.map(|i| positions[i as usize]);
        let area = normal_by_area(positions, face).length();
        (turn_over(corners, face.map(|i| normals[i as usize])), area)
    });
    let mut turns = averaged(of_faces, faces, normals);
    for _ in 0..SMOOTHING {
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
    let [u, normal] = [side(0), side(0).cross(side(1))].map(|v| v.normalize_or_zero());
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
pub(super) fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

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
}
