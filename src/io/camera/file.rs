//! Cameras written as JSON.

use super::PanoramaPose;
use crate::error::{Error, Result};
use crate::frame::{Camera, OutOfRange, Projection, Window, check_place};
use crate::io::open::read_text;
use crate::untrusted::Untrusted;
use glam::{DAffine3, DMat3, DVec2, DVec3};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use std::path::Path;

/// Largest deviation of a rotation from orthonormal: rows printed with four digits still pass.
const ROTATION_TOLERANCE: f64 = 2e-3;

/// Smallest and largest uniform scale of a matrix, whose squares and cubes double precision still holds.
const SCALES: (f64, f64) = (1e-12, 1e12);

/// Longest side of the picture that a camera was made for, as of windows of OpenEXR.
const MOST_SIDE: f64 = (1 << 30) as f64;

/// The longest camera file that is read.
const MOST_BYTES: u64 = 1 << 24;

/// The keys of a camera file.
#[derive(Deserialize)]
struct CameraFile {
    world_to_camera: Option<[[f64; 4]; 4]>,
    focal_px: Option<f64>,
    pixels_per_unit: Option<f64>,
    principal_point_px: Option<[f64; 2]>,
    intrinsics_px: Option<Intrinsics>,
    fov_x: Option<f64>,
    fov_y: Option<f64>,
    camera_type: Option<String>,
    resolution: Option<[f64; 2]>,
}

#[derive(Deserialize)]
struct Intrinsics {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
}

/// Reads a camera from a JSON file.
///
/// Every length in pixels refers to the display window, with (0, 0) at its top-left corner, pixel
/// edges at integers and y down. Keys that are not listed here are ignored.
///
/// | key | meaning |
/// |---|---|
/// | `world_to_camera` | rows of a 4x4 matrix for column vectors; the camera looks down -z, x right, y up. Absent: view space itself, enough for view-space normals |
/// | `focal_px` | perspective: focal length in pixel widths |
/// | `pixels_per_unit` | orthographic: pixel widths per unit of length |
/// | `principal_point_px` | `[x, y]` of the view axis; absent: the centre of the display window |
/// | `intrinsics_px` | `{fx, fy, cx, cy}` in place of the three above; for `camera_type` `"ORTHO"`, `fx` and `fy` are pixels per unit |
/// | `fov_x`, `fov_y` | perspective: the angle across the picture or down it, in degrees, in place of `focal_px` |
/// | `camera_type` | `"PERSP"` or `"ORTHO"`; absent: follows from the other keys |
/// | `resolution` | `[width, height]` that the pixels refer to; absent: the display window |
///
/// The smallest files are `{"focal_px": 900}` and
/// `{"world_to_camera": [[..4], [..4], [..4], [0, 0, 0, 1]], "focal_px": 900}`.
/// Focal lengths are 0.01 to 1e9 px, pixels per unit 1e-6 to 1e9, the principal point lies within 1e7 px of the corner
/// of the display window, the eye within 1e12 units of the origin, sides of `resolution` are 1 to 2^30 px.
/// Where `resolution` has the shape of the display window but another size, as for a proxy, the
/// intrinsics are scaled. A uniform scale in `world_to_camera` is divided out.
///
/// # Errors
/// If the file cannot be read, is not JSON, lacks a key, holds a number outside its range or a mirrored or sheared
/// matrix, belongs to a panorama, or was made for a picture of another shape.
pub fn read_camera(path: &Path, display_window: Window, pixel_aspect: f32) -> Result<Camera> {
    let text = read_text(path, MOST_BYTES)?;
    camera_of_json(&text, display_window, f64::from(pixel_aspect))
        .map_err(|rejected| rejected.in_file(path))
}

/// As [`read_camera`], from the text of such a file.
///
/// # Errors
/// [`Error::BadParameter`] where [`read_camera`] refuses the file.
#[cfg(feature = "host")]
pub(crate) fn camera_of_text(
    text: &str,
    display_window: Window,
    pixel_aspect: f32,
) -> Result<Camera> {
    camera_of_json(text, display_window, f64::from(pixel_aspect))
        .map_err(|rejected| crate::error::bad("camera", rejected.found, rejected.remedy))
}

