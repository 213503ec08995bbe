//! A drawing's lines on a page.

use crate::error::{Error, Result};
use crate::io::svg::{self, write_svg};
use crate::line::contours::Contour;
use crate::params::Params;
use crate::plan::drawing::Drawing;
use crate::plan::outcome::PageExtent;
use glam::Vec2;
use std::path::Path;

/// Stands for the file that a drawing in lines would go to.
pub(crate) const LINES: &str = "made.svg";

/// The lines of a drawing on a page.
pub(crate) fn page<'a>(
    drawing: &'a Drawing,
    params: &Params,
    extent: &PageExtent,
) -> svg::LinePage<'a> {
    let line = |points: &'a [Vec2], widths: &'a [f32]| (points, widths);
    let laid = |crosses: bool| {
        let lines = drawing.lines.iter().filter(|line| line.crosses == crosses);
        lines.map(|laid| line(&laid.points, &laid.widths)).collect()
    };
    let along = |lines: &'a [Contour]| {
        let lines = lines.iter();
        lines.map(|edge| line(&edge.points, &edge.widths)).collect()
    };
    let layers = vec![
        ("strokes", laid(false)),
        ("crossing", laid(true)),
        ("contours", along(&drawing.contour_lines)),
        ("interior", along(&drawing.interior_lines)),
    ];
    let (window, strokes) = (extent.display_window, &params.line.strokes);
    let size = [window.width(), window.height()].map(|side| side as f64);
    let page = params.page_for(size, extent.pixel_aspect);
    let dots = drawing.dots.iter();
    svg::LinePage {
        display_window: window,
        data_window: extent.data_window,
        pixel_aspect: extent.pixel_aspect,
        dpi: page.map_or(strokes.print_dpi(), |(_, dpi)| dpi),
        paper_mm: page.map(|(paper, _)| paper),
        dots: dots.map(|dot| (dot.at, dot.radius)).collect(),
        layers,
        pens: strokes.plotter_pens(),
    }
}

/// A page as the text of an SVG.
///
/// # Errors
/// [`Error::Io`].
pub(crate) fn text_of(page: &svg::LinePage) -> Result<String> {
    let (mut text, path) = (Vec::new(), Path::new(LINES));
    write_svg(&mut text, path, page)?;
    let text = String::from_utf8(text).map_err(std::io::Error::other);
    text.map_err(Error::io(path, "write"))
}
