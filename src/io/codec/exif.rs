//! The first directory of an EXIF block, with a camera's description of a picture.
//!
//! A block is a TIFF without pixels: a byte order, the offset of its first directory, and directories of entries whose
//! longer values are elsewhere in the block. New values are appended, so that all unknown data keep their offsets.

use crate::params::MM_PER_INCH;
use std::ops::RangeInclusive;

/// An entry: its tag, the kind and number of its values, and these or their place in the block.
#[derive(Debug, Clone, PartialEq)]
struct Entry {
    tag: u16,
    kind: u16,
    count: u32,
    value: [u8; 4],
}

/// An EXIF block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Exif {
    bytes: Vec<u8>,
    is_big_endian: bool,
    entries: Vec<Entry>,
}

/// Resolutions that are taken for such, in pixels per inch.
pub(crate) const SOUND_DPI: RangeInclusive<f32> = 1.0..=10_000.0;

/// Tags of the first directory.
pub(crate) const DESCRIPTION: u16 = 0x010e;
const ORIENTATION: u16 = 0x0112;
const RESOLUTIONS: [u16; 2] = [0x011a, 0x011b];
const RESOLUTION_UNIT: u16 = 0x0128;
pub(crate) const SOFTWARE: u16 = 0x0131;

/// Kinds of values.
const TEXT: u16 = 2;
const SHORT: u16 = 3;
const RATIONAL: u16 = 5;
const SIGNED_RATIONAL: u16 = 10;

/// Resolution units.
const INCH: u16 = 2;
const CENTIMETRE: u16 = 3;

/// Most entries of a directory; cameras write some twenty.
const MOST_ENTRIES: u16 = 1000;

/// Bytes of an entry.
const ENTRY_BYTES: usize = 12;

impl Default for Exif {
    /// An empty block.
    fn default() -> Self {
        Self {
            bytes: b"MM\0*\0\0\0\0".to_vec(),
            is_big_endian: true,
            entries: Vec::new(),
        }
    }
}

