//! Undo and redo over every look left unchanged for a moment.

use super::look::Look;

/// Number of looks remembered.
const MOST: usize = 1000;

/// Looks before the current one, and undone ones.
#[derive(Debug)]
pub(super) struct History {
    before: Vec<Look>,
    current: Look,
    undone: Vec<Look>,
}

impl History {
    pub(super) fn new(look: Look) -> Self {
        Self {
            before: Vec::new(),
            current: look,
            undone: Vec::new(),
        }
    }

    /// Records `look` if it differs from the current one.
    pub(super) fn rest_at(&mut self, look: &Look) {
        if *look == self.current {
            return;
        }
        let last = std::mem::replace(&mut self.current, look.clone());
        self.before.push(last);
        if self.before.len() > MOST {
            self.before.remove(0);
        }
        self.undone.clear();
    }

    pub(super) fn can_undo(&self) -> bool {
        !self.before.is_empty()
    }

    pub(super) fn can_redo(&self) -> bool {
        !self.undone.is_empty()
    }

    pub(super) fn undo(&mut self) -> Option<Look> {
        let earlier = self.before.pop()?;
        let last = std::mem::replace(&mut self.current, earlier.clone());
        self.undone.push(last);
        Some(earlier)
    }

    pub(super) fn redo(&mut self) -> Option<Look> {
        let later = self.undone.pop()?;
        let last = std::mem::replace(&mut self.current, later.clone());
        self.before.push(last);
        Some(later)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_undone_can_be_redone_until_something_else_is_done() {
        let looks: Vec<_> = (0..4).map(|n| Look::default().with("scaling", n)).collect();
        let mut history = History::new(looks[0].clone());
        history.rest_at(&looks[1]);
        history.rest_at(&looks[1]);
        history.rest_at(&looks[2]);
        assert_eq!(history.undo().as_ref(), Some(&looks[1]));
        assert_eq!(history.undo().as_ref(), Some(&looks[0]));
        assert_eq!(history.undo(), None);
        assert_eq!(history.redo().as_ref(), Some(&looks[1]));
        history.rest_at(&looks[3]);
        assert_eq!(history.redo(), None);
        assert_eq!(history.undo().as_ref(), Some(&looks[1]));
    }
}
