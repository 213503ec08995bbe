//! Outcomes: planes of the descriptor, a picture, a drawing, by name and by product.

use crate::frame::{
    ColorPlanes, CurvaturePlanes, Frame, Plane, SymmetricPlanes, Vector2Planes, Vector3Planes,
    Window,
};
use crate::params::{LineLevels, Params, ToneLevels};
use crate::plan::drawing::Drawing;
use crate::product::Product;
use std::time::Duration;

/// The products of the descriptor, with the field for each.
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
            /// The planes of a product; none of one that is not there.
            pub(crate) fn planes(&self, product: Product) -> Vec<&Plane> {
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

            /// Moves a product to another shape, in place of that one's.
            pub(crate) fn hand_over(&mut self, product: Product, to: &mut Self) {
                match product {
                    $(Product::$product => to.$field = self.$field.take(),)*
                    _ => {}
                }
            }

            /// Takes out the planes of all products but those `kept`.
            pub(crate) fn take_others(&mut self, kept: &[Product]) -> Vec<Plane> {
                let mut taken = Vec::new();
                $(if !kept.contains(&Product::$product) {
                    let mut left = self.$field.take();
                    taken.extend(left.planes_mut().into_iter().map(std::mem::take));
                })*
                taken
            }

            #[cfg(any(feature = "cli", feature = "gpu"))]
            fn put(&mut self, product: Product, planes: &mut dyn Iterator<Item = Plane>) {
                match product {
                    $(Product::$product => self.$field = ProductPlanes::of_planes(planes),)*
                    _ => {}
                }
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
    /// Depth gradient at the requested scale, y up.
    Gradient: gradient of Vector2Planes;
    /// Trace of the Hessian, per pixel; convex is negative.
    Trace: trace of Plane;
    /// Hessian of the height, per pixel, y up; convex is negative.
    Hessian: hessian of SymmetricPlanes;
    /// Principal and mean curvature, per pixel.
    Curvature: curvatures of CurvaturePlanes;
    /// Mapped curvature, -1..1; **convex is positive**.
    MappedCurvature: kappa of Plane;
    /// Direction, in the picture, of the surface's own principal curvature of larger magnitude: unit vectors, x right,
    /// y up, opposite directions being equal; 0 outside the mask. Where the surface has none it fades within 96 pixels
    /// from its neighbours' direction to a fixed one.
    Direction: direction of Vector2Planes;
    /// Direction of the view-centred curvature (of the Hessian) of larger magnitude, in the same form; 0 where there is
    /// none.
    ViewDirection: direction_view of Vector2Planes;
    /// Height toward the viewer, if asked for by name: with depth its negative, in its unit, with the detail of the
    /// normals; else in pixels, with mean 0 over each connected surface. 0 outside the mask. In a region of a frame it
    /// is that of the region alone.
    Height: height of Plane;
    /// How far the change of that height from pixel to pixel is from what the normals say; in perspective relative to
    /// the distance.
    HeightResidual: height_residual of Plane;
    /// The share of the sky's cosine-weighted light that arrives, 0..1, if asked for by name.
    Sky: sky of Plane;
    /// The unit direction in view space from which that light arrives on average.
    BentNormal: bent of Vector3Planes;
}

/// Curvature at one of several scales.
#[derive(Debug, Clone)]
pub struct ScaleShape {
    /// Sigma of the scale in pixels of the reference.
    pub sigma_px: f32,
    /// Principal and mean curvatures.
    pub curvatures: CurvaturePlanes,
    /// Mapped curvature, with the gain of the first scale.
    pub kappa: Plane,
}

/// The result of a run.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// The descriptor.
    pub shape: Shape,
    /// The picture: enhanced, relit, or the curvature display; for a drawing, the picture that gives its tone.
    pub color: Option<ColorPlanes>,
    /// The drawing.
    pub drawing: Option<Drawing>,
    /// The gain used for the curvature mapping.
    pub gain: Option<f32>,
    /// The white level used.
    pub white_level: Option<f32>,
    /// The levels that shape-showing tones were fitted to, in the order of [`ToneLevels`].
    pub tone_levels: Option<[f32; ToneLevels::COUNT]>,
    /// The levels that widths of interior lines were fitted to, in the order of [`LineLevels`].
    pub line_levels: Option<[f32; LineLevels::COUNT]>,
    /// The gain used for the environment's radiance.
    pub environment_gain: Option<f32>,
    /// Whether the surface has the colours of the frame's picture, in new light: a display keeps its brightness.
    pub(crate) takes_picture: bool,
    /// Whether lamps cast shadows, and what light from all around, where that was chosen.
    pub(crate) casts_shadows: [Option<bool>; 2],
    /// The lights and samples that stand for the environment, where they were chosen by their error.
    pub light_choice: Option<LightChoice>,
    /// The luminance that light met by traced sight lines was compared with, if it was.
    pub middle_light: Option<f32>,
    /// The white levels used where each term of the light has its own, by term.
    pub term_white_levels: Vec<(&'static str, f32)>,
    /// The number of blocks that diffusion left out, as nothing flows in them, and of all.
    pub left_out: [usize; 2],
    /// The time of each pass, in order.
    pub timings: Vec<(&'static str, Duration)>,
    /// How it goes to a file, if a request was run.
    pub(crate) sheet: Option<Box<FileSheet>>,
}

/// What was chosen to stand for an environment, and its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightChoice {
    /// Number of lights.
    pub lights: usize,
    /// Number of samples of the highlight at each pixel.
    pub samples: usize,
    /// Error on a ball of albedo 0.5, in grey levels of 255, for 99 of 100 of its normals.
    pub levels: f32,
}

impl std::fmt::Display for LightChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} lights", self.lights)?;
        if self.samples > 0 {
            write!(f, " + {} samples", self.samples)?;
        }
        write!(f, ": {:.1} levels", self.levels)
    }
}

