//! Shadows of a surface that hides parts of itself: rays toward the lamp, over depth.
//!
//! What is behind a silhouette is not seen. A height would fill all of it, and every silhouette would throw a curtain; here
//! the surface is as thick everywhere, seen along the sight line. Along the ray's line in the picture, nearness (one over
//! depth; in parallel projection depth itself, negated) of points on a straight line is linear, so that a chord of the lamp
//! is the wedge between two linear functions, and a piece of surface with its back hides an interval of it: 32 bits hold
//! what is hidden (visibility bitmasks: Therrien, Levesque, Gilet: Screen Space Indirect Lighting with Visibility Bitmask,
//! 2023). Changes: a wedge toward a lamp instead of half a circle, and no angles are computed.

use crate::frame::memory::Memory;
use crate::frame::{DepthKind, Frame, Mask, Plane, Projection, SightLines, Vector3Planes};
use crate::kernel::quantile::quantile;
use crate::light::shadows::Lamp;
use crate::params::Adaptive;
use crate::shape::occlusion::NOTHING;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Thickness of the surface as a share of the size of what is seen.
const THICK: f64 = 0.15;

/// Pixels that a surface has to rise to be told from its neighbours.
const BIAS_PX: f32 = 0.07;

/// A larger change of nearness from pixel to pixel, as a share, is a jump: nothing lies in between.
const JUMP: f32 = 0.02;

/// The most azimuths across a lamp.
const MOST_AZIMUTHS: usize = 9;

/// Pixels on a side of the blocks that are passed at once where nothing in them is near enough, as a power of two.
const BLOCK: u32 = 4;

/// Pixels whose depths are looked at for the size of what is seen.
const WANTED_DEPTHS: usize = 4_000;

/// Narrower lamps are as wide, in radians: wedges need a width.
const NARROWEST: f64 = 2e-4;

/// Where a lamp is.
#[derive(Clone, Copy)]
pub(super) enum LampPlace {
    /// Far away.
    Far(Lamp),
    /// At a point, as wide as so many radians from its middle.
    Near(DVec3, f64),
}

/// A surface in depth.
pub(super) struct Relief<'f> {
    frame: &'f Frame,
    projection: Projection,
    /// [`NOTHING`] where there is no surface.
    nearness: Plane,
    /// The largest of each block, and of the pixels right beside it.
    blocks: Plane,
    most: f32,
    thickness: f32,
    bias: f32,
    jump: f32,
}

impl<'f> Relief<'f> {
    /// Of a frame with positions; an automatic thickness is one that suits what is seen.
    pub(super) fn new(frame: &'f Frame, thickness: Adaptive) -> Self {
        let projection = SightLines::of(frame).projection();
        let nearness = nearness(frame, &projection);
        let blocks = blocks(&nearness);
        let most = blocks.samples().iter().copied().fold(NOTHING, f32::max);
        let least = nearness.samples().iter().filter(|&&n| n > NOTHING);
        let range = most - least.copied().fold(most, f32::min);
        let [share, step] = frame.source.depth_rounding;
        let (pixels, rounding, jump) = match projection {
            Projection::Perspective { fx, .. } => (fx as f32, share, JUMP),
            Projection::Orthographic { sx, .. } => (sx as f32, step, JUMP * range),
        };
        Self {
            frame,
            thickness: match thickness {
                Adaptive::Fixed(thickness) => thickness,
                Adaptive::Auto => thickness_of(&frame.mask, &nearness, &projection),
            },
            nearness,
            blocks,
            most,
            bias: BIAS_PX / pixels + 2.0 * rounding,
            jump,
            projection,
        }
    }

    /// The share of a lamp that each pixel sees. With normals, it is 1 where they face away: what is dark anyway is not asked
    /// for.
    pub(super) fn shares(
        &self,
        place: &LampPlace,
        normal: Option<&Vector3Planes>,
        memory: &Memory,
    ) -> Plane {
        let mask = &self.frame.mask;
        let mut shares = Plane::filled(mask.width(), mask.height(), 1.0);
        let rows = shares.samples_mut().par_chunks_mut(mask.width().max(1));
        rows.enumerate().with_max_len(4).for_each(|(y, row)| {
            if memory.is_cancelled() {
                return;
            }
            for x in mask.runs(y).flatten() {
                row[x] = self.share([x, y], place, normal.map(|normal| normal.at(x, y)));
            }
        });
        shares
    }

