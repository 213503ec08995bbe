//! The message log of a run: keeps the output of parallel frames in frame order.

use super::message;
use super::progress::{SequenceProgress, Status, Tally};
use std::collections::BTreeSet;
use std::fmt::Display;
use std::sync::{Condvar, Mutex, MutexGuard};
use std::time::Duration;

/// The one voice of all frames of a run.
#[derive(Default)]
pub(super) struct RunLog {
    progress: Option<SequenceProgress>,
    said: Mutex<BTreeSet<String>>,
    pub(super) turns: Turns,
}

impl RunLog {
    pub(super) fn of_sequence(progress: SequenceProgress) -> Self {
        Self {
            progress: Some(progress),
            ..Self::default()
        }
    }

    pub(super) fn is_sequence(&self) -> bool {
        self.progress.is_some()
    }

    pub(super) fn say(&self, line: &str) {
        match &self.progress {
            Some(progress) => progress.say(line),
            None => message::say(line),
        }
    }

    /// Whether `text` is new: a warning of many frames is printed once.
    pub(super) fn is_new(&self, text: &str) -> bool {
        let mut said = self.said.lock().expect("nothing panics here");
        said.insert(text.to_string())
    }

    /// Counts a frame of a sequence that has ended.
    pub(super) fn frame(&self, frame: i32, status: Status, took: Duration, what: impl Display) {
        if let Some(progress) = &self.progress {
            progress.frame(frame, status, took, what);
        }
    }

    /// Ends the tale of a sequence.
    pub(super) fn end(self, quiet: bool) -> Tally {
        self.progress
            .map(|progress| progress.end(quiet))
            .unwrap_or_default()
    }
}

/// Lets parallel frames pass one point in their order.
#[derive(Debug, Default)]
pub(super) struct Turns {
    passed: Mutex<PassedFrame>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct PassedFrame {
    /// All frames below this number have finished.
    below: usize,
    /// Others that have.
    beyond: BTreeSet<usize>,
}

impl Turns {
    /// Runs `pass` when all frames before number `index` have passed or ended.
    pub(super) fn in_turn<T>(&self, index: usize, pass: impl FnOnce() -> T) -> T {
        let mut passed = self.passed();
        while passed.below < index {
            passed = self.changed.wait(passed).expect("nothing panics here");
        }
        drop(passed);
        let result = pass();
        self.leave(index);
        result
    }

    /// Frame number `index` keeps nobody waiting any more.
    pub(super) fn leave(&self, index: usize) {
        let mut passed = self.passed();
        if index >= passed.below {
            passed.beyond.insert(index);
        }
        let PassedFrame { below, beyond } = &mut *passed;
        while beyond.remove(below) {
            *below += 1;
        }
        drop(passed);
        self.changed.notify_all();
    }

    fn passed(&self) -> MutexGuard<'_, PassedFrame> {
        self.passed.lock().expect("nothing panics here")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn frames_pass_in_their_order_and_those_that_fail_hold_nobody_up() {
        let (turns, passed) = (Turns::default(), Mutex::new(Vec::new()));
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= 40 {
                            return;
                        }
                        // Every third frame fails before its turn.
                        if index % 3 != 2 {
                            turns.in_turn(index, || passed.lock().unwrap().push(index));
                        }
                        turns.leave(index);
                    }
                });
            }
        });
        let expected: Vec<_> = (0..40).filter(|index| index % 3 != 2).collect();
        assert_eq!(*passed.lock().unwrap(), expected);
    }
}
