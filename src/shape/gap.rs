//! Gaps between the surfaces of neighbouring pixels: where one hides another.
//!
//! Theory: [LW] section 4.4 takes the Sobel magnitude of depth. Departs from it: a depth may be as steep as one likes
//! on a floor seen at a grazing angle, so its slope tells nothing. The distance of a point from the tangent plane of
//! its neighbour does: on a smooth surface of curvature kappa it is at most kappa / 2 times the square of a chord, under a
//! pixel up to the very rim, whatever the distance, the camera and the unit. So the gap between two pixels is the
//! larger of the distances of each one's point from the other's tangent plane, in pixels at the nearer one's distance.

use crate::engine::cpu::simd::widened;
use crate::frame::{DepthKind, Frame, Plane, Projection, ToEye};
use crate::params::SoftThreshold;
use crate::shape::gap_noise::GapNoise;

/// A perspective camera's focal length where none is known, in longer sides of the picture: 44 degrees across.
const FOCAL_SIDES: f64 = 1.25;

/// Smallest thresholds, in pixels, however small the picture: a pixel's own extent is no gap.
const LEAST_PX: SoftThreshold = SoftThreshold { lo: 1.5, hi: 2.5 };

/// Share of a jump of depth by which it departs from the slopes on both sides: below it is a slope, from the second on
/// it is a jump.
pub(crate) const DEPARTS: SoftThreshold = SoftThreshold { lo: 0.1, hi: 0.3 };

/// Sine of the angle between a tangent plane and the step across: the same for surfaces that meet where depth hardly
/// departs, as blurred ones do. Bumps of a floor's normals stay below.
pub(crate) const TURNS: SoftThreshold = SoftThreshold { lo: 0.3, hi: 0.5 };

/// Depths between which products fit single precision, with all focal lengths that are accepted.
pub(crate) const NEAREST: f32 = 1e-12;
pub(crate) const FARTHEST: f32 = 1e12;

/// Jumps beyond this, in pixels, count as such.
pub(crate) const STEEPEST: f32 = 1e15;

/// From this weight on a silhouette closes in full: a fit between pixels that are nearly closed would magnify the rounding
/// of what is left of them.
pub(crate) const CLOSED: f32 = 0.95;

/// What the gaps of a frame are measured by. Depth is along the view axis here.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapScale {
    pub(crate) is_perspective: bool,
    /// Pixels per unit of length along rows and along columns; in perspective at depth 1.
    pub(crate) pitch: [f32; 2],
    /// The step to the next column in x, and to the next row in y, of points at depth 1.
    pub(crate) step: [f32; 2],
    /// Twice the rounding error of depth: as a share of it, and in its own unit.
    pub(crate) rounding: [f32; 2],
    /// The longer side of the picture, in pixels.
    pub(crate) side: f32,
    /// Gaps that make a silhouette, in pixels.
    pub(crate) threshold: SoftThreshold,
    /// Whether depth is measured along sight lines.
    pub(crate) along_lines: bool,
    pub(crate) projection: Projection,
}

impl GapScale {
    /// The scale of a frame. `threshold` is in longer sides of its display window.
    pub(crate) fn of(frame: &Frame, threshold: SoftThreshold) -> Self {
        let window = frame.display_window;
        let side = window.width().max(window.height()) as f64;
        let projection = frame.camera.map_or_else(
            || {
                let center = window.center();
                Projection::Perspective {
                    fx: FOCAL_SIDES * side,
                    fy: FOCAL_SIDES * side * f64::from(frame.pixel_aspect),
                    cx: center.x,
                    cy: center.y,
                }
            },
            |camera| camera.projection,
        );
        let (is_perspective, [x, y]) = match projection {
            Projection::Perspective { fx, fy, .. } => (true, [fx, fy]),
            Projection::Orthographic { sx, sy, .. } => (false, [sx, sy]),
        };
        let pixels = |share: f32, least: f32| (side as f32 * share).max(least);
        Self {
            is_perspective,
            pitch: [x, y].map(|scale| scale.abs() as f32),
            step: [1.0 / x as f32, -1.0 / y as f32],
            rounding: frame.source.depth_rounding.map(|error| 2.0 * error),
            side: side as f32,
            threshold: SoftThreshold {
                lo: pixels(threshold.lo, LEAST_PX.lo),
                hi: pixels(threshold.hi, LEAST_PX.hi),
            },
            along_lines: frame.source.depth_kind == DepthKind::Ray,
            projection,
        }
    }

