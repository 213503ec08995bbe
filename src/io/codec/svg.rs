//! Lines to SVG: in millimetres, grouped by width, so that a plotter rarely changes its pen, and optionally in an order
//! with little travel in the air.

use crate::error::{Error, Result};
use crate::frame::Window;
use crate::io::codec::pen_way::{Drawn, in_the_air, pen_way};
use crate::line::contours::polyline::thinned;
use crate::params::MM_PER_INCH;
use glam::Vec2;
use rayon::prelude::*;
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
    /// Dots below all layers: middles and radii, in pixels.
    pub dots: Vec<(Vec2, f32)>,
    /// Whether lines are ordered and thinned for a plotter, with a layer for each pen inside those of the drawing.
    pub is_plotted: bool,
}

/// The points of a line and its width at each.
pub type Line<'a> = (&'a [Vec2], &'a [f32]);

/// Largest deviation, in pixels, of a simplified path, and of one for a plotter.
const BEND_PX: f32 = 0.04;
const PLOTTED_BEND_PX: f32 = 0.1;

/// Bends that may be left out in a row.
const MOST_LEFT_OUT: usize = 64;

/// Ratio of the widths of a group to those of the previous one.
const WIDTH_STEP: f32 = 1.2;

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
    let layers_of = match drawing.is_plotted {
        true => " xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\"",
        false => "",
    };
    writeln!(
        file,
        "<svg xmlns=\"http://www.w3.org/2000/svg\"{layers_of} width=\"{:.3}mm\" height=\"{:.3}mm\" viewBox=\"0 0 {width} {height}\" \
         preserveAspectRatio=\"none\" fill=\"none\" stroke=\"black\" stroke-linecap=\"round\" stroke-linejoin=\"round\">",
        drawing.mm(width as f32 * drawing.pixel_aspect),
        drawing.mm(height as f32),
    )?;
    write_content(file, drawing)?;
    writeln!(file, "</svg>")
}

/// The paths of one pen, in drawing order.
struct Pen<'a> {
    step: i32,
    paths: Vec<&'a [Vec2]>,
    ends: Vec<[Vec2; 2]>,
    way: Vec<Drawn>,
}

impl<'a> Pen<'a> {
    /// The paths of a pen of this width.
    fn new(step: i32, paths: Vec<(Line<'a>, RangeInclusive<usize>)>, drawing: &Drawing) -> Self {
        let paths = paths.into_iter().map(|(line, range)| &line.0[range]);
        let paths: Vec<&[Vec2]> = paths.collect();
        let ends = paths
            .iter()
            .map(|points| [points[0], points[points.len() - 1]]);
        let ends: Vec<_> = ends.collect();
        Self {
            step,
            way: drawing.way(&ends),
            paths,
            ends,
        }
    }

    /// Its part of a layer.
    fn group(&self, layer: &str, drawing: &Drawing) -> std::io::Result<Vec<u8>> {
        let (width, corner) = (WIDTH_STEP.powi(self.step), drawing.corner());
        let mut group = Vec::new();
        let (start, bend) = match drawing.is_plotted {
            true => {
                let id = format!("{layer}-{width:.3}");
                let label = format!("{:.3} mm", drawing.mm(width));
                (drawing.group(&id, &label), PLOTTED_BEND_PX)
            }
            false => ("<g".into(), BEND_PX),
        };
        writeln!(group, "{start} stroke-width=\"{width:.3}\">")?;
        for &(number, is_reversed) in &self.way {
            let points = self.paths[number];
            let mut kept = thinned(points, bend, MOST_LEFT_OUT);
            if is_reversed {
                kept.reverse();
            }
            write_path(&mut group, kept.into_iter().map(|i| points[i] + corner))?;
        }
        writeln!(group, "</g>")?;
        Ok(group)
    }
}

/// Writes dots and lines, grouped by width, and for a plotter the pen's travel in the air.
fn write_content(file: &mut impl Write, drawing: &Drawing) -> std::io::Result<()> {
    let dots: Vec<[Vec2; 2]> = drawing.dots.iter().map(|&(at, _)| [at, at]).collect();
    let dotted = drawing.way(&dots);
    let layers: Vec<_> = drawing
        .layers
        .iter()
        .map(|(name, lines)| {
            let pens = by_width(lines).into_par_iter();
            let pens = pens.map(|(step, paths)| Pen::new(step, paths, drawing));
            (*name, pens.collect::<Vec<Pen>>())
        })
        .collect();
    if drawing.is_plotted {
        let pens = layers.iter().flat_map(|(_, pens)| pens);
        let ways = std::iter::once((&dotted, &dots)).chain(pens.map(|pen| (&pen.way, &pen.ends)));
        let (in_air, _) = ways.fold((0.0, -drawing.corner()), |(sum, at), (way, ends)| {
            let (length, end) = in_the_air(way, ends, at);
            (sum + length, end)
        });
        let in_air_mm = drawing.mm(in_air as f32);
        writeln!(
            file,
            "<desc>way of the pen in the air: {in_air_mm:.0} mm</desc>"
        )?;
    }
    if !dots.is_empty() {
        write_dots(file, drawing, dotted)?;
    }
    for (name, pens) in &layers {
        writeln!(file, "{}>", drawing.group(name, name))?;
        let groups = pens.par_iter().map(|pen| pen.group(name, drawing));
        for group in groups.collect::<std::io::Result<Vec<_>>>()? {
            file.write_all(&group)?;
        }
        writeln!(file, "</g>")?;
    }
    Ok(())
}

fn write_dots(file: &mut impl Write, drawing: &Drawing, order: Vec<Drawn>) -> std::io::Result<()> {
    let start = drawing.group("dots", "dots");
    writeln!(file, "{start} fill=\"black\" stroke=\"none\">")?;
    for (number, _) in order {
        let (at, radius) = drawing.dots[number];
        let at = at + drawing.corner();
        writeln!(
            file,
            "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"{radius:.3}\"/>",
            at.x, at.y
        )?;
    }
    writeln!(file, "</g>")
}

impl Drawing<'_> {
    /// Millimetres of a length in pixels.
    fn mm(&self, pixels: f32) -> f32 {
        pixels / self.dpi * MM_PER_INCH
    }

