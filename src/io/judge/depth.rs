//! The kind of depth, judged by how its points fit the tangent planes of the normals.

use super::surface::SurfaceSamples;
use crate::frame::normals::{normalise, turn_to_view};
use crate::frame::{Camera, DepthKind, Frame, Mask, NormalSpace, Plane, SightLines, Vector3Planes};
use crate::io::camera::median;
use crate::io::finding::Finding;
use crate::io::inputs::StoredDepth;
use glam::DVec3;

/// The quantity that a layer of depth holds, where it is known, and why.
pub(crate) type Sense = Option<(StoredDepth, String)>;

/// Approximate number of pixels used.
const SAMPLES: usize = 8192;

/// Fewer samples decide nothing.
const FEWEST_SAMPLES: usize = 16;

/// Median sine of the angle between the neighbours' tangent planes and the steps to a point, from which on the layer is
/// no distance, or shows a different surface than the normals.
const WORST_SINE: f64 = 0.05;

/// Median difference of depth from the distances of positions, as a share, up to which it is one of these. Positions
/// averaged over an open lens are met within 0.05 % (`fixtures/blur.exr`); distances along ray and axis differ by 2 % in the
/// median from a field of view of 30 degrees on.
const WORST_SHARE: f64 = 0.01;

/// The kind of distance of `depth` that positions beside it have by the camera, and why; `None` where they have neither,
/// or both alike. It holds where blur has turned normals and depth away from each other.
pub(crate) fn depth_beside_positions(
    depth: &Plane,
    positions: &Vector3Planes,
    mask: &Mask,
    camera: &Camera,
) -> Sense {
    let pixels = sample_pixels(mask);
    let off = |of: fn(DVec3) -> f64| {
        let shares = pixels.iter().map(|&(x, y)| {
            let seen = camera.view_from_world.transform_point3(positions.at(x, y));
            (f64::from(depth.at(x, y)) / of(seen) - 1.0).abs()
        });
        let mut shares: Vec<f64> = shares.filter(|share| share.is_finite()).collect();
        median(&mut shares, FEWEST_SAMPLES)
    };
    let [planar, ray] = [off(|p| -p.z)?, off(DVec3::length)?];
    let (stored, share, other) = match planar <= ray {
        true => (StoredDepth::Planar, planar, ray),
        false => (StoredDepth::Ray, ray, planar),
    };
    (share < WORST_SHARE && 2.0 * share < other).then(|| {
        let evidence = format!("within {:.2} % of the positions' distances", 100.0 * share);
        (stored, evidence)
    })
}

/// The kind of distance for which the points of `frame` lie on each other's tangent planes, and why.
///
/// Without depth or a camera there is no evidence. Half floats are too coarse for positions: a step of theirs is some
/// tenths of a pixel's size on an ordinary frame.
pub(crate) fn judge_depth(frame: &Frame, is_half: bool) -> Sense {
    let (depth, camera) = (frame.depth.as_ref()?, frame.camera.as_ref()?);
    if is_half {
        return Some((StoredDepth::Relative, "stored as half floats".into()));
    }
    Some(match better_kind(frame, depth, camera) {
        Some((kind, sine)) => {
            let off = sine.asin().to_degrees();
            let evidence = format!("its points lie {off:.2} degrees off the normals' planes");
            match sine < WORST_SINE {
                true => (kind, evidence),
                false => (StoredDepth::Relative, evidence),
            }
        }
        None => (StoredDepth::Relative, "too few pixels to tell".into()),
    })
}

/// The finding on a kind of depth, and why it is this one.
pub(crate) fn depth_finding((stored, evidence): (StoredDepth, String)) -> Finding {
    Finding {
        subject: "depth kind".into(),
        conclusion: stored.to_string(),
        evidence,
        flag: format!("--depth-kind {}", stored.name()),
    }
}

/// Median angle, in degrees, between points and the tangent planes of world-space normals, for the better-fitting kind
/// of distance.
pub(crate) fn off_tangents(
    surface: &SurfaceSamples,
    normal: &Vector3Planes,
    depth: &Plane,
    camera: &Camera,
) -> Option<f64> {
    let mut normal = normal.clone();
    turn_to_view(&mut normal, NormalSpace::World, camera, surface.data_window);
    normalise(&mut normal, surface.mask.plane());
    let mut frame = Frame::of_normals(normal, surface.mask.clone());
    frame.data_window = surface.data_window;
    better_kind(&frame, depth, camera).map(|(_, sine)| sine.asin().to_degrees())
}

/// The kind of distance for which steps between points are nearer to the tangent planes, with the median sine of their
/// angles.
fn better_kind(frame: &Frame, depth: &Plane, camera: &Camera) -> Option<(StoredDepth, f64)> {
    let sight = SightLines::new(camera.projection);
    let pixels = sample_pixels(&frame.mask);
    let kinds = [StoredDepth::Planar, StoredDepth::Ray].into_iter();
    let judged = kinds.filter_map(|stored| {
        let mut sines = sines(frame, depth, &sight, stored.kind(), &pixels);
        Some((stored, median(&mut sines, FEWEST_SAMPLES)?))
    });
    judged.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Covered pixels with covered neighbours on all four sides, evenly spread.
fn sample_pixels(mask: &Mask) -> Vec<(usize, usize)> {
    let stride = ((mask.count() / SAMPLES) as f64).sqrt().max(1.0) as usize;
    let inner = |length: usize| (1..length.saturating_sub(1)).step_by(stride);
    inner(mask.height())
        .flat_map(|y| inner(mask.width()).map(move |x| (x, y)))
        .filter(|&(x, y)| {
            let cross = [(x, y), (x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            cross.iter().all(|&(x, y)| mask.at(x, y))
        })
        .collect()
}

/// Sines of the angles between normals and the ways across their pixels.
fn sines(
    frame: &Frame,
    depth: &Plane,
    sight: &SightLines,
    kind: DepthKind,
    pixels: &[(usize, usize)],
) -> Vec<f64> {
    let (left, top) = (frame.data_window.x0, frame.data_window.y0);
    let point = |x: usize, y: usize| {
        let (column, row) = (f64::from(left) + x as f64, f64::from(top) + y as f64);
        sight.point(column + 0.5, row + 0.5, depth.at(x, y).into(), kind)
    };
    let normal = &frame.normal;
    let sines = pixels.iter().flat_map(|&(x, y)| {
        let n = normal.at(x, y);
        let ways = [
            point(x + 1, y) - point(x - 1, y),
            point(x, y - 1) - point(x, y + 1),
        ];
        ways.map(|way| n.dot(way).abs() / way.length())
    });
    sines.filter(|sine| sine.is_finite()).collect()
}