    /// The direction to the eye, scaled to z = 1, of the pixel at this place of the picture.
    #[cfg(feature = "gpu")]
    pub(crate) fn to_eye(self, x: f64, y: f64) -> glam::DVec2 {
        self.projection.to_eye(x, y)
    }

    /// Depth of a pixel along the view axis.
    #[inline(always)]
    fn planar(&self, depth: f32, [x, y]: [f32; 2]) -> f32 {
        let depth = match self.along_lines {
            true => depth / (1.0 + (x * x + y * y)).sqrt(),
            false => depth,
        };
        let nearest = if self.is_perspective {
            NEAREST
        } else {
            -FARTHEST
        };
        depth.clamp(nearest, FARTHEST)
    }

    /// Its unit along an axis, 0 to the right and 1 downward.
    #[inline(always)]
    pub(crate) fn unit(&self, axis: usize) -> GapUnit {
        GapUnit {
            is_perspective: self.is_perspective,
            pitch: self.pitch[axis],
            rounding: self.rounding,
        }
    }

    /// The jump between two depths along an axis, in pixels at the nearer one.
    pub(crate) fn jump_px(&self, depths: [f32; 2], axis: usize) -> f32 {
        let jump = (depths[1] - depths[0]).abs() * self.pitch[axis];
        match self.is_perspective {
            true => jump / depths[0].min(depths[1]),
            false => jump,
        }
    }

    /// What is nearer than a depth by a gap that makes a silhouette: than a share of it, less a length.
    pub(crate) fn before(&self) -> [f32; 2] {
        let gap = self.threshold.lo / self.pitch[0];
        match self.is_perspective {
            true => [1.0 / (1.0 + gap), 0.0],
            false => [1.0, gap],
        }
    }

    /// What is linear along a plane in the picture: one over depth in perspective, depth elsewhere.
    #[inline(always)]
    pub(crate) fn linear(&self, depth: f32) -> f32 {
        if self.is_perspective {
            1.0 / depth
        } else {
            depth
        }
    }
}

/// What turns depths into pixels along an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapUnit {
    pub(crate) is_perspective: bool,
    /// Pixels per unit of length, in perspective at depth 1.
    pub(crate) pitch: f32,
    /// Twice the rounding error of depth: as a share of it, and in its own unit.
    pub(crate) rounding: [f32; 2],
}

/// A pixel beside the border between it and its neighbour. What is unknown is NaN.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub(crate) depth: f32,
    /// [`GapScale::linear`] of the depth.
    pub(crate) linear: f32,
    /// The same of the next pixel away from the neighbour.
    pub(crate) beyond: f32,
    /// The sight line of z = -1 times the normal, which is negative where it is seen from the front.
    pub(crate) facing: f32,
    /// The step from the first to the second pixel at depth 1, times the normal.
    pub(crate) along: f32,
}

/// Two neighbouring pixels, compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// The distance between their surfaces, in pixels.
    pub(crate) px: f32,
    /// The part of the jump of depth that the slopes beside it do not explain, in pixels.
    pub(crate) bend: f32,
    /// How surely the pixels are on different surfaces, or on parts that are turned apart, 0..1.
    pub(crate) gate: f32,
    /// Smallest gap that rounding of depth makes, in pixels.
    pub(crate) rounding: f32,
}

