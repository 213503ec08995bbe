//! Results as layers of an EXR.

use crate::frame::{ColorPlanes, Frame, Plane};
use crate::io::exr::{OutputChannel, OutputType};
use crate::plan::outcome::{Outcome, ScaleShape};
use crate::product::Product;

/// Colour planes as channels, with alpha where the picture has one.
pub(crate) fn color_channels<'a>(
    layer: Option<&str>,
    color: &'a ColorPlanes,
    alpha: Option<&'a Plane>,
    sample_type: OutputType,
) -> Vec<OutputChannel<'a>> {
    let planes = [
        ("R", Some(&color.r)),
        ("G", Some(&color.g)),
        ("B", Some(&color.b)),
        ("A", alpha),
    ];
    let name = |component: &str| match layer {
        Some(layer) => format!("{layer}.{component}"),
        None => component.to_string(),
    };
    planes
        .into_iter()
        .filter_map(|(component, plane)| plane.map(|plane| (name(component), plane)))
        .map(|(name, plane)| OutputChannel {
            name,
            plane,
            sample_type,
        })
        .collect()
}

/// The coverage of a drawing's layers.
pub(crate) fn stroke_channels(
    outcome: &Outcome,
    sample_type: OutputType,
) -> impl Iterator<Item = OutputChannel<'_>> {
    let drawing = outcome.drawing.iter();
    let planes = drawing.flat_map(|drawing| {
        [
            ("strokes.hatching", Some(&drawing.hatching)),
            ("strokes.contours", drawing.contours.as_ref()),
            ("strokes.interior", drawing.interior.as_ref()),
            ("strokes.tone", drawing.asked.as_ref()),
        ]
    });
    planes.filter_map(move |(name, plane)| {
        Some(OutputChannel {
            name: name.into(),
            plane: plane?,
            sample_type,
        })
    })
}

/// The layers of the contract, under its names.
pub(crate) fn shape_channels<'a>(
    frame: &'a Frame,
    outcome: &'a Outcome,
    sample_type: OutputType,
) -> Vec<OutputChannel<'a>> {
    let normal = &frame.normal;
    let normals = [("x", &normal.x), ("y", &normal.y), ("z", &normal.z)];
    let normals = normals.map(|(axis, plane)| (format!("normal.{axis}"), plane));
    let confidence = frame.confidence.as_ref();
    let confidence = confidence.map(|plane| ("weights.confidence".to_string(), plane));
    let of_product = |product: Product| {
        // Half floats tell heights to three digits.
        let sample_type = match product == Product::Height {
            true => OutputType::Float,
            false => sample_type,
        };
        let channels = product.channels().zip(outcome.planes(product));
        channels.map(move |(name, plane)| (name, plane, sample_type))
    };
    let more = outcome.shape.more_scales.iter();
    let more = more.flat_map(ScaleShape::channels);
    let typed = |(name, plane)| (name, plane, sample_type);
    let channels = normals.into_iter().chain(confidence).map(typed);
    let channels = channels.chain(Product::all().flat_map(of_product));
    let channels = channels.chain(more.map(typed));
    let channels = channels.map(|(name, plane, sample_type)| OutputChannel {
        name,
        plane,
        sample_type,
    });
    channels.collect()
}
