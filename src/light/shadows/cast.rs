//! From a frame in new light to the shadows in it.

use super::casting::{Caster, Casting};
use super::horizons::{Horizons, LOWEST};
use super::keys::{belongs, keys};
use super::march::{LampPlace, Relief};
use super::{Lamp, longest_px, shares};
use crate::frame::memory::Memory;
use crate::frame::{Frame, Plane, SightLines, Vector3Planes, Window};
use crate::light::lights::{DirectionalLight, Illumination};
use crate::params::RelightParams;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::shape::occlusion::cpu::in_pixels;
use std::borrow::Cow;

/// What arrives of the light of lamps, of [`WHOLE`].
#[derive(Default)]
pub(crate) struct CastShadows {
    /// Of lamps far away.
    pub(crate) far: Vec<Shadowed>,
    /// Of lamps near the surface, in their order.
    pub(crate) near: Vec<Plane<u16>>,
    /// What hides light from all around.
    pub(crate) horizons: Option<Horizons>,
    /// The brightest of it, hidden with edges.
    pub(crate) keys: Vec<Shadowed>,
}

impl CastShadows {
    /// What arrives of an environment's light from this direction, if that of a key does.
    #[inline(always)]
    pub(crate) fn of_key(&self, direction: [f32; 3]) -> Option<&Plane<u16>> {
        let key = self.keys.iter().find(|key| belongs(&key.light, direction));
        key.map(|key| &key.share)
    }
}

/// A lamp and what arrives of its light.
pub(crate) struct Shadowed {
    pub(crate) light: DirectionalLight,
    /// By pixel.
    pub(crate) share: Plane<u16>,
}

/// A share of 1.
pub(crate) const WHOLE: f32 = 65_535.0;

/// What arrives on surfaces with these normals of the light that casts shadows, if any does; these lights stand for what
/// comes from all `around`.
pub(crate) fn cast(
    run: &mut Execution,
    normal: &Vector3Planes,
    around: &[DirectionalLight],
) -> Option<CastShadows> {
    let relighting = run.plan.relighting()?;
    let (casting, params) = (&relighting.casting, &relighting.params);
    let illumination = run.illumination().filter(|_| casting.any())?;
    let own = run.made.outcome.shape.height.take();
    let shadows = run.timed("shadows", || {
        let surface = CastingSurface::new(run.frame, run.plan, own.as_ref());
        let lamps = match casting.lamps.is_cast {
            true => surface.shadows_of_lamps(illumination, params, normal, run.memory),
            false => CastShadows::default(),
        };
        match casting.sky.is_cast {
            true => CastShadows {
                horizons: Some(surface.horizons()),
                keys: surface.shadows_of_keys(around, params, run.memory),
                ..lamps
            },
            false => lamps,
        }
    });
    run.made.outcome.shape.height = own;
    Some(shadows)
}

/// A surface that casts shadows.
struct CastingSurface<'a> {
    frame: &'a Frame,
    plan: &'a Plan,
    by: Caster,
    /// In pixels, if sweeps need it.
    height: Option<Plane>,
    /// Pixels are so many times as wide as high.
    pixel_shape: f32,
}

impl<'a> CastingSurface<'a> {
    /// Of a frame; `height` is what its normals tell.
    fn new(frame: &'a Frame, plan: &'a Plan, height: Option<&Plane>) -> Self {
        let relighting = plan.relighting().expect("shadows are of new light");
        let Casting { by, sky, .. } = relighting.casting;
        let is_swept = by != Caster::Depth || sky.is_cast;
        Self {
            frame,
            plan,
            by,
            height: is_swept.then(|| match (by, height) {
                (Caster::Normals, Some(height)) => in_pixels(height, frame),
                _ => heights_of_depth(frame),
            }),
            pixel_shape: SightLines::of(frame).pixel_shape().abs() as f32,
        }
    }