impl Gap {
    /// Compares two pixels.
    #[inline(always)]
    pub(crate) fn between(a: Side, b: Side, unit: GapUnit) -> Self {
        let step = b.depth - a.depth;
        let (farther, nearer_linear) = (a.depth.max(b.depth), a.linear.max(b.linear));
        let pitch = unit.pitch;
        let (per_unit, per_linear, past_a, past_b) = match unit.is_perspective {
            true => (pitch * nearer_linear, pitch * farther, b.depth, a.depth),
            false => (pitch, pitch, 1.0, 1.0),
        };
        let off_a = (per_unit * (step * a.facing + past_a * a.along)).abs();
        let off_b = (per_unit * (step * b.facing + past_b * b.along)).abs();
        let jump = (b.linear - a.linear) * per_linear;
        let chords = [a.linear - a.beyond, b.beyond - b.linear].map(|chord| chord * per_linear);
        let (least, most) = (chords[0].min(chords[1]), chords[0].max(chords[1]));
        let bend = match least.is_nan() {
            true => jump.abs(),
            false => (least - jump).max(jump - most).max(0.0),
        };
        let px = off_a.max(off_b);
        let departs = DEPARTS.weight(bend / jump.abs().max(f32::MIN_POSITIVE));
        // Where its square would not fit, all is a jump.
        let steep = jump.abs().min(STEEPEST);
        let turns = TURNS.weight(px / (1.0 + steep * steep).sqrt());
        let size = a.depth.abs().max(b.depth.abs());
        Self {
            px,
            bend,
            gate: departs.max(turns),
            rounding: per_unit * (unit.rounding[0] * size + unit.rounding[1]),
        }
    }

    /// The weight of the silhouette between them, 0..1, where the depth around has this much noise, in pixels.
    #[inline(always)]
    pub(crate) fn weight(&self, noise: f32, threshold: SoftThreshold) -> f32 {
        let more = self.rounding + NOISES * noise;
        let raised = SoftThreshold {
            lo: threshold.lo + more,
            hi: threshold.hi + more,
        };
        let weight = self.gate * raised.weight(self.px);
        if weight > CLOSED { 1.0 } else { weight }
    }
}

/// Thresholds rise by this many times the noise of depth.
pub(crate) const NOISES: f32 = 4.0;

/// The gaps of a frame.
pub(crate) struct Gaps<'a> {
    frame: &'a Frame,
    depth: &'a Plane,
    pub(crate) scale: GapScale,
    to_eye: ToEye,
    noise: Option<GapNoise>,
}

impl<'a> Gaps<'a> {
    /// The gaps of `depth`, a plane of `frame`. `threshold` is in longer sides of its display window.
    pub(crate) fn new(frame: &'a Frame, depth: &'a Plane, threshold: SoftThreshold) -> Self {
        let scale = GapScale::of(frame, threshold);
        let to_eye = ToEye::of(frame.data_window, Some(scale.projection));
        let mut gaps = Self {
            frame,
            depth,
            scale,
            to_eye,
            noise: None,
        };
        gaps.noise = GapNoise::of(frame, |at, axis| gaps.after(at, axis));
        gaps
    }

    /// The noise of depth, if there is any.
    pub(crate) fn noise(&self) -> Option<&GapNoise> {
        self.noise.as_ref()
    }

