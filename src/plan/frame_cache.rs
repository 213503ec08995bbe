//! The cache of a session: results reusable by the next run of the same frame.

use crate::plan::outcome::Shape;
use crate::product::Product;
use std::any::Any;
use std::collections::{BTreeMap, HashMap};

/// Results reusable by the next run of the same frame.
#[derive(Debug, Default)]
pub(crate) struct FrameCache {
    /// Products of the descriptor. A run moves them into its outcome; recycling that returns them.
    shape: Shape,
    /// The key that each of them was asked for by last.
    keys: BTreeMap<Product, String>,
    /// Copies of other results by name, each with the key of all that it depends on.
    copies: HashMap<&'static str, (String, Box<dyn Any + Send>)>,
}

impl FrameCache {
    /// Whether all these products are there under this key. Those of another key are dropped: the next ones to be recycled
    /// have this key.
    pub(crate) fn has(&mut self, products: &[Product], key: &str) -> bool {
        for product in products {
            if self.keys.get(product).is_none_or(|own| own != key) {
                self.keys.insert(*product, key.into());
                self.shape.hand_over(*product, &mut Shape::default());
            }
        }
        let is_there = |product: &Product| !self.shape.planes(*product).is_empty();
        products.iter().all(is_there)
    }

    /// Moves products that are there to a shape.
    pub(crate) fn take(&mut self, products: &[Product], to: &mut Shape) {
        for product in products {
            self.shape.hand_over(*product, to);
        }
    }

    /// Moves products back from a shape.
    pub(crate) fn put(&mut self, products: &[Product], from: &mut Shape) {
        for product in products {
            from.hand_over(*product, &mut self.shape);
        }
    }

    /// Moves products that were asked for back from the last shape; others stay, as memory to recycle.
    pub(crate) fn recycle(&mut self, last: &mut Shape) {
        for product in self.keys.keys() {
            if !last.planes(*product).is_empty() {
                last.hand_over(*product, &mut self.shape);
            }
        }
    }

    /// A copy of the result kept by this name under this key.
    pub(crate) fn copy<T: Clone + 'static>(&self, name: &str, key: &str) -> Option<T> {
        let (_, value) = self.copies.get(name).filter(|(own, _)| own == key)?;
        value.downcast_ref::<T>().cloned()
    }

    /// Whether a result is kept by this name under this key.
    pub(crate) fn has_copy(&self, name: &str, key: &str) -> bool {
        self.copies.get(name).is_some_and(|(own, _)| own == key)
    }

    /// Keeps a result by this name under this key, in place of any other.
    pub(crate) fn keep(&mut self, name: &'static str, key: &str, value: impl Any + Send) {
        self.copies.insert(name, (key.into(), Box::new(value)));
    }
}
