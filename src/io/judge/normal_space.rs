//! The space of a normal map, judged from the map itself.
//!
//! Names do not decide: one renderer's `N` is in world space, another's in view space, a third's has z pointing away.
//! But a visible surface faces the viewer, so in the right reading nearly all normals do; with positions, the right
//! reading agrees with their shape; and depth rises in the direction in which view-space normals lean, for any focal
//! length: a plane n.P = c seen at P = D (X, Y, -1) has 1/D = (n_x X + n_y Y - n_z) / c with c < 0, so grad D is a
//! positive multiple of (n_x, n_y).
//!
//! Limit: a world-space map of a scene seen from straight above with z up *is* a view-space map, up to a rotation about
//! the view axis. Without camera and depth it is read as view space.

use crate::frame::{Camera, Mask, NormalSpace, Plane, Vector3Planes, Window};
use crate::io::camera::median;
use crate::io::inputs::Flip;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Pixels that the judgement looks at, about.
const WANTED: usize = 8_000;
/// A unit normal counts as facing the viewer down to this cosine: filtering and bump tip a few over.
const FACING: f64 = -0.05;
/// Share of facing normals from which a reading is accepted.
const HOLDS: f64 = 0.98;
/// The same without other evidence for the reading: world-space normals of a scene that is mostly ground, seen from
/// well above, reach 0.99 as they are.
const HOLDS_ALONE: f64 = 0.995;
/// A wrong reading has at least this share of averted normals, and 10 times that of the right one.
const TURNS_AWAY: f64 = 0.01;
/// Share below which a reading fails.
const FAILS: f64 = 0.9;
/// Two readings whose normals differ by less than this on average, in degrees, are one.
const SAME_DEG: f64 = 2.0;
/// Largest median angle to the shape of the positions for a correct reading: bump maps and smoothed normals deviate
/// from the facets, but less than this.
const SHAPE_HOLDS_DEG: f64 = 25.0;
/// The right reading is this many times closer to the shape than a wrong one.
const SHAPE_DECIDES: f64 = 2.0;
/// Largest median angle between the lean of the normals and the slope of depth for a correct reading.
const SLOPE_HOLDS_DEG: f64 = 30.0;
/// The same angle from which a reading is rejected; normals unrelated to the depth reach 90.
const SLOPE_FAILS_DEG: f64 = 60.0;
/// Depth slopes that count: the logarithm changes this much over a picture width, well above the
/// rounding of half floats.
const LEAST_SLOPE: f64 = 0.5;
/// A unit normal that leans less than this does not lean.
const LEAST_LEAN: f64 = 0.02;
/// Fewer samples of shape or slope than this decide nothing.
const FEWEST_SHAPES: usize = 24;

/// Which of x and y are reversed, in the order of the evidence.
const REVERSED: [[bool; 2]; 4] = [[false, false], [true, false], [false, true], [true, true]];
/// Axes count as reversed if the mean angle to the slope of depth is above the first of these as stored, below the
/// second once reversed, and falls to less than a share of it. Means, because half a picture of floor leans the same
/// way with x reversed.
const REVERSED_DEG: (f64, f64) = (10.0, 25.0);
const REVERSED_SHARE: f64 = 0.5;
/// They also do where that angle is above the first and falls to less than this share of it: no other reading fits as well.
const SURELY_REVERSED: (f64, f64) = (4.0, 0.2);

/// How stored normals are read: the space they are in, and the axes that point the wrong way and have to be negated first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NormalReading {
    /// The space.
    pub space: NormalSpace,
    /// The axes.
    pub flip: Flip,
}

impl NormalReading {
    /// View space.
    pub const VIEW: Self = Self::of(NormalSpace::View);
    /// View space with z away from the viewer.
    pub const FLIPPED: Self = Self {
        flip: Flip {
            z: true,
            ..Flip::NONE
        },
        ..Self::VIEW
    };
    /// World space.
    pub const WORLD: Self = Self::of(NormalSpace::World);

