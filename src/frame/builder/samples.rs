//! Borrowed samples in any layout and number type.

use crate::error::{Error, Result};
use crate::frame::{Mask, Plane};
use ndarray::{Array2, Array3, ArrayView2, ArrayView3, Axis};

/// A type that samples are stored in: `f32`, `f16`, `u8`, `u16` or `bool`.
///
/// Integers map to 0..1, with the largest one as 1; `true` is 1.
pub trait Sample: Copy + stored::Stored {}

impl<T: stored::Stored> Sample for T {}

mod stored {
    use half::f16;

    /// Seals [`super::Sample`], and converts values.
    #[allow(unnameable_types, reason = "it seals `Sample`")]
    pub trait Stored: Copy + Send + Sync {
        /// Largest rounding error of a value in -1..1 stored in this type.
        const ROUNDING: f32;
        /// Whether it stores 0..1 only.
        const IS_INTEGER: bool;
        fn value(self) -> f32;
    }

    impl Stored for f32 {
        const ROUNDING: f32 = 0.0;
        const IS_INTEGER: bool = false;
        fn value(self) -> f32 {
            self
        }
    }

    impl Stored for f16 {
        // Half a step between numbers just below 1.
        const ROUNDING: f32 = f16::EPSILON.to_f32_const() / 4.0;
        const IS_INTEGER: bool = false;
        fn value(self) -> f32 {
            self.to_f32()
        }
    }

    impl Stored for u8 {
        const ROUNDING: f32 = 1.0 / 255.0;
        const IS_INTEGER: bool = true;
        fn value(self) -> f32 {
            f32::from(self) / 255.0
        }
    }

    impl Stored for u16 {
        const ROUNDING: f32 = 1.0 / 65535.0;
        const IS_INTEGER: bool = true;
        fn value(self) -> f32 {
            f32::from(self) / 65535.0
        }
    }

    impl Stored for bool {
        const ROUNDING: f32 = 1.0;
        const IS_INTEGER: bool = true;
        fn value(self) -> f32 {
            f32::from(u8::from(self))
        }
    }
}

/// Borrowed samples of one layer, with one or more channels per pixel.
///
/// Made from
/// - a contiguous slice, row-major from the top, channels interleaved: `(&rgb[..]).into()`;
/// - an array of such slices, one for each channel: `[&x[..], &y, &z].into()`;
/// - an `ndarray` view, `[row, column]` or `[row, column, channel]`, with any strides: padded rows, bottom-up rows,
///   channels to skip; for planes stacked as `[channel, row, column]` use `permuted_axes([1, 2, 0])`;
/// - a [`Plane`] or a [`Mask`], or an array of planes.
///
/// [`FrameBuilder::build`](super::FrameBuilder::build) checks that they match the frame.
pub struct Samples<'a> {
    channels: Box<dyn Channels + 'a>,
    /// Largest rounding error of a value in -1..1.
    pub(crate) rounding: f32,
    is_integer: bool,
}

impl<'a> Samples<'a> {
    fn of<T: Sample>(layout: Layout<'a, T>) -> Self {
        Self {
            channels: Box::new(layout),
            rounding: T::ROUNDING,
            is_integer: T::IS_INTEGER,
        }
    }

    /// One plane per channel of the layer that messages call `name`; `accepted` lists the permitted numbers of
    /// channels.
    pub(crate) fn planes(&self, name: Name, size: Size, accepted: &[usize]) -> Result<Vec<Plane>> {
        let channels = self.channels.count(name, size, accepted)?;
        let planes = (0..channels).map(|channel| self.channels.plane(size, channels, channel));
        Ok(planes.collect())
    }

    /// The only plane of a layer.
    pub(crate) fn plane(&self, name: Name, size: Size) -> Result<Plane> {
        Ok(self.planes(name, size, &[1])?.remove(0))
    }

    /// Whether all samples are half floats.
    pub(crate) fn is_half(&self) -> bool {
        !self.is_integer && self.rounding > 0.0
    }

    /// Whether all samples are 8-bit integers.
    pub(super) fn is_coarse(&self) -> bool {
        self.is_integer && self.rounding == <u8 as stored::Stored>::ROUNDING
    }

    /// Refuses integers for linear light.
    pub(super) fn refuse_integers(&self, name: Name) -> Result<()> {
        if !self.is_integer {
            return Ok(());
        }
        Err(bad(
            name,
            "holds integers, which are rarely linear light".into(),
            "decode it, as with io::srgb::decoded, and give f32",
        ))
    }
}

/// The argument named in messages.
pub(crate) type Name = &'static str;

/// Columns and rows.
pub(crate) type Size = [usize; 2];

pub(super) fn bad(name: Name, found: String, remedy: &str) -> Error {
    Error::BadParameter {
        name,
        found,
        remedy: remedy.into(),
    }
}

/// Samples with their type erased.
trait Channels {
    /// The number of channels, if the samples cover a frame of this size.
    fn count(&self, name: Name, size: Size, accepted: &[usize]) -> Result<usize>;
    /// A channel of `channels`, as a plane.
    fn plane(&self, size: Size, channels: usize, channel: usize) -> Plane;
}

