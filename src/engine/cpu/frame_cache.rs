//! The cache of a session: results that the next run of the same frame can use.

use crate::engine::outcome::Outcome;
use crate::frame::CurvaturePlanes;
use crate::frame::{ColorPlanes, Plane, SymmetricPlanes, Vector2Planes};
use crate::line::contours::Contour;
use crate::line::interior::InteriorLayer;
use crate::shape::edges::cpu::Weights;

/// One result, and what it depends on: a key that its stage has in a plan.
#[derive(Debug)]
pub(crate) struct Slot<T> {
    key: String,
    value: Option<T>,
}

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self {
            key: String::new(),
            value: None,
        }
    }
}

impl<T> Slot<T> {
    /// The result of this key, if it is there; one of another is dropped, since the next that comes will be of this.
    pub(crate) fn take(&mut self, key: &str) -> Option<T> {
        self.invalidate_unless(key);
        self.value.take()
    }

    /// Drops a result of another key.
    fn invalidate_unless(&mut self, key: &str) {
        if self.key != key {
            self.value = None;
            self.key = key.into();
        }
    }

    pub(crate) fn get(&self) -> Option<&T> {
        self.value.as_ref()
    }

    /// Keeps a result of the key that was asked for last.
    pub(crate) fn put(&mut self, value: T) {
        self.value = Some(value);
    }

    fn put_any(&mut self, value: Option<T>) {
        if value.is_some() {
            self.value = value;
        }
    }
}

impl<T: Clone> Slot<T> {
    /// A copy of the result of this key, if it is there.
    pub(crate) fn copied(&mut self, key: &str) -> Option<T> {
        self.invalidate_unless(key);
        self.value.clone()
    }
}

/// What was made of a frame. A run takes what it can use and moves it into its outcome; when that is given back it is
/// kept again.
#[derive(Debug, Default)]
pub(crate) struct FrameCache {
    silhouette: Slot<Plane>,
    crease: Slot<Plane>,
    conductance: Slot<Plane>,
    /// The gradient before diffusion.
    pub(crate) undiffused: Slot<Vector2Planes>,
    pub(crate) gradient: Slot<Vector2Planes>,
    pub(crate) trace: Slot<Plane>,
    pub(crate) hessian: Slot<SymmetricPlanes>,
    pub(crate) curvatures: Slot<CurvaturePlanes>,
    pub(crate) direction_view: Slot<Vector2Planes>,
    pub(crate) gain: Slot<f32>,
    pub(crate) rays: Slot<Vector2Planes>,
    pub(crate) term_whites: Slot<Vec<(&'static str, f32)>>,
    pub(crate) field: Slot<Vec<Vector2Planes>>,
    pub(crate) contours: Slot<(Plane, Vec<Contour>)>,
    pub(crate) interior: Slot<InteriorLayer>,
    /// White level of the picture.
    pub(crate) white: Slot<f32>,
    /// Albedo, estimated from the picture.
    pub(crate) albedo: Slot<ColorPlanes>,
}

impl FrameCache {
    /// The edges of this key, if they are kept; weights that are not `wanted` stay here.
    pub(crate) fn take_edges(&mut self, key: &str, wanted: bool) -> Option<Weights> {
        self.silhouette.invalidate_unless(key);
        self.crease.invalidate_unless(key);
        self.undiffused.invalidate_unless(key);
        let all = self.silhouette.get().is_some()
            && self.crease.get().is_some()
            && self.undiffused.get().is_some();
        let conductance = self.conductance.take(key).filter(|_| all)?;
        let silhouette = wanted.then(|| self.silhouette.take(key)).flatten();
        let crease = wanted.then(|| self.crease.take(key)).flatten();
        Some(Weights {
            silhouette,
            crease,
            conductance,
        })
    }

    /// Keeps of weights that were made what is not `wanted`.
    pub(crate) fn keep_unwanted(&mut self, weights: &mut Weights, wanted: bool) {
        if !wanted {
            self.silhouette.put_any(weights.silhouette.take());
            self.crease.put_any(weights.crease.take());
        }
    }

    /// Takes back what the last run made, or took, from its outcome.
    pub(crate) fn recycle(&mut self, outcome: &mut Outcome) {
        let shape = &mut outcome.shape;
        self.silhouette.put_any(shape.silhouette.take());
        self.crease.put_any(shape.crease.take());
        self.conductance.put_any(shape.conductance.take());
        self.gradient.put_any(shape.gradient.take());
        self.trace.put_any(shape.trace.take());
        self.hessian.put_any(shape.hessian.take());
        self.curvatures.put_any(shape.curvatures.take());
        self.direction_view.put_any(shape.direction_view.take());
        self.rays.put_any(shape.direction.take());
    }
}