    /// A space, with all axes as they are.
    pub(crate) const fn of(space: NormalSpace) -> Self {
        Self {
            space,
            flip: Flip::NONE,
        }
    }
}

/// Conclusion about the space of the normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NormalSpaceConclusion {
    /// The reading is known.
    Certain(NormalReading),
    /// Not view space, so world space by elimination, but no camera is known to rotate them with.
    WorldWithoutCamera,
    /// More than one reading is plausible, or none is.
    Ambiguous,
}

/// How normals, read in one way, agree with what else is seen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Agreement {
    /// Share that faces the viewer.
    pub facing: f64,
    /// Median angle, in degrees, to the normal of the positions.
    pub shape_deg: Option<f64>,
    /// Median angle, in degrees, on the picture, between the slope of depth and the lean of the normals.
    pub slope_deg: Option<f64>,
}

/// The numbers behind a judgement.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NormalSpaceEvidence {
    /// Normals looked at.
    pub samples: usize,
    /// Read as view space.
    pub view: Agreement,
    /// Read as view space with z away from the viewer.
    pub flipped: Agreement,
    /// Read as world space. Without a camera to turn them only the shape can be compared.
    pub world: Agreement,
    /// Mean angle, in degrees, between the slope of depth and the lean of the normals read as view space: as they
    /// are, with x reversed, with y reversed, and with both.
    pub slope_reversed_deg: Option<[f64; 4]>,
    /// Mean angle, in degrees, between the world reading and the better view reading; `None` without a camera.
    pub readings_differ_deg: Option<f64>,
}

impl NormalSpaceEvidence {
    /// Whether depth or positions show the axes.
    pub(crate) fn is_judged_by_depth(&self) -> bool {
        self.slope_reversed_deg.is_some() || self.world.shape_deg.is_some()
    }

    /// Whether depth contradicts the normals as they are, read as view space.
    pub(crate) fn is_contradicted_by_depth(&self) -> bool {
        self.view
            .slope_deg
            .is_some_and(|deg| deg >= SLOPE_FAILS_DEG)
    }

    /// Share that faces the viewer in the better reading as view space.
    pub(crate) fn facing_view(&self) -> f64 {
        self.view.facing.max(self.flipped.facing)
    }
}

/// A judgement on the space of a normal map.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalSpaceVerdict {
    /// Conclusion about the normals.
    pub conclusion: NormalSpaceConclusion,
    /// The numbers behind it.
    pub evidence: NormalSpaceEvidence,
    /// A one-line explanation for the user.
    pub reason: String,
}

/// Judges which space `normal` was written in.
///
/// `normal` holds the components as read (signed, not necessarily of unit length), `position` a layer of world-space
/// positions, `depth` distances that grow away from the viewer, `camera` the camera if known; planes and mask fill
/// `data_window`. Zero-length and non-finite normals are skipped.
///
/// With no camera, positions or depth, normals are taken for view space if nearly all have z toward the viewer; the
/// module's documentation describes the limit of that.
pub fn judge_normal_space(
    normal: &Vector3Planes,
    mask: &Mask,
    position: Option<&Vector3Planes>,
    depth: Option<&Plane>,
    camera: Option<&Camera>,
    data_window: Window,
) -> NormalSpaceVerdict {
    NormalSamples::new(normal, mask, position, depth).judge(camera, data_window)
}

/// Normals of pixels spread over a picture, with what shows their space. They are looked at once, when a judgement first
/// needs them, for all judgements.
pub(crate) struct NormalSamples<'a> {
    normal: &'a Vector3Planes,
    mask: &'a Mask,
    position: Option<&'a Vector3Planes>,
    depth: Option<&'a Plane>,
    list: OnceLock<Vec<NormalSample>>,
}

/// A unit normal as stored, and the surface around it.
struct NormalSample {
    place: (usize, usize),
    normal: DVec3,
    /// The gradient of depth on the picture, y up.
    slope: Option<DVec2>,
    /// The normal of the positions around.
    shape: Option<DVec3>,
}

