//! The canvas: results that the stages of a drawing pass on.

use crate::frame::{Plane, Vector2Planes};
use crate::line::background::Backdrop;
use crate::line::contours::Contour;
use crate::line::specular::SeenThrough;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::line::tonal_art_map::TonalArtMap;
use crate::plan::execution::Execution;
use crate::shape::edges::cpu::Weights;
use std::sync::{Arc, LazyLock};

/// An unfinished drawing.
#[derive(Default)]
pub(crate) struct Canvas {
    /// The surface seen in mirrors and lenses, with its edges, which stop lines like any others.
    pub(crate) seen: Option<(SeenThrough, Weights)>,
    /// The planes behind the subject, if it has some.
    pub(crate) background: Option<Backdrop>,
    /// The optical densities to draw, if they do not follow from luminance alone.
    pub(crate) density: Option<Plane>,
    /// Lines along edges, and their coverage.
    pub(crate) contours: Option<(Plane, Vec<Contour>)>,
    /// Lines inside surfaces, and their coverage.
    pub(crate) interior: Option<(Plane, Vec<Contour>)>,
    /// The directions of strokes.
    pub(crate) directions: Vec<Vector2Planes>,
    /// Placement of the stroke texture.
    pub(crate) coordinates: Option<TextureCoordinates>,
    /// The texture of strokes, unless it is given.
    pub(crate) art_map: Option<Arc<TonalArtMap>>,
}

impl<'a> Execution<'a> {
    /// The drawing so far.
    pub(crate) fn canvas(&self) -> &Canvas {
        static BLANK: LazyLock<Canvas> = LazyLock::new(Canvas::default);
        self.made.handed_on.get().unwrap_or(&BLANK)
    }

    /// The drawing so far, to be drawn on.
    pub(crate) fn canvas_mut(&mut self) -> &mut Canvas {
        self.made.handed_on.get_mut()
    }

    /// The texture of strokes that is given, if one is.
    pub(crate) fn given_art_map(&self) -> Option<&'a TonalArtMap> {
        self.inputs.others.get()
    }
}
