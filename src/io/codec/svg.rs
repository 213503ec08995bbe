//! Lines to SVG, in millimetres: the outline of each, filled, or for a plotter the middle of each, drawn with few pens
//! in an order with little travel in the air.

use crate::error::{Error, Result};
use crate::frame::Window;
use crate::io::codec::outline::outline;
use crate::io::codec::pen_way::{PenLine, in_the_air, pen_way};
use crate::line::contours::polyline::{thinned, with_radii};
use crate::line::page::Page;
use crate::params::MM_PER_INCH;
use glam::{IVec2, Vec2, Vec3};
use rayon::prelude::*;
use std::io::Write;
use std::path::Path;

/// A drawing of lines.
pub(crate) struct LinePage<'a> {
    /// The whole picture, which everything is cut to.
    pub(crate) display_window: Window,
    /// The part whose upper left corner points are counted from.
    pub(crate) data_window: Window,
    /// Width of a pixel over its height.
    pub(crate) pixel_aspect: f32,
    /// Pixels per inch.
    pub(crate) dpi: f32,
    /// Width and height of the paper that the picture is centred on; without one, the paper is as large as the picture.
    pub(crate) paper_mm: Option<[f32; 2]>,
    /// Layers from below to above: a name, and lines by points in pixels, y down, and widths in pixels.
    pub(crate) layers: Vec<(&'static str, Vec<SvgLine<'a>>)>,
    /// Dots below all layers: middles and radii, in pixels.
    pub(crate) dots: Vec<(Vec2, f32)>,
    /// The number of pens of a plotter, which draws lines along their middle; without one, lines are outlines.
    pub(crate) pens: Option<u32>,
}

/// The points of a line and its width at each.
pub(crate) type SvgLine<'a> = (&'a [Vec2], &'a [f32]);

/// Steps of a coordinate in a pixel.
const STEPS: f32 = 10.0;

/// Largest deviation of a simplified path, in steps.
const BEND: f32 = 1.0;

/// Points that may be left out in a row.
const MOST_LEFT_OUT: usize = 64;

/// Smallest width that pens are told apart by, in pixels.
const LEAST_WIDTH_PX: f32 = 1e-3;

/// Writes `drawing` to `file`, called `path` in errors.
///
/// # Errors
/// [`Error::Io`] if that fails.
pub(crate) fn write_svg(file: &mut impl Write, path: &Path, drawing: &LinePage) -> Result<()> {
    write(file, drawing).map_err(Error::io(path, "write"))
}

fn write(file: &mut impl Write, drawing: &LinePage) -> std::io::Result<()> {
    let (paper, mut travel) = (drawing.paper(), Travel::default());
    let dots = drawing.dots(&mut travel);
    let pens = drawing.pens.map(|count| pens(&drawing.layers, count));
    let layers = drawing.layers.iter().map(|(name, lines)| {
        let content = match &pens {
            Some(pens) => drawing.plotted(name, lines, pens, &mut travel),
            None => drawing.inked(lines),
        };
        group(name, name, "", &content)
    });
    let layers: String = layers.collect();
    writeln!(
        file,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
         width=\"{:.3}mm\" height=\"{:.3}mm\" viewBox=\"0 0 {:.0} {:.0}\" preserveAspectRatio=\"none\" \
         stroke-linecap=\"round\" stroke-linejoin=\"round\">",
        drawing.mm(paper.x * drawing.pixel_aspect),
        drawing.mm(paper.y),
        paper.x,
        paper.y,
    )?;
    if pens.is_some() {
        let in_air_mm = drawing.mm(travel.length as f32);
        writeln!(
            file,
            "<desc>way of the pen in the air: {in_air_mm:.0} mm</desc>"
        )?;
    }
    writeln!(file, "{dots}{layers}</svg>")
}

/// The way of a pen in the air so far, and where it is.
#[derive(Default)]
struct Travel {
    length: f64,
    at: Vec2,
}

impl Travel {
    /// An order of paths, and the way along it.
    fn along(&mut self, paths: &[Vec<Vec3>]) -> Vec<PenLine> {
        let ends = |path: &Vec<Vec3>| [path[0], path[path.len() - 1]].map(Vec3::truncate);
        let ends: Vec<_> = paths.iter().map(ends).collect();
        let way = pen_way(&ends, self.at);
        let (length, at) = in_the_air(&way, &ends, self.at);
        self.length += length;
        self.at = at;
        way
    }
}