    /// The samples of row `y`.
    pub(crate) fn samples(&self, y: usize) -> Samples<'_> {
        let normal = &self.frame.normal;
        Samples {
            depth: self.depth.row(y),
            covered: self.frame.mask.row(y),
            normal: [normal.x.row(y), normal.y.row(y), normal.z.row(y)],
            to_eye: (&self.to_eye.x, self.to_eye.y[y]),
        }
    }

    /// The gap between a pixel and the next along an axis, 0 to the right and 1 downward, if both are covered.
    pub(crate) fn after(&self, at: [usize; 2], axis: usize) -> Option<Gap> {
        let place = |by: isize| {
            let mut at = at;
            at[axis] = at[axis].checked_add_signed(by)?;
            let inside = at[0] < self.depth.width() && at[1] < self.depth.height();
            (inside && self.frame.mask.at(at[0], at[1])).then_some(at)
        };
        let linear = |by| place(by).map_or(f32::NAN, |at| self.scale.linear(self.planar(at)));
        let side = |at: [usize; 2], beyond| {
            let [x, y] = at;
            let normal = &self.frame.normal;
            let normal = [normal.x.at(x, y), normal.y.at(x, y), normal.z.at(x, y)];
            let depth = self.planar(at);
            Side {
                depth,
                linear: self.scale.linear(depth),
                beyond: linear(beyond),
                facing: facing(normal, [self.to_eye.x[x], self.to_eye.y[y]]),
                along: normal[axis] * self.scale.step[axis],
            }
        };
        let (a, b) = (side(place(0)?, -1), side(place(1)?, 2));
        Some(Gap::between(a, b, self.scale.unit(axis)))
    }

    /// The gap after a pixel, in pixels, where it makes a silhouette.
    pub(crate) fn seen_after(&self, at: [usize; 2], axis: usize) -> Option<f32> {
        let mut noise = [0.0];
        if let Some(of) = &self.noise {
            of.fill_row(at, axis, &mut noise);
        }
        let gap = self.after(at, axis)?;
        (gap.weight(noise[0], self.scale.threshold) > 0.0).then_some(gap.px)
    }

    /// Depth of a pixel along the view axis.
    fn planar(&self, [x, y]: [usize; 2]) -> f32 {
        let eye = [self.to_eye.x[x], self.to_eye.y[y]];
        self.scale.planar(self.depth.at(x, y), eye)
    }
}

/// The sight line of z = -1 times a normal.
#[inline(always)]
fn facing([x, y, z]: [f32; 3], to_eye: [f32; 2]) -> f32 {
    // In this order a transposed frame gives the same bits.
    -(z + (x * to_eye[0] + y * to_eye[1]))
}

/// A row of pixels as gaps are measured between them, with [`PAD`] unknown ones at either end.
#[derive(Debug, Clone, Default)]
pub(crate) struct GapRow {
    depth: Vec<f32>,
    linear: Vec<f32>,
    facing: Vec<f32>,
}

/// Unknown pixels at either end of a row.
const PAD: usize = 2;

impl GapRow {
    /// A row of `width` unknown pixels.
    pub(crate) fn new(width: usize) -> Self {
        let row = || vec![f32::NAN; width + 2 * PAD];
        Self {
            depth: row(),
            linear: row(),
            facing: row(),
        }
    }

    /// Makes all pixels unknown.
    pub(crate) fn clear(&mut self) {
        for row in [&mut self.depth, &mut self.linear, &mut self.facing] {
            row.fill(f32::NAN);
        }
    }
}

