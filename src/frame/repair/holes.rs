//! Filling of missing depth samples inside a surface, single or a few pixels wide.
//!
//! Through fog, glass or a leaf's alpha, a renderer that keeps the first sample's depth sometimes writes the depth of
//! the background, or none: every such pixel would be surrounded by silhouettes.

use crate::frame::depth::is_distance;
use crate::frame::normals::MIN_LENGTH;
use crate::frame::{MOST_ROWS_PER_TASK, Plane, Vector3Planes};
use glam::DVec3;
use rayon::prelude::*;

/// Number of passes over the depth: filled samples allow filling their neighbours.
const PASSES: usize = 4;

/// Width in pixels of the widest cluster of missing samples that is filled.
const WIDEST: usize = 3;

/// Number of rows and columns within which a sample can affect the filling of another.
#[cfg(feature = "cli")]
pub(crate) const HOLE_REACH: usize = PASSES * (WIDEST + 1);

/// Two depths belong to one surface if their relative difference is below this.
const SAME_SURFACE: f32 = 0.05;

/// Cosine of the largest angle between normals of one surface at neighbouring pixels: 25 degrees.
const SAME_DIRECTION: f64 = 0.9;

/// Minimum number of the four pairs of opposite neighbours that must show the surface; all four where neighbours are
/// missing too.
const FEWEST_PAIRS: usize = 2;

/// Minimum number of the eight neighbours that must show the surface where others show nothing: more than beside a
/// straight outline.
const FEWEST_BESIDE: usize = 4;

/// The most samples missing of the 25 within two columns and rows of one along an outline: a cluster of two by three.
const MOST_MISSING: usize = 6;

/// By how much the cosines of angles between a sample's normal and those of one surface differ at most.
const ALIKE: f64 = 0.1;

/// Minimum length of the sample's normal relative to the mean length of its neighbours' normals.
const WHOLE: f64 = 0.8;

/// One neighbour of each pair of opposite ones, as offsets in columns and rows.
const OPPOSITE: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];

/// A hole, and the depth of the surface there.
type Hole = ([usize; 2], f32);

/// Fills samples of `depth`, in distances, that are missing or lie behind the surface shown by all their neighbours,
/// where there is a normal. Returns the number filled.
///
/// In perspective, the inverse depth of a plane is linear in the picture: between neighbours of depths a and b, i and j
/// pixels away, the depth is (i + j) / (j / a + i / b).
pub(crate) fn fill(depth: &mut Plane, normal: &Vector3Planes) -> usize {
    let amid = fill_by_rows(depth, |depth, y| holes_in_row(depth, normal, y));
    let at_border = fill_border(depth, normal);
    amid + at_border + fill_by_rows(depth, |depth, y| missing_in_row(depth, normal, y))
}

/// Fills the holes that are found in each row, again and again while there are any. Returns their number.
fn fill_by_rows(depth: &mut Plane, holes: impl Fn(&Plane, usize) -> Vec<Hole> + Sync) -> usize {
    let mut filled = 0;
    for _ in 0..PASSES {
        let here = &*depth;
        let found: Vec<_> = (0..here.height())
            .into_par_iter()
            .with_max_len(MOST_ROWS_PER_TASK)
            .flat_map_iter(|y| holes(here, y))
            .collect();
        if found.is_empty() {
            break;
        }
        filled += put(&found, depth);
    }
    filled
}

/// Fills the holes of the outermost rows and columns, which have neighbours on one side only.
fn fill_border(depth: &mut Plane, normal: &Vector3Planes) -> usize {
    let (width, height) = (depth.width(), depth.height());
    if width < 3 || height < 3 {
        return 0;
    }
    let columns = |y: usize| match y == 0 || y + 1 == height {
        true => (0..width).step_by(1),
        false => (0..width).step_by(width - 1),
    };
    let found: Vec<_> = (0..height)
        .flat_map(|y| columns(y).map(move |x| [x, y]))
        .filter_map(|at| Some((at, surface_within(depth, normal, at)?)))
        .collect();
    put(&found, depth)
}

/// Fills holes. Returns their number.
fn put(found: &[Hole], depth: &mut Plane) -> usize {
    for &([x, y], surface) in found {
        depth.row_mut(y)[x] = surface;
    }
    found.len()
}

