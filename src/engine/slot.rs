//! Memory for one result between runs of the same frame.

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
    pub(crate) fn invalidate_unless(&mut self, key: &str) {
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

    /// Keeps a result of the key that was asked for last, moved out of `value`; what no stage has asked for stays there.
    pub(crate) fn put_from(&mut self, value: &mut Option<T>) {
        if !self.key.is_empty() && value.is_some() {
            self.value = value.take();
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