    /// The share of a lamp seen from a pixel.
    fn share(&self, at: [usize; 2], place: &LampPlace, normal: Option<DVec3>) -> f32 {
        let [point, to_eye] = self.seen(at);
        let (to_light, radius, distance) = match *place {
            LampPlace::Far(lamp) => (lamp.direction(), lamp.radius, f64::INFINITY),
            LampPlace::Near(position, radius) => {
                let to = position - point;
                (to.normalize_or(DVec3::Z), radius, to.length())
            }
        };
        if normal.is_some_and(|normal| normal.dot(to_light) <= 0.0) {
            return 1.0;
        }
        let across = to_light.cross(DVec3::Z).normalize_or(DVec3::X);
        let radius = radius.max(NARROWEST);
        let count = (2.0 * radius.to_degrees())
            .ceil()
            .clamp(1.0, MOST_AZIMUTHS as f64) as usize
            | 1;
        let (mut seen, mut whole) = (0.0, 0.0);
        for i in 0..count {
            let place = (2 * i + 1) as f64 / count as f64 - 1.0;
            let half = (1.0 - place * place).sqrt();
            let (sine, cosine) = (radius * place).sin_cos();
            let toward = cosine * to_light + sine * across;
            let wedge = self.wedge(point, to_eye, toward, (radius * half).sin_cos());
            let hidden = wedge.map_or(0, |wedge| self.hidden(at, &wedge, distance));
            seen += half as f32 * (1.0 - hidden.count_ones() as f32 / 32.0);
            whole += half as f32;
        }
        seen / whole
    }

    /// The point seen at a pixel, and the unit direction to the eye from there.
    fn seen(&self, [x, y]: [usize; 2]) -> [DVec3; 2] {
        let at = self.frame.data_window.middle(x, y);
        let nearness = f64::from(self.nearness.at(x, y));
        let sight = SightLines::new(self.projection);
        match self.projection {
            Projection::Perspective { .. } => {
                let point = sight.point(at.x, at.y, 1.0 / nearness, DepthKind::Planar);
                [point, (-point).normalize_or(DVec3::Z)]
            }
            Projection::Orthographic { .. } => [
                sight.point(at.x, at.y, -nearness, DepthKind::Planar),
                DVec3::Z,
            ],
        }
    }

    /// Columns right, rows down, and nearness that something at `point` gains as it moves along `direction`, all times the
    /// square of its depth in perspective.
    fn motion(&self, point: DVec3, direction: DVec3) -> [f64; 3] {
        match self.projection {
            Projection::Perspective { fx, fy, .. } => [
                fx * (point.x * direction.z - direction.x * point.z),
                -fy * (point.y * direction.z - direction.y * point.z),
                direction.z,
            ],
            Projection::Orthographic { sx, sy, .. } => {
                [sx * direction.x, -sy * direction.y, direction.z]
            }
        }
    }

    /// The wedge of a chord about `toward`, with sine and cosine of its half angle; `None` where it covers no pixels.
    fn wedge(
        &self,
        point: DVec3,
        to_eye: DVec3,
        toward: DVec3,
        (sine, cosine): (f64, f64),
    ) -> Option<Wedge> {
        let up = (to_eye - to_eye.dot(toward) * toward).normalize_or_zero();
        let [columns, rows, _] = self.motion(point, toward);
        let axis = usize::from(rows.abs() > columns.abs());
        let along = [columns, rows][axis];
        let gains = |direction: DVec3| {
            let motion = self.motion(point, direction);
            let steps = motion[axis] * along.signum();
            (steps > 0.0).then(|| (motion[2] / steps) as f32)
        };
        let low = gains(cosine * toward - sine * up)?;
        let high = gains(cosine * toward + sine * up).unwrap_or(f32::MAX);
        let steps = along.abs();
        (steps > 0.0).then(|| Wedge {
            axis,
            step: [columns / steps, rows / steps].map(|v| v as f32),
            low,
            high: high.max(low + f32::EPSILON * low.abs()),
            toward: toward.as_vec3(),
        })
    }

