//! What the last run copied to the device, for the next one with the same source.

use std::sync::{Arc, Mutex, PoisonError};

/// A copy, and its source.
#[derive(Debug)]
pub(crate) struct Last<K, V>(Mutex<Option<(Arc<K>, V)>>);

impl<K, V> Default for Last<K, V> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<K, V: Clone> Last<K, V> {
    /// The copy of `source`, made if the last one was of another.
    ///
    /// # Errors
    /// Those of `make`.
    pub(crate) fn of<E>(
        &self,
        source: &Arc<K>,
        make: impl FnOnce() -> Result<V, E>,
    ) -> Result<V, E> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((copied, copy)) = &*kept
            && Arc::ptr_eq(copied, source)
        {
            return Ok(copy.clone());
        }
        let copy = make()?;
        *kept = Some((source.clone(), copy.clone()));
        Ok(copy)
    }

    /// Discards it: in a failed run the copy may be incomplete.
    pub(crate) fn forget(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
