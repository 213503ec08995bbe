//! Writing a part, whole or strip by strip.

use super::ExrFile;
use super::append::{copy_chunks, start_append};
use super::encode::{Encoder, Strip};
use super::header::VERSION;
use super::merge::{InputRows, Merged, start_merge};
use super::sink::ChunkSink;
use super::write::{OutputPart, PartDescription, ReadyPart};
use crate::error::{Error, Result};
use crate::frame::Plane;
use std::io::{Seek, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Writes `part` alone as a file. `target` is only named in errors.
///
/// # Panics
/// If a plane does not have the size of the data window.
pub fn write_results(w: &mut (impl Write + Seek), target: &Path, part: &OutputPart) -> Result<()> {
    PartWriter::create(w, target, &part.description())?
        .write(part)
        .map(drop)
}

/// Writes the samples of one part, from the top, some rows at a time.
///
/// The bytes do not depend on how the rows are divided. Rows that do not fill a block are kept for the next call; memory
/// holds no more than those, and the blocks being compressed.
pub struct PartWriter<'a, W> {
    out: ChunkSink<'a, W>,
    target: PathBuf,
    /// Index of the part in the file.
    index: usize,
    /// First row of the data window.
    top: i32,
    width: usize,
    planes: usize,
    encoder: Encoder,
    /// The part that is added to.
    kept: Option<InputRows<'a>>,
}

impl<'a, W: Write + Seek> PartWriter<'a, W> {
    /// Starts a file of this part alone. `target` is only named in errors.
    pub fn create(w: &'a mut W, target: &Path, part: &PartDescription) -> Result<Self> {
        let ready = ReadyPart::new(part, target, None)?;
        let parts = std::slice::from_ref(&ready.attributes);
        let counts = [ready.header.chunk_count];
        let out = ChunkSink::start(w, target, VERSION, (parts, &ready), &counts)?;
        Ok(Self::new(out, target, 0, part, &ready))
    }

    /// Starts a copy of `input` with this part added. `target` is only named in errors.
    ///
    /// The compressed pixels of the input are copied as they are, so nothing is lost a second time, and
    /// every attribute is kept. The new part takes the display window, pixel aspect, chromaticities and
    /// time code of the first one, which all parts must share.
    pub fn append(
        input: &'a ExrFile,
        w: &'a mut W,
        target: &Path,
        part: &PartDescription,
    ) -> Result<Self> {
        let (mut out, ready) = start_append(input, w, target, part)?;
        copy_chunks(input, None, &mut out, target)?;
        Ok(Self::new(out, target, input.parts.len(), part, &ready))
    }

    /// Starts a copy of `input` in which the part at index `part` also has these channels, for programs that see only
    /// one part. `target` is only named in errors.
    ///
    /// The part's own channels keep every bit, NaN payloads included, and its attributes stay; the text attributes of
    /// `added` are set. Its pixels are compressed anew, with the same compression if that is lossless, else with ZIP;
    /// tiles become rows, at full resolution only. Other parts are copied as they are. If a layer of `added` shares a
    /// channel with the part, the layer is renamed: bare channels go to a layer named like `added`. Its window must be
    /// that of the part, which otherwise keeps its own description.
    ///
    /// # Panics
    /// If there is no such part.
    pub fn add_channels(
        input: &'a ExrFile,
        part: usize,
        w: &'a mut W,
        target: &Path,
        added: &PartDescription,
    ) -> Result<(Self, Merged)> {
        let (mut out, ready, merged) = start_merge(input, part, w, target, added)?;
        copy_chunks(input, Some(part), &mut out, target)?;
        let mut writer = Self::new(out, target, part, added, &ready);
        let kept = InputRows::open(input, part, writer.encoder.batch_rows());
        writer.kept = Some(kept.map_err(|fault| fault.at(&input.path))?);
        Ok((writer, merged))
    }

    fn new(
        out: ChunkSink<'a, W>,
        target: &Path,
        index: usize,
        part: &PartDescription,
        ready: &ReadyPart,
    ) -> Self {
        PartWriter {
            out,
            target: target.to_path_buf(),
            index,
            top: part.data_window.y0,
            width: part.data_window.width(),
            planes: part.channels.len(),
            encoder: Encoder::new(ready),
            kept: None,
        }
    }

    /// Writes the next rows: the rows `rows` of `planes`, one for each channel described, in that
    /// order.
    ///
    /// # Panics
    /// If there are more or fewer planes than channels, if one is not as wide as the data window or
    /// lacks some of the rows, or if there are more rows than the data window has left.
    pub fn push(&mut self, planes: &[&Plane], rows: Range<usize>) -> Result<()> {
        self.push_beside(planes, rows, &mut || ())
    }

    /// [`PartWriter::push`] of at least one row. `beside` is done once, by threads that have none of the rows to compress.
    pub(crate) fn push_beside(
        &mut self,
        planes: &[&Plane],
        rows: Range<usize>,
        beside: &mut (dyn FnMut() + Send),
    ) -> Result<()> {
        assert_eq!(planes.len(), self.planes, "one plane for each channel");
        for plane in planes {
            let fits = plane.width() == self.width && rows.end <= plane.height();
            assert!(fits, "a plane does not fill the data window");
        }
        assert!(
            rows.len() <= self.encoder.missing(),
            "more rows than the data window has"
        );
        let (mut next, mut nothing) = (rows.start, || ());
        let mut beside = beside;
        while next < rows.end {
            let rows = next..rows.end.min(next + self.encoder.batch_rows());
            next = rows.end;
            self.write_strip(planes, rows, beside)?;
            beside = &mut nothing;
        }
        Ok(())
    }

    fn write_strip(
        &mut self,
        planes: &[&Plane],
        rows: Range<usize>,
        beside: &mut (dyn FnMut() + Send),
    ) -> Result<()> {
        let taken = self.encoder.taken;
        let kept = match &mut self.kept {
            Some(part) => part.rows(&(taken..taken + rows.len()))?,
            None => &[],
        };
        let strip = Strip { planes, rows, kept };
        let compressed = self.encoder.take(&strip, beside);
        let (first, blocks) = compressed.map_err(|fault| fault.at(&self.target))?;
        for (index, bytes) in (first..).zip(blocks) {
            let top = self.top + (index * self.encoder.block_rows) as i32;
            let written = self.out.chunk(self.index, index, &[top], &bytes);
            written.map_err(Error::io(&self.target, "write"))?;
        }
        Ok(())
    }

    /// Finishes the file. Returns the number of finite samples clamped because they were too large for half floats,
    /// whether requested or used by DWA for colours.
    ///
    /// # Panics
    /// If rows are missing.
    pub fn finish(self) -> Result<u64> {
        assert_eq!(self.encoder.missing(), 0, "rows are missing");
        let finished = self.out.finish();
        finished.map_err(Error::io(&self.target, "write"))?;
        Ok(self.encoder.clamped)
    }

    /// Writes all rows, and finishes the file as [`PartWriter::finish`] does.
    ///
    /// # Panics
    /// If there are more or fewer planes than channels, or one does not have the size of the data window.
    pub fn write(mut self, part: &OutputPart) -> Result<u64> {
        let (planes, height) = (part.planes(), part.data_window.height());
        let fit = planes.iter().all(|plane| plane.height() == height);
        assert!(fit, "a plane does not fill the data window");
        self.push(&planes, 0..height)?;
        self.finish()
    }
}