/// Reads where a panorama was seen from, in world space, and the turn from world space to its own (x right, y
/// up, -z in the middle of the picture): `world_to_camera` of a file as [`read_camera`] reads it.
///
/// # Errors
/// If the file cannot be read, is not JSON, or has no such matrix of a rotation and a translation.
pub(crate) fn read_pose(path: &Path) -> Result<PanoramaPose> {
    let text = read_text(path, MOST_BYTES)?;
    let parsed = || {
        let matrix = CameraFile::parsed(&text)?.world_to_camera.ok_or_else(|| {
            Rejected::new(
                "has no world_to_camera",
                "write the rows of a 4x4 matrix: where the panorama was seen from",
            )
        })?;
        let (map_from_world, _) = rigid_transform(&matrix)?;
        check_place(map_from_world.translation)?;
        Ok(map_from_world)
    };
    let map_from_world = parsed().map_err(|rejected: Rejected| rejected.in_file(path))?;
    let center = map_from_world.inverse().translation;
    Ok((center, map_from_world.matrix3))
}

/// Why a camera file was not accepted, before the file's name is attached.
#[derive(Debug)]
struct Rejected {
    found: String,
    remedy: String,
}

impl Rejected {
    fn new(found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            found: found.into(),
            remedy: remedy.into(),
        }
    }

    fn in_file(self, path: &Path) -> Error {
        Error::Unsupported {
            path: path.to_path_buf(),
            found: self.found,
            remedy: self.remedy,
        }
    }
}

impl From<OutOfRange> for Rejected {
    fn from(number: OutOfRange) -> Self {
        Self::new(number.found(), number.remedy())
    }
}

type ParsedCamera<T> = std::result::Result<T, Rejected>;

fn camera_of_json(text: &str, display: Window, aspect: f64) -> ParsedCamera<Camera> {
    let file = CameraFile::parsed(text)?;
    let is_parallel = file.is_parallel()?;
    let (view_from_world, scale) = match &file.world_to_camera {
        Some(rows) => rigid_transform(rows)?,
        None => (DAffine3::IDENTITY, 1.0),
    };
    let lens = FileLens::of(&file, is_parallel, display, aspect)?;
    let camera = Camera {
        view_from_world,
        projection: lens.projection(is_parallel, scale, display),
    };
    camera.check(display)?;
    Ok(camera)
}

impl CameraFile {
    fn parsed(text: &str) -> ParsedCamera<Self> {
        serde_json::from_str(text).map_err(|error| {
            Rejected::new(
                format!("not a JSON camera ({})", Untrusted(&error.to_string())),
                "write an object with world_to_camera and focal_px",
            )
        })
    }

    fn is_parallel(&self) -> ParsedCamera<bool> {
        let (focal, parallel) = (self.focal_px.is_some(), self.pixels_per_unit.is_some());
        let named = self
            .camera_type
            .as_deref()
            .map(names_parallel)
            .transpose()?;
        let (found, remedy) = match named {
            _ if focal && parallel => (
                "has both focal_px and pixels_per_unit",
                "keep focal_px for a perspective camera, pixels_per_unit for an orthographic one",
            ),
            Some(false) if parallel => (
                "camera_type PERSP with pixels_per_unit",
                "give focal_px instead, or set camera_type to ORTHO",
            ),
            Some(true) if focal => (
                "camera_type ORTHO with focal_px",
                "give pixels_per_unit instead, or set camera_type to PERSP",
            ),
            Some(named) => return Ok(named),
            None => return Ok(parallel),
        };
        Err(Rejected::new(found, remedy))
    }