    /// The order of paths with these ends: for a plotter one with little travel in the air.
    fn way(&self, ends: &[[Vec2; 2]]) -> Vec<Drawn> {
        match self.is_plotted {
            true => pen_way(ends, -self.corner()),
            false => (0..ends.len()).map(|number| (number, false)).collect(),
        }
    }

    /// The start of a group, which drawing programs and plotters treat as a layer of a plotted drawing.
    fn group(&self, id: &str, label: &str) -> String {
        match self.is_plotted {
            true => {
                format!("<g id=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{label}\"")
            }
            false => format!("<g id=\"{id}\""),
        }
    }

    /// Origin of the points on the page.
    fn corner(&self) -> Vec2 {
        let (window, data) = (self.display_window, self.data_window);
        Vec2::new(
            data.x0.wrapping_sub(window.x0) as f32,
            data.y0.wrapping_sub(window.y0) as f32,
        )
    }
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

fn write_path(
    file: &mut impl Write,
    points: impl ExactSizeIterator<Item = Vec2>,
) -> std::io::Result<()> {
    let is_dot = points.len() == 1;
    write!(file, "<path d=\"")?;
    for (n, at) in points.enumerate() {
        let command = ["M", "L"][usize::from(n > 0)];
        write!(file, "{command}{:.2} {:.2}", at.x, at.y)?;
    }
    // A dot is a line of no length, with round ends.
    if is_dot {
        write!(file, "h0")?;
    }
    writeln!(file, "\"/>")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(layers: Vec<(&'static str, Vec<Line>)>) -> String {
        page_of(layers, false)
    }

    fn page_of(layers: Vec<(&'static str, Vec<Line>)>, is_plotted: bool) -> String {
        let drawing = Drawing {
            display_window: Window::from_size(300, 200),
            data_window: Window::at(10, -20, 50, 50),
            pixel_aspect: 2.0,
            dpi: 100.0,
            layers,
            dots: vec![(Vec2::new(1.0, 22.0), 0.5)],
            is_plotted,
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

    #[test]
    fn a_plotter_gets_layers_of_one_pen_and_lines_from_the_nearer_end() {
        let far = [Vec2::new(0.0, 40.0), Vec2::new(40.0, 20.0)];
        let near = [
            Vec2::new(-10.0, 20.0),
            Vec2::new(0.0, 20.04),
            Vec2::new(30.0, 20.0),
        ];
        let page = page_of(
            vec![("strokes", vec![(&far, &[1.0; 2]), (&near, &[1.0; 3])])],
            true,
        );
        // Points are at (10, -20) from the corner of the page. From there the pen goes to the dot at (11, 2), then 11.2
        // to the near line's first point at (0, 0), and from its last 10 on to the far line's last. A bend of 0.04 is
        // left out.
        let paths = "<path d=\"M0.00 0.00L40.00 0.00\"/>\n<path d=\"M50.00 0.00L10.00 20.00\"/>\n";
        assert!(page.contains(paths), "{page}");
        assert!(page.contains("<circle cx=\"11.00\" cy=\"2.00\" r=\"0.500\"/>"));
        let label = "inkscape:groupmode=\"layer\" inkscape:label=\"0.254 mm\"";
        assert!(page.contains(label), "{page}");
        // 11.18 + 11.18 + 10 pixels, 100 to the inch.
        assert!(
            page.contains("<desc>way of the pen in the air: 8 mm</desc>"),
            "{page}"
        );
    }
}
