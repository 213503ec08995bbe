//! Reading rows, one range after another.

use super::chunks::ChunkReader;
use super::decode::{Rows, Slot, Target, TargetSamples};
use super::fault::Parsed;
use super::read::PartBlocks;
use super::{ChannelId, ExrFile};
use crate::error::Result;
use crate::frame::Plane;
use std::ops::Range;
use std::sync::atomic::AtomicBool;

/// Reads channels of an open file a few rows at a time, for pictures that do not fit in memory.
///
/// The file stays open, and its tables of blocks are read once. The blocks of the last range stay
/// decoded, so that a range that overlaps it costs only the blocks it does not share.
pub struct RowReader<'f> {
    exr: &'f ExrFile,
    wanted: Vec<ChannelId>,
    chunks: ChunkReader<'f>,
    parts: Vec<PartRows>,
}

/// The wanted channels of one part.
struct PartRows {
    blocks: PartBlocks,
    /// Each channel and its index among all that are wanted.
    slots: Vec<(usize, Slot)>,
    held: HeldRows<f32>,
}

impl<'f> RowReader<'f> {
    /// Opens `exr` for reading rows of the `wanted` channels.
    ///
    /// # Panics
    /// If a wanted channel is not in [`ExrFile::parts`].
    pub fn new(exr: &'f ExrFile, wanted: &[ChannelId]) -> Result<Self> {
        let open = || -> Parsed<Self> {
            let mut chunks = ChunkReader::open(exr)?;
            let parts = parts_of(&mut chunks, wanted)?;
            Ok(RowReader {
                exr,
                wanted: wanted.to_vec(),
                chunks,
                parts,
            })
        };
        open().map_err(|fault| fault.at(&exr.path))
    }

    /// The rows `rows` of the wanted channels, in the order requested, counted from the top of the data window of each
    /// channel's part.
    ///
    /// The limits apply to the rows, each of which is held twice, and to the blocks they touch.
    ///
    /// # Panics
    /// If the part of a wanted channel has fewer rows.
    pub fn rows(&mut self, rows: Range<usize>) -> Result<Vec<Plane>> {
        self.read(rows).map_err(|fault| fault.at(&self.exr.path))
    }

    fn read(&mut self, rows: Range<usize>) -> Parsed<Vec<Plane>> {
        self.exr.check_rows(&self.wanted, Some(&rows), 2)?;
        let mut planes = vec![Plane::filled(0, 0, 0.0); self.wanted.len()];
        for PartRows {
            blocks,
            slots,
            held,
        } in &mut self.parts
        {
            let goal = blocks.layout.rows_of(&blocks.layout.bands_of(&rows));
            held.hold(goal, |missing, targets| {
                let is_broken = AtomicBool::new(false);
                let target = |(&(_, slot), samples)| Target {
                    slot,
                    samples: TargetSamples::Floats(samples),
                    is_broken: &is_broken,
                };
                let targets = slots.iter().zip(targets).map(target).collect();
                blocks.read(&mut self.chunks, missing, Rows::Samples(targets))
            })?;
            for (i, &(index, _)) in slots.iter().enumerate() {
                let samples = held.rows(i, &rows).to_vec();
                planes[index] = Plane::from_samples(blocks.layout.width, rows.len(), samples);
            }
        }
        Ok(planes)
    }
}

fn parts_of(chunks: &mut ChunkReader, wanted: &[ChannelId]) -> Parsed<Vec<PartRows>> {
    let mut parts = Vec::new();
    for (part, header) in chunks.exr.header.meta.headers.iter().enumerate() {
        let slots: Vec<(usize, Slot)> = wanted
            .iter()
            .enumerate()
            .filter(|(_, id)| id.part == part)
            .map(|(index, id)| (index, Slot::of_channel(header, id.channel)))
            .collect();
        if !slots.is_empty() {
            let blocks = PartBlocks::open(chunks, part)?;
            parts.push(PartRows {
                held: HeldRows::new(slots.len(), blocks.layout.width),
                blocks,
                slots,
            });
        }
    }
    Ok(parts)
}

/// Consecutive rows of some buffers, kept so that rows wanted again need not be read.
pub(super) struct HeldRows<T> {
    held: Range<usize>,
    /// Elements in a row of a buffer.
    stride: usize,
    buffers: Vec<Vec<T>>,
}

impl<T: Copy + Default> HeldRows<T> {
    pub(super) fn new(buffers: usize, stride: usize) -> Self {
        HeldRows {
            held: 0..0,
            stride,
            buffers: vec![Vec::new(); buffers],
        }
    }

    /// The rows `rows` of a buffer; they must be held.
    pub(super) fn rows(&self, buffer: usize, rows: &Range<usize>) -> &[T] {
        let first = rows.start.saturating_sub(self.held.start) * self.stride;
        match rows.is_empty() {
            true => &[],
            false => &self.buffers[buffer][first..][..rows.len() * self.stride],
        }
    }

    /// Makes the buffers hold the rows `goal` and no others; `read` fills the rows that are new.
    pub(super) fn hold(
        &mut self,
        goal: Range<usize>,
        mut read: impl FnMut(Range<usize>, Vec<&mut [T]>) -> Parsed<()>,
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
        for buffer in &mut self.buffers {
            let to = within_goal(&shared);
            let from = shared.start.saturating_sub(held.start) * stride;
            buffer.resize(buffer.len().max(goal.len() * stride), T::default());
            if !shared.is_empty() {
                buffer.copy_within(from..from + to.len(), to.start);
            }
            buffer.truncate(goal.len() * stride);
        }
        for missing in [goal.start..shared.start, shared.end..goal.end] {
            if !missing.is_empty() {
                let targets = self.buffers.iter_mut();
                let targets = targets.map(|b| &mut b[within_goal(&missing)]).collect();
                read(missing, targets)?;
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

    /// Rows of one element, whose value is the row.
    fn held(rows: &mut HeldRows<usize>, goal: Range<usize>) -> Vec<Range<usize>> {
        let mut read = Vec::new();
        let filled = rows.hold(goal, |missing, mut targets| {
            let rows = missing.clone().zip(targets[0].iter_mut());
            rows.for_each(|(row, element)| *element = row);
            read.push(missing);
            Ok(())
        });
        filled.unwrap();
        read
    }

    #[test]
    fn rows_that_are_held_are_not_read_again() {
        let mut rows = HeldRows::new(1, 1);
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
            let values: Vec<usize> = goal.clone().collect();
            assert_eq!(rows.rows(0, &goal), values);
        }
    }

    #[test]
    fn nothing_is_held_once_reading_failed() {
        let mut rows = HeldRows::new(1, 1);
        held(&mut rows, 0..8);
        let failed = rows.hold(4..12, |_, _| {
            Err(super::super::fault::Fault::damaged("cut"))
        });
        assert!(failed.is_err());
        assert_eq!(held(&mut rows, 4..12), [4..12]);
    }
}