impl<'a> NormalSamples<'a> {
    /// Samples for [`judge_normal_space`], whose inputs these are.
    pub(crate) fn new(
        normal: &'a Vector3Planes,
        mask: &'a Mask,
        position: Option<&'a Vector3Planes>,
        depth: Option<&'a Plane>,
    ) -> Self {
        Self {
            normal,
            mask,
            position,
            depth,
            list: OnceLock::new(),
        }
    }

    /// The judgement with a camera, or without.
    pub(crate) fn judge(&self, camera: Option<&Camera>, data_window: Window) -> NormalSpaceVerdict {
        let turn = camera.map(|c| c.view_from_world.matrix3);
        let mut tally = ReadingSums::default();
        for sample in self.list.get_or_init(|| self.gathered()) {
            let (x, y) = sample.place;
            let n = sample.normal;
            let flipped = DVec3::new(n.x, n.y, -n.z);
            let readings = [Some(n), Some(flipped), turn.map(|turn| turn * n)];
            tally.add_facing(readings, to_eye(camera, data_window.middle(x, y)));
            if let Some(slope) = sample.slope {
                tally.add_slope(readings, slope);
            }
            if let Some(shape) = sample.shape {
                let in_view = turn.map(|turn| turn * shape);
                tally.add_shape([(n, in_view), (flipped, in_view), (n, Some(shape))]);
            }
        }
        let evidence = tally.evidence(camera.is_some());
        let (conclusion, why) = concluded(&evidence);
        NormalSpaceVerdict {
            conclusion,
            reason: format!("{why}{}", numbers(&evidence)),
            evidence,
        }
    }

    fn gathered(&self) -> Vec<NormalSample> {
        let sample = |(x, y)| {
            let n = self.normal.at(x, y);
            // Filtering shortens normals at edges; the shortest ones have no meaningful direction.
            let normal = n
                .try_normalize()
                .filter(|_| n.is_finite() && n.length() > 0.1)?;
            Some(NormalSample {
                place: (x, y),
                normal,
                slope: self.slope(x, y),
                shape: self.shape(x, y),
            })
        };
        let places: Vec<_> = self.mask.sample(WANTED).collect();
        places.into_par_iter().filter_map(sample).collect()
    }

    /// The gradient of depth on the picture, y up, where it is clear of rounding and of edges.
    fn slope(&self, x: usize, y: usize) -> Option<DVec2> {
        let depth = self.depth.filter(|_| self.is_inside(x, y))?;
        let seen = |x: usize, y: usize| {
            let d = f64::from(depth.at(x, y));
            (self.mask.at(x, y) && d.is_finite() && d > 0.0).then(|| d.ln())
        };
        let here = seen(x, y)?;
        let run = |before: f64, after: f64| {
            let (a, b) = (here - before, after - here);
            // Away from edges both halves agree, up to the effect of rounding on short steps.
            ((a - b).abs() < 0.5 * (a.abs() + b.abs()) + 2e-3).then_some(0.5 * (a + b))
        };
        let right = run(seen(x - 1, y)?, seen(x + 1, y)?)?;
        let up = run(seen(x, y + 1)?, seen(x, y - 1)?)?;
        let slope = DVec2::new(right, up);
        (slope.length() * depth.width() as f64 > LEAST_SLOPE).then_some(slope)
    }

    /// Whether a pixel has neighbours on all sides.
    fn is_inside(&self, x: usize, y: usize) -> bool {
        let plane = self.mask.plane();
        x > 0 && y > 0 && x + 1 < plane.width() && y + 1 < plane.height()
    }

    /// The world-space unit normal of the surface through the positions around a pixel, away from edges.
    fn shape(&self, x: usize, y: usize) -> Option<DVec3> {
        let position = self.position.filter(|_| self.is_inside(x, y))?;
        let seen = |x: usize, y: usize| {
            let point = position.at(x, y);
            (point.is_finite() && self.mask.at(x, y)).then_some(point)
        };
        let here = seen(x, y)?;
        let right = central(seen(x - 1, y)?, here, seen(x + 1, y)?)?;
        let up = central(seen(x, y + 1)?, here, seen(x, y - 1)?)?;
        right.cross(up).try_normalize()
    }
}