/// What files of an outcome take beside its planes.
#[derive(Debug, Clone)]
pub(crate) struct FileSheet {
    pub(crate) params: Params,
    pub(crate) shows: Shows,
    /// That of the frame, enlarged as the drawing is.
    pub(crate) extent: PageExtent,
}

/// The windows of a result.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PageExtent {
    pub(crate) data_window: Window,
    pub(crate) display_window: Window,
    pub(crate) pixel_aspect: f32,
}

impl From<&Frame> for PageExtent {
    fn from(frame: &Frame) -> Self {
        Self {
            data_window: frame.data_window,
            display_window: frame.display_window,
            pixel_aspect: frame.pixel_aspect,
        }
    }
}

/// What the picture of an outcome is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shows {
    /// There is none, but layers.
    Layers,
    /// The curvature display.
    Curvature,
    /// The frame's picture, enhanced.
    Enhanced,
    /// The surface in new light.
    Relit,
    /// A drawing.
    Drawing,
}

/// The planes of a product.
trait ProductPlanes {
    fn planes(&self) -> Vec<&Plane>;
    fn planes_mut(&mut self) -> Vec<&mut Plane>;
    #[cfg(any(feature = "cli", feature = "gpu"))]
    fn of_planes(planes: &mut dyn Iterator<Item = Plane>) -> Self;
}

/// Planes as fields of a struct, in the order of the product's components.
macro_rules! planes {
    ($($type:ty { $($field:tt),+ })*) => {$(
        impl ProductPlanes for $type {
            fn planes(&self) -> Vec<&Plane> {
                vec![$(&self.$field),+]
            }

            fn planes_mut(&mut self) -> Vec<&mut Plane> {
                vec![$(&mut self.$field),+]
            }

            #[cfg(any(feature = "cli", feature = "gpu"))]
            fn of_planes(planes: &mut dyn Iterator<Item = Plane>) -> Self {
                Self { $($field: Plane::of_planes(planes)),+ }
            }
        }
    )*};
}

planes! {
    Vector2Planes { x, y }
    Vector3Planes { x, y, z }
    SymmetricPlanes { xx, xy, yy }
    CurvaturePlanes { u, v, mean }
    ColorPlanes { r, g, b }
}

impl ProductPlanes for Plane {
    fn planes(&self) -> Vec<&Plane> {
        vec![self]
    }

    fn planes_mut(&mut self) -> Vec<&mut Plane> {
        vec![self]
    }

    #[cfg(any(feature = "cli", feature = "gpu"))]
    fn of_planes(planes: &mut dyn Iterator<Item = Plane>) -> Self {
        planes.next().expect("every component is there")
    }
}

impl<P: ProductPlanes> ProductPlanes for Option<P> {
    fn planes(&self) -> Vec<&Plane> {
        self.as_ref().map_or_else(Vec::new, ProductPlanes::planes)
    }

    fn planes_mut(&mut self) -> Vec<&mut Plane> {
        self.as_mut()
            .map_or_else(Vec::new, ProductPlanes::planes_mut)
    }