/// The depth at a pixel of the border, if it is a hole, of the plane through the two pixels further in, if their
/// normals resemble its own. A farther sample is a hole only between two that lie on that plane.
fn surface_within(depth: &Plane, normal: &Vector3Planes, [x, y]: [usize; 2]) -> Option<f32> {
    let inward = |at: usize, length: usize| match at {
        0 => 1,
        _ if at + 1 == length => -1,
        _ => 0,
    };
    let [dx, dy] = [inward(x, depth.width()), inward(y, depth.height())];
    let moved = |by: isize, [dx, dy]: [isize; 2]| {
        [
            x.wrapping_add_signed(by * dx),
            y.wrapping_add_signed(by * dy),
        ]
    };
    let sample = |[x, y]: [usize; 2]| Some(depth.at(x, y)).filter(|&sample| is_distance(sample));
    let is_near = |a: f32, b: f32| (a / b - 1.0).abs() <= SAME_SURFACE;
    let [next, second] = [1, 2].map(|by| moved(by, [dx, dy]));
    let (a, b) = (sample(next)?, sample(second)?);
    let surface = (2.0 / a - 1.0 / b).recip();
    let farther = sample([x, y]);
    if !is_near(surface, a) || farther.is_some_and(|here| here <= (1.0 + SAME_SURFACE) * surface) {
        return None;
    }
    let here = direction(normal, x, y)?;
    let resembles =
        |[x, y]: [usize; 2]| direction(normal, x, y).is_some_and(|n| n.dot(here) > SAME_DIRECTION);
    // Along the border; a corner has no such neighbours.
    let is_between = || {
        let mut along = [1, -1]
            .map(|by| moved(by, [dy.abs(), dx.abs()]))
            .into_iter();
        let is_on_plane = |at| sample(at).is_some_and(|sample| is_near(sample, surface));
        (dx == 0 || dy == 0) && along.all(is_on_plane)
    };
    (resembles(next) && resembles(second) && (farther.is_none() || is_between())).then_some(surface)
}

/// The holes of row `y` that have neighbours on all sides.
fn holes_in_row(depth: &Plane, normal: &Vector3Planes, y: usize) -> Vec<Hole> {
    if y == 0 || y + 1 == depth.height() {
        return Vec::new();
    }
    let pixels = (1..).zip(depth.row(y).windows(3));
    let holes = pixels.filter(|(_, near)| may_be_hole(near[1], [near[0], near[2]]));
    let found = holes.filter_map(|(x, _)| Some(([x, y], surface_of_hole(depth, normal, [x, y])?)));
    found.collect()
}

/// The missing samples of row `y` whose surface is seen beside them.
fn missing_in_row(depth: &Plane, normal: &Vector3Planes, y: usize) -> Vec<Hole> {
    let row = (0..).zip(depth.row(y));
    let missing = row.filter(|(_, sample)| !is_distance(**sample));
    let found = missing.filter_map(|(x, _)| Some(([x, y], surface_beside(depth, normal, [x, y])?)));
    found.collect()
}

/// Whether a sample is none, or farther than both neighbours: most are not.
fn may_be_hole(here: f32, beside: [f32; 2]) -> bool {
    let [is_near, is_near_too] = beside.map(|other| here <= (1.0 + SAME_SURFACE) * other);
    !(is_distance(here) & (is_near | is_near_too))
}

/// The depth of the surface at a pixel that may be a hole, if it is one.
fn surface_of_hole(depth: &Plane, normal: &Vector3Planes, [x, y]: [usize; 2]) -> Option<f32> {
    // Without depth above only one pair is left, along the row, which is too few: most of a background is like that.
    let above = &depth.row(y - 1)[x - 1..=x + 1];
    if !above.iter().copied().any(is_distance) {
        return None;
    }
    let here = depth.at(x, y);
    match is_distance(here) {
        // Beyond neighbours of the same depth a gap may lie, through which it is seen.
        true => surface_at(depth, normal, [x, y], 1)
            .filter(|surface| here > (1.0 + SAME_SURFACE) * surface),
        false => surface_at(depth, normal, [x, y], 1)
            .or_else(|| surface_at(depth, normal, [x, y], WIDEST)),
    }
}

