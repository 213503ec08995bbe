//! The camera from a file's attributes, in the forms renderers write.
//!
//! The standard's `worldToCamera` and `worldToNDC` are row-vector matrices to a camera that looks along +z, with (0, 0)
//! at the top left of the display window and (1, 1) at its bottom right. Writers depart from it: pbrt transposes both,
//! others look along -z, or count from -1 to 1 with y up. V-Ray and Redshift write the camera-to-world transform and
//! the field of view, Unreal strings in a left-handed world. So every plausible reading is tried, the standard's first,
//! and the layers of positions or normals decide.

use crate::frame::{Camera, Projection, Window};
use crate::io::roles::names::plain_attribute;
use glam::{DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4};
use std::collections::BTreeMap;

/// A camera that the attributes may mean.
#[derive(Debug, Clone)]
pub(super) struct CameraCandidate {
    pub(super) camera: Camera,
    /// The attributes it was read from, and how.
    pub(super) reading: String,
}

impl CameraCandidate {
    fn new(view_from_world: DAffine3, projection: Projection, reading: String) -> Self {
        let camera = Camera {
            view_from_world,
            projection,
        };
        Self { camera, reading }
    }
}

/// A turn may be off orthonormal by this much.
const ROTATION_TOLERANCE: f64 = 2e-3;
/// Largest offset of the view axis from the middle of the picture, as a share of it; a larger lens shift is not
/// accepted.
const MOST_SHIFT: f64 = 0.4;

/// Axes of a camera as view space has them: x right, y up, z toward the viewer.
const AXES: [(DVec3, &str); 4] = [
    (DVec3::new(1.0, 1.0, -1.0), "looking along +z"),
    (DVec3::new(1.0, 1.0, 1.0), "looking along -z"),
    (
        DVec3::new(-1.0, 1.0, -1.0),
        "looking along +z, x to the left",
    ),
    (DVec3::new(1.0, -1.0, -1.0), "looking along +z, y down"),
];

/// Every camera that the attributes may mean, the likeliest first, with numbers in their ranges.
pub(super) fn candidates(
    attributes: &BTreeMap<String, String>,
    display: Window,
    aspect: f64,
) -> Vec<CameraCandidate> {
    let by_name = attributes
        .iter()
        .map(|(name, text)| (plain_attribute(name).to_ascii_lowercase(), text.as_str()));
    let attributes = NamedAttributes(by_name.collect());
    let picture = CameraPicture { display, aspect };
    let mut found = attributes.of_matrices(&picture);
    found.extend(attributes.of_placings(&picture));
    found.extend(attributes.of_unreal(&picture));
    found.retain(|candidate| candidate.camera.check(display).is_ok());
    found
}

/// The pixels of the camera's picture.
struct CameraPicture {
    display: Window,
    aspect: f64,
}

impl CameraPicture {
    fn size(&self) -> DVec2 {
        DVec2::new(self.display.width() as f64, self.display.height() as f64)
    }

    fn corner(&self) -> DVec2 {
        DVec2::new(self.display.x0.into(), self.display.y0.into())
    }

    /// A centred lens of this horizontal field of view.
    fn lens(&self, half_tan: f64) -> Option<Projection> {
        let fx = 0.5 * self.size().x / half_tan;
        let is_lens = half_tan > 0.0 && fx.is_finite();
        is_lens.then(|| Projection::new(false, [fx, fx * self.aspect], self.display.center()))
    }
}

/// Attributes by their names in lower case.
struct NamedAttributes<'a>(BTreeMap<String, &'a str>);

