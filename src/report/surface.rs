//! The surface that the reference starts from, in double precision.

use crate::frame::depth::to_distances;
use crate::frame::normals::from_sight_line;
use crate::frame::{Camera, Frame, NormalEncoding, NormalSpace, Plane, StoredDepth};
use crate::io::Loaded;
use crate::io::inputs::Conventions;
use crate::io::stored_surface::StoredSurface;
use glam::{DVec2, DVec3};

/// Normals and depth where the frame's mask is.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    pub(super) normal: [Plane<f64>; 3],
    pub(super) depth: Option<Plane<f64>>,
}

impl Surface {
    /// That of the frame: unit normals and depth in single precision, as they are.
    pub(crate) fn of(frame: &Frame) -> Self {
        let normal = [&frame.normal.x, &frame.normal.y, &frame.normal.z];
        Self {
            normal: normal.map(|plane| plane.map(f64::from)),
            depth: frame.depth.as_ref().map(|depth| depth.map(f64::from)),
        }
    }

    /// That of the files, by the conventions they were read by: what turning, normalising and converting in single
    /// precision costs the frame is a difference from this.
    ///
    /// Samples count as they were decoded to single precision, and depth that was filled counts as filled. The
    /// formulas are those of [`crate::frame::normals`] and [`crate::frame::depth`], written anew.
    pub(crate) fn stored(stored: &StoredSurface, loaded: &Loaded) -> Self {
        let Loaded {
            frame, conventions, ..
        } = loaded;
        let camera = frame.camera.as_ref();
        let normal = |x: usize, y: usize| match frame.mask.at(x, y) {
            true => {
                let place = frame.data_window.middle(x, y);
                in_view(stored.normal.at(x, y), conventions, camera, place)
            }
            false => DVec3::ZERO,
        };
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let normal = [0, 1, 2].map(|axis| Plane::from_fn(width, height, |x, y| normal(x, y)[axis]));
        let depth = frame.depth.as_ref().map(|own| depth(own, stored, loaded));
        Self { normal, depth }
    }
}

/// The normal stored for a `place` of the picture as a unit normal in view space.
fn in_view(
    stored: DVec3,
    conventions: &Conventions,
    camera: Option<&Camera>,
    place: DVec2,
) -> DVec3 {
    let decoded = match conventions.normal_encoding {
        NormalEncoding::Signed => stored,
        NormalEncoding::Unsigned => 2.0 * stored - 1.0,
    };
    let unit = conventions.normal_flip.of(decoded).normalize_or_zero();
    match (conventions.normal_space, camera) {
        (NormalSpace::World, Some(camera)) => camera.view_from_world.matrix3 * unit,
        (NormalSpace::Sight, Some(camera)) => {
            from_sight_line(unit, camera.projection.to_eye(place.x, place.y))
        }
        _ => unit,
    }
}

/// The depth of the frame, `own`, from what is stored.
fn depth(own: &Plane, stored: &StoredSurface, loaded: &Loaded) -> Plane<f64> {
    let Frame { mask, camera, .. } = &loaded.frame;
    let kind = loaded.conventions.depth_kind;
    let kind = kind.unwrap_or(StoredDepth::Planar);
    // A sample whose own conversion is not the frame's was filled.
    let converted = stored.depth.clone().map(|mut depth| {
        to_distances(&mut depth, kind);
        depth
    });
    Plane::from_fn(own.width(), own.height(), |x, y| {
        if !mask.at(x, y) {
            return 0.0;
        }
        match (&stored.depth, &converted, &stored.position, camera) {
            (Some(stored), Some(converted), ..) if converted.at(x, y) == own.at(x, y) => {
                distance(stored.at(x, y).into(), kind)
            }
            (None, _, Some(position), Some(camera)) => {
                -camera.view_from_world.transform_point3(position.at(x, y)).z
            }
            _ => own.at(x, y).into(),
        }
    })
}