/// The depth of the surface shown by opposite neighbours, if enough pairs do, all agree, and the sample's normal
/// resembles theirs. Across missing samples, neighbours may be up to `most` pixels away.
fn surface_at(
    depth: &Plane,
    normal: &Vector3Planes,
    [x, y]: [usize; 2],
    most: usize,
) -> Option<f32> {
    let here = direction(normal, x, y)?;
    // Steps to a neighbour and its inverse depth; zeros if it is too far, `None` if it shows another surface.
    let neighbour = |[dx, dy]: [isize; 2]| -> Option<(usize, f32)> {
        let (mut column, mut row) = (x, y);
        for steps in 1..=most {
            column = column.wrapping_add_signed(dx);
            row = row.wrapping_add_signed(dy);
            if column >= depth.width() || row >= depth.height() {
                break;
            }
            let is_same = |n: DVec3| n.dot(here) > SAME_DIRECTION;
            if !direction(normal, column, row).is_none_or(is_same) {
                return None;
            }
            let sample = depth.at(column, row);
            if is_distance(sample) {
                return Some((steps, sample.recip()));
            }
        }
        Some((0, 0.0))
    };
    let (mut count, mut sum, mut farthest) = (0, 0.0, 0);
    let (mut least, mut most_found) = (f32::INFINITY, 0.0f32);
    for [dx, dy] in OPPOSITE {
        let ((i, a), (j, b)) = (neighbour([dx, dy])?, neighbour([-dx, -dy])?);
        farthest = farthest.max(i).max(j);
        if i > 0 && j > 0 {
            let between = (i + j) as f32 / (j as f32 * a + i as f32 * b);
            (least, most_found) = (least.min(between), most_found.max(between));
            count += 1;
            sum += between;
        }
    }
    let agree = most_found <= (1.0 + SAME_SURFACE) * least;
    let fewest = if farthest > 1 {
        OPPOSITE.len()
    } else {
        FEWEST_PAIRS
    };
    (count >= fewest && agree).then(|| sum / count as f32)
}

/// The depth of the surface beside a missing sample that its normal resembles most: the mean of the neighbours that show
/// it. Few may be missing around. Where a neighbour shows nothing the pixel may show nothing too: there four neighbours
/// must show the surface, and the sample's normal must be about as long as theirs.
fn surface_beside(depth: &Plane, normal: &Vector3Planes, [x, y]: [usize; 2]) -> Option<f32> {
    let here = direction(normal, x, y)?;
    let near =
        |at: usize, by: usize, length: usize| at.saturating_sub(by)..(at + by + 1).min(length);
    let square = |by: usize| {
        let rows = near(y, by, depth.height());
        rows.flat_map(move |y| near(x, by, depth.width()).map(move |x| [x, y]))
    };
    let is_missing = |[x, y]: &[usize; 2]| !is_distance(depth.at(*x, *y));
    let mut is_amid = true;
    let mut shown = Vec::with_capacity(8);
    for at @ [x, y] in square(1) {
        match direction(normal, x, y) {
            Some(n) if !is_missing(&at) => shown.push((at, n.dot(here), depth.at(x, y))),
            Some(_) => {}
            None => is_amid = false,
        }
    }
    let &(_, best, of_best) = shown.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    shown.retain(|&(_, cosine, sample)| {
        cosine > best - ALIKE && (sample / of_best - 1.0).abs() <= SAME_SURFACE
    });
    let lengths = shown.iter().map(|([x, y], ..)| normal.at(*x, *y).length());
    let length = lengths.sum::<f64>() / shown.len() as f64;
    let is_shown = match is_amid {
        true => 25 * square(2).filter(is_missing).count() <= MOST_MISSING * square(2).count(),
        false => shown.len() >= FEWEST_BESIDE && normal.at(x, y).length() > WHOLE * length,
    };
    let inverses = shown.iter().map(|(.., sample)| sample.recip());
    is_shown.then(|| shown.len() as f32 / inverses.sum::<f32>())
}

