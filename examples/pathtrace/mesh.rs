//! Triangles with normals and curvature at their corners, from an OBJ file or a formula.

use super::geometry::Form;
use super::mesh_curvature::turns_of_normals;
use glam::{Mat3, Vec3};
use std::collections::HashMap;
use std::error::Error;
use std::io::Write;
use std::path::Path;

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

    /// The meshes of an OBJ file as one, upright on the ground y = 0 around the axis, `height` tall.
    ///
    /// Normals in the file are ignored: curvature needs those of the triangles themselves.
    pub(crate) fn read(path: &Path, height: f32) -> Result<Self, Box<dyn Error>> {
        let named = |what: String| format!("{}: {what}", path.display());
        // The loader reports every file only as impossible to open; the system gives the reason.
        std::fs::File::open(path).map_err(|error| named(error.to_string()))?;
        let options = tobj::LoadOptions {
            triangulate: true,
            ..tobj::LoadOptions::default()
        };
        let (models, _) = tobj::load_obj(path, &options).map_err(|e| named(e.to_string()))?;
        let (mut corners, mut faces) = (Corners::default(), Vec::new());
        for mesh in models.into_iter().map(|model| model.mesh) {
            let corner = |&index: &u32| {
                let at = 3 * index as usize;
                let position = mesh.positions.get(at..at + 3)?;
                corners.place_of(Vec3::from_slice(position))
            };
            let places: Option<Vec<u32>> = mesh.indices.iter().map(corner).collect();
            let places = places.ok_or_else(|| named("a corner is missing or not finite".into()))?;
            faces.extend(
                places
                    .chunks_exact(3)
                    .map(|face| [face[0], face[1], face[2]]),
            );
        }
        let positions = corners.positions;
        let low = positions.iter().fold(Vec3::INFINITY, |low, &p| low.min(p));
        let high = positions
            .iter()
            .fold(Vec3::NEG_INFINITY, |high, &p| high.max(p));
        let scale = height / (high.y - low.y);
        if faces.is_empty() || !scale.is_finite() {
            return Err(named("has no triangles, or they are all level".into()).into());
        }
        let foot = Vec3::new(0.5 * (low.x + high.x), low.y, 0.5 * (low.z + high.z));
        let stood = positions.into_iter().map(|p| scale * (p - foot)).collect();
        Ok(Self::new(stood, faces))
    }

    /// Writes the mesh as OBJ.
    pub(crate) fn write(&self, w: &mut impl Write) -> std::io::Result<()> {
        for p in &self.positions {
            writeln!(w, "v {} {} {}", p.x, p.y, p.z)?;
        }
        for [a, b, c] in self.faces.iter().map(|face| face.map(|i| i + 1)) {
            writeln!(w, "f {a} {b} {c}")?;
        }
        Ok(())
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

/// Corners of a file, merged where they coincide: files repeat them along texture seams.
#[derive(Default)]
struct Corners {
    positions: Vec<Vec3>,
    places: HashMap<[u32; 3], u32>,
}

impl Corners {
    /// `None` where it is not finite.
    fn place_of(&mut self, position: Vec3) -> Option<u32> {
        let next = self.positions.len() as u32;
        // Plus 0, so that -0 and 0 are one.
        let bits = (position + 0.0).to_array().map(f32::to_bits);
        let place = *self.places.entry(bits).or_insert(next);
        if place == next {
            self.positions.push(position);
        }
        position.is_finite().then_some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_mesh_reads_back_and_stands_on_the_ground() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("tent.obj");
        // A tent 2 wide and 4 tall, a bag of corners away from the origin.
        let corners = [[0, 0, 0], [2, 0, 0], [1, 4, 1], [1, 0, 2]]
            .map(|[x, y, z]| Vec3::new(x as f32, y as f32, z as f32) + Vec3::new(9.0, -7.0, 3.0));
        let faces = vec![[0, 2, 1], [1, 2, 3], [3, 2, 0], [0, 1, 3]];
        let tent = Mesh::new(corners.to_vec(), faces.clone());
        let mut file = std::fs::File::create(&path).unwrap();
        tent.write(&mut file).unwrap();
        let read = Mesh::read(&path, 2.0).unwrap();
        assert_eq!(read.positions.len(), 4);
        let low = read.positions.iter().fold(Vec3::INFINITY, |a, &b| a.min(b));
        let high = read
            .positions
            .iter()
            .fold(-Vec3::INFINITY, |a, &b| a.max(b));
        assert_eq!((low.y, high.y), (0.0, 2.0));
        assert!((low.x + high.x).abs() < 1e-6 && (low.z + high.z).abs() < 1e-6);
    }

    #[test]
    fn what_cannot_be_read_is_told_in_one_line() {
        let place = tempfile::tempdir().unwrap();
        let contents = [
            ("empty.obj", ""),
            ("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"),
            ("beyond.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n"),
            ("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"),
            ("broken.obj", "v 0 zero 0\n"),
        ];
        for (name, text) in contents {
            let path = place.path().join(name);
            std::fs::write(&path, text).unwrap();
            let error = Mesh::read(&path, 1.0).err().expect(name).to_string();
            assert!(error.contains(name) && !error.contains('\n'), "{error}");
        }
        let missing = Mesh::read(&place.path().join("none.obj"), 1.0)
            .err()
            .unwrap();
        assert!(missing.to_string().contains("none.obj"), "{missing}");
    }
}