/// The unit direction from a place on the picture to the eye, in view space.
fn to_eye(camera: Option<&Camera>, place: DVec2) -> DVec3 {
    let lean = camera.map_or(DVec2::ZERO, |c| c.projection.to_eye(place.x, place.y));
    lean.extend(1.0).normalize_or(DVec3::Z)
}

/// The step from `before` to `after`; `None` across an edge, where the two halves are unlike.
fn central(before: DVec3, here: DVec3, after: DVec3) -> Option<DVec3> {
    let (a, b) = ((here - before).length(), (after - here).length());
    (a.max(b) < 3.0 * a.min(b)).then_some(after - before)
}

/// Sums over normals, by the readings as view space, as that with z away, and as world space.
#[derive(Default)]
struct ReadingSums {
    samples: usize,
    facing: [usize; 3],
    shape: [Vec<f64>; 3],
    slope: [Vec<f64>; 3],
    /// Sums of angles between the world reading and the two view readings.
    differ: [f64; 2],
    /// Sums of angles to the slope, by reversed axes.
    reversed: [f64; 4],
}

impl ReadingSums {
    fn add_facing(&mut self, readings: [Option<DVec3>; 3], eye: DVec3) {
        self.samples += 1;
        for (count, n) in self.facing.iter_mut().zip(readings) {
            *count += usize::from(n.is_some_and(|n| n.dot(eye) > FACING));
        }
        let [views @ .., world] = readings;
        for (sum, view) in self.differ.iter_mut().zip(views) {
            *sum += world.zip(view).map_or(0.0, |(a, b)| angle_deg(a, b));
        }
    }

    fn add_slope(&mut self, readings: [Option<DVec3>; 3], slope: DVec2) {
        // A normal that does not lean where depth rises counts as leaning sideways.
        let off = |n: DVec3| match n.truncate() {
            lean if lean.length() < LEAST_LEAN => 90.0,
            lean => lean.angle_to(slope).abs().to_degrees(),
        };
        for (angles, n) in self.slope.iter_mut().zip(readings) {
            angles.extend(n.map(off));
        }
        let [as_is, x_reversed] = [1.0, -1.0].map(|x| {
            let mirrored = readings[0].map(|n| n * DVec3::new(x, 1.0, 1.0));
            mirrored.map_or(0.0, off)
        });
        // With the other axis reversed, a normal leans the opposite way.
        let angles = [as_is, x_reversed, 180.0 - x_reversed, 180.0 - as_is];
        let sums = self.reversed.iter_mut().zip(angles);
        sums.for_each(|(sum, angle)| *sum += angle);
    }

    /// Adds normals, and those of the shape in the same space.
    fn add_shape(&mut self, readings: [(DVec3, Option<DVec3>); 3]) {
        for (angles, (n, shape)) in self.shape.iter_mut().zip(readings) {
            angles.extend(shape.map(|shape| line_angle_deg(n, shape)));
        }
    }

    fn evidence(mut self, camera: bool) -> NormalSpaceEvidence {
        let count = self.samples.max(1) as f64;
        let [view, flipped, world] = [0, 1, 2].map(|i| Agreement {
            facing: self.facing[i] as f64 / count,
            shape_deg: median(&mut self.shape[i], FEWEST_SHAPES),
            slope_deg: median(&mut self.slope[i], FEWEST_SHAPES),
        });
        let differ = self.differ[usize::from(view.facing < flipped.facing)];
        let slopes = self.slope[0].len();
        let mean = |sum: f64| sum / slopes as f64;
        NormalSpaceEvidence {
            samples: self.samples,
            view,
            flipped,
            world,
            slope_reversed_deg: (slopes >= FEWEST_SHAPES).then(|| self.reversed.map(mean)),
            readings_differ_deg: camera.then_some(differ / count),
        }
    }
}

fn angle_deg(a: DVec3, b: DVec3) -> f64 {
    a.dot(b).clamp(-1.0, 1.0).acos().to_degrees()
}

