//! The layers of a frame that can be shown.

use super::flow;
use super::look::{OneLine, ViewPixels, What};
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::io::picture::{Picture, ViewTransform};
use crate::plan::outcome::Outcome;
use crate::product::{Product, Shown};

/// The command that draws lines.
const DRAWN: &str = "hatch";

/// A layer shown in the window.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum ShownLayer {
    /// The command's result.
    #[default]
    Picture,
    /// The coloured curvature display.
    Curvature,
    /// A product shown in grey.
    Grey(Product),
    /// Directions of curvature, as noise smeared along them.
    Flow,
    /// Directions of curvature, as strokes over the curvature.
    Arrows,
    /// Luminance of the command's result.
    Tone,
}

/// Whether a product belongs to the shape descriptor, rather than a picture or a drawing.
fn is_of_shape(product: Product) -> bool {
    product < Product::Picture
}

impl ShownLayer {
    /// The layers of a command, in the order of the list.
    pub(super) fn all(command: &str) -> impl Iterator<Item = Self> + use<> {
        let is_drawn = command == DRAWN;
        let grey = Product::all().filter(|product| product.row().shown.is_some());
        let (shape, lines): (Vec<_>, Vec<_>) = grey.partition(|product| is_of_shape(*product));
        [Self::Picture, Self::Curvature]
            .into_iter()
            .chain(shape.into_iter().map(Self::Grey))
            .chain([Self::Flow, Self::Arrows, Self::Tone])
            .chain(lines.into_iter().filter(move |_| is_drawn).map(Self::Grey))
    }

    /// The layer after this one among the picture and the lines that it is drawn with; the picture after any other.
    pub(super) fn next_lines(self) -> Self {
        let lines = Self::all(DRAWN).filter(|layer| layer.is_drawn());
        let mut circle = [Self::Picture].into_iter().chain(lines);
        circle.find(|layer| *layer == self);
        circle.next().unwrap_or(Self::Picture)
    }

    /// Whether it holds lines of a drawing.
    pub(super) fn is_drawn(self) -> bool {
        matches!(self, Self::Grey(product) if !is_of_shape(product))
    }

    pub(super) fn name(self) -> &'static str {
        self.shown().name
    }

    pub(super) fn help(self) -> &'static str {
        self.shown().help
    }

    fn shown(self) -> Shown {
        let (name, help) = match self {
            Self::Grey(product) => {
                return product.row().shown.expect("the list holds what is shown");
            }
            Self::Picture => ("Picture", "what the command makes"),
            Self::Curvature => ("Curvature", "convex blue, concave red, edges black"),
            Self::Flow => (
                "Directions, flow",
                "a texture smeared along the larger curvature",
            ),
            Self::Arrows => ("Directions, strokes", "strokes along the larger curvature"),
            Self::Tone => ("Tone", "luminance of the picture, and of what is drawn"),
        };
        Shown { name, help }
    }

    /// The result that has to be computed for it.
    pub(super) fn made_of(self) -> What {
        match self {
            Self::Picture | Self::Tone => What::Picture,
            _ if self.is_drawn() => What::Picture,
            Self::Curvature => What::Curvature,
            _ => What::Layers,
        }
    }
}

/// A layer other than a picture, as grey pixels.
///
/// # Errors
/// The missing product.
pub(super) fn pixels(
    layer: ShownLayer,
    frame: &Frame,
    outcome: &Outcome,
) -> Result<ViewPixels, OneLine> {
    let shape = &outcome.shape;
    let made = match layer {
        ShownLayer::Grey(product) => {
            outcome
                .planes(product)
                .first()
                .map(|plane| match layer.is_drawn() {
                    // Ink on paper, as the drawing shows it.
                    true => grey(&plane.map(|coverage| 1.0 - coverage), true),
                    false => grey(plane, false),
                })
        }
        ShownLayer::Flow => shape
            .direction
            .as_ref()
            .map(|direction| grey(&flow::along(direction, &frame.mask), false)),
        ShownLayer::Arrows => shape.conductance.as_ref().map(|plane| {
            // Pale, so that strokes stand out.
            grey(&plane.map(|c| 0.7 + 0.25 * c), false)
        }),
        ShownLayer::Tone => {
            let color = outcome.color.as_ref().or(frame.color.as_ref());
            color.map(|color| grey(&luminance(color, frame), true))
        }
        ShownLayer::Picture | ShownLayer::Curvature => None,
    };
    made.ok_or_else(|| format!("{} is not there to be shown", layer.name()))
}

fn luminance(color: &ColorPlanes, frame: &Frame) -> Plane {
    let [r, g, b] = frame.luminance_weights();
    let samples = color.r.samples().iter().zip(color.g.samples());
    let samples = samples.zip(color.b.samples());
    let luminance = samples.map(|((&red, &green), &blue)| r * red + g * green + b * blue);
    Plane::from_samples(color.r.width(), color.r.height(), luminance.collect())
}

fn grey(plane: &Plane, is_linear: bool) -> ViewPixels {
    let color = ColorPlanes {
        r: plane.clone(),
        ..ColorPlanes::default()
    };
    ViewPixels::of(&Picture {
        grey: true,
        ..Picture::of(
            &color,
            match is_linear {
                true => ViewTransform::Srgb,
                false => ViewTransform::None,
            },
        )
    })
}