impl Exif {
    /// The block in `bytes`, from the order of its bytes on; `None` where they are none.
    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        let is_big_endian = match bytes.get(..4)? {
            b"MM\0*" => true,
            b"II*\0" => false,
            _ => return None,
        };
        let mut exif = Self {
            bytes: bytes.to_vec(),
            is_big_endian,
            entries: Vec::new(),
        };
        let at = exif.long(bytes.get(4..8)?) as usize;
        let count = exif.short(bytes.get(at..)?.get(..2)?);
        if count > MOST_ENTRIES {
            return None;
        }
        let entries = bytes.get(at + 2..)?;
        let entries = entries.get(..usize::from(count) * ENTRY_BYTES)?;
        let entries = entries.as_chunks::<ENTRY_BYTES>().0.iter();
        let entries = entries.map(|entry| Entry {
            tag: exif.short(&entry[..2]),
            kind: exif.short(&entry[2..4]),
            count: exif.long(&entry[4..8]),
            value: [entry[8], entry[9], entry[10], entry[11]],
        });
        exif.entries = entries.filter(|entry| exif.is_sound(entry)).collect();
        Some(exif)
    }

    /// Pixels per inch, across and down.
    pub(crate) fn dpi(&self) -> Option<[f32; 2]> {
        let unit = self.get(RESOLUTION_UNIT, SHORT, 1);
        let per_inch = match unit.map(|unit| self.short(&unit.value)) {
            None | Some(INCH) => 1.0,
            Some(CENTIMETRE) => MM_PER_INCH / 10.0,
            Some(_) => return None,
        };
        let [across, down] = RESOLUTIONS.map(|tag| Some(self.rational(tag)? * per_inch));
        Some([across?, down?])
    }

    /// The image description.
    pub(crate) fn description(&self) -> Option<String> {
        let entry = self.entries.iter().find(|entry| entry.tag == DESCRIPTION)?;
        let length = entry.count as usize;
        let text = match length {
            ..=4 => &entry.value[..length],
            _ => {
                let at = self.long(&entry.value) as usize;
                self.bytes.get(at..)?.get(..length)?
            }
        };
        let text = String::from_utf8_lossy(text);
        let text = text.trim_matches(|c: char| c == '\0' || c.is_whitespace());
        (entry.kind == TEXT && !text.is_empty()).then(|| text.to_string())
    }

    /// Sets the orientation to upright, if there is one.
    pub(crate) fn set_upright(&mut self) {
        if self.entries.iter().any(|entry| entry.tag == ORIENTATION) {
            self.set_short(ORIENTATION, 1);
        }
    }

    /// Sets the resolution; without one, an unsound one is left out.
    pub(crate) fn set_dpi(&mut self, dpi: Option<[f32; 2]>) {
        let Some(dpi) = dpi else {
            let is_sound = |tag| {
                self.rational(tag)
                    .is_none_or(|dpi| SOUND_DPI.contains(&dpi))
            };
            if !RESOLUTIONS.into_iter().all(is_sound) {
                let of_resolution = |tag| RESOLUTIONS.contains(&tag) || tag == RESOLUTION_UNIT;
                self.entries.retain(|entry| !of_resolution(entry.tag));
            }
            return;
        };
        for (tag, dpi) in RESOLUTIONS.into_iter().zip(dpi) {
            let [n, d] = thousandths(dpi).map(|number| self.of_long(number));
            self.set(tag, RATIONAL, 1, &[n, d].concat());
        }
        self.set_short(RESOLUTION_UNIT, INCH);
    }

    /// The block with the new values. Its thumbnail is dropped, since it shows the unprocessed picture.
    pub(crate) fn into_bytes(mut self) -> Vec<u8> {
        self.entries.sort_by_key(|entry| entry.tag);
        self.align();
        let at = self.of_long(self.bytes.len() as u32);
        let mut directory = self.of_short(self.entries.len() as u16).to_vec();
        for entry in &self.entries {
            directory.extend(self.of_short(entry.tag));
            directory.extend(self.of_short(entry.kind));
            directory.extend(self.of_long(entry.count));
            directory.extend(entry.value);
        }
        // No further directory.
        directory.extend([0; 4]);
        self.bytes[4..8].copy_from_slice(&at);
        self.bytes.extend(directory);
        self.bytes
    }

    /// Whether the values of an entry are in the block, and no fraction of them divides by 0.
    fn is_sound(&self, entry: &Entry) -> bool {
        let size = match entry.kind {
            1 | TEXT | 6 | 7 => 1,
            SHORT | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            RATIONAL | SIGNED_RATIONAL | 12 => 8,
            _ => return false,
        };
        let Some(length) = (entry.count as usize).checked_mul(size) else {
            return false;
        };
        let at = self.long(&entry.value) as usize;
        let values = match length {
            ..=4 => Some(&entry.value[..length]),
            _ => self.bytes.get(at..).and_then(|rest| rest.get(..length)),
        };
        values.is_some_and(|values| match entry.kind {
            RATIONAL | SIGNED_RATIONAL => values.chunks(8).all(|pair| self.long(&pair[4..]) != 0),
            _ => true,
        })
    }

    fn get(&self, tag: u16, kind: u16, count: u32) -> Option<&Entry> {
        let mut entries = self.entries.iter();
        entries.find(|entry| (entry.tag, entry.kind, entry.count) == (tag, kind, count))
    }

    fn rational(&self, tag: u16) -> Option<f32> {
        let at = self.long(&self.get(tag, RATIONAL, 1)?.value) as usize;
        let value = self.bytes.get(at..)?.get(..8)?;
        Some(self.long(&value[..4]) as f32 / self.long(&value[4..]) as f32)
    }

    pub(crate) fn set_text(&mut self, tag: u16, text: &str) {
        let text = [text.as_bytes(), &[0]].concat();
        self.set(tag, TEXT, text.len() as u32, &text);
    }

    fn set_short(&mut self, tag: u16, number: u16) {
        let number = self.of_short(number);
        self.set(tag, SHORT, 1, &number);
    }

    /// Sets `count` values of an entry: up to four bytes in place, longer ones at the end of the block.
    fn set(&mut self, tag: u16, kind: u16, count: u32, values: &[u8]) {
        let mut value = [0; 4];
        if let Some(place) = value.get_mut(..values.len()) {
            place.copy_from_slice(values);
        } else {
            self.align();
            value = self.of_long(self.bytes.len() as u32);
            self.bytes.extend(values);
        }
        let entry = Entry {
            tag,
            kind,
            count,
            value,
        };
        self.entries.retain(|entry| entry.tag != tag);
        self.entries.push(entry);
    }

    /// Values begin at even places.
    fn align(&mut self) {
        if !self.bytes.len().is_multiple_of(2) {
            self.bytes.push(0);
        }
    }

    fn short(&self, bytes: &[u8]) -> u16 {
        self.number(&bytes[..2]) as u16
    }

    fn long(&self, bytes: &[u8]) -> u32 {
        self.number(&bytes[..4])
    }

    fn number(&self, bytes: &[u8]) -> u32 {
        let digit = |number: u32, &byte: &u8| number << 8 | u32::from(byte);
        match self.is_big_endian {
            true => bytes.iter().fold(0, digit),
            false => bytes.iter().rev().fold(0, digit),
        }
    }

    fn of_short(&self, number: u16) -> [u8; 2] {
        self.ordered(number.to_be_bytes())
    }

    fn of_long(&self, number: u32) -> [u8; 4] {
        self.ordered(number.to_be_bytes())
    }

    /// Bytes in the order of the block.
    fn ordered<const BYTES: usize>(&self, mut bytes: [u8; BYTES]) -> [u8; BYTES] {
        if !self.is_big_endian {
            bytes.reverse();
        }
        bytes
    }
}

