//! Memory for one result between runs of the same frame.

/// One result, and the key of all that it depends on, from its stage in a plan.
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
    /// The result of this key, if present; a result of another key is dropped, since the next one stored will have this
    /// key.
    pub(crate) fn take(&mut self, key: &str) -> Option<T> {
        self.invalidate_unless(key);
        self.value.take()
    }

    /// Drops a result with another key.
    pub(crate) fn invalidate_unless(&mut self, key: &str) {
        if self.key != key {
            self.value = None;
            self.key = key.into();
        }
    }

    pub(crate) fn get(&self) -> Option<&T> {
        self.value.as_ref()
    }

    /// Stores a result for the key requested last.
    pub(crate) fn put(&mut self, value: T) {
        self.value = Some(value);
    }

    /// Stores a result for the key requested last, moved out of `value`; without a requested key it stays there.
    pub(crate) fn put_from(&mut self, value: &mut Option<T>) {
        if !self.key.is_empty() && value.is_some() {
            self.value = value.take();
        }
    }
}