    /// Focal lengths of a picture of this size by its angle across it, down it, or both; `None` where neither is given.
    fn focal_of_view(&self, size: [f64; 2], aspect: f64) -> ParsedCamera<Option<[f64; 2]>> {
        let focal = |key: &str, degrees: Option<f64>, side: f64| match degrees {
            None => Ok(None),
            Some(degrees) if degrees > 0.0 && degrees < 180.0 => {
                Ok(Some(0.5 * side / (0.5 * degrees).to_radians().tan()))
            }
            Some(degrees) => Err(Rejected::new(
                format!("{key} is {degrees}"),
                "give an angle in degrees, above 0 and below 180",
            )),
        };
        let across = focal("fov_x", self.fov_x, size[0])?;
        Ok(match (across, focal("fov_y", self.fov_y, size[1])?) {
            (Some(fx), Some(fy)) => Some([fx, fy]),
            (Some(fx), None) => Some([fx, fx * aspect]),
            (None, Some(fy)) => Some([fy / aspect, fy]),
            (None, None) => None,
        })
    }
}

fn names_parallel(name: &str) -> ParsedCamera<bool> {
    match name.to_ascii_uppercase().as_str() {
        "PERSP" | "PERSPECTIVE" => Ok(false),
        "ORTHO" | "ORTHOGRAPHIC" => Ok(true),
        "PANO" | "PANORAMA" | "EQUIRECTANGULAR" => Err(Rejected::new(
            "the camera is a panorama",
            "render with a perspective or orthographic camera, or give view-space normals",
        )),
        _ => Err(Rejected::new(
            format!("camera_type is {}", Untrusted(name)),
            "set it to PERSP or ORTHO",
        )),
    }
}

fn positive(n: f64, name: &str) -> ParsedCamera<f64> {
    match n > 0.0 {
        true => Ok(n),
        false => Err(Rejected::new(
            format!("{name} is {n}"),
            "give a number above 0",
        )),
    }
}

/// The rigid part of a row-major matrix, and the uniform scale that was divided out of it.
fn rigid_transform(rows: &[[f64; 4]; 4]) -> ParsedCamera<(DAffine3, f64)> {
    check_last_row(rows)?;
    let linear = Matrix3::from_fn(|r, c| rows[r][c]);
    let scale = uniform_scale(&linear)?;
    let rotation = nearest_rotation(&(linear / scale))?;
    let t = DVec3::new(rows[0][3], rows[1][3], rows[2][3]) / scale;
    Ok((DAffine3::from_mat3_translation(dmat3(&rotation), t), scale))
}

fn check_last_row(rows: &[[f64; 4]; 4]) -> ParsedCamera<()> {
    let [x, y, z, w] = rows[3];
    let largest = x.abs().max(y.abs()).max(z.abs());
    if largest < 1e-6 && (w - 1.0).abs() < 1e-6 {
        return Ok(());
    }
    let transposed = rows[..3].iter().all(|row| row[3] == 0.0) && w == 1.0;
    Err(if transposed {
        Rejected::new(
            "world_to_camera has its translation in the last row",
            "transpose it: rows of a matrix for column vectors, translation in the last column",
        )
    } else {
        Rejected::new(
            format!("the last row of world_to_camera is [{x}, {y}, {z}, {w}]"),
            "give the world-to-view matrix, without the projection; its last row is [0, 0, 0, 1]",
        )
    })
}

fn uniform_scale(linear: &Matrix3<f64>) -> ParsedCamera<f64> {
    let lengths: Vector3<f64> = Vector3::from_fn(|r, _| linear.row(r).norm());
    let (least, most) = (lengths.min(), lengths.max());
    if least <= 0.0 {
        return Err(Rejected::new(
            "world_to_camera has a row of zeros",
            "give a rotation and a translation",
        ));
    }
    if !(least >= SCALES.0 && most <= SCALES.1) {
        return Err(Rejected::new(
            format!("world_to_camera scales by {least:e} to {most:e}"),
            format!("give a scale of {:e} to {:e}", SCALES.0, SCALES.1),
        ));
    }
    if most / least > 1.0 + ROTATION_TOLERANCE {
        return Err(Rejected::new(
            format!("world_to_camera stretches axes unevenly ({least} to {most})"),
            "give a rotation and a translation",
        ));
    }
    Ok(lengths.mean())
}