/// The angle between two lines, 0..90 degrees: back faces and mirrored scenes reverse a normal without
/// changing its space.
fn line_angle_deg(a: DVec3, b: DVec3) -> f64 {
    a.dot(b).abs().min(1.0).acos().to_degrees()
}

type Concluded = (NormalSpaceConclusion, String);

/// A reading that is known, and why.
fn certain(reading: NormalReading, why: &str) -> Concluded {
    let name = match reading {
        NormalReading::FLIPPED => "view with z away from the viewer",
        other => other.space.name(),
    };
    let conclusion = NormalSpaceConclusion::Certain(reading);
    (conclusion, format!("{name}: {why}"))
}

fn concluded(e: &NormalSpaceEvidence) -> Concluded {
    if e.samples == 0 {
        let why = "undecided: no covered pixel holds a normal";
        return (NormalSpaceConclusion::Ambiguous, why.into());
    }
    by_shape(e)
        .or_else(|| by_shape_without_camera(e))
        .or_else(|| by_reversed_slope(e))
        .or_else(|| by_slope(e))
        .unwrap_or_else(|| match e.readings_differ_deg {
            Some(differ) => by_facing(e, differ),
            None => by_facing_without_camera(e),
        })
}

/// Whether axes are reversed, judged by mean angles to the slope of depth, in degrees: with the axes as stored, and
/// with some reversed.
pub(crate) fn is_reversed(as_is: f64, turned: f64) -> bool {
    let (least, share) = SURELY_REVERSED;
    let surely = as_is > least && turned < share * as_is;
    let (least, most) = REVERSED_DEG;
    surely || (as_is > least && turned < most && turned < REVERSED_SHARE * as_is)
}

/// View space with x or y reversed, if depth shows it.
fn by_reversed_slope(e: &NormalSpaceEvidence) -> Option<Concluded> {
    let angles = e.slope_reversed_deg?;
    let best = (1..4).min_by(|&a, &b| angles[a].total_cmp(&angles[b]))?;
    let shows = is_reversed(angles[0], angles[best]);
    let world_holds = e.world.slope_deg.is_some_and(|deg| deg < angles[best]);
    let (share, toward) = better_view(e);
    let [x, y] = REVERSED[best];
    let flip = Flip {
        x,
        y,
        ..toward.flip
    };
    let why = "agrees with the depth once reversed axes are turned round";
    let reading = NormalReading { flip, ..toward };
    (shows && !world_holds && share >= FAILS).then(|| certain(reading, why))
}

/// The reading that agrees with the positions, where one does and the others do not.
fn by_shape(e: &NormalSpaceEvidence) -> Option<Concluded> {
    let mut readings = [
        (e.world.shape_deg?, NormalReading::WORLD),
        (e.view.shape_deg?, NormalReading::VIEW),
        (e.flipped.shape_deg?, NormalReading::FLIPPED),
    ];
    readings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(best, reading), (next, _), _] = readings;
    let decides = best <= SHAPE_HOLDS_DEG && next > SHAPE_DECIDES * best + SAME_DEG;
    decides.then(|| certain(reading, "agrees with the positions"))
}

/// Positions without a camera only show whether the normals share their space.
fn by_shape_without_camera(e: &NormalSpaceEvidence) -> Option<Concluded> {
    let has_camera = e.readings_differ_deg.is_some();
    let world = e.world.shape_deg.filter(|_| !has_camera)?;
    let also_view = e.facing_view() >= HOLDS;
    (world <= 0.5 * SHAPE_HOLDS_DEG || (world <= SHAPE_HOLDS_DEG && !also_view))
        .then(|| certain(NormalReading::WORLD, "agrees with the positions"))
}

