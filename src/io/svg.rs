//! Lines to SVG: in millimetres, grouped by width, so that a plotter changes its pen as seldom as can be.

use crate::error::{Error, Result};
use crate::frame::Window;
use crate::line::contours::polyline::thinned;
use glam::Vec2;
use std::collections::BTreeMap;
use std::io::Write;
use std::ops::RangeInclusive;
use std::path::Path;

/// A drawing of lines.
pub struct Drawing<'a> {
    /// The whole picture.
    pub display_window: Window,
    /// The part whose upper left corner points are counted from.
    pub data_window: Window,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// Pixels per inch.
    pub dpi: f32,
    /// Layers from below to above: a name, and lines by points in pixels, y down, and widths in pixels.
    pub layers: Vec<(&'static str, Vec<Line<'a>>)>,
}

/// The points of a line and its width at each.
pub type Line<'a> = (&'a [Vec2], &'a [f32]);

/// How far, in pixels, a path may leave out a bend.
const BEND_PX: f32 = 0.04;

/// Bends that may be left out in a row.
const MOST_LEFT_OUT: usize = 64;

/// Widths of a group over those of the one before.
const WIDTH_STEP: f32 = 1.2;

const MM_PER_INCH: f32 = 25.4;

/// Writes `drawing` to `file`, called `path` in errors.
///
/// # Errors
/// [`Error::Io`] if that fails.
pub fn write_svg(file: &mut impl Write, path: &Path, drawing: &Drawing) -> Result<()> {
    write(file, drawing).map_err(Error::io(path, "write"))
}

fn write(file: &mut impl Write, drawing: &Drawing) -> std::io::Result<()> {
    let window = drawing.display_window;
    let (width, height) = (window.width(), window.height());
    let mm = |pixels: f32| pixels / drawing.dpi * MM_PER_INCH;
    writeln!(
        file,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.3}mm\" height=\"{:.3}mm\" viewBox=\"0 0 {width} {height}\" \
         preserveAspectRatio=\"none\" fill=\"none\" stroke=\"black\" stroke-linecap=\"round\" stroke-linejoin=\"round\">",
        mm(width as f32 * drawing.pixel_aspect),
        mm(height as f32),
    )?;
    let data = drawing.data_window;
    let corner = Vec2::new(
        data.x0.wrapping_sub(window.x0) as f32,
        data.y0.wrapping_sub(window.y0) as f32,
    );
    for (name, lines) in &drawing.layers {
        writeln!(file, "<g id=\"{name}\">")?;
        for (step, paths) in by_width(lines) {
            writeln!(file, "<g stroke-width=\"{:.3}\">", WIDTH_STEP.powi(step))?;
            for (line, range) in paths {
                write_path(file, &line.0[range], corner)?;
            }
            writeln!(file, "</g>")?;
        }
        writeln!(file, "</g>")?;
    }
    writeln!(file, "</svg>")
}

/// Parts of lines whose widths are about the same power of [`WIDTH_STEP`], the thinnest first; parts of a line
/// share the point between them.
fn by_width<'a>(lines: &[Line<'a>]) -> BTreeMap<i32, Vec<(Line<'a>, RangeInclusive<usize>)>> {
    let mut groups: BTreeMap<i32, Vec<_>> = BTreeMap::new();
    for &line in lines.iter().filter(|line| !line.0.is_empty()) {
        let step = |i: usize| (line.1[i].max(1e-3).ln() / WIDTH_STEP.ln()).round() as i32;
        let last = line.0.len() - 1;
        let mut from = 0;
        while from < last || last == 0 {
            let width = step(from);
            let mut to = from;
            while to < last && step(to) == width {
                to += 1;
            }
            groups.entry(width).or_default().push((line, from..=to));
            from = to;
            if last == 0 {
                break;
            }
        }
    }
    groups
}

fn write_path(file: &mut impl Write, points: &[Vec2], corner: Vec2) -> std::io::Result<()> {
    write!(file, "<path d=\"")?;
    for (n, i) in thinned(points, BEND_PX, MOST_LEFT_OUT)
        .into_iter()
        .enumerate()
    {
        let at = points[i] + corner;
        let command = ["M", "L"][usize::from(n > 0)];
        write!(file, "{command}{:.2} {:.2}", at.x, at.y)?;
    }
    // A dot is a line of no length, with round ends.
    if points.len() == 1 {
        write!(file, "h0")?;
    }
    writeln!(file, "\"/>")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(layers: Vec<(&'static str, Vec<Line>)>) -> String {
        let drawing = Drawing {
            display_window: Window::from_size(300, 200),
            data_window: Window::at(10, -20, 50, 50),
            pixel_aspect: 2.0,
            dpi: 100.0,
            layers,
        };
        let mut file = Vec::new();
        write_svg(&mut file, Path::new("a.svg"), &drawing).unwrap();
        String::from_utf8(file).unwrap()
    }

    #[test]
    fn a_page_has_its_size_in_millimetres() {
        // 300 pixels twice as wide as high, 100 to the inch: 6 inches by 2.
        let page = written(vec![]);
        assert!(
            page.contains("width=\"152.400mm\" height=\"50.800mm\""),
            "{page}"
        );
        assert!(page.contains("viewBox=\"0 0 300 200\""));
    }

    #[test]
    fn lines_are_cut_where_their_width_changes_and_moved_to_the_page() {
        let points = [Vec2::ZERO, Vec2::X, 2.0 * Vec2::X, Vec2::new(2.0, 5.0)];
        let page = written(vec![("strokes", vec![(&points, &[1.0, 1.02, 1.44, 1.44])])]);
        let thin =
            page.find("<g stroke-width=\"1.000\">\n<path d=\"M10.00 -20.00L12.00 -20.00\"/>");
        let thick =
            page.find("<g stroke-width=\"1.440\">\n<path d=\"M12.00 -20.00L12.00 -15.00\"/>");
        assert!(thin.unwrap() < thick.unwrap(), "{page}");
    }

    #[test]
    fn a_point_is_a_dot_and_nothing_is_nothing() {
        let page = written(vec![("strokes", vec![(&[Vec2::ONE], &[2.0]), (&[], &[])])]);
        assert_eq!(page.matches("<path").count(), 1);
        assert!(page.contains("M11.00 -19.00h0"));
    }
}
