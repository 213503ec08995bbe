//! Borrowed samples in any layout and number type.

use crate::error::{Result, bad};
use crate::frame::depth::depth_of_positions;
use crate::frame::{Camera, Mask, Plane, Vector3Planes};
use ndarray::{Array2, Array3, ArrayView2, ArrayView3, ArrayViewMut1, Axis};

/// A type that samples are stored in: `f32`, `f16`, `u8`, `u16` or `bool`.
///
/// Integers map to 0..1, with the largest one as 1; `true` is 1.
pub trait Sample: Copy + stored::Stored {}

impl<T: stored::Stored> Sample for T {}

mod stored {
    use half::f16;

    /// Seals [`super::Sample`], and converts values.
    #[allow(unnameable_types, reason = "it seals `Sample`")]
    pub trait Stored: Copy + Send + Sync + Into<f32> {
        /// The value that stands for 1.
        const ONE: f32 = 1.0;
        /// Largest rounding error of a value in -1..1 stored in this type.
        const ROUNDING: f32 = 1.0 / Self::ONE;
        /// Whether it stores 0..1 only.
        const IS_INTEGER: bool = true;
    }

    impl Stored for f32 {
        const ROUNDING: f32 = 0.0;
        const IS_INTEGER: bool = false;
    }

    impl Stored for f16 {
        // Half a step between numbers just below 1.
        const ROUNDING: f32 = f16::EPSILON.to_f32_const() / 4.0;
        const IS_INTEGER: bool = false;
    }

    impl Stored for u8 {
        const ONE: f32 = 255.0;
    }

    impl Stored for u16 {
        const ONE: f32 = 65535.0;
    }

    impl Stored for bool {}
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
    planes: Box<DecodedPlanes<'a>>,
    /// Largest rounding error of a value in -1..1.
    pub(crate) rounding: f32,
    is_integer: bool,
}

/// The planes of a layer of this name in a frame of this size, if it has one of these numbers of channels.
type DecodedPlanes<'a> = dyn Fn(Name, Size, &[usize]) -> Result<Vec<Plane>> + 'a;

impl<'a> Samples<'a> {
    /// Samples of which `views` gives one view of the frame's size for each channel.
    fn of<T: Sample + 'a>(
        views: impl Fn(Name, Size, &[usize]) -> Result<Vec<ArrayView2<'a, T>>> + 'a,
    ) -> Self {
        let planes = move |name: Name, size: Size, accepted: &[usize]| {
            let views = views(name, size, accepted)?;
            Ok(views.iter().map(decoded).collect())
        };
        Self {
            planes: Box::new(planes),
            rounding: T::ROUNDING,
            is_integer: T::IS_INTEGER,
        }
    }

    /// Samples of one view for each channel.
    fn of_views<T: Sample + 'a>(views: Vec<ArrayView2<'a, T>>) -> Self {
        Self::of(move |name, [width, height], accepted| {
            check_count(name, views.len(), accepted)?;
            let mut sizes = views.iter().map(ArrayView2::dim);
            match sizes.find(|size| *size != (height, width)) {
                Some((rows, columns)) => {
                    let found = format!("is {rows} rows of {columns}, for {width}x{height} pixels");
                    let remedy = "give an array indexed [row, column] of the frame's size";
                    Err(bad(name, found, remedy))
                }
                None => Ok(views.clone()),
            }
        })
    }

    /// One plane per channel of the layer that messages call `name`; `accepted` lists the permitted numbers of
    /// channels.
    pub(crate) fn planes(&self, name: Name, size: Size, accepted: &[usize]) -> Result<Vec<Plane>> {
        (self.planes)(name, size, accepted)
    }

    /// The only plane of a layer.
    pub(crate) fn plane(&self, name: Name, size: Size) -> Result<Plane> {
        Ok(self.planes(name, size, &[1])?.remove(0))
    }

    /// Vectors of three channels; a fourth is ignored.
    pub(crate) fn vectors(&self, name: Name, size: Size) -> Result<Vector3Planes> {
        let mut planes = self.planes(name, size, &[3, 4])?;
        planes.truncate(3);
        Ok(Vector3Planes::of(planes))
    }

    /// Depths along the view axis of positions in world space.
    pub(crate) fn depths(&self, size: Size, camera: &Camera) -> Result<Plane> {
        let points = self.vectors("position", size)?;
        Ok(depth_of_positions(&points, camera))
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
            "holds integers, which are rarely linear light",
            "decode it, as with io::srgb::decoded, and give f32",
        ))
    }
}

