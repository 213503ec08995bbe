//! What a run is to make.

use crate::params::{LineParams, RelightParams};
use crate::product::Product;

/// The result wanted from a run, and its own parameters.
#[expect(clippy::large_enum_variant, reason = "one is made for a run")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal<'a> {
    /// Every layer of the descriptor.
    Layers {
        /// Products beside them that are made on request alone: the height and what it misses of the normals, the sky seen
        /// over it, and bent normals.
        and: &'a [Product],
        /// Further scales that curvature is made at: sigmas in pixels.
        more_px: &'a [f32],
    },
    /// These products of the shape alone.
    Products(&'a [Product]),
    /// The coloured curvature display of [LW] figure 6.
    Display,
    /// Radiance scaling of the picture.
    Enhance,
    /// New light.
    Relight(RelightParams),
    /// A drawing.
    Hatch(Tone, LineParams),
}

/// Source of a drawing's tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tone {
    /// The picture unchanged.
    Picture,
    /// The picture after radiance scaling.
    Enhanced,
    /// New light.
    Relit(RelightParams),
    /// Shape-showing tone: a key light combined with new light, or else with the picture after radiance scaling, if
    /// there is a picture; stretched over all tones from ink to paper.
    Shape(Option<RelightParams>),
}

impl Goal<'_> {
    /// Every layer of the descriptor, at one scale.
    pub const LAYERS: Goal<'static> = Goal::Layers {
        and: &[],
        more_px: &[],
    };

    /// Products that it consists of; pictures are made beside them.
    pub(crate) fn products(&self) -> Vec<Product> {
        match self {
            Self::Layers { and, .. } => {
                let layers = Product::all().filter(|product| {
                    let row = product.row();
                    row.layer.is_some() && !row.on_request
                });
                layers.chain(and.iter().copied()).collect()
            }
            Self::Products(products) => products.to_vec(),
            _ => Vec::new(),
        }
    }
}
