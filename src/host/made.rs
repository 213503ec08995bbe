//! What a command has made.

use crate::command::chosen::Chosen;
use crate::command::commands::{command_named, long};
use crate::command::flags::Flag;
use crate::frame::{ColorPlanes, Plane};
use crate::plan::outcome::Outcome;
use crate::product::Product;
use crate::work;

/// What a command has made of a scene.
#[derive(Debug, Default)]
pub struct Made {
    pub(super) made: work::Results,
    /// A drawing as the text of an SVG, if lines were asked for.
    pub svg: Option<String>,
    /// Warnings about inputs and settings.
    pub warnings: Vec<String>,
    /// The command that made it.
    pub(super) command: String,
    /// Choices made on the way.
    pub(super) chosen: Chosen,
}

/// A named plane, or several of one vector.
#[derive(Debug)]
pub struct MadeLayer<'a> {
    /// Its name: of a product, a map, or a kind of stroke.
    pub name: String,
    /// Its components.
    pub planes: Vec<&'a Plane>,
    /// The scale in pixels, for curvature beyond the first one.
    pub sigma_px: Option<f32>,
}

impl Made {
    /// The picture, scene-linear: enhanced, in new light, or a drawing on its paper.
    pub fn picture(&self) -> Option<&ColorPlanes> {
        self.made.outcome.picture()
    }

    /// Layers: of the descriptor, maps, or coverage by the strokes of a drawing.
    pub fn layers(&self) -> Vec<MadeLayer<'_>> {
        let maps = self
            .made
            .planes
            .iter()
            .map(|(name, plane)| layer(name, vec![plane]));
        let products = Product::all().filter(|product| {
            let row = product.row();
            row.layer.is_some()
                || (self.made.outcome.drawing.is_some()
                    && self.svg.is_none()
                    && *product != Product::Picture)
        });
        let products =
            products.map(|product| layer(&name_of(product), self.made.outcome.planes(product)));
        let asked = self.made.outcome.drawing.iter().flat_map(|d| &d.asked);
        let asked = asked.map(|plane| layer("tone", vec![plane]));
        let scales = self.made.outcome.shape.more_scales.iter();
        let further = scales.flat_map(|scale| {
            Product::all().map(|product| MadeLayer {
                sigma_px: Some(scale.sigma_px),
                ..layer(&name_of(product), scale.planes(product))
            })
        });
        let all = maps.chain(products).chain(asked).chain(further);
        all.filter(|layer| !layer.planes.is_empty()).collect()
    }

    /// The names of the maps among the layers.
    pub fn map_names(&self) -> impl Iterator<Item = &str> {
        self.made.planes.iter().map(|(name, _)| &name[..])
    }

    /// What was chosen by itself, by the names of settings.
    pub fn choices(&self) -> Vec<(String, String)> {
        settings_in(&self.chosen, &self.command)
    }

    /// Its memory, to be used again by the engine.
    pub fn into_outcome(self) -> Outcome {
        self.made.outcome
    }
}

/// The name of a product's layer: that of its only component, or its own.
fn name_of(product: Product) -> String {
    let row = product.row();
    match row.components {
        [one] => one.to_string(),
        _ => row.name.replace(' ', "_"),
    }
}

/// A layer at the first scale.
fn layer<'a>(name: &str, planes: Vec<&'a Plane>) -> MadeLayer<'a> {
    MadeLayer {
        name: name.into(),
        planes,
        sigma_px: None,
    }
}

/// Choices as settings of a command. Some of what is found on the way is no setting of it, as the white level of a
/// picture that gives the tone of a drawing.
pub(super) fn settings_in(chosen: &Chosen, command: &str) -> Vec<(String, String)> {
    let command = command_named(command);
    let flags = chosen.flags().into_iter();
    let known = flags.filter(|flag| long(&command, flag.name()).is_some());
    known.map(|flag| named(&flag)).collect()
}

/// A flag as a setting.
pub(super) fn named(flag: &Flag) -> (String, String) {
    (flag.name().into(), flag.value().unwrap_or("true").into())
}