impl NamedAttributes<'_> {
    fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        self.0.get(name).map(|text| numbers(text))
    }

    fn number(&self, name: &str) -> Option<f64> {
        match self.numbers(name)?.as_slice() {
            [number] => Some(*number),
            _ => None,
        }
    }

    /// The matrix for column vectors, if the file holds one for row vectors.
    fn matrix(&self, name: &str) -> Option<DMat4> {
        let numbers: [f64; 16] = self.numbers(name)?.try_into().ok()?;
        Some(DMat4::from_cols_array(&numbers))
    }

    /// `worldToCamera`, with `worldToNDC` or a lens of its own.
    fn of_matrices(&self, picture: &CameraPicture) -> Vec<CameraCandidate> {
        let Some(to_camera) = self.matrix("worldtocamera") else {
            return Vec::new();
        };
        let to_ndc = self.matrix("worldtondc");
        let mut found = Vec::new();
        for (transposed, how) in [(false, ""), (true, "transposed, ")] {
            let read = |m: DMat4| if transposed { m.transpose() } else { m };
            let Some(camera_from_world) = rigid(read(to_camera)) else {
                continue;
            };
            for (axes, looks) in AXES {
                let view_from_world = DAffine3::from_scale(axes) * camera_from_world;
                let mut add = |projection, lens: &str| {
                    let reading = format!("worldToCamera {how}{looks}{lens}");
                    found.push(CameraCandidate::new(view_from_world, projection, reading));
                };
                if let Some(to_ndc) = to_ndc {
                    let ndc_from_view = read(to_ndc)
                        * DMat4::from(camera_from_world.inverse())
                        * DMat4::from_scale(axes);
                    for (ndc, lens) in Ndc::ALL {
                        if let Some(projection) = ndc.projection(&ndc_from_view, picture) {
                            add(projection, lens);
                        }
                    }
                } else if let Some(projection) = self.lens(picture) {
                    add(projection, "");
                }
            }
        }
        // A turn that mirrors makes sense in a left-handed world alone.
        found.sort_by_key(|candidate| is_mirrored(&candidate.camera));
        found
    }

    /// Focal length over aperture, or a field of view, under the names that renderers give them.
    fn lens(&self, picture: &CameraPicture) -> Option<Projection> {
        let apertures = [
            ("camerafilmaperturehorizontal", "camerafocallength"),
            ("cameraaperture", "camerafocallength"),
        ];
        let by_aperture = apertures
            .iter()
            .find_map(|(aperture, focal)| Some(0.5 * self.number(aperture)? / self.number(focal)?));
        let by_angle = ["camerafov", "rs/camera/fov", "camera/fov"]
            .iter()
            .find_map(|name| Some((0.5 * self.number(name)?.to_radians()).tan()));
        picture.lens(by_angle.or(by_aperture)?)
    }

    /// The camera's own placing in the world: `cameraTransform` of V-Ray, `rs/camera/transform` of Redshift.
    fn of_placings(&self, picture: &CameraPicture) -> Vec<CameraCandidate> {
        let names = [
            ("cameratransform", "cameraTransform", [1, 0, 2, 3]),
            ("rs/camera/transform", "rs/camera/transform", [1, 2, 0, 3]),
        ];
        let mut found = Vec::new();
        for (name, stated, order) in names {
            let (Some(matrix), Some(projection)) = (self.matrix(name), self.lens(picture)) else {
                continue;
            };
            for (matrix, how) in [(matrix, ""), (matrix.transpose(), "transposed, ")] {
                let Some(world_from_camera) = rigid(matrix) else {
                    continue;
                };
                for (axes, looks) in order.map(|i| AXES[i]) {
                    let view_from_world = DAffine3::from_scale(axes) * world_from_camera.inverse();
                    let reading = format!("{stated} {how}{looks}");
                    found.push(CameraCandidate::new(view_from_world, projection, reading));
                }
            }
        }
        found.sort_by_key(|candidate| is_mirrored(&candidate.camera));
        found
    }

    /// `unreal/camera/[pass/]curPos`, `curRot` and `fov`, numbers in one text or in texts of their own: z up,
    /// left-handed, angles in degrees.
    fn of_unreal(&self, picture: &CameraPicture) -> Option<CameraCandidate> {
        let find = |what: &str| {
            let mut keys = self.0.keys();
            keys.find_map(|key| {
                let start = key.strip_prefix("unreal/camera/")?;
                (start == what || start.ends_with(&format!("/{what}"))).then(|| key.clone())
            })
        };
        let triple = |what: &str, parts: [&str; 3]| -> Option<DVec3> {
            if let Some(key) = find(what) {
                let numbers: [f64; 3] = self.numbers(&key)?.try_into().ok()?;
                return Some(numbers.into());
            }
            let number = |part| self.number(&find(&format!("{what}/{part}"))?);
            let [a, b, c] = parts.map(number);
            Some(DVec3::new(a?, b?, c?))
        };
        let eye = triple("curpos", ["x", "y", "z"])?;
        let turn = triple("currot", ["pitch", "yaw", "roll"])?;
        let ([sp, sy, sr], [cp, cy, cr]) = {
            let angles = turn.to_array().map(f64::to_radians);
            (angles.map(f64::sin), angles.map(f64::cos))
        };
        let forward = DVec3::new(cp * cy, cp * sy, sp);
        let right = DVec3::new(sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, -sr * cp);
        let up = DVec3::new(-(cr * sp * cy + sr * sy), cy * sr - cr * sp * sy, cr * cp);
        let rotation = DMat3::from_cols(right, up, -forward).transpose();
        let half_tan = match find("fov").and_then(|key| self.number(&key)) {
            Some(degrees) => (0.5 * degrees.to_radians()).tan(),
            None => {
                let number = |what| self.number(&find(what)?);
                0.5 * number("sensorwidth")? / number("focallength")?
            }
        };
        let view_from_world = DAffine3::from_mat3_translation(rotation, -(rotation * eye));
        let reading = "unreal/camera, a left-handed world".into();
        Some(CameraCandidate::new(
            view_from_world,
            picture.lens(half_tan)?,
            reading,
        ))
    }
}

