//! A figure: a title, a legend, and panels of points over logarithmic axes, as SVG.

use crate::report::numbers::scientific;
use plotters::coord::Shift;
use plotters::coord::combinators::{LogCoord, WithKeyPoints};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

pub(super) type Drawn<T = ()> = std::result::Result<T, DrawingAreaErrorKind<std::io::Error>>;
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Names of series with their colours.
pub(super) type Legend<'a> = [(&'a str, RGBColor)];

pub(super) const INK: RGBColor = RGBColor(40, 44, 52);
pub(super) const FAINT: RGBColor = RGBColor(120, 126, 136);
pub(super) const GRID: RGBColor = RGBColor(232, 234, 238);
pub(super) const FRONT: RGBColor = RGBColor(240, 196, 60);
/// Colours distinguishable with colour blindness (Okabe and Ito), in the order of the series.
pub(super) const SERIES: [RGBColor; 4] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(170, 80, 140),
];
/// Size of a panel in pixels.
const PANEL: (u32, u32) = (460, 350);
const HEADER: u32 = 70;

/// A setting on a plot.
#[derive(Clone, Default)]
pub(super) struct Point {
    /// Cost and error.
    pub(super) place: (f64, f64),
    /// Text beside it, omitted where it would overlap another label.
    pub(super) label: String,
    /// Whether the label is always drawn.
    pub(super) is_marked: bool,
    /// Whether it is on the Pareto front.
    pub(super) on_front: bool,
}

impl Point {
    pub(super) fn new(x: f64, y: f64, label: impl ToString) -> Self {
        Self {
            place: (x, y),
            label: label.to_string(),
            ..Self::default()
        }
    }

    /// Whether it can be placed on logarithmic axes.
    fn is_drawable(&self) -> bool {
        let (x, y) = self.place;
        x > 0.0 && y > 0.0 && y.is_finite()
    }
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Marks {
    /// Discs of this radius along a line.
    Discs(i32),
    /// Rings along a dashed line.
    Rings,
    /// A dashed vertical line across the panel at every point.
    Uprights,
}

/// Points of one kind.
pub(super) struct Series {
    pub(super) color: RGBColor,
    pub(super) marks: Marks,
    pub(super) labels: HPos,
    pub(super) points: Vec<Point>,
}

impl Series {
    /// Points with labels on their right.
    pub(super) fn new(color: RGBColor, marks: Marks, points: impl Iterator<Item = Point>) -> Self {
        Self {
            color,
            marks,
            labels: HPos::Left,
            points: points.filter(Point::is_drawable).collect(),
        }
    }
}

/// Axes with a caption.
pub(super) struct Panel {
    pub(super) caption: String,
    pub(super) series: Vec<Series>,
    /// The horizontal axis and its ticks, if other than the range of the points.
    pub(super) x: Option<(Range<f64>, Vec<f64>)>,
}

/// Panels with a common range of errors, and the names of both axes.
pub(super) fn figure(
    title: &str,
    legend: &Legend,
    axes: [&str; 2],
    panels: impl IntoIterator<Item = Panel>,
) -> String {
    figure_up_to(f64::INFINITY, title, legend, axes, panels)
}

/// [`figure`] for errors up to `most`.
pub(super) fn figure_up_to(
    most: f64,
    title: &str,
    legend: &Legend,
    axes: [&str; 2],
    panels: impl IntoIterator<Item = Panel>,
) -> String {
    let any = |panel: &Panel| panel.points().next().is_some();
    let panels: Vec<Panel> = panels.into_iter().filter(any).collect();
    let errors = decades(
        panels
            .iter()
            .flat_map(Panel::points)
            .map(|point| point.place.1),
    );
    let errors = errors.start..errors.end.min(most);
    svg(title, legend, panels.len(), |i, area| {
        panels[i].draw(area, errors.clone(), axes)
    })
}

type Axis = WithKeyPoints<LogCoord<f64>>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

impl Panel {
    pub(super) fn new(caption: impl ToString, series: impl IntoIterator<Item = Series>) -> Self {
        Self {
            caption: caption.to_string(),
            series: series.into_iter().collect(),
            x: None,
        }
    }