/// The pens of a plotter: the pen of a line by its median width, each for widths up to the same ratio, and the widths of
/// pens in pixels: the mean along its lines, which keeps their ink.
fn pens(
    layers: &[(&str, Vec<SvgLine>)],
    count: u32,
) -> (impl Fn(&SvgLine) -> usize + Sync, Vec<f32>) {
    let lines = layers.iter().flat_map(|(_, lines)| lines);
    let range = [f32::INFINITY, 0.0];
    let medians = lines.clone().map(|line| median(line.1));
    let [least, most] = medians.fold(range, |[a, b], width| [a.min(width), b.max(width)]);
    let step = (most / least).ln() / count as f32;
    // Where all widths are equal, the quotient is not a number and becomes 0.
    let pen = move |line: &SvgLine| {
        let number = ((median(line.1) / least).ln() / step) as usize;
        number.min(count as usize - 1)
    };
    let mut sums = vec![(0.0, 0); count as usize];
    for line in lines {
        let (sum, points) = &mut sums[pen(line)];
        *sum += line.1.iter().sum::<f32>();
        *points += line.1.len();
    }
    let means = sums.iter().map(|&(sum, points)| sum / points as f32);
    (pen, means.collect())
}

fn median(widths: &[f32]) -> f32 {
    let mut widths = widths.to_vec();
    widths.sort_unstable_by(f32::total_cmp);
    let middle = widths.get(widths.len() / 2);
    middle.map_or(LEAST_WIDTH_PX, |width| width.max(LEAST_WIDTH_PX))
}

impl LinePage<'_> {
    /// Millimetres of a length in steps.
    fn mm(&self, steps: f32) -> f32 {
        steps / STEPS / self.dpi * MM_PER_INCH
    }

    /// Width and height of the picture, in steps.
    fn size(&self) -> Vec2 {
        let window = self.display_window;
        STEPS * Vec2::new(window.width() as f32, window.height() as f32)
    }

    /// Width and height of the paper, in steps.
    fn paper(&self) -> Vec2 {
        let per_mm = self.mm(1.0).recip() / Vec2::new(self.pixel_aspect, 1.0);
        let of_mm = |mm| Vec2::from_array(mm) * per_mm;
        self.paper_mm.map_or(self.size(), of_mm)
    }

    /// The corners of the picture on the paper; between them is any radius.
    fn border(&self) -> [Vec3; 2] {
        let margin = 0.5 * (self.paper() - self.size());
        [margin.extend(0.0), (margin + self.size()).extend(f32::MAX)]
    }

    /// The picture in the plane of the lines.
    fn page(&self) -> Page {
        let (window, data) = (self.display_window, self.data_window);
        let first = Vec2::new(
            window.x0.wrapping_sub(data.x0) as f32,
            window.y0.wrapping_sub(data.y0) as f32,
        );
        Page {
            first,
            last: first + self.size() / STEPS,
        }
    }

    /// The parts of a line within the picture, in steps on the paper, simplified.
    fn parts(&self, points: &[Vec2], widths: &[f32]) -> Vec<Vec<Vec3>> {
        let [first, last] = self.border();
        // Each part has a point beyond the border at either end.
        let on_paper = |at: Vec3| (first + STEPS * at).clamp(first, last);
        let parts = self.page().parts_of(points, widths);
        let parts = parts.map(|(points, widths)| {
            let line = with_radii(&points, &widths).into_iter();
            simplified(line.map(on_paper).collect())
        });
        parts.collect()
    }

    /// The layer of dots.
    fn dots(&self, travel: &mut Travel) -> String {
        let ([first, _], page) = (self.border(), self.page());
        let dots = self.dots.iter().filter(|(at, _)| page.distance(*at) == 0.0);
        let dots = dots.map(|&(at, radius)| first + STEPS * (at - page.first).extend(radius));
        let dots: Vec<_> = dots.map(|dot| vec![dot]).collect();
        let circles = travel.along(&dots).into_iter().map(|(number, _)| {
            let [x, y, r] = dots[number][0].to_array();
            format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.2}\"/>\n")
        });
        group("dots", "dots", "", &circles.collect::<String>())
    }

    /// Lines as areas of ink.
    fn inked(&self, lines: &[SvgLine]) -> String {
        let [first, last] = self.border();
        let inked = |part: Vec<Vec3>| {
            let rim = outline(part).into_iter();
            let rim = rim.map(|at| at.clamp(first, last));
            path(&simplified(rim.collect()), "z")
        };
        let parts = lines
            .par_iter()
            .flat_map_iter(|line| self.parts(line.0, line.1));
        parts.map(inked).collect::<Vec<_>>().concat()
    }

    /// Lines along their middle, with a layer for each pen.
    fn plotted(
        &self,
        layer: &str,
        lines: &[SvgLine],
        (pen_of, widths): &(impl Fn(&SvgLine) -> usize + Sync, Vec<f32>),
        travel: &mut Travel,
    ) -> String {
        let pens = widths.iter().enumerate().map(|(pen, width)| {
            let own = lines.par_iter().filter(|line| pen_of(line) == pen);
            let parts = own.flat_map_iter(|line| self.parts(line.0, &vec![0.0; line.0.len()]));
            let mut parts: Vec<_> = parts.collect();
            let way = travel.along(&parts).into_iter();
            let paths = way.map(|(number, is_reversed)| {
                if is_reversed {
                    parts[number].reverse();
                }
                path(&parts[number], "")
            });
            let (id, width) = (format!("{layer}-{}", pen + 1), STEPS * width);
            let label = format!("{:.3} mm", self.mm(width));
            let pen = format!(" fill=\"none\" stroke=\"black\" stroke-width=\"{width:.2}\"");
            group(&id, &label, &pen, &paths.collect::<String>())
        });
        pens.collect()
    }
}

