//! The caller's memory as a target for results.

use crate::error::{Error, Result};
use crate::frame::Plane;
use crate::product::Product;
use ndarray::{ArrayViewMut2, ArrayViewMut3, Axis};

/// The caller's memory as a target for a product: a contiguous slice, rows from the top down, components interleaved;
/// or an `ndarray` view, `[row, column]` or `[row, column, component]`, with any strides.
#[derive(Debug)]
pub struct Target<'a>(TargetLayout<'a>);

#[derive(Debug)]
enum TargetLayout<'a> {
    Packed(&'a mut [f32]),
    View(ArrayViewMut3<'a, f32>),
}

impl<'a> From<&'a mut [f32]> for Target<'a> {
    fn from(slice: &'a mut [f32]) -> Self {
        Self(TargetLayout::Packed(slice))
    }
}

impl<'a> From<&'a mut Vec<f32>> for Target<'a> {
    fn from(samples: &'a mut Vec<f32>) -> Self {
        Self::from(samples.as_mut_slice())
    }
}

impl<'a> From<ArrayViewMut3<'a, f32>> for Target<'a> {
    fn from(view: ArrayViewMut3<'a, f32>) -> Self {
        Self(TargetLayout::View(view))
    }
}

impl<'a> From<ArrayViewMut2<'a, f32>> for Target<'a> {
    fn from(view: ArrayViewMut2<'a, f32>) -> Self {
        Self(TargetLayout::View(view.insert_axis(Axis(2))))
    }
}

impl Target<'_> {
    /// Checks that a product of a picture of this size, rows first, fits.
    ///
    /// # Errors
    /// [`Error::Unfit`] if it does not.
    pub(crate) fn check(&self, product: Product, [height, width]: [usize; 2]) -> Result<()> {
        let row = product.row();
        let components = row.components.len();
        let fits = match &self.0 {
            TargetLayout::Packed(slice) => slice.len() == height * width * components,
            TargetLayout::View(view) => *view.shape() == [height, width, components],
        };
        match fits {
            true => Ok(()),
            false => Err(Error::Unfit {
                found: format!(
                    "{} has {components} components of {width}x{height} pixels, and its target has not",
                    row.name
                ),
                remedy: "give a target of this size",
            }),
        }
    }

    /// Writes the planes of a product, one per component.
    ///
    /// # Errors
    /// [`Error::Unfit`] if the product is missing or has another size.
    pub(crate) fn write(&mut self, product: Product, planes: &[&Plane]) -> Result<()> {
        let name = product.row().name;
        let Some(first) = planes.first() else {
            return Err(Error::Unfit {
                found: format!("{name} is to be written, and the run does not make it"),
                remedy: "leave it out, or ask for what has it",
            });
        };
        self.check(product, [first.height(), first.width()])?;
        let shape = [first.height(), first.width(), planes.len()];
        let mut view = match &mut self.0 {
            TargetLayout::Packed(slice) => {
                ArrayViewMut3::from_shape(shape, slice).expect("the size was checked")
            }
            TargetLayout::View(view) => view.view_mut(),
        };
        for (mut component, plane) in view.axis_iter_mut(Axis(2)).zip(planes) {
            component.assign(&plane.view());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;

    #[test]
    fn planes_go_to_any_layout_of_their_size_and_to_no_other() {
        let plane = |k: usize| Plane::from_fn(3, 2, |x, y| (100 * k + 10 * y + x) as f32);
        let planes = [plane(1), plane(2), plane(3)];
        let planes = [&planes[0], &planes[1], &planes[2]];
        let mut packed = vec![0.0; 18];
        let mut target = Target::from(&mut packed);
        target.write(Product::Picture, &planes).unwrap();
        assert_eq!(packed[3..6], [101.0, 201.0, 301.0]);
        // Component by component, as in a planar buffer.
        let mut planar = Array3::zeros([3, 2, 3]);
        let view = planar.view_mut().permuted_axes([1, 2, 0]);
        Target::from(view).write(Product::Picture, &planes).unwrap();
        assert_eq!(planar[[2, 1, 0]], 310.0);
        let mut small = vec![0.0; 17];
        let mut target = Target::from(&mut small);
        let error = target.write(Product::Picture, &planes).unwrap_err();
        assert!(error.to_string().contains("3x2 pixels"), "{error}");
        let error = target.write(Product::Strokes, &[]).unwrap_err();
        assert!(error.to_string().starts_with("strokes"), "{error}");
    }
}