    #[cfg(any(feature = "cli", feature = "gpu"))]
    fn of_planes(planes: &mut dyn Iterator<Item = Plane>) -> Self {
        Some(P::of_planes(planes))
    }
}

/// The planes of a product in their field: shared or mutable.
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
    /// The planes of a product, one per component; none if it was not computed.
    pub fn planes(&self, product: Product) -> Vec<&Plane> {
        held!(self, product, planes, as_ref)
    }

    fn planes_mut(&mut self, product: Product) -> Vec<&mut Plane> {
        held!(self, product, planes_mut, as_mut)
    }

    /// Moves a product of the descriptor, or a picture, out of the front of `planes`.
    #[cfg(any(feature = "cli", feature = "gpu"))]
    pub(crate) fn put(&mut self, product: Product, planes: &mut dyn Iterator<Item = Plane>) {
        match product {
            Product::Picture => self.color = ProductPlanes::of_planes(planes),
            // Drawings are assembled together with their lines.
            Product::Strokes | Product::Contours | Product::Interior => {}
            of_shape => self.shape.put(of_shape, planes),
        }
    }

    /// Moves the curvature at a further scale out of the front of `planes`.
    #[cfg(any(feature = "cli", feature = "gpu"))]
    pub(crate) fn put_scale(&mut self, sigma_px: f32, planes: &mut dyn Iterator<Item = Plane>) {
        self.shape.more_scales.push(ScaleShape {
            sigma_px,
            curvatures: ProductPlanes::of_planes(planes),
            kappa: ProductPlanes::of_planes(planes),
        });
    }

    /// All products that were computed, further scales after the first.
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

    /// The shape with planes that `change` makes of its own, and the gain chosen for it.
    #[cfg(feature = "cli")]
    pub(crate) fn shape_mapped(&self, change: impl Fn(&Plane) -> Plane) -> Self {
        let mut made = Self {
            gain: self.gain,
            ..Self::default()
        };
        for product in Product::all().filter(|product| *product < Product::Picture) {
            let planes = self.shape.planes(product);
            if !planes.is_empty() {
                made.put(product, &mut planes.into_iter().map(&change));
            }
        }
        for ScaleShape {
            sigma_px,
            curvatures,
            kappa,
        } in &self.shape.more_scales
        {
            let planes = curvatures.planes().into_iter().chain([kappa]);
            made.put_scale(*sigma_px, &mut planes.map(&change));
        }
        made
    }

    /// The same for another window, with planes of zeros.
    pub(crate) fn blank(&self, window: Window) -> Self {
        let mut blank = Self {
            left_out: [0; 2],
            timings: Vec::new(),
            ..self.clone()
        };
        blank.for_each_plane(|plane| {
            *plane = Plane::filled(window.width(), window.height(), 0.0);
        });
        blank
    }

    /// Lays the planes of a `part` of the window `whole` in their place.
    pub(crate) fn paste(&mut self, part: &Self, whole: Window, at: Window) {
        let lay = |all: Vec<&mut Plane>, part: Vec<&Plane>| {
            let planes = all.into_iter().zip(part);
            planes.for_each(|(all, part)| all.paste(whole, at, part, at));
        };
        for product in Product::all() {
            lay(self.planes_mut(product), part.planes(product));
            let scales = self.shape.more_scales.iter_mut();
            for (all, part) in scales.zip(&part.shape.more_scales) {
                lay(all.planes_mut(product), part.planes(product));
            }
        }
        let sums = self.left_out.iter_mut().zip(part.left_out);
        sums.for_each(|(sum, left_out)| *sum += left_out);
    }

    /// The first plane of a product, of most the only one; `None` if it was not computed.
    pub fn plane(&self, product: Product) -> Option<&Plane> {
        self.planes(product).first().copied()
    }

    /// The picture, if one was computed: `None` if the frame's own is unchanged.
    pub fn picture(&self) -> Option<&ColorPlanes> {
        self.color.as_ref()
    }

    /// All planes of the outcome.
    pub(crate) fn into_planes(mut self) -> Vec<Plane> {
        let mut planes = Vec::new();
        self.for_each_plane(|plane| planes.push(std::mem::take(plane)));
        planes
    }
}

impl ScaleShape {
    /// The planes of a product at this scale; none of one that is made at the first alone.
    pub(crate) fn planes(&self, product: Product) -> Vec<&Plane> {
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