    /// The shadows of lamps far away and near.
    fn shadows_of_lamps(
        &self,
        illumination: &Illumination,
        params: &RelightParams,
        normal: &Vector3Planes,
        memory: &Memory,
    ) -> CastShadows {
        let fill = params.shadow_fill;
        let arrives = |seen: f32| (WHOLE * (fill + (1.0 - fill) * seen)).round() as u16;
        // Light that is turned to the form also comes to what faces away from the lamp.
        let is_turned = self.plan.relighting().is_some_and(|lit| lit.aligns);
        let facing = (!is_turned).then_some(normal);
        let is_marched = self.by == Caster::Depth || !illumination.points.is_empty();
        let relief = is_marched.then(|| Relief::new(self.frame, params.thickness));
        let far = lamps(illumination, params).map(|(light, lamp)| {
            let seen = match (self.by, &relief) {
                (Caster::Depth, Some(relief)) => {
                    relief.shares(&LampPlace::Far(lamp), facing, memory)
                }
                _ => self.swept(&lamp, memory),
            };
            Shadowed {
                light,
                share: seen.map(arrives),
            }
        });
        let radius = 0.5 * f64::from(params.light_size).to_radians();
        let near = relief.iter().flat_map(|relief| {
            illumination.points.iter().map(move |point| {
                let place = LampPlace::Near(point.position.as_dvec3(), radius);
                relief.shares(&place, facing, memory).map(arrives)
            })
        });
        CastShadows {
            far: far.collect(),
            near: near.collect(),
            ..CastShadows::default()
        }
    }

    /// What is seen of a lamp by sweeps.
    fn swept(&self, lamp: &Lamp, memory: &Memory) -> Plane {
        let around = self.around(lamp.elevation.tan() as f32);
        around.cut(shares(&around.height, lamp, self.pixel_shape, memory))
    }

    /// The shadows of the keys of an environment.
    fn shadows_of_keys(
        &self,
        lights: &[DirectionalLight],
        params: &RelightParams,
        memory: &Memory,
    ) -> Vec<Shadowed> {
        let keys = keys(lights, self.frame.luminance_weights());
        let shadowed = keys.into_iter().map(|light| {
            let seen = self.swept(&Lamp::of(&light, params.light_size), memory);
            let share = seen.map(|seen| (WHOLE * seen).round() as u16);
            Shadowed { light, share }
        });
        shadowed.collect()
    }

    /// What hides light from all around.
    fn horizons(&self) -> Horizons {
        let around = self.around(LOWEST);
        Horizons::of(&around.height, self.pixel_shape, |plane| around.cut(plane))
    }

    /// The heights; those that repeat a tile as the tile, with as much of its repetition as shadows are long in light of this
    /// slope, but no more than once to every side.
    fn around(&self, slope: f32) -> SweptHeights<'_> {
        let height = self.height.as_ref().expect("sweeps have it");
        let Some(tile) = self.plan.tile else {
            return SweptHeights {
                height: Cow::Borrowed(height),
                windows: None,
            };
        };
        let (window, whole) = (tile.window, self.frame.data_window);
        let own = height.crop(whole, window);
        let most = window.width().max(window.height());
        let grown = tile.grown(longest_px(&own, slope).min(most as f32).ceil() as usize);
        SweptHeights {
            height: Cow::Owned(own.repeated(window, grown)),
            windows: Some([grown, window, whole]),
        }
    }
}

/// Heights to be swept.
struct SweptHeights<'a> {
    height: Cow<'a, Plane>,
    /// Those of a tile with some of its repetition, of the tile, and of the frame that repeats it.
    windows: Option<[Window; 3]>,
}

impl SweptHeights<'_> {
    /// What was found over these heights, over the frame.
    fn cut<T: Copy>(&self, found: Plane<T>) -> Plane<T> {
        match self.windows {
            Some([grown, window, whole]) => found.crop(grown, window).repeated(window, whole),
            None => found,
        }
    }
}

/// The lamps far away.
fn lamps<'i>(
    illumination: &'i Illumination,
    params: &'i RelightParams,
) -> impl Iterator<Item = (DirectionalLight, Lamp)> + 'i {
    let widths = illumination.widths_deg.iter().copied();
    let widths = widths.chain(std::iter::repeat(None));
    let lights = illumination.directional.iter().zip(widths);
    lights.map(|(light, width)| (*light, Lamp::of(light, width.unwrap_or(params.light_size))))
}

/// Heights in pixels as depth tells them; in perspective at the distance of each pixel.
fn heights_of_depth(frame: &Frame) -> Plane {
    let (sight, depth) = (SightLines::of(frame), frame.depth.as_ref());
    let depth = depth.expect("the plan found it in the frame");
    let kind = frame.source.depth_kind;
    let window = frame.data_window;
    let mut heights = depth.clone();
    heights.each_row(|y, row| {
        for x in frame.mask.runs(y).flatten() {
            let at = window.middle(x, y);
            let point = sight.point(at.x, at.y, f64::from(row[x]), kind);
            row[x] = point.z as f32;
        }
    });
    in_pixels(&heights, frame)
}
