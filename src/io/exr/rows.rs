//! Rows that stay decoded between reads.

use super::fault::Parsed;
use std::ops::Range;

/// Consecutive rows, kept so that rows wanted again need not be read.
pub(super) struct HeldRows {
    held: Range<usize>,
    /// Bytes in a row.
    stride: usize,
    bytes: Vec<u8>,
}

impl HeldRows {
    pub(super) fn new(stride: usize) -> Self {
        HeldRows {
            held: 0..0,
            stride,
            bytes: Vec::new(),
        }
    }

    /// The rows `rows`; they must be held.
    pub(super) fn rows(&self, rows: &Range<usize>) -> &[u8] {
        let first = rows.start.saturating_sub(self.held.start) * self.stride;
        match rows.is_empty() {
            true => &[],
            false => &self.bytes[first..][..rows.len() * self.stride],
        }
    }

    /// Holds the rows `goal` and no others; `read` fills the rows that are new.
    pub(super) fn hold(
        &mut self,
        goal: Range<usize>,
        mut read: impl FnMut(Range<usize>, &mut [u8]) -> Parsed<()>,
    ) -> Parsed<()> {
        // Should reading fail, nothing is held.
        let held = std::mem::replace(&mut self.held, 0..0);
        let shared = goal.start.max(held.start)..goal.end.min(held.end);
        let shared = match shared.is_empty() {
            true => goal.start..goal.start,
            false => shared,
        };
        let stride = self.stride;
        let within_goal = |rows: &Range<usize>| {
            (rows.start - goal.start) * stride..(rows.end - goal.start) * stride
        };
        let to = within_goal(&shared);
        let from = shared.start.saturating_sub(held.start) * stride;
        let bytes = &mut self.bytes;
        bytes.resize(bytes.len().max(goal.len() * stride), 0);
        if !shared.is_empty() {
            bytes.copy_within(from..from + to.len(), to.start);
        }
        bytes.truncate(goal.len() * stride);
        for missing in [goal.start..shared.start, shared.end..goal.end] {
            if !missing.is_empty() {
                let target = within_goal(&missing);
                read(missing, &mut bytes[target])?;
            }
        }
        self.held = goal;
        Ok(())
    }
}

#[cfg(test)]
#[expect(
    clippy::single_range_in_vec_init,
    reason = "one missing range is a list of one"
)]
mod tests {
    use super::*;

    /// Rows of one byte, whose value is the row.
    fn held(rows: &mut HeldRows, goal: Range<usize>) -> Vec<Range<usize>> {
        let mut read = Vec::new();
        let filled = rows.hold(goal, |missing, target| {
            let rows = missing.clone().zip(target);
            rows.for_each(|(row, byte)| *byte = row as u8);
            read.push(missing);
            Ok(())
        });
        filled.unwrap();
        read
    }

    #[test]
    fn rows_that_are_held_are_not_read_again() {
        let mut rows = HeldRows::new(1);
        let goals = [
            (10..20, vec![10..20]),
            (14..26, vec![20..26]),         // down
            (14..26, vec![]),               // the same
            (12..30, vec![12..14, 26..30]), // on both sides
            (20..22, vec![]),               // fewer
            (19..22, vec![19..20]),         // up
            (40..44, vec![40..44]),         // apart
            (44..48, vec![44..48]),         // touching
        ];
        for (goal, expected) in goals {
            assert_eq!(held(&mut rows, goal.clone()), expected, "{goal:?}");
            let values: Vec<u8> = goal.clone().map(|row| row as u8).collect();
            assert_eq!(rows.rows(&goal), values);
        }
    }

    #[test]
    fn nothing_is_held_once_reading_failed() {
        let mut rows = HeldRows::new(1);
        held(&mut rows, 0..8);
        let failed = rows.hold(4..12, |_, _| {
            Err(super::super::fault::Fault::damaged("cut"))
        });
        assert!(failed.is_err());
        assert_eq!(held(&mut rows, 4..12), [4..12]);
    }
}
