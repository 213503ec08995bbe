//! Which of x and y are reversed in normals of view space, where neither flags nor depth nor positions tell.
//!
//! In the order of the evidence: the program that wrote the map, where the file records it; outlines and rims; the file's
//! name; and the curl of slopes, which tells OpenGL from DirectX and nothing of x: with a warning.

use super::integrability::Curl;
use super::map_writers::MapWriter;
use super::rims::Rims;
use super::silhouettes::Silhouettes;
use crate::frame::{Flip, Mask, Vector3Planes};

/// Axes that are reversed, and why.
pub(crate) struct SettledAxes {
    pub(crate) flip: Flip,
    pub(crate) reason: String,
    pub(crate) warning: Option<String>,
}

impl SettledAxes {
    fn new([x, y]: [bool; 2], reason: String) -> Self {
        Self {
            flip: Flip { x, y, z: false },
            reason,
            warning: None,
        }
    }

    fn warned(self, warning: String) -> Self {
        Self {
            warning: Some(warning),
            ..self
        }
    }
}

/// Settles the axes of unit normals of view space. `writer` is the program that wrote them, as far as it is known;
/// `is_layer` tells those of a renderer that is known: they let x point right.
pub(crate) fn settle(
    normal: &Vector3Planes,
    mask: &Mask,
    writer: Option<&MapWriter>,
    is_layer: bool,
) -> SettledAxes {
    let recorded = writer.filter(|writer| writer.is_recorded);
    if let Some(writer) = recorded {
        return SettledAxes::new(writer.reversed, writer.to_string());
    }
    let curl = Curl::of(normal, mask);
    let [x, y] = Silhouettes::of(normal, mask, None).reversed(None);
    let why = curl.reason();
    let by_outlines = x
        .zip(y)
        .map(<[bool; 2]>::from)
        .filter(|axes| curl.allows(*axes));
    if let Some(axes) = by_outlines {
        return shown(axes, format!("{why}; at outlines"), writer);
    }
    let rims = Rims::of(normal, mask);
    if let Some(axes) = rims.show(&curl) {
        let numbers = rims.numbers();
        return shown(axes, format!("{why}; at rims ({numbers})"), writer);
    }
    let points_down = curl.y_points_down();
    let settled = SettledAxes::new([false, points_down == Some(true)], why.clone());
    if let Some(writer) = writer {
        return match curl.allows(writer.reversed) {
            true => SettledAxes::new(writer.reversed, format!("{writer}; {why}")),
            false => settled.warned(format!(
                "normals: {why}, though {writer}: compare with --normal-flip {}",
                named(writer.reversed)
            )),
        };
    }
    let is_usual = is_layer && points_down == Some(false) && !rims.speak_against();
    if curl.is_flat() || is_usual {
        return settled;
    }
    settled.warned(match points_down {
        Some(true) => format!(
            "normals: {why}; or x points left instead (as in DSINE, NormalBAE, StableNormal), which nothing shows: if bumps \
             come out as hollows, give --normal-flip stablenormal"
        ),
        Some(false) => format!(
            "normals: {why}; nothing shows that x points right: if bumps come out as hollows, give --normal-flip xy"
        ),
        None => format!(
            "normals: {why}; taken to point up (OpenGL): say --normal-flip y if green points down (DirectX), x if red \
             points left (DSINE, NormalBAE, StableNormal), else none"
        ),
    })
}

/// Axes that outlines or rims show; a warning where x is reversed, which is rare, and where the file's name says otherwise.
fn shown(axes: [bool; 2], at: String, writer: Option<&MapWriter>) -> SettledAxes {
    let outward = match axes {
        [false, false] => "normals point outward",
        [true, false] => "normals point outward with x reversed",
        [false, true] => "normals point outward with y reversed",
        [true, true] => "normals point outward with both reversed",
    };
    let reason = format!("{at} {outward}");
    let settled = SettledAxes::new(axes, reason.clone());
    match writer {
        Some(writer) if writer.reversed == axes => settled,
        Some(writer) => settled.warned(format!(
            "normals: {reason}, though {writer}: compare with --normal-flip {}",
            named(writer.reversed)
        )),
        None if axes[0] => {
            let other = named([false, !axes[1]]);
            settled.warned(format!(
                "normals: {reason}; a hollow form looks the same: say --normal-flip {other} if it is one"
            ))
        }
        None => settled,
    }
}

fn named([x, y]: [bool; 2]) -> Flip {
    Flip { x, y, z: false }
}