    /// The parts of a wedge that are hidden: bits from its lower to its upper edge.
    fn hidden(&self, at: [usize; 2], wedge: &Wedge, distance: f64) -> u32 {
        let (plane, axis) = (&self.nearness, wedge.axis);
        let size = [plane.width(), plane.height()];
        let strides = [1, plane.width()];
        let own = plane.at(at[0], at[1]);
        let (along, aside) = (at[axis], at[1 - axis] as f32);
        let goes_up = wedge.step[axis] > 0.0;
        let drift = wedge.step[1 - axis];
        let last = wedge.last(at, size).min(self.steps_to(at, wedge, distance));
        let samples = plane.samples();
        let (mut bits, mut step, mut until) = (0_u32, 1_usize, 0_usize);
        while step <= last {
            let far = step as f32;
            let low = own + wedge.low * far;
            if low > self.most && wedge.low >= 0.0 {
                break;
            }
            let place = if goes_up { along + step } else { along - step };
            let beside = (aside + drift * far).max(0.0);
            if step >= until {
                let (most, leave) = self.block(place, beside, wedge);
                until = step + leave;
                let lowest = low.min(own + wedge.low * until as f32);
                if most <= lowest {
                    step = until;
                    continue;
                }
            }
            let whole = (beside as usize).min(size[1 - axis] - 1);
            let next = (whole + 1).min(size[1 - axis] - 1);
            let row = place * strides[axis];
            let near = [whole, next].map(|i| samples[row + i * strides[1 - axis]]);
            if near[0].max(near[1]) > low {
                let front = match step {
                    // Where an edge passes between pixels is not known, and a staircase would cast a dotted line.
                    1 => near[0].min(near[1]),
                    _ => self.between(near, beside - whole as f32),
                };
                bits |= self.mask(front, low, (wedge.high - wedge.low) * far);
                if bits == u32::MAX {
                    break;
                }
            }
            step += 1;
        }
        bits
    }

    /// Steps to a lamp near the surface.
    fn steps_to(&self, at: [usize; 2], wedge: &Wedge, distance: f64) -> usize {
        if distance.is_infinite() {
            return usize::MAX;
        }
        let [point, _] = self.seen(at);
        let lamp = point + distance * wedge.toward.as_dvec3();
        let middle = self.frame.data_window.middle(at[0], at[1]);
        match self.projection.pixel_of(lamp) {
            Some(pixel) => (pixel - middle).to_array()[wedge.axis].abs() as usize,
            None => usize::MAX,
        }
    }

    /// The largest nearness in the block of a place on a wedge's line, and the steps until the line leaves it.
    fn block(&self, place: usize, beside: f32, wedge: &Wedge) -> (f32, usize) {
        let side = 1_usize << BLOCK;
        let aside = beside as usize;
        let (x, y) = if wedge.axis == 0 {
            (place, aside)
        } else {
            (aside, place)
        };
        let most = self.blocks.at(x >> BLOCK, y >> BLOCK);
        let within = place & (side - 1);
        let along = if wedge.step[wedge.axis] > 0.0 {
            side - within
        } else {
            within + 1
        };
        let (drift, within) = (
            wedge.step[1 - wedge.axis],
            beside - (aside >> BLOCK << BLOCK) as f32,
        );
        let rest = if drift > 0.0 {
            side as f32 - within
        } else {
            within
        };
        // Pixels right beside a block count as of it: a step beyond its side is within them.
        let across = rest / drift.abs().max(1e-6);
        (most, along.min(across as usize + 1))
    }

    /// Nearness between two pixels, a share from the first to the second: that of the nearest beside a jump.
    fn between(&self, [a, b]: [f32; 2], share: f32) -> f32 {
        let jump = match self.projection {
            Projection::Perspective { .. } => self.jump * a.max(b),
            Projection::Orthographic { .. } => self.jump,
        };
        match (a - b).abs() < jump {
            true => a + share * (b - a),
            false if share < 0.5 => a,
            false => b,
        }
    }

