//! What the last run made of a source, for the next one with the same.

use std::sync::{Arc, Mutex, PoisonError};

/// What was made, and its source.
#[derive(Debug)]
pub(crate) struct Last<K, V>(Mutex<Option<(Arc<K>, V)>>);

impl<K, V> Default for Last<K, V> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<K, V: Clone> Last<K, V> {
    /// What is made of `source`, unless it was the last.
    ///
    /// # Errors
    /// Those of `make`.
    pub(crate) fn of<E>(
        &self,
        source: &Arc<K>,
        make: impl FnOnce() -> Result<V, E>,
    ) -> Result<V, E> {
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of, made)) = &*kept()
            && Arc::ptr_eq(of, source)
        {
            return Ok(made.clone());
        }
        // Not under the lock: while it waits for others, this thread may take up another run that asks for it too.
        let made = make()?;
        *kept() = Some((source.clone(), made.clone()));
        Ok(made)
    }

    /// Discards it: in a failed run a copy on the device may be incomplete.
    #[cfg(feature = "gpu")]
    pub(crate) fn forget(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
