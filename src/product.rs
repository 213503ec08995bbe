//! The table of products, shared by EXR layers, the viewer's list and probe, device read-back, comparisons between
//! backends and memory recycling.

use serde::Serialize;

/// Name of the part that holds our results, of the layer that holds a picture beside others, and prefix of full names.
pub(crate) const PART: &str = "relievo";

/// A named result of a run: one or more planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Product {
    /// Silhouette weight.
    Silhouette,
    /// Crease weight.
    Crease,
    /// Conductance.
    Conductance,
    /// The gradient after diffusion.
    Gradient,
    /// Trace of the Hessian.
    Trace,
    /// The Hessian.
    Hessian,
    /// Principal and mean curvature.
    Curvature,
    /// Mapped curvature.
    MappedCurvature,
    /// Direction of the principal curvature of the surface.
    Direction,
    /// Direction of the view-centred curvature.
    ViewDirection,
    /// Height toward the viewer.
    Height,
    /// What the height misses of the slopes.
    HeightResidual,
    /// The share of the sky seen over that height.
    Sky,
    /// The direction from which its light arrives on average.
    BentNormal,
    /// The picture: enhanced, in new light, or the curvature display.
    Picture,
    /// Coverage of the strokes.
    Strokes,
    /// Coverage of the contours.
    Contours,
    /// Coverage of the interior lines.
    Interior,
}

/// How a product is compared between backends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Compared {
    /// By the largest difference, relative to the largest value.
    Largest,
    /// By the mean difference of ink, since rounding may flip a pixel of a texture.
    Ink,
    /// By the mean angle between directions, where opposite directions are equal.
    Directions,
}

/// How the viewer shows a product.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shown {
    /// Its name in the list of layers.
    pub name: &'static str,
    /// One-line description of the picture.
    pub help: &'static str,
}

/// One product: its layer in a file, its unit and range, and the tolerance between backends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProductRow {
    /// The product.
    pub product: Product,
    /// Its name in reports.
    pub name: &'static str,
    /// The layer of an EXR that holds it; `None` for a product without a layer of its own.
    pub layer: Option<&'static str>,
    /// Its components, each a plane, as the layer's channels are named.
    pub components: &'static [&'static str],
    /// Unit and range of its values.
    pub unit: &'static str,
    /// Whether each further scale has this product too.
    pub at_scales: bool,
    /// Whether it is made only when it is named.
    pub(crate) on_request: bool,
    /// How backends are compared.
    pub(crate) compared: Compared,
    /// Tolerance of other backends against the CPU; its origin: [`Product::tolerance`].
    pub tolerance: f64,
    /// How the viewer shows it as a grey picture: 0 black and 1 white, or ink on paper.
    pub shown: Option<Shown>,
}

/// A row hidden from the viewer's list, compared by the largest difference.
const fn row(
    product: Product,
    name: &'static str,
    layer: Option<&'static str>,
    components: &'static [&'static str],
    unit: &'static str,
    tolerance: f64,
) -> ProductRow {
    ProductRow {
        product,
        name,
        layer,
        components,
        unit,
        at_scales: false,
        on_request: false,
        compared: Compared::Largest,
        tolerance,
        shown: None,
    }
}

impl ProductRow {
    const fn at_scales(self) -> Self {
        Self {
            at_scales: true,
            ..self
        }
    }

    const fn on_request(self) -> Self {
        Self {
            on_request: true,
            ..self
        }
    }

    const fn compared(self, compared: Compared) -> Self {
        Self { compared, ..self }
    }

    const fn shown(self, name: &'static str, help: &'static str) -> Self {
        Self {
            shown: Some(Shown { name, help }),
            ..self
        }
    }
}

const PER_PIXEL: &str = "per pixel; convex is negative";
const HEIGHT: &str = "pixels; with depth its unit, less the distance";
const DIRECTION: &str = "unit, x right, y up; 0 for none";

