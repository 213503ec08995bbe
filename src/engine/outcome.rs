//! What a run gives: planes of the descriptor, a picture, a drawing, by name and by product.

use crate::frame::{ColorPlanes, CurvaturePlanes, Plane, SymmetricPlanes, Vector2Planes};
use crate::line::contours::Contour;
use crate::line::streamlines::Streamline;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::product::Product;
use std::time::Duration;

/// The planes of the shape descriptor that a plan asked for, and those it needed on the way.
///
/// Curvature is per pixel; where a [reference height](crate::params::ShapeParams::reference_height) is
/// given it is per pixel of the reference.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// Silhouette weight, 0..1.
    pub silhouette: Option<Plane>,
    /// Crease weight, 0..1.
    pub crease: Option<Plane>,
    /// Conductance, 0..1; 0 outside the mask.
    pub conductance: Option<Plane>,
    /// Depth gradient at the scale asked for, y up.
    pub gradient: Option<Vector2Planes>,
    /// Trace of the Hessian, per pixel; convex is negative.
    pub trace: Option<Plane>,
    /// Hessian of the height, per pixel, y up; convex is negative.
    pub hessian: Option<SymmetricPlanes>,
    /// Principal and mean curvature, per pixel.
    pub curvatures: Option<CurvaturePlanes>,
    /// Mapped curvature, -1..1; **convex is positive**.
    pub kappa: Option<Plane>,
    /// Curvature at further scales.
    pub more_scales: Vec<ScaleShape>,
    /// Direction, in the picture, of the curvature of the surface itself that is larger in size: unit,
    /// x right, y up, equal to its opposite; 0 outside the mask. Where the surface has none it turns from that
    /// of its neighbours to a fixed one, within `FILL_REACH_PX`.
    pub direction: Option<Vector2Planes>,
    /// Direction of the view-centred curvature (of the Hessian) larger in size, likewise; 0 where there
    /// is none.
    pub direction_view: Option<Vector2Planes>,
}

/// Curvature at one of several scales.
#[derive(Debug, Clone)]
pub struct ScaleShape {
    /// Sigma of the scale in pixels of the reference.
    pub sigma_px: f32,
    /// Principal and mean curvatures.
    pub curvatures: CurvaturePlanes,
    /// Mapped curvature, by the gain of the first scale.
    pub kappa: Plane,
}

/// A drawing in layers: how much of the paper each covers, 0..1; 0 outside the mask.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// Strokes along the curvature.
    pub hatching: Plane,
    /// The same as lines, for [`crate::params::Style::Lines`].
    pub lines: Vec<Streamline>,
    /// Lines along silhouettes and creases, where they were asked for; also outside the mask.
    pub contours: Option<Plane>,
    /// The same as lines, silhouettes first.
    pub contour_lines: Vec<Contour>,
    /// Luminance of paper white that was used.
    pub white_point: f32,
    /// Where the texture of strokes lies, for the next frame of a sequence.
    pub coordinates: Option<TextureCoordinates>,
}