fn nearest_rotation(near: &Matrix3<f64>) -> ParsedCamera<Matrix3<f64>> {
    if near.determinant() < 0.0 {
        return Err(Rejected::new(
            "world_to_camera mirrors the scene (its determinant is negative)",
            "negate the axis that is reversed; the camera looks down -z with x right and y up",
        ));
    }
    let skew = (near * near.transpose() - Matrix3::identity()).amax();
    if skew > 2.0 * ROTATION_TOLERANCE {
        return Err(Rejected::new(
            format!("the axes of world_to_camera are not at right angles (off by {skew:.2e})"),
            "give a rotation and a translation",
        ));
    }
    super::model::orthonormal(near).ok_or_else(|| {
        Rejected::new(
            "world_to_camera holds no rotation",
            "give a rotation and a translation",
        )
    })
}

/// The same matrix in the types of the frame.
pub(super) fn dmat3(m: &Matrix3<f64>) -> DMat3 {
    DMat3::from_cols_array_2d(&m.data.0)
}

/// Pixels of the display window, origin at its top-left corner.
struct FileLens {
    focal: DVec2,
    axis: DVec2,
}

impl FileLens {
    fn of(
        file: &CameraFile,
        is_parallel: bool,
        display: Window,
        aspect: f64,
    ) -> ParsedCamera<Self> {
        let size = [display.width() as f64, display.height() as f64];
        let made_for = file.resolution.unwrap_or(size);
        let lens = match &file.intrinsics_px {
            Some(given) => Self {
                focal: DVec2::new(
                    positive(given.fx, "intrinsics_px.fx")?,
                    positive(given.fy, "intrinsics_px.fy")?,
                ),
                axis: DVec2::new(given.cx, given.cy),
            },
            None => Self::of_focal(file, is_parallel, made_for, aspect)?,
        };
        lens.scaled(made_for, size)
    }

    fn of_focal(
        file: &CameraFile,
        is_parallel: bool,
        made_for: [f64; 2],
        aspect: f64,
    ) -> ParsedCamera<Self> {
        let (key, given) = match is_parallel {
            false => ("focal_px", file.focal_px),
            true => ("pixels_per_unit", file.pixels_per_unit),
        };
        let focal = match given {
            Some(fx) => {
                let fx = positive(fx, key)?;
                Some([fx, fx * aspect])
            }
            None if is_parallel => None,
            None => file.focal_of_view(made_for, aspect)?,
        };
        let focal = focal.ok_or_else(|| {
            Rejected::new(
                format!("has neither intrinsics_px nor {key}"),
                "add focal_px or fov_x (perspective) or pixels_per_unit (orthographic)",
            )
        })?;
        let centre = made_for.map(|side| 0.5 * side);
        Ok(Self {
            focal: focal.into(),
            axis: file.principal_point_px.unwrap_or(centre).into(),
        })
    }

    /// The lens of a picture made in size `from`, for the same picture in size `to`.
    fn scaled(self, from: [f64; 2], to: [f64; 2]) -> ParsedCamera<Self> {
        if from == to {
            return Ok(self);
        }
        let mut sides = from.into_iter();
        if let Some(side) = sides.find(|side| !(1.0..=MOST_SIDE).contains(side)) {
            return Err(Rejected::new(
                format!("a side of its resolution is {side:e}"),
                "give 1 to 2^30 pixels",
            ));
        }
        let times = DVec2::from(to) / DVec2::from(from);
        // Sides are whole pixels: either may be one pixel off the exact proportion.
        let same_shape =
            (from[1] * times.x - to[1]).abs() <= 1.0 || (from[0] * times.y - to[0]).abs() <= 1.0;
        if !same_shape {
            return Err(Rejected::new(
                format!(
                    "was made for {}x{} pixels, but the display window has {}x{}",
                    from[0], from[1], to[0], to[1]
                ),
                "give the camera of this picture, or set resolution to its display window",
            ));
        }
        Ok(Self {
            focal: self.focal * times,
            axis: self.axis * times,
        })
    }

