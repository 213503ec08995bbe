//! Outcomes: planes of the descriptor, a picture, a drawing, by name and by product.

use crate::engine::slot::Slot;
use crate::frame::{ColorPlanes, CurvaturePlanes, Plane, SymmetricPlanes, Vector2Planes, Window};
use crate::line::contours::Contour;
use crate::line::stippling::Dot;
use crate::line::streamlines::Streamline;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::params::{LineLevels, ToneLevels};
use crate::product::Product;
use glam::Vec2;
use std::time::Duration;

/// The products of the descriptor: the field that holds each, and what is kept of it for the next run of a frame.
macro_rules! shape_products {
    ($($(#[doc = $doc:literal])+ $product:ident: $field:ident of $planes:ty;)*) => {
        /// The planes of the shape descriptor that a plan wants, and those computed on the way.
        ///
        /// Curvature is per pixel; where a [reference height](crate::params::ShapeParams::reference_height) is
        /// given it is per pixel of the reference.
        #[derive(Debug, Clone, Default)]
        pub struct Shape {
            $($(#[doc = $doc])+ pub $field: Option<$planes>,)*
            /// Curvature at further scales.
            pub more_scales: Vec<ScaleShape>,
        }

        impl Shape {
            fn planes(&self, product: Product) -> Vec<&Plane> {
                match product {
                    $(Product::$product => self.$field.planes(),)*
                    _ => Vec::new(),
                }
            }

            fn planes_mut(&mut self, product: Product) -> Vec<&mut Plane> {
                match product {
                    $(Product::$product => self.$field.planes_mut(),)*
                    _ => Vec::new(),
                }
            }

            #[cfg(feature = "gpu")]
            fn put(&mut self, product: Product, planes: &mut dyn Iterator<Item = Plane>) {
                match product {
                    $(Product::$product => self.$field = Planes::of_planes(planes),)*
                    _ => {}
                }
            }
        }

        /// Products of the descriptor that the next run of the same frame may use.
        #[derive(Debug, Default)]
        pub(crate) struct ShapeSlots {
            $(pub(crate) $field: Slot<$planes>,)*
        }

        impl ShapeSlots {
            /// Takes back what stages have asked for here; the rest is memory.
            pub(crate) fn recycle(&mut self, shape: &mut Shape) {
                $(self.$field.put_from(&mut shape.$field);)*
            }
        }
    };
}

shape_products! {
    /// Silhouette weight, 0..1.
    Silhouette: silhouette of Plane;
    /// Crease weight, 0..1.
    Crease: crease of Plane;
    /// Conductance, 0..1; 0 outside the mask.
    Conductance: conductance of Plane;
    /// Depth gradient at the scale asked for, y up.
    Gradient: gradient of Vector2Planes;
    /// Trace of the Hessian, per pixel; convex is negative.
    Trace: trace of Plane;
    /// Hessian of the height, per pixel, y up; convex is negative.
    Hessian: hessian of SymmetricPlanes;
    /// Principal and mean curvature, per pixel.
    Curvature: curvatures of CurvaturePlanes;
    /// Mapped curvature, -1..1; **convex is positive**.
    MappedCurvature: kappa of Plane;
    /// Direction, in the picture, of the surface's own principal curvature of larger magnitude: unit, x right, y up, equal
    /// to its opposite; 0 outside the mask. Where the surface has none it fades within 96 pixels from its neighbours'
    /// direction to a fixed one.
    Direction: direction of Vector2Planes;
    /// Direction of the view-centred curvature (of the Hessian) of larger magnitude, likewise; 0 where there is none.
    ViewDirection: direction_view of Vector2Planes;
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
    /// The strokes as vector lines, where [they are laid one by one](crate::params::Style::is_laid).
    pub lines: Vec<Streamline>,
    /// The strokes as dots, for styles of dots.
    pub dots: Vec<Dot>,
    /// Lines along silhouettes and creases, where they were asked for; also outside the mask.
    pub contours: Option<Plane>,
    /// These as vector lines, silhouettes first.
    pub contour_lines: Vec<Contour>,
    /// Lines inside surfaces, where they were asked for.
    pub interior: Option<Plane>,
    /// These as vector lines.
    pub interior_lines: Vec<Contour>,
    /// Target coverage of the strokes, 0..1, where tone shows the shape.
    pub asked: Option<Plane>,
    /// Luminance of paper white that was used.
    pub white_point: f32,
    /// Where the texture of strokes lies, for the next frame of a sequence.
    pub coordinates: Option<TextureCoordinates>,
}

impl Drawing {
    /// All layers, composited.
    pub fn layers(&self) -> Vec<&Plane> {
        let lines = self.contours.iter().chain(&self.interior);
        std::iter::once(&self.hatching).chain(lines).collect()
    }
}

/// The result of a run.
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
    /// The levels that tones showing the shape were fit to, in the order of [`ToneLevels`].
    pub tone_levels: Option<[f32; ToneLevels::COUNT]>,
    /// The levels that widths of interior lines were fit to, in the order of [`LineLevels`].
    pub line_levels: Option<[f32; LineLevels::COUNT]>,
    /// The factor of the environment's radiance that was used.
    pub environment_gain: Option<f32>,
    /// The white levels that were used where each term of the light has its own, with the terms' names.
    pub term_white_levels: Vec<(&'static str, f32)>,
    /// How long each pass took, in order.
    pub timings: Vec<(&'static str, Duration)>,
}

/// Adds times to those of the same passes.
pub(crate) fn add_timings(
    sum: &mut Vec<(&'static str, Duration)>,
    more: &[(&'static str, Duration)],
) {
    for &(pass, time) in more {
        match sum.iter_mut().find(|(name, _)| *name == pass) {
            Some((_, sum)) => *sum += time,
            None => sum.push((pass, time)),
        }
    }
}

/// The planes of a product.
trait Planes {
    fn planes(&self) -> Vec<&Plane>;
    fn planes_mut(&mut self) -> Vec<&mut Plane>;
    #[cfg(feature = "gpu")]
    fn of_planes(planes: &mut dyn Iterator<Item = Plane>) -> Self;
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

            #[cfg(feature = "gpu")]
            fn of_planes(planes: &mut dyn Iterator<Item = Plane>) -> Self {
                Self { $($field: Plane::of_planes(planes)),+ }
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

    #[cfg(feature = "gpu")]
    fn of_planes(planes: &mut dyn Iterator<Item = Plane>) -> Self {
        planes.next().expect("every component is there")
    }
}

impl<P: Planes> Planes for Option<P> {
    fn planes(&self) -> Vec<&Plane> {
        self.as_ref().map_or_else(Vec::new, Planes::planes)
    }

    fn planes_mut(&mut self) -> Vec<&mut Plane> {
        self.as_mut().map_or_else(Vec::new, Planes::planes_mut)
    }

    #[cfg(feature = "gpu")]
    fn of_planes(planes: &mut dyn Iterator<Item = Plane>) -> Self {
        Some(P::of_planes(planes))
    }
}

/// The planes of a product, where it is at home: read, or to be changed.
macro_rules! held {
    ($outcome:ident, $product:ident, $planes:ident, $as_ref:ident) => {{
        let drawing = $outcome.drawing.$as_ref();
        match $product {
            Product::Picture => $outcome.color.$planes(),
            Product::Strokes => drawing.map_or_else(Vec::new, |drawing| drawing.hatching.$planes()),
            Product::Contours => {
                drawing.map_or_else(Vec::new, |drawing| drawing.contours.$planes())
            }
            Product::Interior => {
                drawing.map_or_else(Vec::new, |drawing| drawing.interior.$planes())
            }
            of_shape => $outcome.shape.$planes(of_shape),
        }
    }};
}

impl Outcome {
    /// The planes of a product, one a component; none where it was not made.
    pub fn planes(&self, product: Product) -> Vec<&Plane> {
        held!(self, product, planes, as_ref)
    }

    /// The same with those of further scales.
    pub(crate) fn at_all_scales(&self, product: Product) -> impl Iterator<Item = &Plane> {
        let scales = self.shape.more_scales.iter();
        let more = scales.flat_map(move |scale| scale.planes(product));
        self.planes(product).into_iter().chain(more)
    }

    fn planes_mut(&mut self, product: Product) -> Vec<&mut Plane> {
        held!(self, product, planes_mut, as_mut)
    }

    /// Takes a product of the descriptor, or a picture, from planes that begin with its own.
    #[cfg(feature = "gpu")]
    pub(crate) fn put(&mut self, product: Product, planes: &mut dyn Iterator<Item = Plane>) {
        match product {
            Product::Picture => self.color = Planes::of_planes(planes),
            // Drawings are put together with their lines.
            Product::Strokes | Product::Contours | Product::Interior => {}
            of_shape => self.shape.put(of_shape, planes),
        }
    }

    /// Takes curvature at a further scale from planes that begin with it.
    #[cfg(feature = "gpu")]
    pub(crate) fn put_scale(&mut self, sigma_px: f32, planes: &mut dyn Iterator<Item = Plane>) {
        self.shape.more_scales.push(ScaleShape {
            sigma_px,
            curvatures: Planes::of_planes(planes),
            kappa: Planes::of_planes(planes),
        });
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

    /// Leaves the part `to` of what was made of the window `from`.
    pub(crate) fn crop(&mut self, from: Window, to: Window) {
        self.for_each_plane(|plane| *plane = plane.crop(from, to));
        let Some(drawing) = &mut self.drawing else {
            return;
        };
        let corner = Vec2::new((to.x0 - from.x0) as f32, (to.y0 - from.y0) as f32);
        let strokes = drawing.lines.iter_mut().map(|line| &mut line.points);
        let contours = drawing.contour_lines.iter_mut();
        let contours = contours.chain(&mut drawing.interior_lines);
        let contours = contours.map(|line| &mut line.points);
        let dots = drawing.dots.iter_mut().map(|dot| &mut dot.at);
        let points = strokes.chain(contours).flatten().chain(dots);
        points.for_each(|point| *point -= corner);
    }

    /// The picture, if one was made: `None` where there was nothing to change in that of the frame.
    pub fn picture(&self) -> Option<&ColorPlanes> {
        self.color.as_ref()
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