/// A resolution as a fraction: above and below the line.
pub(crate) fn thousandths(dpi: f32) -> [u32; 2] {
    [((dpi * 1000.0).round() as u32).max(1), 1000]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_anew_is_read_back_and_all_else_keeps_its_place() {
        // Little-endian; the directory at 8 has three entries: orientation (0x112, a short) 6, artist (0x13b, a text of 6
        // bytes) at 50, and 0x8769, the place of another directory, which is not understood; then none follows.
        let mut block = b"II*\0\x08\0\0\0\x03\0".to_vec();
        block.extend(b"\x12\x01\x03\0\x01\0\0\0\x06\0\0\0");
        block.extend(b"\x3b\x01\x02\0\x06\0\0\0\x32\0\0\0");
        block.extend(b"\x69\x87\x04\0\x01\0\0\0\x38\0\0\0");
        block.extend(b"\0\0\0\0Marie\0");
        let mut exif = Exif::read(&block).unwrap();
        assert_eq!((exif.dpi(), exif.description()), (None, None));
        exif.set_upright();
        exif.set_dpi(Some([72.5, 300.0]));
        exif.set_text(SOFTWARE, "program 1");
        exif.set_text(DESCRIPTION, "a = 1\nb = 2");
        let written = exif.into_bytes();
        assert_eq!(written[8..block.len()], block[8..]);
        let read = Exif::read(&written).unwrap();
        assert_eq!(read.dpi(), Some([72.5, 300.0]));
        assert_eq!(read.description().as_deref(), Some("a = 1\nb = 2"));
        let of = |tag| {
            let found = read.entries.iter().find(|entry| entry.tag == tag);
            found.map(|entry| entry.value).unwrap()
        };
        assert_eq!(of(ORIENTATION), [1, 0, 0, 0]);
        assert_eq!((of(0x13b), of(0x8769)), ([50, 0, 0, 0], [56, 0, 0, 0]));
        let tags: Vec<u16> = read.entries.iter().map(|entry| entry.tag).collect();
        assert!(tags.is_sorted() && tags.len() == 8, "{tags:x?}");
    }

    #[test]
    fn what_is_no_block_or_ends_too_early_says_nothing() {
        let mut exif = Exif::default();
        exif.set_dpi(Some([300.0; 2]));
        exif.set_text(DESCRIPTION, "long enough to lie elsewhere");
        let whole = exif.into_bytes();
        for end in 0..whole.len() {
            let exif = Exif::read(&whole[..end]);
            assert!(exif.is_none_or(|exif| exif.entries.len() == 4), "{end}");
        }
        // A place beyond the block, and a denominator of 0.
        let mut far = whole.clone();
        far[4..8].fill(255);
        assert_eq!(Exif::read(&far), None);
        assert_eq!(Exif::read(b"no block at all"), None);
    }

    /// A little-endian block whose directory at 8 has these entries, with eight bytes after it at 14 and 12 for each.
    fn block(entries: &[[u8; ENTRY_BYTES]], after: [u8; 8]) -> Vec<u8> {
        let count = (entries.len() as u16).to_le_bytes();
        let start = [&b"II*\0\x08\0\0\0"[..], &count].concat();
        [start, entries.concat(), vec![0; 4], after.to_vec()].concat()
    }

    #[test]
    fn unsound_entries_are_left_out() {
        let tags = |bytes: &[u8], dpi| {
            let mut exif = Exif::read(bytes).unwrap();
            exif.set_dpi(dpi);
            let read = Exif::read(&exif.into_bytes()).unwrap();
            read.entries
                .iter()
                .map(|entry| entry.tag)
                .collect::<Vec<_>>()
        };
        // Across (0x11a), a unit (0x128), and the artist (0x13b) in 200 bytes, of which there are not as many.
        let entries = [
            *b"\x1a\x01\x05\0\x01\0\0\0\x32\0\0\0",
            *b"\x28\x01\x03\0\x01\0\0\0\x02\0\0\0",
            *b"\x3b\x01\x02\0\xc8\0\0\0\x32\0\0\0",
        ];
        for (fraction, kept) in [
            ([0, 1], &[][..]),
            ([1, 0], &[RESOLUTION_UNIT]),
            ([u32::MAX, 1], &[]),
            ([72, 1], &[RESOLUTIONS[0], RESOLUTION_UNIT]),
        ] {
            let bytes = block(
                &entries,
                fraction.map(u32::to_le_bytes).concat().try_into().unwrap(),
            );
            assert_eq!(tags(&bytes, None), kept, "{fraction:?}");
            let all = [RESOLUTIONS[0], RESOLUTIONS[1], RESOLUTION_UNIT];
            assert_eq!(tags(&bytes, Some([300.0; 2])), all);
        }
        assert_eq!(thousandths(1e-9), [1, 1000]);
    }

    #[test]
    fn a_directory_without_end_is_none() {
        let entry = *b"\x3b\x01\x01\0\x01\0\0\0\x01\0\0\0";
        // With the four that are added 65,535 entries and more would wrap around.
        for count in [usize::from(MOST_ENTRIES) + 1, 65_535] {
            assert_eq!(Exif::read(&block(&vec![entry; count], [0; 8])), None);
        }
        let most = block(&vec![entry; usize::from(MOST_ENTRIES)], [0; 8]);
        let mut exif = Exif::read(&most).unwrap();
        exif.set_text(SOFTWARE, "x");
        let written = exif.into_bytes();
        // The place of the new directory, and its 1000 and one more entries.
        let at = u32::from_le_bytes(written[4..8].try_into().unwrap()) as usize;
        assert_eq!(written[at..at + 2], 1001u16.to_le_bytes());
    }
}