/// The samples of a row of a frame, and the direction to the eye by column and of the row.
#[derive(Clone, Copy)]
pub(crate) struct Samples<'a> {
    pub(crate) depth: &'a [f32],
    pub(crate) covered: &'a [bool],
    pub(crate) normal: [&'a [f32]; 3],
    pub(crate) to_eye: (&'a [f32], f32),
}

/// Prepares a row.
#[inline(always)]
pub(crate) fn fill_gap_row(row: &mut GapRow, samples: &Samples, scale: &GapScale) {
    let n = samples.depth.len();
    let [nx, ny, nz] = samples.normal.map(|row| &row[..n]);
    let (covered, to_eye) = (&samples.covered[..n], &samples.to_eye.0[..n]);
    let inside = PAD..PAD + n;
    let depths = &mut row.depth[inside.clone()];
    let (linear, facing) = (&mut row.linear[inside.clone()], &mut row.facing[inside]);
    for x in 0..n {
        let eye = [to_eye[x], samples.to_eye.1];
        let depth = scale.planar(samples.depth[x], eye);
        let depth = if covered[x] { depth } else { f32::NAN };
        depths[x] = depth;
        linear[x] = scale.linear(depth);
        facing[x] = self::facing([nx[x], ny[x], nz[x]], eye);
    }
}

/// Weights of the silhouettes between the pixels of `rows` 1 and 2, or with `beside` between each pixel of row 1 and the
/// next one: positive where the first is the nearer, else negative. `along` are their normals along the step.
#[inline(always)]
pub(crate) fn gap_weight_row(
    out: &mut [f32],
    rows: [&GapRow; 4],
    along: [&[f32]; 2],
    noise: &[f32],
    direction: (usize, &GapScale),
) {
    let n = out.len();
    let (axis, scale) = direction;
    let shifts = if axis == 0 {
        [PAD - 1, PAD, PAD + 1, PAD + 2]
    } else {
        [PAD; 4]
    };
    let [before, a, b, behind] = [0, 1, 2, 3].map(|i| &rows[i].linear[shifts[i]..][..n]);
    let [depth_a, depth_b] = [1, 2].map(|i| &rows[i].depth[shifts[i]..][..n]);
    let [facing_a, facing_b] = [1, 2].map(|i| &rows[i].facing[shifts[i]..][..n]);
    let [along_a, along_b] = along.map(|row| &row[..n]);
    let (noise, step, unit) = (&noise[..n], scale.step[axis], scale.unit(axis));
    for x in 0..n {
        let first = Side {
            depth: depth_a[x],
            linear: a[x],
            beyond: before[x],
            facing: facing_a[x],
            along: along_a[x] * step,
        };
        let second = Side {
            depth: depth_b[x],
            linear: b[x],
            beyond: behind[x],
            facing: facing_b[x],
            along: along_b[x] * step,
        };
        let weight = Gap::between(first, second, unit).weight(noise[x], scale.threshold);
        out[x] = if first.depth <= second.depth {
            weight
        } else {
            -weight
        };
    }
}

widened! {
    fn fill_gap_row(row: &mut GapRow, samples: &Samples, scale: &GapScale);
    fn gap_weight_row(
        out: &mut [f32],
        rows: [&GapRow; 4],
        along: [&[f32]; 2],
        noise: &[f32],
        direction: (usize, &GapScale),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::cpu::memory::Memory;
    use crate::frame::{Camera, Mask, Vector3Planes};
    use crate::params::{ScalingParams, ShapeParams};
    use crate::plan::{Available, Goal, Plan};
    use crate::shape::edges::cpu::edges_and_gradient;
    use glam::{DAffine3, DVec3};

    const SIDE: usize = 200;

    /// The weights drawn in a frame, and its conductance.
    fn silhouettes(frame: &Frame) -> [Plane; 2] {
        let (available, shape) = (Available::in_frame(frame), ShapeParams::default());
        let plan = Plan::new(Goal::Layers, available, shape, ScalingParams::default()).unwrap();
        let (weights, _) = edges_and_gradient(&plan, frame, &Memory::default());
        [weights.silhouette.unwrap(), weights.conductance]
    }

    /// A frame of `SIDE` columns and rows, of the normal and the depth at the middle of each pixel; nothing at depth 0.
    fn frame(projection: Option<Projection>, at: impl Fn(f64, f64) -> (DVec3, f64)) -> Frame {
        let here = |x: usize, y: usize| at(x as f64 + 0.5, y as f64 + 0.5);
        let normal = Vector3Planes::from_fn(SIDE, SIDE, |x, y| here(x, y).0);
        let depth = Plane::from_fn(SIDE, SIDE, |x, y| here(x, y).1 as f32);
        let mut frame = Frame::of_normals(normal, Mask::new(depth.map(|depth| depth != 0.0)));
        frame.depth = Some(depth);
        frame.camera = projection.map(|projection| Camera {
            view_from_world: DAffine3::IDENTITY,
            projection,
        });
        frame
    }

    fn perspective(focal: f64) -> Projection {
        let center = SIDE as f64 / 2.0;
        Projection::Perspective {
            fx: focal,
            fy: focal,
            cx: center,
            cy: center,
        }
    }

    fn parallel(scale: f64) -> Projection {
        let center = SIDE as f64 / 2.0;
        Projection::Orthographic {
            sx: scale,
            sy: scale,
            cx: center,
            cy: center,
        }
    }

    /// A ball of radius 60 at the middle, at `distance`, before a wall 40 behind it: in pixels at the ball.
    fn ball(projection: Projection, distance: f64) -> Frame {
        frame(Some(projection), |x, y| {
            let eye = projection.to_eye(x, y);
            let (start, line) = match projection {
                Projection::Perspective { .. } => (DVec3::ZERO, DVec3::new(-eye.x, -eye.y, -1.0)),
                Projection::Orthographic { .. } => {
                    (DVec3::new(x - 100.0, 100.0 - y, 0.0), DVec3::NEG_Z)
                }
            };
            let to = start - DVec3::new(0.0, 0.0, -distance);
            let (a, b) = (line.length_squared(), to.dot(line));
            let root = b * b - a * (to.length_squared() - 3600.0);
            if root < 0.0 {
                return (DVec3::Z, distance + 100.0);
            }
            let along = (-b - root.sqrt()) / a;
            ((to + along * line) / 60.0, along)
        })
    }

    #[test]
    fn a_floor_has_none_however_grazing_and_bumpy() {
        // The floor n . P = -1 with its horizon in row 20, seen with these focal lengths: at depth -1 / (n . line).
        let floor = |focal: f64, projection| {
            let upright = DVec3::new(0.0, focal, 80.0).normalize();
            let ahead = DVec3::new(0.0, -upright.z, upright.y);
            frame(projection, |x, y| {
                let line = DVec3::new((x - 100.0) / focal, (100.0 - y) / focal, -1.0);
                let below = -upright.dot(line);
                let (sine, cosine) = (0.9 * x + 0.7 * y).sin_cos();
                // 11 degrees from upright.
                let normal = upright + 0.2 * (sine * DVec3::X + cosine * ahead);
                (
                    normal.normalize(),
                    if below > 1e-6 { 1.0 / below } else { 0.0 },
                )
            })
        };
        // An unknown lens is taken for one of 250 pixels here.
        for (focal, projection) in [
            (250.0, Some(perspective(250.0))),
            (250.0, None),
            (325.0, None),
        ] {
            let [weights, _] = silhouettes(&floor(focal, projection));
            for y in 22..SIDE - 1 {
                let row = &weights.row(y)[1..SIDE - 1];
                assert!(row.iter().all(|&weight| weight == 0.0), "{focal}, row {y}");
            }
        }
    }

    #[test]
    fn a_ball_before_a_wall_has_its_outline_at_any_distance_in_one_pixel() {
        for distance in [300.0, 1000.0, 5000.0, 30_000.0] {
            for projection in [perspective(distance), parallel(1.0)] {
                let frame = ball(projection, distance);
                let depth = frame.depth.as_ref().unwrap();
                let is_wall = |x: usize, y: usize| f64::from(depth.at(x, y)) > distance + 99.0;
                let [weights, conductance] = silhouettes(&frame);
                let (mut outline, mut drawn) = (0, 0);
                for (y, x) in (1..SIDE - 1).flat_map(|y| (1..SIDE - 1).map(move |x| (y, x))) {
                    let beside = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
                    let differs = beside.iter().any(|&(i, j)| is_wall(i, j) != is_wall(x, y));
                    let is_front = differs && !is_wall(x, y);
                    assert!(
                        !is_front || weights.at(x, y) == 1.0,
                        "{projection:?} at {x}, {y}"
                    );
                    assert!(
                        !differs || conductance.at(x, y) == 0.0,
                        "{projection:?} at {x}, {y}"
                    );
                    outline += usize::from(is_front);
                    drawn += usize::from(weights.at(x, y) > 0.0);
                }
                assert!(
                    outline > 300 && drawn == outline,
                    "{projection:?}: {drawn} of {outline}"
                );
            }
        }
    }

    #[test]
    fn mirrored_and_transposed_frames_have_the_same_to_the_bit() {
        let at = |projection: Projection, swap: bool, sign: f64| {
            let own = ball(projection, 300.0);
            let (normal, depth) = (own.normal.clone(), own.depth.clone().unwrap());
            frame(own.camera.map(|camera| camera.projection), move |x, y| {
                let x = if sign < 0.0 { SIDE as f64 - x } else { x };
                let [x, y] = if swap { [y, x] } else { [x, y] };
                let (i, j) = (x as usize, y as usize);
                let n = [normal.x.at(i, j), normal.y.at(i, j), normal.z.at(i, j)];
                let [nx, ny, nz] = n.map(f64::from);
                let (nx, ny) = if swap { (-ny, -nx) } else { (nx, ny) };
                // Noise, which thresholds follow.
                let noise = f64::from((i * 7 + j * 13) as u32 % 11);
                (
                    DVec3::new(sign * nx, ny, nz),
                    f64::from(depth.at(i, j)) + noise,
                )
            })
        };
        for projection in [perspective(300.0), parallel(1.0)] {
            let of = |swap, sign| silhouettes(&at(projection, swap, sign));
            let own = of(false, 1.0);
            assert!(
                own[0]
                    .samples()
                    .iter()
                    .any(|&weight| weight > 0.0 && weight < 1.0)
            );
            let (mirrored, transposed) = (of(false, -1.0), of(true, 1.0));
            for k in 0..2 {
                for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
                    let here = own[k].at(x, y).to_bits();
                    assert_eq!(mirrored[k].at(SIDE - 1 - x, y).to_bits(), here, "{x}, {y}");
                    assert_eq!(transposed[k].at(y, x).to_bits(), here, "{x}, {y}");
                }
            }
        }
    }

    #[test]
    fn rounding_of_depth_is_none() {
        // A plane at 80 degrees to the picture, around depth 5000, where half floats are 4 apart.
        let slope = 80.0_f64.to_radians();
        let normal = DVec3::new(-slope.sin(), 0.0, slope.cos());
        let mut frame = frame(Some(parallel(1.0)), |x, _| {
            let depth = 5000.0 - (x - 100.0) * slope.tan();
            (normal, half::f16::from_f64(depth).to_f64())
        });
        let drawn = |frame: &Frame| {
            let inside = |y| silhouettes(frame)[0].row(y)[1..SIDE - 1].to_vec();
            inside(100)
                .into_iter()
                .filter(|&weight| weight > 0.0)
                .count()
        };
        // Of an error of 2 in each depth, 4 cos 80 = 0.7 pixels are off the plane: below the least threshold. At ten times
        // the pixels per unit they are above.
        frame.source.depth_rounding = [f32::from(half::f16::EPSILON) / 2.0, 0.0];
        assert_eq!(drawn(&frame), 0);
    }

    #[test]
    fn thresholds_rise_by_the_noise_of_depth() {
        let noise = |x: f64, y: f64| {
            let hash = (x as u64).wrapping_mul(2_654_435_761) ^ (y as u64).wrapping_mul(40_503_917);
            f64::from((hash.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as u32 % 1000) / 1000.0
        };
        let frame = frame(Some(parallel(1.0)), |x, y| {
            (
                DVec3::Z,
                500.0 + if x < 100.0 { 0.0 } else { 10.0 * noise(x, y) },
            )
        });
        let [weights, _] = silhouettes(&frame);
        let marked = (1..SIDE - 1).flat_map(|y| weights.row(y)[120..SIDE - 1].to_vec());
        let share =
            marked.clone().filter(|&weight| weight > 0.0).count() as f64 / marked.count() as f64;
        // Two numbers up to 10 differ by more than d in (1 - d / 10)^2 of all pairs: by 1.6 pixels, where silhouettes begin, in
        // 70 %. Four times the noise, about 1.75 pixels, on top leave 2 % of two pairs to each pixel.
        assert!(share < 0.06, "{share}");
    }
}