/// The reading whose normals lean toward rising depth.
fn by_slope(e: &NormalSpaceEvidence) -> Option<Concluded> {
    let view = e.view.slope_deg?;
    let (share, as_view) = better_view(e);
    let agrees = |reading| Some(certain(reading, "agrees with the depth"));
    match e.world.slope_deg {
        Some(world) if world <= SLOPE_HOLDS_DEG && view >= 2.0 * world + 10.0 => {
            agrees(NormalReading::WORLD)
        }
        Some(world) if view <= SLOPE_HOLDS_DEG && world >= 2.0 * view + 10.0 => agrees(as_view),
        None if view <= SLOPE_HOLDS_DEG && share >= FAILS => agrees(as_view),
        None if view >= SLOPE_FAILS_DEG => Some((
            NormalSpaceConclusion::WorldWithoutCamera,
            "world, but no camera: as they are, the normals contradict the depth".into(),
        )),
        _ => None,
    }
}

/// The view reading that more normals face the viewer in, and its share.
fn better_view(e: &NormalSpaceEvidence) -> (f64, NormalReading) {
    match e.view.facing >= e.flipped.facing {
        true => (e.view.facing, NormalReading::VIEW),
        false => (e.flipped.facing, NormalReading::FLIPPED),
    }
}

/// A view reading by the normals that face the viewer in it.
fn facing_as(reading: NormalReading) -> Concluded {
    let how = match reading {
        NormalReading::FLIPPED => "once z is negated",
        _ => "as they are",
    };
    certain(reading, &format!("the normals face the viewer {how}"))
}

fn by_facing(e: &NormalSpaceEvidence, differ: f64) -> Concluded {
    let why = "the normals face the viewer once turned by the camera";
    let turned = || certain(NormalReading::WORLD, why);
    let (world, (view, as_view)) = (e.world.facing, better_view(e));
    let beats = |a: f64, b: f64| a >= HOLDS && 1.0 - b > TURNS_AWAY + 10.0 * (1.0 - a);
    let are_one = differ <= SAME_DEG;
    if are_one && world > view || !are_one && beats(world, view) {
        return turned();
    }
    if are_one || beats(view, world) {
        return facing_as(as_view);
    }
    let why = match world.min(view) >= FAILS {
        true => "undecided: the normals face the viewer both as they are and turned by the camera",
        false => "undecided: the normals face the viewer in no space",
    };
    (NormalSpaceConclusion::Ambiguous, why.into())
}

fn by_facing_without_camera(e: &NormalSpaceEvidence) -> Concluded {
    match better_view(e) {
        (share, reading) if share >= HOLDS_ALONE => facing_as(reading),
        (share, _) if share < FAILS => (
            NormalSpaceConclusion::WorldWithoutCamera,
            "world, but no camera: the normals do not face the viewer as they are".into(),
        ),
        _ => (
            NormalSpaceConclusion::Ambiguous,
            "undecided: most normals face the viewer as they are, but not nearly all".into(),
        ),
    }
}

/// The evidence as the tail of a sentence.
fn numbers(e: &NormalSpaceEvidence) -> String {
    if e.samples == 0 {
        return String::new();
    }
    let mut text = String::from(" (facing the viewer: ");
    if e.readings_differ_deg.is_some() {
        let world = 100.0 * e.world.facing;
        text += &format!("{world:.1} % turned by the camera, ");
    }
    let [view, flipped] = [e.view, e.flipped].map(|reading| 100.0 * reading.facing);
    text += &format!("{view:.1} % as they are, {flipped:.1} % with z negated");
    if let Some(world) = e.world.shape_deg {
        text += &format!("; angle to the positions' shape: {world:.1} deg as world");
    }
    if let (Some(view), Some(flipped)) = (e.view.shape_deg, e.flipped.shape_deg) {
        text += &format!(", {view:.1} as view, {flipped:.1} with z negated");
    }
    if let Some(view) = e.view.slope_deg {
        text += &format!("; angle to the slope of depth: {view:.1} deg as they are");
    }
    if let Some(world) = e.world.slope_deg {
        text += &format!(", {world:.1} turned");
    }
    let axes_tell = by_reversed_slope(e).is_some();
    if let Some([as_is, x, y, both]) = e.slope_reversed_deg.filter(|_| axes_tell) {
        text += &format!(
            "; on average {as_is:.1} deg as they are, {x:.1} with x reversed, {y:.1} with y, {both:.1} with both"
        );
    }
    text + ")"
}
