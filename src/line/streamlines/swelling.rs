//! Engraved lines: tapered to points, and swelling to cover the tone.

use super::{Streamline, Tool, Wanted};
use crate::line::contours::polyline::lengths;
use crate::line::ink_cells::InkCells;
use glam::Vec2;

/// Length of the taper at a line's end, in distances between lines; and at an edge, where paper would show.
const TAPER: f32 = 2.5;
const TAPER_AT_EDGE: f32 = 0.4;

/// The most of a line's length that runs thin at an end.
const MOST_TAPERED: f32 = 0.4;

/// Exponent of the taper: width follows this power of the distance to the point.
const POINTED: f32 = 0.6;

/// Width of a point, as a share of that of the thinnest line.
const POINT: f32 = 0.5;

/// Side of a cell in which ink is matched to the tone, in distances between lines.
const CELL: f32 = 2.0;

/// Number of corrections of widths, and the limits of the factor in each.
const MENDS: usize = 3;
const MEND: [f32; 2] = [0.6, 1.6];

/// Makes lines run to points, and as wide as covers the ink wanted on average about them.
pub(super) fn swell(lines: &mut [Streamline], wanted: Wanted, burin: &Tool) {
    for line in lines.iter_mut() {
        taper(line, wanted, burin);
    }
    let wanted = InkCells::of_plane(wanted.ink, CELL * burin.least_spacing);
    let point = POINT * burin.widths[0];
    for _ in 0..MENDS {
        let mut drawn = wanted.blank();
        for line in lines.iter() {
            add_line(&mut drawn, line);
        }
        let drawn = drawn.evened();
        for line in lines.iter_mut() {
            for (&at, width) in line.points.iter().zip(&mut line.widths) {
                let mend = drawn.mend(&wanted, at, MEND);
                *width = (*width * mend).clamp(point, burin.widths[1]);
            }
        }
    }
}

/// Tapers a line toward its ends: slowly at an end on open paper, abruptly at an edge.
fn taper(line: &mut Streamline, wanted: Wanted, burin: &Tool) {
    let (points, lengths) = (&line.points, lengths(&line.points));
    let [.., before, last] = points[..] else {
        return;
    };
    let whole = lengths[lengths.len() - 1];
    let ends = [(points[0], points[1]), (last, before)].map(|(end, inner)| {
        let share = match is_at_edge(end, end - inner, wanted, burin.least_spacing) {
            true => TAPER_AT_EDGE,
            false => TAPER,
        };
        (share * burin.least_spacing).min(MOST_TAPERED * whole)
    });
    for (width, length) in line.widths.iter_mut().zip(lengths) {
        let [from_start, to_end] = [length / ends[0], (whole - length) / ends[1]];
        *width *= from_start.min(to_end).clamp(0.0, 1.0).powf(POINTED);
    }
}

/// Whether a line that is dark at its end stops at an edge.
fn is_at_edge(end: Vec2, outward: Vec2, wanted: Wanted, spacing: f32) -> bool {
    let beyond = end + 0.5 * spacing.max(2.0) * outward.normalize_or_zero();
    let ink = |at: Vec2| wanted.ink_at(at).unwrap_or(0.0);
    let meets = ink(beyond) == 0.0 || wanted.is_edge(end) || wanted.is_edge(beyond);
    ink(end) > EDGE_INK && meets
}

/// Ink that does not end at nothing but at an edge.
const EDGE_INK: f32 = 0.2;

/// Adds the ink of a line.
fn add_line(cells: &mut InkCells, line: &Streamline) {
    let pieces = line.points.windows(2).zip(line.widths.windows(2));
    for (points, widths) in pieces {
        let area = points[0].distance(points[1]) * 0.5 * (widths[0] + widths[1]);
        cells.add(0.5 * (points[0] + points[1]), area);
    }
}
