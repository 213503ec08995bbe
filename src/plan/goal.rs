//! What a run is to make.

use crate::light::relight::setting::LightKinds;
use crate::params::RelightParams;
use crate::product::Product;
use serde::Serialize;

/// The result requested from a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Goal {
    /// Every layer of the descriptor.
    Layers,
    /// The coloured curvature display of [LW] figure 6.
    Display,
    /// Radiance scaling of the picture.
    Enhance,
    /// New light.
    Relight,
    /// The picture unchanged, for a drawing.
    Picture,
}

/// Source of a drawing's tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToneFrom {
    /// The picture unchanged.
    Picture,
    /// The picture after radiance scaling.
    Enhanced,
    /// New light.
    Relit(RelightParams, LightKinds),
    /// Shape-showing tone: a key light combined with new light, or else with the picture after radiance scaling, if
    /// there is a picture; stretched over all tones from ink to paper.
    Shape(Option<(RelightParams, LightKinds)>),
}

impl Goal {
    /// Products the goal consists of; pictures are handled separately.
    pub(crate) fn products(self) -> impl Iterator<Item = Product> {
        let is_layer = |product: &Product| {
            let row = product.row();
            row.layer.is_some() && !row.on_request
        };
        Product::all().filter(move |product| self == Self::Layers && is_layer(product))
    }
}