    fn projection(&self, is_parallel: bool, scale: f64, display: Window) -> Projection {
        let corner = DVec2::new(display.x0.into(), display.y0.into());
        // Lengths in view space shrank with the scale, so a unit now spans more pixels.
        let times = if is_parallel { scale } else { 1.0 };
        let per_unit = (self.focal * times).to_array();
        Projection::new(is_parallel, per_unit, self.axis + corner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn parse(text: &str) -> ParsedCamera<Camera> {
        camera_of_json(text, Window::from_size(640, 480), 1.0)
    }

    fn message(text: &str) -> String {
        let Rejected { found, remedy } = parse(text).expect_err("accepted a bad camera");
        let line = format!("{found}; {remedy}");
        assert!(!line.contains('\n'), "{line}");
        line
    }

    #[test]
    fn a_bare_focal_length_is_a_view_space_camera() {
        let camera = parse(r#"{"focal_px": 900}"#).unwrap();
        assert_eq!(camera.view_from_world, DAffine3::IDENTITY);
        let centre = camera.pixel_of(DVec3::new(0.0, 0.0, -5.0)).unwrap();
        assert_eq!(centre, DVec2::new(320.0, 240.0));
    }

    /// 640 pixels across 90 degrees are 320 from the middle at a distance of 320, and so are 240 of 480.
    #[test]
    fn angles_of_view_tell_the_focal_length() {
        for (text, expected) in [
            (r#"{"fov_x": 90}"#, [320.0, 320.0]),
            (r#"{"fov_y": 90}"#, [240.0, 240.0]),
            (r#"{"fov_x": 90, "fov_y": 90}"#, [320.0, 240.0]),
        ] {
            let Projection::Perspective { fx, fy, .. } = parse(text).unwrap().projection else {
                panic!("not a perspective")
            };
            assert!((fx - expected[0]).abs() < 1e-9 && (fy - expected[1]).abs() < 1e-9);
        }
        assert!(message(r#"{"fov_x": 180}"#).contains("fov_x is 180"));
    }

    #[test]
    fn tall_pixels_shorten_the_vertical_focal_length() {
        let camera =
            camera_of_json(r#"{"focal_px": 900}"#, Window::from_size(640, 480), 2.0).unwrap();
        // Pixels twice as wide as high: a length covers twice as many pixel heights as widths.
        let Projection::Perspective { fx, fy, .. } = camera.projection else {
            panic!("not a perspective")
        };
        assert_eq!((fx, fy), (900.0, 1800.0));
    }

    #[test]
    fn a_display_window_off_the_origin_shifts_the_principal_point() {
        let window = Window::at(-100, 20, 640, 480);
        let camera = camera_of_json(r#"{"focal_px": 900}"#, window, 1.0).unwrap();
        let centre = camera.pixel_of(DVec3::NEG_Z).unwrap();
        assert_eq!(centre, DVec2::new(220.0, 260.0));
    }

    #[test]
    fn proxies_are_scaled_and_other_shapes_refused() {
        let text = r#"{"intrinsics_px": {"fx": 2000, "fy": 2000, "cx": 960, "cy": 540},
                       "resolution": [1920, 1080]}"#;
        let half = camera_of_json(text, Window::from_size(960, 540), 1.0).unwrap();
        let Projection::Perspective { fx, cx, cy, .. } = half.projection else {
            panic!("not a perspective")
        };
        assert_eq!((fx, cx, cy), (1000.0, 480.0, 270.0));
        // 427x240 rounds 426.67 up and is still the same picture.
        camera_of_json(text, Window::from_size(427, 240), 1.0).unwrap();
        assert!(message(text).contains("1920x1080"));
    }

    #[test]
    fn a_uniform_scale_is_divided_out() {
        let text = r#"{"world_to_camera": [[2,0,0,4],[0,2,0,6],[0,0,2,-20],[0,0,0,1]],
                       "pixels_per_unit": 10}"#;
        let camera = parse(text).unwrap();
        // u = 320 + 10 (2 * 1 + 4), v = 240 - 10 (2 * 1 + 6)
        let seen = camera.pixel_of(DVec3::ONE).unwrap();
        assert!((seen - DVec2::new(380.0, 160.0)).length() < 1e-9, "{seen}");
        let determinant = camera.view_from_world.matrix3.determinant();
        assert!((determinant - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_nearly_orthonormal_rotation_is_mended() {
        let text = r#"{"world_to_camera": [[0.6,0.8001,0,0],[-0.8,0.6,0,0],[0,0,1,-3],[0,0,0,1]],
                       "focal_px": 500}"#;
        let m = parse(text).unwrap().view_from_world.matrix3;
        let off = m * m.transpose() - DMat3::IDENTITY;
        assert!(off.to_cols_array().iter().all(|e| e.abs() < 1e-12));
    }

    #[test]
    fn each_fault_is_told_in_one_line() {
        let with_matrix = |m: &str| format!(r#"{{"focal_px": 9, "world_to_camera": {m}}}"#);
        let mirrored = with_matrix("[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]");
        assert!(message(&mirrored).contains("mirrors"));
        let stretched = with_matrix("[[1,0,0,0],[0,3,0,0],[0,0,1,0],[0,0,0,1]]");
        assert!(message(&stretched).contains("unevenly"));
        let sheared = with_matrix("[[1,0,0,0],[0.6,0.8,0,0],[0,0,1,0],[0,0,0,1]]");
        assert!(message(&sheared).contains("right angles"));
        let transposed = with_matrix("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[1,2,3,1]]");
        assert!(message(&transposed).contains("transpose"));
        let zero = with_matrix("[[0,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]");
        assert!(message(&zero).contains("zeros"));
        assert!(message(&with_matrix("[[1,0],[0,1]]")).contains("length 4"));
        assert!(message(&with_matrix("7")).contains("`7`"));
        assert!(message(r#"{"focal_px": -3}"#).contains("is -3"));
        assert!(message(r#"{"focal_px": "50mm"}"#).contains("50mm"));
        assert!(message(r#"{"focal_px": 1, "pixels_per_unit": 1}"#).contains("both"));
        assert!(message(r#"{"camera_type": "PANO"}"#).contains("panorama"));
        assert!(message(r#"{"camera_type": "FISHEYE"}"#).contains("FISHEYE"));
        assert!(message(r#"{"camera_type": "ORTHO", "focal_px": 9}"#).contains("ORTHO"));
        assert!(message("{}").contains("focal_px"));
        assert!(message(r#"{"intrinsics_px": {"fx": 9}}"#).contains("`fy`"));
        assert!(message(r#"{"focal_px": 9, "resolution": [0, 0]}"#).contains("resolution"));
        assert!(message("[1, 2]").contains("not a JSON"));
        // Values outside the range of single precision.
        for (text, expected) in [
            (
                r#"{"focal_px": 1e-300}"#,
                "focal length is 1e-300 px; give 0.01 to 1e9",
            ),
            (r#"{"focal_px": 1e10}"#, "focal length is 1e10 px"),
            (
                r#"{"pixels_per_unit": 1e-30}"#,
                "number of pixels per unit is ",
            ),
            (
                r#"{"focal_px": 9, "principal_point_px": [1e300, 0]}"#,
                "principal point is 1e300 px",
            ),
            (
                r#"{"intrinsics_px": {"fx": 9, "fy": 1e-9, "cx": 0, "cy": 0}}"#,
                "focal length is ",
            ),
            (
                r#"{"focal_px": 9, "resolution": [1e300, 1e300]}"#,
                "resolution is 1e300; give 1 to",
            ),
            (
                &with_matrix("[[1,0,0,0],[0,1,0,1e15],[0,0,1,0],[0,0,0,1]]"),
                "origin is 1e15",
            ),
            (
                &with_matrix("[[1e-200,0,0,0],[0,1e-200,0,0],[0,0,1e-200,0],[0,0,0,1]]"),
                "zeros",
            ),
            (
                &with_matrix("[[1e-20,0,0,0],[0,1e-20,0,0],[0,0,1e-20,0],[0,0,0,1]]"),
                "scales by ",
            ),
        ] {
            let said = message(text);
            assert!(said.contains(expected), "{text}: {said}");
        }
        assert!(message("{\"focal_px\": \n").contains("not a JSON"));
    }

    #[test]
    fn an_absent_file_names_itself() {
        let path = Path::new("no/such/camera.json");
        let error = read_camera(path, Window::from_size(4, 4), 1.0).expect_err("read nothing");
        assert!(error.to_string().contains("camera.json"), "{error}");
    }
}