/// The points that a line and its swelling need.
fn simplified(line: Vec<Vec3>) -> Vec<Vec3> {
    let kept = thinned(&line, BEND, MOST_LEFT_OUT).into_iter();
    kept.map(|i| line[i]).collect()
}

/// A group, which drawing programs and plotters treat as a layer; none without content.
fn group(id: &str, label: &str, attributes: &str, content: &str) -> String {
    if content.is_empty() {
        return String::new();
    }
    format!(
        "<g id=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{label}\"{attributes}>\n{content}</g>\n"
    )
}

/// A path from point to point, each relative to the one before.
fn path(points: &[Vec3], end: &str) -> String {
    let mut text = String::from("<path d=\"");
    let mut before = IVec2::ZERO;
    for (n, point) in points.iter().enumerate() {
        let at = point.truncate().round().as_ivec2();
        let command = ["M", "l", " "][n.min(2)];
        let [x, y] = (at - before).to_array();
        text += &format!("{command}{x} {y}");
        before = at;
    }
    // A dot is a line of no length, with round ends.
    let end = if points.len() == 1 { "h0" } else { end };
    text + end + "\"/>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of 300 x 200 pixels with its lines at (10, -20).
    fn of(
        layers: Vec<(&'static str, Vec<SvgLine<'static>>)>,
        pens: Option<u32>,
    ) -> LinePage<'static> {
        LinePage {
            display_window: Window::from_size(300, 200),
            data_window: Window::at(10, -20, 50, 50),
            pixel_aspect: 2.0,
            dpi: 100.0,
            paper_mm: None,
            layers,
            dots: vec![(Vec2::new(1.0, 22.0), 0.5)],
            pens,
        }
    }

    fn written(drawing: &LinePage) -> String {
        let mut file = Vec::new();
        write_svg(&mut file, Path::new("a.svg"), drawing).unwrap();
        String::from_utf8(file).unwrap()
    }

    fn line(points: &[[f32; 2]], widths: &[f32]) -> SvgLine<'static> {
        let points: Vec<Vec2> = points.iter().map(|&at| at.into()).collect();
        (points.leak(), widths.to_vec().leak())
    }

    #[test]
    fn a_page_has_its_size_in_millimetres() {
        // 300 pixels twice as wide as high, 100 to the inch: 6 inches by 2.
        let page = written(&of(vec![], None));
        assert!(
            page.contains("width=\"152.400mm\" height=\"50.800mm\""),
            "{page}"
        );
        assert!(page.contains("viewBox=\"0 0 3000 2000\""));
    }

    #[test]
    fn a_picture_is_in_the_middle_of_its_paper() {
        // 8 by 4 inches at 100 to the inch are 400 pixels twice as wide as high, by 400: 50 more on the left and 100
        // above. The line starts there 10 further right and 20 further down.
        let strokes = vec![line(&[[0.0, 40.0], [50.0, 40.0]], &[3.0; 2])];
        let drawing = LinePage {
            paper_mm: Some([203.2, 101.6]),
            ..of(vec![("strokes", strokes)], Some(1))
        };
        let page = written(&drawing);
        assert!(
            page.contains("width=\"203.200mm\" height=\"101.600mm\" viewBox=\"0 0 4000 4000\"")
        );
        assert!(page.contains("d=\"M600 1200l500 0\""), "{page}");
    }

    #[test]
    fn every_line_is_one_outline() {
        let swelling = line(&[[0.0, 40.0], [20.0, 40.0], [40.0, 40.0]], &[0.0, 6.0, 0.0]);
        let even = line(&[[0.0, 60.0], [9.0, 60.0], [40.0, 60.0]], &[2.0; 3]);
        let layers = vec![("strokes", vec![swelling]), ("contours", vec![even])];
        let page = written(&of(layers, None));
        assert_eq!(page.matches("<path d=\"M").count(), 2);
        assert_eq!(page.matches("z\"/>").count(), 2);
        // A rhombus from tip to tip.
        assert!(page.contains("<path d=\"M100 200l"), "{page}");
        for name in ["strokes", "contours"] {
            let layer =
                format!("id=\"{name}\" inkscape:groupmode=\"layer\" inkscape:label=\"{name}\">");
            assert!(page.contains(&layer), "{page}");
        }
        assert!(!page.contains("stroke-width"));
    }

    #[test]
    fn a_point_is_a_dot_and_nothing_is_nothing() {
        let strokes = vec![line(&[[1.0, 21.0]], &[2.0]), line(&[], &[])];
        let page = written(&of(vec![("strokes", strokes.clone())], Some(1)));
        assert_eq!(page.matches("<path").count(), 1);
        assert!(page.contains("M110 10h0"), "{page}");
        let page = written(&of(vec![("strokes", strokes)], None));
        assert_eq!(page.matches("<path").count(), 1);
    }

    #[test]
    fn nothing_is_off_the_page() {
        // It leaves the picture on the left and comes back; it is outside; it is on the border by half of its width.
        let points: Vec<_> = (0..100)
            .map(|i| {
                [
                    (30 - i.min(50)) as f32 + (i.max(50) - 50) as f32,
                    40.0 + 0.2 * i as f32,
                ]
            })
            .collect();
        let outside: Vec<_> = (0..40)
            .map(|i| [i as f32 - 30.0, 10.0 - i as f32])
            .collect();
        let border = [[0.0, 20.0], [20.0, 20.0]];
        for pens in [None, Some(1)] {
            let widths: Vec<_> = (0..100).map(|i| 2.0 + 0.04 * i as f32).collect();
            let lines = [
                line(&points, &widths),
                line(&outside, &widths[..40]),
                line(&border, &widths[..2]),
            ];
            let page = written(&of(vec![("strokes", lines.into())], pens));
            assert_eq!(page.matches("<path").count(), 3, "{page}");
            for path in page.split(" d=\"M").skip(1) {
                let text = path.split('"').next().unwrap().trim_end_matches('z');
                let numbers: Vec<f32> =
                    text.split(['l', ' ']).map(|n| n.parse().unwrap()).collect();
                let ends = numbers.chunks(2).scan(Vec2::ZERO, |at, step| {
                    *at += Vec2::from_slice(step);
                    Some(*at)
                });
                for at in ends {
                    assert_eq!(
                        at,
                        at.clamp(Vec2::ZERO, Vec2::new(3000.0, 2000.0)),
                        "{text}"
                    );
                }
            }
        }
    }

    #[test]
    fn pens_are_few_and_keep_the_ink() {
        let at = |y: f32| [[0.0, y], [10.0, y], [20.0, y]];
        let strokes = vec![
            line(&at(40.0), &[0.5, 1.0, 1.5]),
            line(&at(50.0), &[8.0, 8.0, 2.0]),
        ];
        let contours = vec![line(&at(60.0), &[3.0, 4.0, 5.0])];
        let widths = |pens: u32| {
            let layers = vec![("strokes", strokes.clone()), ("contours", contours.clone())];
            let page = written(&of(layers, Some(pens)));
            assert_eq!(page.matches("<path").count(), 3);
            let widths = page.split("stroke-width=\"").skip(1);
            widths.map(|text| text[..5].to_string()).collect::<Vec<_>>()
        };
        // (3 + 18 + 12) / 9. Medians of 1, 4 and 8 in two pens: up to the root of 8, and (18 + 12) / 6.
        assert_eq!(widths(1), ["36.67", "36.67"]);
        assert_eq!(widths(2), ["10.00", "50.00", "50.00"]);
        assert_eq!(widths(16), ["10.00", "60.00", "40.00"]);
    }

    #[test]
    fn a_plotter_gets_layers_of_one_pen_and_lines_from_the_nearer_end() {
        let far = line(&[[0.0, 40.0], [40.0, 20.0]], &[1.0; 2]);
        let near = line(&[[-10.0, 20.0], [0.0, 20.04], [30.0, 20.0]], &[1.0; 3]);
        let page = written(&of(vec![("strokes", vec![far, near])], Some(1)));
        // From the corner of the page the pen goes to the dot at (11, 2), then 11.2 to the near line's first point at
        // (0, 0), and from its last 10 on to the far line's last. A bend of 0.04 is left out.
        let paths = "<path d=\"M0 0l400 0\"/>\n<path d=\"M500 0l-400 200\"/>\n";
        assert!(page.contains(paths), "{page}");
        assert!(page.contains("<circle cx=\"110.0\" cy=\"20.0\" r=\"5.00\"/>"));
        let label = "inkscape:groupmode=\"layer\" inkscape:label=\"0.254 mm\"";
        assert!(page.contains(label), "{page}");
        // 11.18 + 11.18 + 10 pixels, 100 to the inch.
        assert!(
            page.contains("<desc>way of the pen in the air: 8 mm</desc>"),
            "{page}"
        );
    }
}