/// What a run gave.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// The descriptor.
    pub shape: Shape,
    /// The picture with its shape brought out, in new light, or the curvature display; where it is drawn,
    /// the tone of the drawing.
    pub color: Option<ColorPlanes>,
    /// The drawing.
    pub drawing: Option<Drawing>,
    /// The gain of the curvature mapping that was used.
    pub gain: Option<f32>,
    /// The white level that was used.
    pub white_level: Option<f32>,
    /// The factor of the environment's radiance that was used.
    pub environment_gain: Option<f32>,
    /// The white levels that were used where each term of the light has its own, with the terms' names.
    pub term_white_levels: Vec<(&'static str, f32)>,
    /// How long each pass took, in order.
    pub timings: Vec<(&'static str, Duration)>,
}

/// What holds the planes of a product.
trait Planes {
    fn planes(&self) -> Vec<&Plane>;
    fn planes_mut(&mut self) -> Vec<&mut Plane>;
}

/// Planes as the fields of a struct, in the order of the product's components.
macro_rules! planes {
    ($($type:ty { $($field:tt),+ })*) => {$(
        impl Planes for $type {
            fn planes(&self) -> Vec<&Plane> {
                vec![$(&self.$field),+]
            }

            fn planes_mut(&mut self) -> Vec<&mut Plane> {
                vec![$(&mut self.$field),+]
            }
        }
    )*};
}

planes! {
    Vector2Planes { x, y }
    SymmetricPlanes { xx, xy, yy }
    CurvaturePlanes { u, v, mean }
    ColorPlanes { r, g, b }
}

impl Planes for Plane {
    fn planes(&self) -> Vec<&Plane> {
        vec![self]
    }

    fn planes_mut(&mut self) -> Vec<&mut Plane> {
        vec![self]
    }
}

impl<P: Planes> Planes for Option<P> {
    fn planes(&self) -> Vec<&Plane> {
        self.as_ref().map_or_else(Vec::new, Planes::planes)
    }

    fn planes_mut(&mut self) -> Vec<&mut Plane> {
        self.as_mut().map_or_else(Vec::new, Planes::planes_mut)
    }
}

/// The planes of a product, where it is at home: read, or to be changed.
macro_rules! held {
    ($outcome:ident, $product:ident, $planes:ident, $as_ref:ident) => {
        match $product {
            Product::Silhouette => $outcome.shape.silhouette.$planes(),
            Product::Crease => $outcome.shape.crease.$planes(),
            Product::Conductance => $outcome.shape.conductance.$planes(),
            Product::Gradient => $outcome.shape.gradient.$planes(),
            Product::Trace => $outcome.shape.trace.$planes(),
            Product::Hessian => $outcome.shape.hessian.$planes(),
            Product::Curvature => $outcome.shape.curvatures.$planes(),
            Product::MappedCurvature => $outcome.shape.kappa.$planes(),
            Product::Direction => $outcome.shape.direction.$planes(),
            Product::ViewDirection => $outcome.shape.direction_view.$planes(),
            Product::Picture => $outcome.color.$planes(),
            Product::Strokes => {
                let drawing = $outcome.drawing.$as_ref();
                drawing.map_or_else(Vec::new, |drawing| drawing.hatching.$planes())
            }
            Product::Contours => {
                let drawing = $outcome.drawing.$as_ref();
                drawing.map_or_else(Vec::new, |drawing| drawing.contours.$planes())
            }
        }
    };
}

impl Outcome {
    /// The planes of a product, one a component; none where it was not made.
    pub fn planes(&self, product: Product) -> Vec<&Plane> {
        held!(self, product, planes, as_ref)
    }

    fn planes_mut(&mut self, product: Product) -> Vec<&mut Plane> {
        held!(self, product, planes_mut, as_mut)
    }

    /// All products that were made, those of further scales after that of the first.
    pub fn products(&self) -> impl Iterator<Item = (Product, Vec<&Plane>)> {
        let made = Product::all().flat_map(|product| {
            let scales = self.shape.more_scales.iter();
            let scales = scales.map(move |scale| scale.planes(product));
            let all = std::iter::once(self.planes(product)).chain(scales);
            all.map(move |planes| (product, planes))
        });
        made.filter(|(_, planes)| !planes.is_empty())
    }

    /// Changes every plane.
    pub(crate) fn for_each_plane(&mut self, mut change: impl FnMut(&mut Plane)) {
        for product in Product::all() {
            self.planes_mut(product).into_iter().for_each(&mut change);
            for scale in &mut self.shape.more_scales {
                scale.planes_mut(product).into_iter().for_each(&mut change);
            }
        }
    }

    /// Changes every plane by that of an outcome of the same plan.
    #[cfg(feature = "gpu")]
    pub(crate) fn for_each_pair(&mut self, of: &Self, mut change: impl FnMut(&mut Plane, &Plane)) {
        let mut pairs = |planes: Vec<&mut Plane>, of: Vec<&Plane>| {
            let pairs = planes.into_iter().zip(of);
            pairs.for_each(|(plane, of)| change(plane, of));
        };
        for product in Product::all() {
            pairs(self.planes_mut(product), of.planes(product));
            let scales = self.shape.more_scales.iter_mut();
            for (scale, of) in scales.zip(&of.shape.more_scales) {
                pairs(scale.planes_mut(product), of.planes(product));
            }
        }
    }

    /// All of its planes.
    pub(crate) fn into_planes(mut self) -> Vec<Plane> {
        let mut planes = Vec::new();
        self.for_each_plane(|plane| planes.push(std::mem::take(plane)));
        planes
    }
}

impl ScaleShape {
    fn planes(&self, product: Product) -> Vec<&Plane> {
        match product {
            Product::Curvature => self.curvatures.planes(),
            Product::MappedCurvature => self.kappa.planes(),
            _ => Vec::new(),
        }
    }

    fn planes_mut(&mut self, product: Product) -> Vec<&mut Plane> {
        match product {
            Product::Curvature => self.curvatures.planes_mut(),
            Product::MappedCurvature => self.kappa.planes_mut(),
            _ => Vec::new(),
        }
    }

    /// The channels of an EXR that hold it, with their planes.
    pub fn channels(&self) -> impl Iterator<Item = (String, &Plane)> {
        Product::all()
            .flat_map(|product| product.channels_at(self.sigma_px).zip(self.planes(product)))
    }
}
