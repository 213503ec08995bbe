//! The cache of a session: results reusable by the next run of the same frame.

use crate::engine::outcome::{Outcome, ShapeSlots};
use crate::engine::slot::Slot;
use crate::frame::Vector2Planes;
use crate::shape::edges::cpu::Weights;
use std::any::Any;
use std::collections::HashMap;

/// Results reusable by the next run of the same frame. A run moves them into its outcome; recycling the outcome returns
/// them.
#[derive(Debug, Default)]
pub(crate) struct FrameCache {
    /// Products of the descriptor.
    pub(crate) shape: ShapeSlots,
    /// The gradient before diffusion.
    pub(crate) undiffused: Slot<Vector2Planes>,
    /// Copies of other results by name, each with the key of all that it depends on.
    copies: HashMap<&'static str, (String, Box<dyn Any + Send>)>,
}

impl FrameCache {
    /// A copy of the result kept by this name under this key.
    pub(crate) fn copy<T: Clone + 'static>(&self, name: &str, key: &str) -> Option<T> {
        let (_, value) = self.copies.get(name).filter(|(own, _)| own == key)?;
        value.downcast_ref::<T>().cloned()
    }

    /// Keeps a result by this name under this key, in place of any other.
    pub(crate) fn keep(&mut self, name: &'static str, key: &str, value: impl Any + Send) {
        self.copies.insert(name, (key.into(), Box::new(value)));
    }

    /// The edges cached under this key, if any; weights that are not `wanted` stay in the cache.
    pub(crate) fn take_edges(&mut self, key: &str, wanted: bool) -> Option<Weights> {
        let shape = &mut self.shape;
        shape.silhouette.invalidate_unless(key);
        shape.crease.invalidate_unless(key);
        self.undiffused.invalidate_unless(key);
        let all = shape.silhouette.get().is_some()
            && shape.crease.get().is_some()
            && self.undiffused.get().is_some();
        let conductance = shape.conductance.take(key).filter(|_| all)?;
        let silhouette = wanted.then(|| shape.silhouette.take(key)).flatten();
        let crease = wanted.then(|| shape.crease.take(key)).flatten();
        Some(Weights {
            silhouette,
            crease,
            conductance,
        })
    }

    /// Caches new weights that are not `wanted`.
    pub(crate) fn keep_unwanted(&mut self, weights: &mut Weights, wanted: bool) {
        if !wanted {
            self.shape.silhouette.put_from(&mut weights.silhouette);
            self.shape.crease.put_from(&mut weights.crease);
        }
    }

    /// Returns the results of the last run from its outcome to the cache.
    pub(crate) fn recycle(&mut self, outcome: &mut Outcome) {
        self.shape.recycle(&mut outcome.shape);
    }
}