/// All products, in the order of their layers in a file.
#[rustfmt::skip]
static TABLE: [ProductRow; 18] = [
    row(Product::Silhouette, "silhouette", Some("weights"), &["silhouette"], "0..1", 1e-5)
        .shown("Silhouette", "weights in front of gaps: 1 is white"),
    row(Product::Crease, "crease", Some("weights"), &["crease"], "0..1", 1e-5)
        .shown("Crease", "weights where the surface bends sharply: 1 is white"),
    row(Product::Conductance, "conductance", Some("weights"), &["conductance"], "0..1", 1e-5)
        .shown("Conductance", "what both leave for slopes to spread: 0, an edge, is black"),
    row(Product::Gradient, "gradient", Some("gradient"), &["x", "y"], "slope, y up", 1e-5),
    row(Product::Trace, "trace", None, &["trace"], PER_PIXEL, 2e-5),
    row(Product::Hessian, "hessian", Some("hessian"), &["xx", "xy", "yy"], PER_PIXEL, 2e-5),
    row(Product::Curvature, "curvature", Some("curvature"), &["u", "v", "mean"], PER_PIXEL, 2e-5).at_scales(),
    row(Product::MappedCurvature, "mapped curvature", Some("curvature"), &["kappa"], "-1..1; convex is positive", 2e-5)
        .at_scales(),
    row(Product::Direction, "direction", Some("direction"), &["x", "y"], DIRECTION, 2e-5).compared(Compared::Directions),
    row(Product::ViewDirection, "view direction", Some("direction_view"), &["x", "y"], DIRECTION, 2e-5)
        .compared(Compared::Directions),
    row(Product::Height, "height", Some("relief"), &["height"], HEIGHT, 1e-4).on_request(),
    row(Product::HeightResidual, "height residual", Some("relief"), &["residual"], "change per pixel", 1e-4).on_request(),
    row(Product::Sky, "sky", Some("relief"), &["sky"], "0..1", 1e-4).on_request(),
    row(Product::BentNormal, "bent normal", Some("bent"), &["x", "y", "z"], "unit, view space", 1e-4).on_request(),
    row(Product::Picture, "picture", None, &["R", "G", "B"], "scene-linear", 1e-5),
    row(Product::Strokes, "strokes", None, &["strokes"], "coverage, 0..1", 1e-4).compared(Compared::Ink)
        .shown("Strokes", "strokes alone"),
    row(Product::Contours, "contours", None, &["contours"], "coverage, 0..1", 1e-5).compared(Compared::Ink)
        .shown("Contours", "lines along silhouettes and creases alone"),
    row(Product::Interior, "interior", None, &["interior"], "coverage, 0..1", 1e-5).compared(Compared::Ink)
        .shown("Interior lines", "lines inside surfaces alone"),
];

impl ProductRow {
    /// Label of its values: the layer, with the component where there is only one: `gradient`, `weights.crease`.
    pub fn label(&self) -> Option<String> {
        let layer = self.layer?;
        Some(match self.components {
            [one] => format!("{layer}.{one}"),
            _ => layer.into(),
        })
    }
}

impl Product {
    /// All products, in the order of their layers in a file.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.product)
    }

    /// Its row of the table.
    pub fn row(self) -> &'static ProductRow {
        let row = &TABLE[self as usize];
        debug_assert!(
            row.product == self,
            "the table has the order of the products"
        );
        row
    }

    /// The channels of an EXR that hold it, in the order of its planes.
    pub fn channels(self) -> impl Iterator<Item = String> {
        let row = self.row();
        let layer = row.layer.into_iter();
        layer.flat_map(|layer| row.components.iter().map(move |c| format!("{layer}.{c}")))
    }

    /// The same at a scale beyond the first, whose layer name carries the scale: `curvature_8px`, `curvature_2_5px`.
    pub fn channels_at(self, sigma_px: f32) -> impl Iterator<Item = String> {
        let row = self.row();
        // A dot would end the layer's name.
        let sigma = sigma_px.to_string().replace('.', "_");
        let layer = row.layer.into_iter().filter(|_| row.at_scales);
        layer.flat_map(move |layer| {
            let name = format!("{layer}_{sigma}px");
            row.components.iter().map(move |c| format!("{name}.{c}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_product_stands_at_its_place_and_no_channel_twice() {
        for (place, product) in Product::all().enumerate() {
            assert_eq!(product as usize, place);
            assert_eq!(product.row().product, product);
        }
        let mut channels: Vec<_> = Product::all().flat_map(Product::channels).collect();
        let count = channels.len();
        channels.sort();
        channels.dedup();
        assert_eq!(channels.len(), count);
        let at_scale: Vec<_> = Product::all().flat_map(|p| p.channels_at(2.5)).collect();
        assert_eq!(
            at_scale,
            [
                "curvature_2_5px.u",
                "curvature_2_5px.v",
                "curvature_2_5px.mean",
                "curvature_2_5px.kappa"
            ]
        );
    }
}