/// The unit normal of a pixel, where it has one.
fn direction(normal: &Vector3Planes, x: usize, y: usize) -> Option<DVec3> {
    let n = normal.at(x, y);
    (n.is_finite() && n.length() > f64::from(MIN_LENGTH)).then(|| n.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: usize = 24;

    /// Normals toward the viewer everywhere.
    fn facing() -> Vector3Planes {
        let zero = Plane::filled(SIZE, SIZE, 0.0);
        Vector3Planes {
            x: zero.clone(),
            y: zero.clone(),
            z: Plane::filled(SIZE, SIZE, 1.0),
        }
    }

    /// The distance of a plane: its inverse is linear in the picture.
    fn slope(x: usize, y: usize) -> f32 {
        1.0 / (0.2 + 0.002 * x as f32 - 0.001 * y as f32)
    }

    #[test]
    fn samples_of_fog_are_filled_with_the_plane_around_them() {
        for behind in [1e10, f32::INFINITY, 0.0, f32::NAN, 40.0] {
            let is_hole = |x: usize, y: usize| x % 3 == 1 && y % 2 == 1;
            let mut depth = Plane::from_fn(SIZE, SIZE, |x, y| match is_hole(x, y) {
                true => behind,
                false => slope(x, y),
            });
            assert!(fill(&mut depth, &facing()) > SIZE * SIZE / 8);
            // The last row, of the outermost, has holes too.
            for y in 0..SIZE {
                for x in 0..SIZE {
                    // A mean of harmonic means on a plane is exact up to rounding, and so is the line through two.
                    let error = depth.at(x, y) / slope(x, y) - 1.0;
                    assert!(error.abs() < 1e-5, "{behind} at {x}, {y}: {error}");
                }
            }
        }
    }

    #[test]
    fn clusters_are_filled_where_the_surface_goes_on_all_around() {
        let clusters = |side: usize| {
            move |x: usize, y: usize| x % 8 >= 8 - side && y % 8 >= 8 - side && x < 17 && y < 17
        };
        for side in 1..=WIDEST {
            let is_hole = clusters(side);
            let mut depth = Plane::from_fn(SIZE, SIZE, |x, y| match is_hole(x, y) {
                true => f32::INFINITY,
                false => slope(x, y),
            });
            assert_eq!(fill(&mut depth, &facing()), 4 * side * side);
            for (x, y) in (0..SIZE * SIZE).map(|i| (i % SIZE, i / SIZE)) {
                let error = depth.at(x, y) / slope(x, y) - 1.0;
                assert!(error.abs() < 1e-5, "{side} at {x}, {y}: {error}");
            }
        }
        // Larger ones, stripes, and those at the end of a normal stay.
        let slit = |x: usize, _: usize| (9..11).contains(&x);
        let mut outline = folded();
        // A pixel of the left side that its surface covers by half, beside one that shows nothing.
        outline.z.row_mut(9)[11] = 0.5;
        outline.x.row_mut(9)[12] = 0.0;
        outline.z.row_mut(9)[12] = 0.0;
        let half = |x: usize, y: usize| (x, y) == (11, 9);
        let is_hole: [&dyn Fn(usize, usize) -> bool; 3] = [&clusters(6), &slit, &half];
        let normals = [facing(), facing(), outline];
        for (is_hole, normal) in is_hole.into_iter().zip(&normals) {
            let stored = Plane::from_fn(SIZE, SIZE, |x, y| match is_hole(x, y) {
                true => 0.0,
                false => slope(x, y),
            });
            let mut depth = stored.clone();
            assert_eq!(fill(&mut depth, normal), 0);
            assert_eq!(depth.samples(), stored.samples());
        }
    }

    /// Normals that turn by 53 degrees between columns 11 and 12.
    fn folded() -> Vector3Planes {
        let mut normal = facing();
        for y in 0..SIZE {
            normal.x.row_mut(y)[12..].fill(0.8);
            normal.z.row_mut(y)[12..].fill(0.6);
        }
        normal
    }

    #[test]
    fn along_a_fold_or_an_outline_a_sample_is_of_the_side_it_resembles() {
        for behind in [5.1, 9.0] {
            let depth_of = |x: usize| if x < 12 { 5.0 } else { behind };
            let is_hole = |x: usize, y: usize| (11..13).contains(&x) && y % 4 == 2;
            let mut depth = Plane::from_fn(SIZE, SIZE, |x, y| match is_hole(x, y) {
                true => f32::INFINITY,
                false => depth_of(x),
            });
            assert_eq!(fill(&mut depth, &folded()), 12);
            for (x, y) in (0..SIZE * SIZE).map(|i| (i % SIZE, i / SIZE)) {
                let error = depth.at(x, y) / depth_of(x) - 1.0;
                assert!(error.abs() < 1e-6, "{behind} at {x}, {y}: {error}");
            }
        }
    }

    #[test]
    fn what_is_seen_between_things_and_beside_them_stays() {
        let mut normal = facing();
        let scenes: [fn(usize, usize) -> f32; 4] = [
            // A step to a wall behind, a gap of one pixel to it, a wire in front, and single nearer pixels.
            |x, y| if x + y < SIZE { 5.0 } else { 9.0 },
            |x, _| if x == 9 { 9.0 } else { 5.0 },
            |x, y| if x == y { 5.0 } else { 9.0 },
            |x, y| if x % 5 == 2 && y % 5 == 2 { 5.0 } else { 9.0 },
        ];
        for scene in scenes {
            let stored = Plane::from_fn(SIZE, SIZE, scene);
            let mut depth = stored.clone();
            assert_eq!(fill(&mut depth, &normal), 0);
            assert_eq!(depth.samples(), stored.samples());
        }
        // Without a normal there is no surface.
        let mut depth = Plane::filled(SIZE, SIZE, 5.0);
        depth.row_mut(9)[9] = f32::INFINITY;
        normal.z.row_mut(9)[9] = 0.0;
        assert_eq!(fill(&mut depth, &normal), 0);
        assert_eq!(fill(&mut Plane::filled(1, 1, 0.0), &normal), 0);
    }
}