    /// The bits of a wedge, `wide` from its lower edge up, that a surface of this nearness hides.
    fn mask(&self, nearness: f32, low: f32, wide: f32) -> u32 {
        if nearness <= NOTHING {
            return 0;
        }
        let (front, back) = match self.projection {
            Projection::Perspective { .. } => {
                let front = nearness * (1.0 - self.bias);
                (front, front / (1.0 + front * self.thickness))
            }
            Projection::Orthographic { .. } => {
                let front = nearness - self.bias;
                (front, front - self.thickness)
            }
        };
        let bit = |edge: f32| (32.0 * ((edge - low) / wide).clamp(0.0, 1.0) + 0.5) as u32;
        let (from, to) = (bit(back), bit(front));
        let up_to = |bit: u32| if bit >= 32 { u32::MAX } else { (1 << bit) - 1 };
        up_to(to) & !up_to(from)
    }
}

/// A chord of a lamp, seen along its line in the picture.
struct Wedge {
    /// That in which a step is a whole pixel: 0 for columns, 1 for rows.
    axis: usize,
    /// Columns right and rows down.
    step: [f32; 2],
    /// Nearness gained per step at the lower edge, and at the upper one.
    low: f32,
    high: f32,
    toward: Vec3,
}

impl Wedge {
    /// The last step inside a picture of this size.
    fn last(&self, at: [usize; 2], size: [usize; 2]) -> usize {
        let steps = |axis: usize| {
            let step = self.step[axis];
            let room = if step > 0.0 {
                size[axis] - 1 - at[axis]
            } else {
                at[axis]
            };
            match step.abs() > 1e-6 {
                true => (room as f32 / step.abs()) as usize,
                false => usize::MAX,
            }
        };
        steps(0).min(steps(1))
    }
}

/// One over depth along the view axis in perspective, else depth negated.
fn nearness(frame: &Frame, projection: &Projection) -> Plane {
    let depth = frame
        .depth
        .as_ref()
        .expect("the plan found it in the frame");
    let sight = SightLines::new(*projection);
    let (kind, window) = (frame.source.depth_kind, frame.data_window);
    let mut nearness = Plane::filled(depth.width(), depth.height(), NOTHING);
    nearness.each_row(|y, row| {
        for x in frame.mask.runs(y).flatten() {
            let depth = depth.at(x, y);
            row[x] = match projection {
                Projection::Orthographic { .. } => -depth,
                Projection::Perspective { .. } => {
                    let at = window.middle(x, y);
                    let z = sight.point(at.x, at.y, f64::from(depth), kind).z;
                    if z < 0.0 { (-1.0 / z) as f32 } else { NOTHING }
                }
            };
        }
    });
    nearness
}

/// The largest nearness of each block of pixels and those right beside it.
fn blocks(nearness: &Plane) -> Plane {
    let (width, height, side) = (nearness.width(), nearness.height(), 1_usize << BLOCK);
    let mut blocks = Plane::filled(width.div_ceil(side), height.div_ceil(side), NOTHING);
    blocks.each_row(|j, row| {
        let rows = (j * side).saturating_sub(1)..height.min((j + 1) * side + 2);
        for y in rows {
            for (i, block) in row.iter_mut().enumerate() {
                let columns = (i * side).saturating_sub(1)..width.min((i + 1) * side + 2);
                let own = nearness.row(y)[columns].iter().copied();
                *block = own.fold(*block, f32::max);
            }
        }
    });
    blocks
}

/// The thickness that suits what is seen: a share of the size of its area at its median depth.
fn thickness_of(mask: &Mask, nearness: &Plane, projection: &Projection) -> f32 {
    let sampled = mask.sample(WANTED_DEPTHS);
    let mut seen: Vec<f32> = sampled.map(|(x, y)| nearness.at(x, y)).collect();
    let middle = quantile(&mut seen, 0.5, f32::total_cmp).unwrap_or(1.0);
    let size_px = (mask.count() as f64).sqrt();
    let size = match *projection {
        Projection::Perspective { fx, fy, .. } => {
            size_px / ((fx * fy).sqrt() * f64::from(middle.max(f32::MIN_POSITIVE)))
        }
        Projection::Orthographic { sx, sy, .. } => size_px / (sx * sy).sqrt(),
    };
    (THICK * size) as f32
}
