//! Layers of motion: what they hold by their names, and how they lead to the frame before by what both frames show.
//!
//! Renderers agree neither on the direction of time, nor on that of y, nor on the unit. `layers` finds the pairs of
//! channels that may hold motion; `evidence` compares two frames under each reading of them.

mod convention;
mod evidence;
mod layers;

pub(crate) use convention::MotionConvention;
pub use evidence::{FrameBefore, MotionVerdict};
#[cfg(feature = "cli")]
pub(super) use layers::means_motion;
pub(super) use layers::motion_sources;
use layers::{convention_by_name, has_third};

use crate::frame::{Frame, Plane, Vector2Planes, Window};
use crate::io::load::sources::RoleSource;
use crate::untrusted::Untrusted;

/// The layers of a frame that may hold its motion, as stored.
#[derive(Debug, Clone)]
pub struct MotionLayers {
    pub(super) pairs: Vec<MotionPair>,
    pub(super) display: Window,
}

/// Two channels that may hold motion.
#[derive(Debug, Clone)]
pub(super) struct MotionPair {
    /// The layer and its channels, for messages.
    pub(super) label: String,
    /// The layer or file that `--motion` names.
    layer: String,
    /// Whether the layer has a third number beside these, and no fourth.
    has_third: bool,
    /// The convention implied by its name, if all writers agree on it.
    by_name: Option<MotionConvention>,
    pub(super) x: Plane,
    pub(super) y: Plane,
}

impl MotionLayers {
    /// The layers of `sources`, with their planes as `read`; a layer named by a flag is read as the flag says unless the
    /// frames show otherwise. A file named for motion may hold a single channel: no motion along the other axis.
    pub(super) fn of<'a>(
        sources: impl Iterator<Item = &'a RoleSource>,
        read: impl Iterator<Item = Vec<Plane>>,
        is_given: bool,
        display: Window,
    ) -> Option<Self> {
        let pair = |(index, (source, planes)): (usize, (&RoleSource, Vec<Plane>))| {
            let mut planes = planes.into_iter();
            let x = planes.next()?;
            let y = planes.next().unwrap_or_else(|| x.map(|_| 0.0));
            let given = (is_given && index == 0).then_some(MotionConvention::BACK);
            Some(MotionPair {
                label: source.channel_names(),
                layer: source.label().to_string(),
                has_third: has_third(source),
                by_name: given.or_else(|| convention_by_name(source)),
                x,
                y,
            })
        };
        let pairs: Vec<_> = sources.zip(read).enumerate().filter_map(pair).collect();
        (!pairs.is_empty()).then_some(Self { pairs, display })
    }

    /// Motion of the surface at each pixel since the previous frame, in pixels, x right, y up, as implied by the name of
    /// the first layer; [`Vector2Planes::AWAY`] where the file has no finite number. `None` if no name implies a convention.
    pub fn by_name(&self) -> Option<Vector2Planes> {
        let (index, convention) = self.named()?;
        Some(self.come(index, convention))
    }

    /// Whether `verdict` is what the name of a layer says.
    pub fn is_by_name(&self, verdict: &MotionVerdict) -> bool {
        verdict.found.is_some() && verdict.found == self.named()
    }

    /// Whether the name of a layer, or a flag, says how to read it.
    pub fn has_named(&self) -> bool {
        self.named().is_some()
    }

    /// The first pair whose name says what it holds.
    fn named(&self) -> Option<(usize, MotionConvention)> {
        let mut pairs = self.pairs.iter().enumerate();
        pairs.find_map(|(index, pair)| Some((index, pair.by_name?)))
    }

    /// The same of the first layer, read by a convention that was given.
    #[cfg(feature = "cli")]
    pub(crate) fn given(&self, convention: MotionConvention) -> Vector2Planes {
        self.come(0, convention)
    }

    /// The flags by which a pair is read so.
    fn flags(&self, pair: usize, convention: MotionConvention) -> String {
        let layer = &self.pairs[pair].layer;
        let name = Untrusted(layer).quoted();
        let first = self.pairs.iter().position(|pair| pair.layer == *layer);
        match first == Some(pair) {
            true => format!("--motion {name} --motion-convention {}", convention.flag()),
            false => format!("--motion {name}"),
        }
    }

    /// How far the surface has come since the frame before, by one pair read in one way.
    fn come(&self, pair: usize, convention: MotionConvention) -> Vector2Planes {
        let MotionPair { x, y, .. } = &self.pairs[pair];
        let both = Plane::from_fn(x.width(), x.height(), |i, j| {
            match convention.back([x.at(i, j), y.at(i, j)], self.display) {
                [x, y] if x.is_finite() && y.is_finite() => [-x, -y],
                _ => [Vector2Planes::AWAY; 2],
            }
        });
        Vector2Planes {
            x: both.map(|come| come[0]),
            y: both.map(|come| come[1]),
        }
    }

    /// Compares `now`, the frame of these layers, to the frame `before` under each convention. `steps` is the number of
    /// frames from one to the other; `still` is the motion of a still world, if cameras are known.
    pub fn judge(
        &self,
        now: &Frame,
        before: &FrameBefore,
        steps: u32,
        still: Option<&Vector2Planes>,
    ) -> MotionVerdict {
        evidence::judge(self, now, before, steps, still)
    }

    /// The motion that a verdict found; `None` where it found none.
    pub fn read_as(&self, verdict: &MotionVerdict) -> Option<Vector2Planes> {
        let (pair, convention) = verdict.found?;
        (pair < self.pairs.len()).then(|| self.come(pair, convention))
    }
}
