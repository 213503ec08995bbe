//! Lines cut at the border of a page.

use glam::Vec2;

/// The part of a drawing that is kept, by two corners.
#[derive(Clone, Copy)]
pub(crate) struct Page {
    pub(crate) first: Vec2,
    pub(crate) last: Vec2,
}

impl Page {
    pub(crate) fn distance(self, at: Vec2) -> f32 {
        at.distance(at.clamp(self.first, self.last))
    }

    /// The parts of a line that are on the page, counted from its corner: points and widths, each with the next point
    /// beyond the border at either end.
    pub(crate) fn parts_of<'a>(
        self,
        points: &'a [Vec2],
        widths: &'a [f32],
    ) -> impl Iterator<Item = (Vec<Vec2>, Vec<f32>)> + use<'a> {
        let is_on = move |at: &Vec2| self.distance(*at) == 0.0;
        let mut next = 0;
        let runs = points.chunk_by(move |a, b| is_on(a) == is_on(b));
        runs.filter_map(move |run| {
            let start = next;
            next += run.len();
            let part = start.saturating_sub(1)..(next + 1).min(points.len());
            let moved = points[part.clone()].iter().map(|&point| point - self.first);
            is_on(&run[0]).then(|| (moved.collect(), widths[part].to_vec()))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line across a page of 3 by 3 pixels at (1, 1) enters it at x = 1 and leaves it at x = 4; the one after that
    /// comes back on its lower border.
    #[test]
    fn lines_of_a_cropped_drawing_end_a_point_beyond_its_page() {
        let across = (0..7).map(|x| Vec2::new(x as f32, 2.0));
        let back = (2..7).rev().map(|x| Vec2::new(x as f32, 4.0));
        let points: Vec<Vec2> = across.chain(back).collect();
        let widths: Vec<f32> = (0..points.len()).map(|i| i as f32).collect();
        let page = Page {
            first: Vec2::splat(1.0),
            last: Vec2::splat(4.0),
        };
        let parts: Vec<_> = page.parts_of(&points, &widths).collect();
        let at = |x: f32, y: f32| Vec2::new(x, y);
        let first = (-1..=4).map(|x| at(x as f32, 1.0)).collect::<Vec<_>>();
        let second = vec![at(4.0, 3.0), at(3.0, 3.0), at(2.0, 3.0), at(1.0, 3.0)];
        assert_eq!(parts.len(), 2);
        assert_eq!(parts[0], (first, (0..6).map(|i| i as f32).collect()));
        assert_eq!(parts[1], (second, vec![8.0, 9.0, 10.0, 11.0]));
    }
}