enum Layout<'a, T> {
    /// Interleaved channels, contiguous.
    Packed(&'a [T]),
    /// A contiguous slice per channel.
    Planes(Vec<&'a [T]>),
    /// `[row, column]`, one per channel.
    Views(Vec<ArrayView2<'a, T>>),
}

impl<T: Sample> Channels for Layout<'_, T> {
    fn count(&self, name: Name, [width, height]: Size, accepted: &[usize]) -> Result<usize> {
        let pixels = width * height;
        let wanted = one_of(accepted);
        let short = |held: usize| {
            let found = format!("holds {held} samples for {width}x{height} pixels");
            let remedy = format!("give {wanted} for each pixel, or a view where there are gaps");
            bad(name, found, &remedy)
        };
        let count = match self {
            Self::Packed(slice) => {
                let count = accepted
                    .iter()
                    .find(|&&count| count * pixels == slice.len());
                return count.copied().ok_or_else(|| short(slice.len()));
            }
            Self::Planes(slices) => slices.len(),
            Self::Views(views) => views.len(),
        };
        if !accepted.contains(&count) {
            let found = format!("has {count} channels");
            return Err(bad(name, found, &format!("give {wanted}")));
        }
        match self {
            Self::Packed(_) => unreachable!("returned above"),
            Self::Planes(slices) => match slices.iter().find(|slice| slice.len() != pixels) {
                Some(slice) => {
                    let found = format!(
                        "has a channel of {} samples for {width}x{height} pixels",
                        slice.len()
                    );
                    Err(bad(name, found, "give one sample for each pixel"))
                }
                None => Ok(count),
            },
            Self::Views(views) => match views[0].dim() == (height, width) {
                true => Ok(count),
                false => {
                    let (rows, columns) = views[0].dim();
                    let found = format!("is {rows} rows of {columns}, for {width}x{height} pixels");
                    Err(bad(
                        name,
                        found,
                        "give an array indexed [row, column] of the frame's size",
                    ))
                }
            },
        }
    }

    fn plane(&self, [width, height]: Size, channels: usize, channel: usize) -> Plane {
        let mut plane = Plane::filled(width, height, 0.0);
        plane.each_row(|y, row| match self {
            Self::Packed(slice) => {
                let stored = &slice[y * width * channels..][channel..];
                fill(row, stored.iter().step_by(channels));
            }
            Self::Planes(slices) => fill(row, &slices[channel][y * width..]),
            Self::Views(views) => fill(row, views[channel].row(y)),
        });
        plane
    }
}

/// Decodes samples into a row.
fn fill<'a, T: Sample + 'a>(row: &mut [f32], stored: impl IntoIterator<Item = &'a T>) {
    for (value, stored) in row.iter_mut().zip(stored) {
        *value = stored.value();
    }
}

/// "1", "1 or 3", "1, 3 or 4".
fn one_of(counts: &[usize]) -> String {
    let words: Vec<String> = counts.iter().map(usize::to_string).collect();
    match words.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

impl<'a, T: Sample> From<&'a [T]> for Samples<'a> {
    fn from(slice: &'a [T]) -> Self {
        Self::of(Layout::Packed(slice))
    }
}

impl<'a, T: Sample> From<&'a Vec<T>> for Samples<'a> {
    fn from(samples: &'a Vec<T>) -> Self {
        Self::from(samples.as_slice())
    }
}

impl<'a, T: Sample, const N: usize> From<[&'a [T]; N]> for Samples<'a> {
    fn from(slices: [&'a [T]; N]) -> Self {
        Self::of(Layout::Planes(slices.to_vec()))
    }
}

impl<'a, T: Sample> From<&'a Plane<T>> for Samples<'a> {
    fn from(plane: &'a Plane<T>) -> Self {
        Self::from(plane.view())
    }
}

impl<'a, T: Sample, const N: usize> From<[&'a Plane<T>; N]> for Samples<'a> {
    fn from(planes: [&'a Plane<T>; N]) -> Self {
        Self::of(Layout::Views(planes.map(Plane::view).to_vec()))
    }
}

impl<'a> From<&'a Mask> for Samples<'a> {
    fn from(mask: &'a Mask) -> Self {
        Self::from(mask.plane())
    }
}

impl<'a, T: Sample> From<ArrayView2<'a, T>> for Samples<'a> {
    fn from(view: ArrayView2<'a, T>) -> Self {
        Self::of(Layout::Views(vec![view]))
    }
}

impl<'a, T: Sample> From<&'a Array2<T>> for Samples<'a> {
    fn from(array: &'a Array2<T>) -> Self {
        Self::from(array.view())
    }
}

impl<'a, T: Sample> From<ArrayView3<'a, T>> for Samples<'a> {
    fn from(view: ArrayView3<'a, T>) -> Self {
        let channels = 0..view.len_of(Axis(2));
        let channel = |c| view.index_axis_move(Axis(2), c);
        Self::of(Layout::Views(channels.map(channel).collect()))
    }
}

impl<'a, T: Sample> From<&'a Array3<T>> for Samples<'a> {
    fn from(array: &'a Array3<T>) -> Self {
        Self::from(array.view())
    }
}