    /// All points with an error.
    fn points(&self) -> impl Iterator<Item = &Point> {
        let series = self.series.iter().filter(|s| s.marks != Marks::Uprights);
        series.flat_map(|series| &series.points)
    }

    fn draw(&self, area: &Area, errors: Range<f64>, [x_name, y_name]: [&str; 2]) -> Drawn {
        let (x, x_ticks) = self.x.clone().unwrap_or_else(|| self.range());
        let y_ticks = ticks(&errors, &[1.0]);
        let mut chart = ChartBuilder::on(area)
            .caption(&self.caption, text(16, INK))
            .margin(14)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d(
                x.log_scale().with_key_points(x_ticks),
                errors.clone().log_scale().with_key_points(y_ticks),
            )?;
        chart
            .configure_mesh()
            .axis_style(FAINT)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .label_style(text(13, INK))
            .axis_desc_style(text(14, INK))
            .x_labels(20)
            .y_labels(20)
            .x_label_formatter(&|v| plain(*v))
            .y_label_formatter(&|v| power_of_ten(*v))
            .x_desc(x_name)
            .y_desc(y_name)
            .draw()?;
        let mut front: Vec<_> = self
            .points()
            .filter(|p| p.on_front)
            .map(|p| p.place)
            .collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        chart.draw_series(LineSeries::new(front, FRONT.mix(0.6).stroke_width(9)))?;
        self.series
            .iter()
            .try_for_each(|series| series.draw(&mut chart, &errors))
    }

    /// The range of the points with room for labels, and its ticks.
    fn range(&self) -> (Range<f64>, Vec<f64>) {
        let times = self.points().map(|point| point.place.0);
        let (first, last) = times.fold((f64::INFINITY, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
        let range = first / 2.2..last * 2.2;
        let of: &[f64] = match last / first > 200.0 {
            true => &[1.0],
            false => &[1.0, 2.0, 5.0],
        };
        let ticks = ticks(&range, of);
        (range, ticks)
    }
}

impl Series {
    fn draw(&self, chart: &mut Chart, errors: &Range<f64>) -> Drawn {
        let places = || self.points.iter().map(|point| point.place);
        let (disc, stroke) = (self.color.filled(), self.color.stroke_width(2));
        match self.marks {
            Marks::Discs(radius) => {
                let line = self.color.mix(0.7).stroke_width(2);
                chart.draw_series(LineSeries::new(places(), line))?;
                chart.draw_series(places().map(|at| Circle::new(at, radius, disc)))?;
            }
            Marks::Rings => {
                chart.draw_series(DashedLineSeries::new(places(), 6, 5, stroke))?;
                chart.draw_series(places().map(|at| Circle::new(at, 7, stroke)))?;
            }
            Marks::Uprights => {
                for (x, _) in places() {
                    let line = [(x, errors.start), (x, errors.end)];
                    let style = self.color.mix(0.7).stroke_width(1);
                    chart.draw_series(DashedLineSeries::new(line, 3, 4, style))?;
                }
            }
        }
        let on_front = self.points.iter().filter(|point| point.on_front);
        chart.draw_series(on_front.map(|point| Circle::new(point.place, 7, stroke)))?;
        let offset = match self.labels {
            HPos::Right => (-11, 5),
            _ => (9, -4),
        };
        let style = text(12, self.color).pos(Pos::new(self.labels, VPos::Bottom));
        let label = |point: &Point| {
            EmptyElement::at(point.place) + Text::new(point.label.clone(), offset, style.clone())
        };
        chart.draw_series(labelled(&self.points).into_iter().map(label))?;
        Ok(())
    }
}

/// The points whose labels do not overlap an earlier one.
fn labelled(points: &[Point]) -> Vec<&Point> {
    let mut kept: Vec<&Point> = Vec::new();
    for point in points.iter().filter(|point| !point.label.is_empty()) {
        let is_apart = |other: &&Point| {
            let ((x, y), (u, v)) = (point.place, other.place);
            (x / u).ln().abs() > 0.3 || (y / v).ln().abs() > 1.2
        };
        if point.is_marked || kept.iter().all(is_apart) {
            kept.push(point);
        }
    }
    kept
}

/// A title, a legend, and panels in two columns.
pub(super) fn svg(
    title: &str,
    legend: &Legend,
    panels: usize,
    panel: impl Fn(usize, &Area) -> Drawn,
) -> String {
    let columns = panels.clamp(1, 2);
    let rows = panels.div_ceil(columns).max(1);
    let size = (
        PANEL.0 * columns.max(2) as u32,
        HEADER + PANEL.1 * rows as u32,
    );
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let draw = || -> Drawn {
            root.fill(&WHITE)?;
            let (header, body) = root.split_vertically(HEADER);
            draw_header(&header, title, legend)?;
            let areas = body.split_evenly((rows, columns));
            for (i, area) in areas.iter().enumerate().take(panels) {
                panel(i, area)?;
            }
            root.present()
        };
        draw().expect("a string takes any picture");
    }
    svg
}

pub(super) fn text(size: i32, color: impl Color) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&color)
}

