//! Triangles with normals and curvature at their corners, on a grid.

use super::geometry::Form;
use super::mesh_curvature::turns_of_normals;
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
        let turns = turns_of_normals(&positions, &normals, &faces, SMOOTHING);
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