/// The numbers in a text, with any separators: `X=1.5 Y=-2 Z=3`, `(1.5, -2, 3)`, `1.5 -2 3`.
fn numbers(text: &str) -> Vec<f64> {
    text.split(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))
        .filter_map(|word| word.parse().ok())
        .collect()
}

/// Whether the world-to-view transform mirrors.
pub(super) fn is_mirrored(camera: &Camera) -> bool {
    camera.view_from_world.matrix3.determinant() < 0.0
}

/// The rotation, mirrored or not, and translation that a matrix is, with a uniform scale divided out.
fn rigid(matrix: DMat4) -> Option<DAffine3> {
    let last = matrix.row(3);
    if !matrix.is_finite() || last.distance(DVec4::W) > 1e-6 {
        return None;
    }
    let affine = DAffine3::from_mat4(matrix);
    let scale = affine.matrix3.determinant().abs().cbrt();
    let turn = affine.matrix3 * (1.0 / scale);
    let off = turn * turn.transpose() - DMat3::IDENTITY;
    let is_turn = off
        .to_cols_array()
        .iter()
        .all(|e| e.abs() < ROTATION_TOLERANCE);
    is_turn.then(|| DAffine3::from_mat3_translation(turn, affine.translation / scale))
}

/// Convention of normalised device coordinates.
#[derive(Clone, Copy)]
struct Ndc {
    /// -1 to 1 instead of 0 to 1.
    signed: bool,
    /// y up instead of down.
    up: bool,
}

impl Ndc {
    const ALL: [(Self, &'static str); 4] = [
        (Self::new(false, false), ", worldToNDC 0..1"),
        (Self::new(true, true), ", worldToNDC -1..1 with y up"),
        (Self::new(false, true), ", worldToNDC 0..1 with y up"),
        (Self::new(true, false), ", worldToNDC -1..1"),
    ];

    const fn new(signed: bool, up: bool) -> Self {
        Self { signed, up }
    }

    fn pixel(self, ndc: DVec2, picture: &CameraPicture) -> DVec2 {
        let share = if self.signed { 0.5 * (ndc + 1.0) } else { ndc };
        let y = if self.up { 1.0 - share.y } else { share.y };
        picture.corner() + DVec2::new(share.x, y) * picture.size()
    }

    /// The projection that a matrix from view space is, if that puts the view axis near the middle, x to the
    /// right and y up.
    fn projection(self, ndc_from_view: &DMat4, picture: &CameraPicture) -> Option<Projection> {
        let seen = |x: f64, y: f64, z: f64| {
            let p = *ndc_from_view * DVec4::new(x, y, z, 1.0);
            self.pixel(DVec2::new(p.x, p.y) / p.w, picture)
        };
        let (here, right, up) = (
            seen(0.0, 0.0, -1.0),
            seen(1.0, 0.0, -1.0),
            seen(0.0, 1.0, -1.0),
        );
        let far = seen(1.0, 0.0, -2.0);
        let (x, y) = (right.x - here.x, here.y - up.y);
        let shift = ((here - picture.display.center()) / picture.size())
            .abs()
            .max_element();
        // Both axes must give the same pixel size: reading 0..1 as -1..1 keeps that, but moves the view axis.
        let square = (y / (x * picture.aspect) - 1.0).abs() < 0.02;
        if !(x > 0.0 && y > 0.0 && shift < MOST_SHIFT && square && far.is_finite()) {
            return None;
        }
        let are_parallel = (far.x - here.x - x).abs() < 1e-3 * x;
        Some(Projection::new(are_parallel, [x, y], here))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_in_any_text() {
        assert_eq!(numbers("X=1.5 Y=-2e1 Z=3"), [1.5, -20.0, 3.0]);
        assert_eq!(numbers("(1, 2, -.5)"), [1.0, 2.0, -0.5]);
        assert!(numbers("none").is_empty());
    }
}