fn draw_header(area: &Area, title: &str, legend: &Legend) -> Drawn {
    area.draw(&Text::new(title.to_string(), (18, 12), text(18, INK)))?;
    let mut x = 20;
    for (name, color) in legend {
        area.draw(&Rectangle::new([(x, 46), (x + 22, 52)], color.filled()))?;
        area.draw(&Text::new((*name).to_string(), (x + 28, 42), text(14, INK)))?;
        // 14-pixel letters are 7 to 8 pixels wide.
        x += 28 + 8 * name.len() as i32 + 18;
    }
    Ok(())
}

/// The range of powers of ten that encloses `values`.
fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = values.filter(|v| v.is_finite() && *v > 0.0);
    let (lo, hi) = finite.fold((f64::INFINITY, 0.0_f64), |(lo, hi), v| {
        (lo.min(v), hi.max(v))
    });
    if lo > hi {
        return 1e-3..1.0;
    }
    10_f64.powf(lo.log10().floor())..10_f64.powf((hi.log10() + 0.15).ceil())
}

/// The multiples `of` of powers of ten within `range`.
pub(super) fn ticks(range: &Range<f64>, of: &[f64]) -> Vec<f64> {
    let decades = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let all = decades.flat_map(|e| of.iter().map(move |m| m * 10_f64.powi(e)));
    // The bounds are powers of ten, up to rounding.
    all.filter(|v| range.start * (1.0 - 1e-9) <= *v && *v <= range.end * (1.0 + 1e-9))
        .collect()
}

/// A tick without an exponent.
fn plain(value: f64) -> String {
    if value >= 1.0 {
        format!("{value:.0}")
    } else {
        format!("{}", (value * 1e4).round() / 1e4)
    }
}

/// A tick as a power of ten, 10⁻³; other values unchanged.
fn power_of_ten(value: f64) -> String {
    let exponent = value.log10();
    if (exponent - exponent.round()).abs() > 1e-6 {
        return scientific(value);
    }
    let digits = format!("{}", exponent.round() as i32);
    let raised = digits.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    });
    format!("10{}", raised.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_powers_of_ten() {
        assert_eq!(power_of_ten(1e-4), "10⁻⁴");
        assert_eq!(power_of_ten(1e12), "10¹²");
        assert_eq!((plain(20.0), plain(0.05)), ("20".into(), "0.05".into()));
    }

    #[test]
    fn ranges_are_whole_decades_around_the_values() {
        assert_eq!(
            decades([2e-4, 0.3, f64::INFINITY, 0.0].into_iter()),
            1e-4..1.0
        );
        assert_eq!(decades(std::iter::empty()), 1e-3..1.0);
    }
}
