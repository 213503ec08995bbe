//! The memory that pictures take, whole and in strips, and how they are cut as it allows.

use super::job::Job;
use crate::command::args::BackendArg;
use crate::command::memory::MaxMemory;
use crate::command::output::MOST_PLANES;
use crate::engine::tiles::Strips;
use crate::error::{Result, bad};
use crate::io::exr::encoding_bytes;
use crate::io::inputs::Wrap;
use crate::io::output::OutputKind;
use crate::io::picture::Gathered;
use crate::io::{decoding_bytes, picture_size, program_bytes, surroundings_bytes};
use crate::untrusted::shown;
use std::path::Path;

/// Most that a photo takes where no amount is given: beyond it goes in strips.
const PHOTO_BYTES: u64 = 1536 << 20;

/// Most that blocks are taken to need while they are encoded: those of wide pictures and many threads may take more, but
/// planes of strips less than they are taken to.
const ENCODED_BYTES: u64 = 160 << 20;

/// Bytes per pixel of all layers of a tile, which are held at once. Measured with `shape --wrap xy`, at .8 megapixels: 117
/// beyond a tile.
const TILE_LAYERS_PER_PIXEL: u64 = 130;

/// Fewer rows are not worth a strip.
pub(super) const FEWEST_ROWS: usize = 16;

/// Whether a frame takes more memory than it may have, and goes in strips.
///
/// # Errors
/// [`Error::Unsupported`] for such a tile: strips have no borders to join.
pub(super) fn goes_in_strips(job: &Job) -> Result<bool> {
    if job.part.is_some() {
        return job
            .args()
            .refuse_too_large(&job.args().input)
            .map(|()| false);
    }
    if job.args().roles.named.wrap != Wrap::None {
        let input = &job.args().input;
        let is_exr = matches!(job.args().output.kind(), Ok(OutputKind::Exr));
        let size = picture_size(input).filter(|_| is_exr);
        let layers = size.map_or(0, |size| size.pixels.saturating_mul(TILE_LAYERS_PER_PIXEL));
        let beside = layers.saturating_add(job.work().bytes_around_tile(input));
        let why = "joins the borders of the picture whole";
        job.args().refuse_above(input, beside, why)?;
        return Ok(false);
    }
    Ok(whole_bytes(job) > allowed(job))
}

/// Refuses surroundings that are too large to go with the frame, and those of a sheet.
pub(super) fn refuse_large_surroundings(job: &Job, path: Option<&Path>) -> Result<()> {
    if job.part.is_some() {
        return Err(bad(
            "--grid",
            "does not go with what mirrors and lenses show",
            "leave one of them out",
        ));
    }
    let Some(path) = path else { return Ok(()) };
    let why = format!("keeps {} beside it", shown(path));
    let args = job.args();
    args.refuse_above(&args.input, surroundings_bytes(path)?, &why)
}

/// About how much memory the frame takes as a whole.
pub(super) fn whole_bytes(job: &Job) -> u64 {
    job.args().frame_bytes(&job.args().input)
}

/// Memory that the frame may take before it goes in strips. Where nothing is given, photos take no more than they
/// need to be quick; a GPU that was asked for works on whole frames.
fn allowed(job: &Job) -> u64 {
    let run = &job.args().run;
    let bytes = run.max_memory.bytes();
    let is_photo = !matches!(OutputKind::of(&job.args().input), Ok(OutputKind::Exr));
    match run.max_memory {
        MaxMemory::Auto if is_photo && run.compute.backend != BackendArg::Gpu => {
            bytes.min(PHOTO_BYTES)
        }
        _ => bytes,
    }
}

/// Bytes of planes that are written as numbers, of which all are held.
fn array_bytes(job: &Job) -> u64 {
    let pixels = || picture_size(&job.args().input).map_or(0, |size| size.pixels);
    match job.args().output.kind() {
        Ok(OutputKind::Numbers(_)) => {
            pixels().saturating_mul((MOST_PLANES * size_of::<f32>()) as u64)
        }
        _ => 0,
    }
}

/// Memory needed for a picture in strips, in bytes.
#[derive(Clone, Copy)]
pub(super) struct StripMemory {
    /// Independent of the strips.
    fixed: u64,
    /// For each row of a strip.
    row: u64,
    /// Blocks of an EXR that are being decoded.
    decoding: u64,
    /// Whether an EXR is written.
    is_exr: bool,
    /// Rows of the picture.
    height: usize,
}

impl StripMemory {
    /// The memory of the picture of `job`, which has so many rows, and of what is gathered of it.
    pub(super) fn new(
        job: &Job,
        height: usize,
        photo_bytes: u64,
        gathered: Option<&Gathered>,
    ) -> Self {
        let row = whole_bytes(job).div_ceil(height.max(1) as u64).max(1);
        let output = job.args().output.output.as_ref();
        let [samples, encoding] = gathered.map_or([0; 2], |g| [g.bytes(), g.encoding_bytes()]);
        Self {
            // Photos are let go of before the result is encoded.
            fixed: program_bytes() + samples + array_bytes(job) + photo_bytes.max(encoding),
            row,
            decoding: decoding_bytes(&job.args().input),
            is_exr: output.is_some_and(|path| matches!(OutputKind::of(path), Ok(OutputKind::Exr))),
            height,
        }
    }

    /// Bytes that strips of so many rows take.
    fn of_rows(&self, rows: usize) -> u64 {
        let strip = self.row.saturating_mul(rows as u64);
        // Results are half of a strip at most.
        let encoding = match self.is_exr {
            true => encoding_bytes(strip, self.row / 2),
            false => 0,
        };
        let blocks = self.decoding.max(encoding.min(ENCODED_BYTES));
        self.fixed.saturating_add(blocks).saturating_add(strip)
    }

    /// The least that strips take which reach so many rows beyond what they give.
    pub(super) fn least(&self, reach: usize) -> u64 {
        self.of_rows((FEWEST_ROWS + 2 * reach).min(self.height))
    }

    /// Rows that fit into the memory that `job` may take.
    pub(super) fn rows_allowed(&self, job: &Job) -> usize {
        self.rows_in(allowed(job))
    }

    /// Rows that fit into so many bytes.
    fn rows_in(&self, bytes: u64) -> usize {
        let (mut fitting, mut too_many) = (0, self.height + 1);
        while too_many - fitting > 1 {
            let rows = usize::midpoint(fitting, too_many);
            match self.of_rows(rows) <= bytes {
                true => fitting = rows,
                false => too_many = rows,
            }
        }
        fitting
    }
}

/// How a picture is cut, as memory allows.
pub(super) fn strips_of(job: &Job, cost: StripMemory, reach: usize) -> Result<Strips> {
    let (least, most) = (cost.least(reach), job.args().run.max_memory.bytes());
    let rows = cost.rows_in(allowed(job).max(least));
    let strips = Strips::new(reach, cost.height, rows).filter(|_| least <= most);
    strips.ok_or_else(|| {
        let why = format!("takes {} MiB even in strips", least.div_ceil(1 << 20));
        let work = job.args();
        work.too_large(&work.input, &why, least.min(whole_bytes(job)))
    })
}
