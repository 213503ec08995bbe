//! A bar of a round length with that length written above it: 1, 2 or 5 times a power of ten.

use crate::params::ScaleBar;

/// Largest share of the picture's width for the bar: the next shorter length is at least two fifths of it, so bars take
/// about a fifth.
const SHARE: f64 = 0.3;
/// Rows of a letter, and columns of one with the space after it.
const LETTER: [usize; 2] = [7, 6];
/// Columns of a picture for a pixel of a letter.
const WIDTH_PER_DOT: usize = 320;
/// Least size of a pixel of a letter in a picture that has room for it.
const READABLE: usize = 2;

/// Letters of 5 columns and 7 rows, the leftmost column the highest bit.
const LETTERS: [(char, [u8; 7]); 10] = [
    ('0', [0x0e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e]),
    ('1', [0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e]),
    ('2', [0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f]),
    ('5', [0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e]),
    ('m', [0x00, 0x00, 0x1a, 0x15, 0x15, 0x15, 0x15]),
    ('c', [0x00, 0x00, 0x0e, 0x11, 0x10, 0x11, 0x0e]),
    ('k', [0x10, 0x10, 0x12, 0x14, 0x18, 0x14, 0x12]),
    ('n', [0x00, 0x00, 0x16, 0x19, 0x11, 0x11, 0x11]),
    ('µ', [0x00, 0x00, 0x11, 0x11, 0x13, 0x1d, 0x10]),
    (' ', [0; 7]),
];

/// Units that lengths are written in, and their millimetres, the largest first.
const UNITS: [(&str, f64); 6] = [
    ("km", 1e6),
    ("m", 1e3),
    ("cm", 10.0),
    ("mm", 1.0),
    ("µm", 1e-3),
    ("nm", 1e-6),
];

/// The bar of a picture: black, with white around it.
pub(super) struct Bar {
    width: usize,
    height: usize,
    /// Row by row, whether a pixel is black (1), white (0) or unchanged.
    pixels: Vec<Option<bool>>,
}

/// The largest round length, in millimetres, up to `most`, and how it is written.
fn round_length(most: f64) -> (f64, String) {
    let power = most.log10().floor() as i32;
    // A power of ten may round to just above the value.
    let lengths = [(5, power), (2, power), (1, power), (5, power - 1)];
    let of = |(digit, power): (i32, i32)| f64::from(digit) * 10f64.powi(power);
    let fits = |length: &(i32, i32)| of(*length) <= most * (1.0 + 1e-9);
    let length = of(lengths.into_iter().find(fits).unwrap_or((5, power - 1)));
    let in_unit = |(_, mm): &&(&str, f64)| length >= mm * (1.0 - 1e-9);
    let (unit, mm) = UNITS.iter().find(in_unit).unwrap_or(&UNITS[5]);
    (length, format!("{} {unit}", (length / mm).round()))
}

impl Bar {
    /// The bar for a picture of `size`, columns and rows, with columns `pixel_mm` wide on the depicted object.
    pub(super) fn new(size: [usize; 2], pixel_mm: f64) -> Self {
        let (length, label) = round_length(SHARE * size[0] as f64 * pixel_mm);
        let long = ((length / pixel_mm).round() as usize).max(1);
        let dot = (size[0] / WIDTH_PER_DOT).max(READABLE);
        let letters = label.chars().count();
        let written = (letters * LETTER[1] - 1) * dot;
        // Half a letter of room on each side.
        let room = 3 * dot;
        let width = long.max(written) + 2 * room;
        let height = (LETTER[0] + 5) * dot + 2 * room;
        let mut black = vec![false; width * height];
        let mut fill = |x0: usize, y0: usize, columns: usize, rows: usize| {
            for y in y0..y0 + rows {
                black[y * width + x0..y * width + x0 + columns].fill(true);
            }
        };
        let (left, top) = ((width - written) / 2, room);
        for (at, letter) in label.chars().enumerate() {
            let rows = LETTERS.iter().find(|(known, _)| *known == letter);
            for (row, bits) in rows
                .map_or([0; 7], |(_, rows)| *rows)
                .into_iter()
                .enumerate()
            {
                for column in (0..5).filter(|column| bits & (0x10 >> column) != 0) {
                    let x = left + (at * LETTER[1] + column) * dot;
                    fill(x, top + row * dot, dot, dot);
                }
            }
        }
        fill(
            (width - long) / 2,
            top + (LETTER[0] + 2) * dot,
            long,
            2 * dot,
        );
        // A white margin, as wide as a pixel of a letter, around black.
        let near = |x: usize, y: usize| {
            let columns = x.saturating_sub(dot)..(x + dot + 1).min(width);
            let mut rows = y.saturating_sub(dot)..(y + dot + 1).min(height);
            rows.any(|y| black[y * width..][columns.clone()].contains(&true))
        };
        let pixel = |i: usize| match black[i] {
            true => Some(true),
            false => near(i % width, i / width).then_some(false),
        };
        Self {
            pixels: (0..width * height).map(pixel).collect(),
            width,
            height,
        }
    }

