//! A static camera: recovered once for all frames of a sequence.

use crate::frame::{Camera, Projection};
use crate::io::inputs::KnownCamera;
use crate::untrusted::Untrusted;
use glam::DAffine3;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Larger angles between cameras, in radians, rolls included, mean that the camera moves; for cameras recovered from
/// positions.
const TURN_BY_POSITIONS: f64 = 2e-4;
/// The same for cameras recovered from depth and normals, which determine it less well.
const TURN_BY_DEPTH: f64 = 1e-2;
/// Larger relative differences of focal length mean a zoom; for the same two sources.
const ZOOM_BY_POSITIONS: f64 = 1e-3;
const ZOOM_BY_DEPTH: f64 = 0.1;
/// Larger shifts of the eye, relative to the distance of the surface, mean that the camera moves.
const SHIFT: f64 = 1e-3;

/// A camera in its command-line form: JSON.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StillCamera(pub(super) KnownCamera);

/// The camera in its serialised form.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    view_from_world: [f64; 12],
    is_placed: bool,
    projection: Projection,
}

impl fmt::Display for StillCamera {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let KnownCamera { camera, is_placed } = self.0;
        let written = Written {
            view_from_world: camera.view_from_world.to_cols_array(),
            is_placed,
            projection: camera.projection,
        };
        let text = serde_json::to_string(&written).map_err(|_| fmt::Error)?;
        f.write_str(&text)
    }
}

impl FromStr for StillCamera {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let written: Written = serde_json::from_str(text).map_err(|error| {
            format!(
                "expected a camera that --save-recipe wrote: {}",
                Untrusted(&error.to_string())
            )
        })?;
        let view_from_world = DAffine3::from_cols_array(&written.view_from_world);
        let turn = view_from_world.matrix3;
        let is_rigid = (turn * turn.transpose()).abs_diff_eq(glam::DMat3::IDENTITY, 1e-6);
        if !is_rigid || !view_from_world.translation.is_finite() {
            return Err("expected a rotation and a translation".into());
        }
        Ok(Self(KnownCamera {
            camera: Camera {
                view_from_world,
                projection: written.projection,
            },
            is_placed: written.is_placed,
        }))
    }
}

/// The common camera of all frames, given their cameras and surface distances; `None` if it moves or zooms.
pub(super) fn of_all(cameras: &[(KnownCamera, f64)]) -> Option<StillCamera> {
    let &(middle, distance) = cameras.get(cameras.len() / 2)?;
    let all_stand = cameras
        .iter()
        .all(|(one, _)| stands(&middle, one, distance));
    (cameras.len() > 1 && all_stand).then_some(StillCamera(middle))
}

fn stands(a: &KnownCamera, b: &KnownCamera, distance: f64) -> bool {
    if a.is_placed != b.is_placed {
        return false;
    }
    let (turn, zoom) = match a.is_placed {
        true => (TURN_BY_POSITIONS, ZOOM_BY_POSITIONS),
        false => (TURN_BY_DEPTH, ZOOM_BY_DEPTH),
    };
    let [from, to] = [a, b].map(|known| known.camera.view_from_world);
    let axes = from.matrix3 - to.matrix3;
    let turned = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.length());
    let eye = |view_from_world: DAffine3| view_from_world.inverse().translation;
    turned.into_iter().all(|by| by <= turn)
        && lenses_agree(a.camera.projection, b.camera.projection, zoom)
        && eye(from).distance(eye(to)) <= SHIFT * distance
}

fn lenses_agree(a: Projection, b: Projection, zoom: f64) -> bool {
    let near = |a: f64, b: f64| (a / b - 1.0).abs() <= zoom;
    match (a, b) {
        (Projection::Perspective { fx: a, .. }, Projection::Perspective { fx: b, .. })
        | (Projection::Orthographic { sx: a, .. }, Projection::Orthographic { sx: b, .. }) => {
            near(a, b)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    fn camera(turn: f64, eye: DVec3, focal: f64, is_placed: bool) -> KnownCamera {
        let turn = DMat3::from_rotation_y(turn);
        KnownCamera {
            camera: Camera {
                view_from_world: DAffine3::from_mat3_translation(turn, turn * -eye),
                projection: Projection::Perspective {
                    fx: focal,
                    fy: focal,
                    cx: 320.0,
                    cy: 240.5,
                },
            },
            is_placed,
        }
    }

    #[test]
    fn a_camera_is_read_as_it_was_written() {
        for is_placed in [true, false] {
            let still = StillCamera(camera(0.1, DVec3::new(1.0, 1e-9, -7.25), 912.3, is_placed));
            assert_eq!(still.to_string().parse(), Ok(still));
        }
        for wrong in ["", "{}", "[1]", "render.json"] {
            assert!(wrong.parse::<StillCamera>().is_err(), "{wrong}");
        }
        let skewed = StillCamera(camera(0.0, DVec3::ZERO, 1.0, false)).to_string();
        let skewed = skewed.replacen("1.0", "2.0", 1);
        assert!(skewed.parse::<StillCamera>().is_err(), "{skewed}");
    }

    #[test]
    fn what_moves_turns_or_zooms_does_not_stand_still() {
        let still = camera(0.1, DVec3::X, 900.0, true);
        let all = |other| of_all(&[(still, 5.0), (still, 5.0), (other, 5.0)]).is_some();
        assert!(all(still));
        assert!(all(camera(0.1, DVec3::X * 1.001, 900.0, true)));
        assert!(!all(camera(0.1, DVec3::X * 1.01, 900.0, true)));
        assert!(!all(camera(0.101, DVec3::X, 900.0, true)));
        assert!(!all(camera(0.1, DVec3::X, 905.0, true)));
        assert!(!all(camera(0.1, DVec3::X, 900.0, false)));
        // A single frame does not show whether the camera moves.
        assert!(of_all(&[(still, 5.0)]).is_none());
        // Depth and normals determine turns less well: half a degree may be noise.
        let by_depth = camera(0.1, DVec3::ZERO, 900.0, false);
        let near = camera(0.108, DVec3::ZERO, 950.0, false);
        assert!(of_all(&[(by_depth, 5.0), (near, 5.0)]).is_some());
    }
}
