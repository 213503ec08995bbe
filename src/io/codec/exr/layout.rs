//! Division of a part's pixels into blocks.

use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::TileDescription;
use ::exr::meta::header::Header;
use std::ops::Range;

/// Decoded bytes that are worked on at one time, unless two bands have more.
const BATCH_BYTES: usize = 32 << 20;

/// A part divided into bands over its full width, and those into blocks.
#[derive(Debug, Clone)]
pub(super) struct BandLayout {
    /// Columns of the part.
    pub(super) width: usize,
    /// Rows of the part.
    height: usize,
    /// Rows in a band; the last one may have fewer.
    band_rows: usize,
    /// Columns in a block; the last one of a band may have fewer.
    block_columns: usize,
    /// Bytes of a pixel with all its channels.
    pub(super) pixel_bytes: usize,
    /// Bytes of a sample of each channel.
    pub(super) sample_bytes: Vec<usize>,
    /// First row of the part.
    top: i32,
    tiled: bool,
}

/// The pixels of a block, counted from the corner of the part.
#[derive(Debug, Clone)]
pub(super) struct Area {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl BandLayout {
    pub(super) fn of(header: &Header) -> BandLayout {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        let (columns, rows, tiled) = match header.blocks {
            BlockDescription::ScanLines => {
                (width, header.compression.scan_lines_per_block(), false)
            }
            BlockDescription::Tiles(TileDescription { tile_size, .. }) => {
                (tile_size.width(), tile_size.height(), true)
            }
        };
        let channels = header.channels.list.iter();
        // A tile may be larger than the picture; its block is not.
        BandLayout {
            width,
            height,
            band_rows: rows.min(height),
            block_columns: columns.min(width),
            pixel_bytes: header.channels.bytes_per_pixel,
            sample_bytes: channels.map(|c| c.sample_type.bytes_per_sample()).collect(),
            top: header.own_attributes.layer_position.y(),
            tiled,
        }
    }

    /// Number of blocks at full resolution.
    pub(super) fn blocks(&self) -> usize {
        self.height.div_ceil(self.band_rows) * self.blocks_per_band()
    }

    pub(super) fn blocks_per_band(&self) -> usize {
        self.width.div_ceil(self.block_columns)
    }

    /// Most bytes of one block.
    pub(super) fn block_bytes(&self) -> u128 {
        let pixels = self.block_columns as u128 * self.band_rows as u128;
        pixels * self.pixel_bytes as u128
    }

    /// Most bytes of one band.
    pub(super) fn band_bytes(&self) -> u128 {
        self.block_bytes() * self.blocks_per_band() as u128
    }

    /// Most bands that are worked on at one time, each by a thread: at least two, so that one can be read while another is
    /// decoded.
    pub(super) fn bands_at_once(&self) -> usize {
        let fitting = BATCH_BYTES as u128 / self.band_bytes().max(1);
        let bands = self.height.div_ceil(self.band_rows);
        let most = rayon::current_num_threads().min(bands);
        (fitting.clamp(2, 1024) as usize).min(most)
    }

    /// The bands that hold any of `rows`.
    pub(super) fn bands_of(&self, rows: &Range<usize>) -> Range<usize> {
        let first = rows.start / self.band_rows;
        match rows.is_empty() {
            true => first..first,
            false => first..rows.end.div_ceil(self.band_rows),
        }
    }

    /// Rows of the bands `bands`.
    pub(super) fn rows_of(&self, bands: &Range<usize>) -> Range<usize> {
        bands.start * self.band_rows..(bands.end * self.band_rows).min(self.height)
    }

    /// Area of block `block` in band `band`.
    pub(super) fn area(&self, band: usize, block: usize) -> Area {
        let x = block * self.block_columns;
        Area {
            columns: x..(x + self.block_columns).min(self.width),
            rows: self.rows_of(&(band..band + 1)),
        }
    }

    /// The place expected in the chunk of block `block` in band `band`.
    pub(super) fn place(&self, band: usize, block: usize) -> Vec<i32> {
        match self.tiled {
            true => vec![block as i32, band as i32, 0, 0],
            false => vec![self.top + (band * self.band_rows) as i32],
        }
    }
}