    /// Draws it on the samples of a picture of `size`, with `channels` per pixel, between 0 and `white`, which has the bytes
    /// of a sample; returns its size, or `None` without room.
    pub(super) fn draw(
        &self,
        samples: &mut Vec<u8>,
        size: [usize; 2],
        channels: usize,
        white: &[u8],
        place: ScaleBar,
    ) -> Option<[usize; 2]> {
        let [columns, rows] = size;
        if self.width > columns || (place == ScaleBar::On && self.height > rows) {
            return None;
        }
        let (left, top, size) = match place {
            ScaleBar::Off => return Some(size),
            ScaleBar::Outside => {
                samples.extend(white.repeat(columns * self.height * channels));
                (0, rows, [columns, rows + self.height])
            }
            ScaleBar::On => {
                let [left, top] = self.quietest(samples, size, [channels, white.len()]);
                (left, top, size)
            }
        };
        let bytes = channels * white.len();
        let white_pixel = white.repeat(channels);
        let mut black_pixel = vec![0; bytes];
        if channels == 4 {
            // Opaque.
            black_pixel[3 * white.len()..].copy_from_slice(white);
        }
        for (i, is_black) in self.pixels.iter().enumerate() {
            let Some(is_black) = is_black else { continue };
            let (x, y) = (left + i % self.width, top + i / self.width);
            let pixel = if *is_black {
                &black_pixel
            } else {
                &white_pixel
            };
            samples[(y * columns + x) * bytes..][..bytes].copy_from_slice(pixel);
        }
        Some(size)
    }

    /// The corner whose samples differ least often from their neighbours, preferring the lower right one.
    fn quietest(
        &self,
        samples: &[u8],
        [columns, rows]: [usize; 2],
        [channels, bytes]: [usize; 2],
    ) -> [usize; 2] {
        let (right, bottom) = (columns - self.width, rows - self.height);
        let corners = [[right, bottom], [0, bottom], [right, 0], [0, 0]];
        let unrest = |[left, top]: &[usize; 2]| {
            let row = |y: usize| {
                let from = ((top + y) * columns + left) * channels * bytes;
                let row = &samples[from..][..self.width * channels * bytes];
                let next = row.chunks(bytes).zip(row.chunks(bytes).skip(channels));
                next.filter(|(a, b)| a != b).count()
            };
            (0..self.height).map(row).sum::<usize>()
        };
        corners.into_iter().min_by_key(unrest).unwrap_or([0, 0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round_and_the_largest_that_fit() {
        for (most, length, label) in [
            (9.99, 5.0, "5 mm"),
            (10.0, 10.0, "1 cm"),
            (0.2, 0.2, "200 µm"),
            (4999.0, 2000.0, "2 m"),
            (1e6, 1e6, "1 km"),
            (0.000_7, 0.000_5, "500 nm"),
            (1.999, 1.0, "1 mm"),
        ] {
            let (found, written) = round_length(most);
            assert!((found / length - 1.0).abs() < 1e-9, "{most}: {found}");
            assert_eq!(written, label);
            // Every letter can be written.
            assert!(
                label
                    .chars()
                    .all(|c| LETTERS.iter().any(|(known, _)| *known == c))
            );
        }
    }

    #[test]
    fn a_bar_is_as_long_as_it_says_in_the_quietest_corner() {
        // Three tenths of 400 columns of 0.05 mm are 6 mm: 5 mm are 100 columns.
        let size = [400, 300];
        let bar = Bar::new(size, 0.05);
        let mut samples = vec![128u8; 400 * 300];
        // Noise everywhere but in the upper left quarter.
        for (i, sample) in samples.iter_mut().enumerate() {
            let (x, y) = (i % 400, i / 400);
            *sample = if x < 200 && y < 150 {
                128
            } else {
                (i % 7) as u8 + 100
            };
        }
        let before = samples.clone();
        let drawn = bar.draw(&mut samples, size, 1, &[255], ScaleBar::On);
        assert_eq!(drawn, Some(size));
        let black_run = |row: &[u8]| row.split(|&v| v != 0).map(<[u8]>::len).max();
        let longest = samples.chunks(400).filter_map(black_run).max();
        assert_eq!(longest, Some(100));
        let changed = |i: &usize| samples[*i] != before[*i];
        assert!(
            (0..samples.len())
                .filter(changed)
                .all(|i| i % 400 < 200 && i / 400 < 150)
        );
        // Below the picture nothing of it changes.
        let mut samples = before.clone();
        let [columns, rows] = bar
            .draw(&mut samples, size, 1, &[255], ScaleBar::Outside)
            .unwrap();
        assert!(columns == 400 && rows > 300 && samples.len() == columns * rows);
        assert!(samples.starts_with(&before));
        assert_eq!(
            samples[300 * 400..].chunks(400).filter_map(black_run).max(),
            Some(100)
        );
        // Too small for a bar.
        let mut small = vec![0u8; 16 * 8];
        assert_eq!(
            Bar::new([16, 8], 1.0).draw(&mut small, [16, 8], 1, &[255], ScaleBar::On),
            None
        );
    }
}