/// The argument named in messages.
pub(crate) type Name = &'static str;

/// Columns and rows.
pub(crate) type Size = [usize; 2];

/// A view of each channel of interleaved samples, if they fill a frame of this size.
fn interleaved<'a, T>(
    slice: &'a [T],
    name: Name,
    [width, height]: Size,
    accepted: &[usize],
) -> Result<Vec<ArrayView2<'a, T>>> {
    let mut shapes = accepted.iter().map(|&count| (height, width, count));
    let view = shapes.find_map(|shape| match shape.0 * shape.1 * shape.2 == slice.len() {
        true => ArrayView3::from_shape(shape, slice).ok(),
        false => None,
    });
    view.map(channels).ok_or_else(|| {
        let found = format!("holds {} samples for {width}x{height} pixels", slice.len());
        let wanted = one_of(accepted);
        let remedy = format!("give {wanted} for each pixel, or a view where there are gaps");
        bad(name, found, remedy)
    })
}

/// A view of each channel.
fn channels<T>(view: ArrayView3<'_, T>) -> Vec<ArrayView2<'_, T>> {
    let channels = 0..view.len_of(Axis(2));
    let channel = |c| view.index_axis_move(Axis(2), c);
    channels.map(channel).collect()
}

/// Refuses a number of channels that is not accepted.
fn check_count(name: Name, count: usize, accepted: &[usize]) -> Result<()> {
    if accepted.contains(&count) {
        return Ok(());
    }
    let remedy = format!("give {}", one_of(accepted));
    Err(bad(name, format!("has {count} channels"), remedy))
}

/// The values of stored samples.
fn decoded<T: Sample>(stored: &ArrayView2<T>) -> Plane {
    let (height, width) = stored.dim();
    Plane::of_rows(width, height, |y, row| {
        let mut row = ArrayViewMut1::from(row);
        row.zip_mut_with(&stored.row(y), |value, &stored| {
            *value = stored.into() / T::ONE;
        });
    })
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
        Self::of(move |name, size, accepted| interleaved(slice, name, size, accepted))
    }
}

impl<'a, T: Sample> From<&'a Vec<T>> for Samples<'a> {
    fn from(samples: &'a Vec<T>) -> Self {
        Self::from(samples.as_slice())
    }
}

impl<'a, T: Sample, const N: usize> From<[&'a [T]; N]> for Samples<'a> {
    fn from(slices: [&'a [T]; N]) -> Self {
        Self::of(move |name, size, accepted| {
            check_count(name, N, accepted)?;
            let view = |slice| Ok(interleaved(slice, name, size, &[1])?.remove(0));
            slices.into_iter().map(view).collect()
        })
    }
}

impl<'a, T: Sample> From<&'a Plane<T>> for Samples<'a> {
    fn from(plane: &'a Plane<T>) -> Self {
        Self::from(plane.view())
    }
}

impl<'a, T: Sample, const N: usize> From<[&'a Plane<T>; N]> for Samples<'a> {
    fn from(planes: [&'a Plane<T>; N]) -> Self {
        Self::of_views(planes.map(Plane::view).to_vec())
    }
}

impl<'a> From<&'a Mask> for Samples<'a> {
    fn from(mask: &'a Mask) -> Self {
        Self::from(mask.plane())
    }
}

impl<'a, T: Sample> From<ArrayView2<'a, T>> for Samples<'a> {
    fn from(view: ArrayView2<'a, T>) -> Self {
        Self::of_views(vec![view])
    }
}

impl<'a, T: Sample> From<&'a Array2<T>> for Samples<'a> {
    fn from(array: &'a Array2<T>) -> Self {
        Self::from(array.view())
    }
}

impl<'a, T: Sample> From<ArrayView3<'a, T>> for Samples<'a> {
    fn from(view: ArrayView3<'a, T>) -> Self {
        Self::of_views(channels(view))
    }
}

impl<'a, T: Sample> From<&'a Array3<T>> for Samples<'a> {
    fn from(array: &'a Array3<T>) -> Self {
        Self::from(array.view())
    }
}