/// Stored depth as a value that increases with distance.
fn distance(stored: f64, kind: StoredDepth) -> f64 {
    match kind {
        StoredDepth::Planar | StoredDepth::Ray | StoredDepth::Relative => stored,
        StoredDepth::Inverse => stored.recip(),
        StoredDepth::WhiteFar => 1.0 + stored.clamp(0.0, 1.0),
        StoredDepth::NormalizedNearIsOne => 2.0 - stored.clamp(0.0, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Flip, Vector3Planes};
    use crate::io::inputs::Inputs;
    use crate::io::{Needs, load};
    use crate::params::{Scale, ShapeParams};
    use crate::report::compare::Errors;
    use crate::report::engine::layers;
    use crate::report::sweeps::Measuring;
    use std::path::Path;

    fn bust() -> (Loaded, Surface) {
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
        let inputs = Inputs {
            picture: fixtures.join("bust.exr"),
            ..Inputs::default()
        };
        let needs = Needs {
            projection: true,
            ..Needs::default()
        };
        let loaded = load(&inputs, needs).unwrap();
        let surface = Surface::stored(&loaded.stored_surface(&inputs).unwrap(), &loaded);
        (loaded, surface)
    }

    #[test]
    fn the_surface_of_a_file_is_its_frame_without_rounding() {
        let (loaded, surface) = bust();
        let frame = &loaded.frame;
        assert_eq!(loaded.conventions.normal_space, NormalSpace::World);
        let depth = frame.depth.as_ref().unwrap().map(f64::from);
        assert_eq!(surface.depth.unwrap(), depth);
        let (mut largest, mut unlike) = (0.0_f64, 0);
        let Vector3Planes { x, y, z } = &frame.normal;
        for (found, exact) in [x, y, z].into_iter().zip(&surface.normal) {
            for (found, exact) in found.samples().iter().zip(exact.samples()) {
                largest = largest.max((f64::from(*found) - exact).abs());
                unlike += usize::from(f64::from(*found) != *exact);
            }
        }
        // Nine products, six sums and a division, each within 2^-24 of numbers up to 1.
        assert!(largest < 16.0 / f64::from(1 << 24), "{largest:e}");
        assert!(unlike > frame.mask.count(), "{unlike}");
    }

    #[test]
    fn what_is_stored_is_read_by_its_conventions() {
        let conventions = Conventions {
            normal_space: NormalSpace::View,
            normal_encoding: NormalEncoding::Unsigned,
            normal_flip: Flip {
                y: true,
                ..Flip::NONE
            },
            depth_kind: None,
        };
        let stored = DVec3::new(0.5, 0.8, 0.9);
        let normal = in_view(stored, &conventions, None, DVec2::ZERO);
        // (0, 0.6, 0.8) with y reversed, of length 1.
        assert!(normal.abs_diff_eq(DVec3::new(0.0, -0.6, 0.8), 1e-15));
        for (kind, expected) in [
            (StoredDepth::Planar, 0.25),
            (StoredDepth::Inverse, 4.0),
            (StoredDepth::WhiteFar, 1.25),
            (StoredDepth::NormalizedNearIsOne, 1.75),
        ] {
            assert_eq!(distance(0.25, kind), expected, "{kind:?}");
        }
    }

    #[test]
    fn an_error_of_preparation_is_seen() {
        let (loaded, surface) = bust();
        let shape = ShapeParams {
            scale: Scale::Iterations(0),
            ..ShapeParams::default()
        };
        let errors = |frame: &Frame, surface: &Surface| -> Errors {
            let measuring = Measuring::from(frame, surface, shape).unwrap();
            let gradient = layers(frame, shape).unwrap().gradient;
            measuring.gradient_errors(&gradient, &measuring.diffused(shape.scale))
        };
        let frame = &loaded.frame;
        assert!(errors(frame, &surface).max < 1e-6);
        // Turned about the view axis by 1e-4 radians, slopes of length up to 1 are off by as much.
        let turn = glam::DMat3::from_rotation_z(1e-4);
        let normal = &frame.normal;
        let turned = Frame {
            normal: Vector3Planes::from_fn(normal.x.width(), normal.x.height(), |x, y| {
                turn * normal.at(x, y)
            }),
            ..frame.clone()
        };
        let seen = errors(&turned, &surface).max;
        assert!((5e-5..1.1e-4).contains(&seen), "{seen:e}");
        // A reference of the frame itself does not see it.
        assert!(errors(&turned, &Surface::of(&turned)).max < 1e-6);
    }
}
