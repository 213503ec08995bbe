//! Clutter: fur, leaves and fog, whose silhouettes lie closer together than a drawing can tell apart, and specks of a pixel
//! or two, as are left where alpha cut a leaf out.
//!
//! Practice: a draughtsman gives such a thing one outline and the tone of its mass. So each of its pixels becomes the mean
//! of those around it that are about as far away as most of them.

use super::enlarged::around_pixel;
use super::gap::of_frame::is_beside;
use super::gap::scale::GapScale;
use super::repair::squares::mean_over_squares;
use super::{Frame, Mask, Plane};
use crate::kernel::quantile::quantile;
use crate::params::ShapeParams;

/// Half the side of the square that silhouettes are counted in, as a share of the picture's size.
const REACH: f32 = 1.0 / 72.0;

/// The same in pixels at the least, so that two lines within the square stay below [`DENSE`].
const LEAST_REACH: usize = 4;

/// From this share of pixels at silhouettes on there is clutter: two lines within the square give a fourth or less.
const DENSE: f32 = 0.28;

/// From this share of such places on, the pixels between them are clutter too.
const BETWEEN: f32 = 0.2;

/// The radius within which a mass is averaged, as a share of the picture's size; and that of fur.
const MASS: f32 = 1.0 / 60.0;
const FUR: f32 = 1.0 / 30.0;

/// Pixels that are averaged, to each side at the most: of wide masses every second one, or third. With 7 the disc would have
/// more than 128 pixels.
const MOST_STEPS: usize = 6;

/// What differs by less than this share of the picture's longer side in depth is of one mass.
const DEEP: f32 = 0.05;

impl Frame {
    /// The frame with its clutter made into masses; `None` if it has none. `parted` tells its silhouettes:
    /// see [`super::gap::of_frame::parted`].
    pub(super) fn calmed(&self, parted: &Plane<[bool; 2]>) -> Option<Frame> {
        let depth = self.depth.as_ref()?;
        let is_at_silhouette = Plane::of_pixels(depth.width(), depth.height(), |x, y| {
            let is_hidden = |[i, k]: [usize; 2], is_parted: bool| {
                !self.mask.at(i, k) || is_parted && depth.at(x, y) < depth.at(i, k)
            };
            self.mask.at(x, y)
                && is_beside(parted, [x, y]).any(|(at, is_parted)| is_hidden(at, is_parted))
        });
        let size = self.display_window.size_px();
        let reach = ((REACH * size).round() as usize).max(LEAST_REACH);
        let dense = share_around(&is_at_silhouette, reach).map(|share| share > DENSE);
        let mut is_clutter = share_around(&dense, reach).map(|share| share > BETWEEN);
        let scale = GapScale::of(self, ShapeParams::default().silhouette);
        let specks = specks(depth, &self.mask, &scale);
        let fur = self.fur(depth, reach);
        for more in [&specks, &fur] {
            is_clutter.each_with(more, |own, is_more| *own |= is_more);
        }
        if !is_clutter.samples().contains(&true) {
            return None;
        }
        let mut calm = Masses::new(self, scale, is_clutter, MASS).averaged();
        let has_fur = fur.samples().contains(&true);
        for share in [FUR, FUR, MASS].into_iter().filter(|_| has_fur) {
            calm = Masses::new(&calm, scale, fur.clone(), share).averaged();
        }
        Some(calm)
    }
}

/// Covered pixels before or behind others within a column and a row, of which none is about as far away, or one that has no
/// other.
fn specks(depth: &Plane, mask: &Mask, scale: &GapScale) -> Plane<bool> {
    let size = [depth.width(), depth.height()];
    let alike = |at @ [x, y]: [usize; 2]| {
        around_pixel(at, size, 2).filter(move |&[i, k]| {
            mask.at(i, k) && is_of_one_mass(scale, [depth.at(x, y), depth.at(i, k)])
        })
    };
    Plane::of_pixels(size[0], size[1], |x, y| {
        let mut beside = alike([x, y]);
        let (first, second) = (beside.next(), beside.next());
        let is_alone = first.is_none_or(|other| alike(other).nth(1).is_none());
        let mut others = around_pixel([x, y], size, 2).filter(|&at| Some(at) != first);
        mask.at(x, y) && second.is_none() && is_alone && others.any(|[x, y]| mask.at(x, y))
    })
}

/// Whether two depths are about as far as each other.
fn is_of_one_mass(scale: &GapScale, depths: [f32; 2]) -> bool {
    scale.jump_px(depths, 0) < DEEP * scale.side
}

/// The share of pixels within so many columns and rows that are set; beyond the picture none is.
pub(super) fn share_around(is_set: &Plane<bool>, reach: usize) -> Plane {
    mean_over_squares(&is_set.map(|is_set| f32::from(u8::from(is_set))), reach)
}

/// The masses of a frame.
struct Masses<'a> {
    frame: &'a Frame,
    depth: &'a Plane,
    scale: GapScale,
    /// Columns and rows from a pixel to those that are averaged: at most 113, which 128 bits can choose among.
    disc: Vec<[isize; 2]>,
    /// The depth of the mass seen at each pixel of clutter, where most pixels around it are covered; NaN elsewhere.
    middle: Plane,
    is_clutter: Plane<bool>,
}

impl<'a> Masses<'a> {
    /// The masses of pixels of clutter, averaged within this share of the picture's size.
    fn new(frame: &'a Frame, scale: GapScale, is_clutter: Plane<bool>, share: f32) -> Self {
        let depth = frame.depth.as_ref().expect("clutter is told by depth");
        let radius = (share * frame.display_window.size_px()).round().max(1.0) as usize;
        let step = radius.div_ceil(MOST_STEPS);
        let (step, steps) = (step as isize, (radius / step) as isize);
        let square = (-steps..=steps).flat_map(|down| (-steps..=steps).map(move |a| [a, down]));
        let disc = square.filter(|[a, down]| a * a + down * down <= steps * steps);
        let mut masses = Self {
            frame,
            depth,
            scale,
            disc: disc.map(|at| at.map(|steps| steps * step)).collect(),
            middle: Plane::default(),
            is_clutter,
        };
        masses.middle = Plane::of_pixels(depth.width(), depth.height(), |x, y| {
            masses.middle_around([x, y]).unwrap_or(f32::NAN)
        });
        masses
    }

    /// The pixels around, with their bits.
    fn around(&self, [x, y]: [usize; 2]) -> impl Iterator<Item = (u128, [usize; 2])> {
        let (width, height) = (self.depth.width(), self.depth.height());
        let places = self
            .disc
            .iter()
            .enumerate()
            .map(move |(i, [across, down])| {
                let place = [x.wrapping_add_signed(*across), y.wrapping_add_signed(*down)];
                (1 << i, place)
            });
        places.filter(move |(_, [x, y])| *x < width && *y < height)
    }

    /// The middle depth around a pixel of clutter, if most of the pixels there are covered.
    fn middle_around(&self, at: [usize; 2]) -> Option<f32> {
        if !self.is_clutter.at(at[0], at[1]) {
            return None;
        }
        let mut count = 0;
        let around = self.around(at).inspect(|_| count += 1);
        let covered = around.filter(|(_, [x, y])| self.frame.mask.at(*x, *y));
        let mut depths: Vec<f32> = covered.map(|(_, [x, y])| self.depth.at(x, y)).collect();
        if 2 * depths.len() <= count {
            return None;
        }
        quantile(&mut depths, 0.5, f32::total_cmp)
    }

    /// The frame with the means of masses in place of their pixels.
    fn averaged(&self) -> Frame {
        let frame = self.frame;
        let [width, height] = [self.depth.width(), self.depth.height()];
        let mask = Mask::new(Plane::from_fn(width, height, |x, y| {
            match self.is_clutter.at(x, y) {
                true => !self.middle.at(x, y).is_nan(),
                false => frame.mask.at(x, y),
            }
        }));
        let members = Plane::of_pixels(width, height, |x, y| self.members([x, y]));
        let means = |plane: &Plane| {
            Plane::of_pixels(width, height, |x, y| match members.at(x, y) {
                0 => plane.at(x, y),
                chosen => self.mean(plane, [x, y], chosen),
            })
        };
        let mut calm = frame.with_planes(mask, means);
        calm.objects = frame.objects.clone();
        if let Some(lengths) = &mut calm.normal_length {
            // A mass has no edges within pixels.
            lengths.each_with(&self.middle, |length, middle| {
                *length = if middle.is_nan() { *length } else { 1.0 };
            });
        }
        calm.normal.make_unit();
        calm
    }

    /// The bits of those around a pixel whose mean it becomes: of its mass, and of the clutter or beside it, whichever
    /// are more. None for what stays as it is.
    fn members(&self, [x, y]: [usize; 2]) -> u128 {
        let middle = self.middle.at(x, y);
        if middle.is_nan() {
            return 0;
        }
        let is_of_mass = |[x, y]: [usize; 2]| {
            let depths = [middle, self.depth.at(x, y)];
            self.frame.mask.at(x, y) && is_of_one_mass(&self.scale, depths)
        };
        let mut chosen = [0_u128; 2];
        for (bit, at) in self.around([x, y]).filter(|(_, at)| is_of_mass(*at)) {
            chosen[usize::from(self.is_clutter.at(at[0], at[1]))] |= bit;
        }
        let [beside, within] = chosen;
        match beside.count_ones() > within.count_ones() {
            // What is seen between strands.
            true if is_of_mass([x, y]) => 0,
            true => beside,
            false => within,
        }
    }

    /// The mean of a plane over the pixels around that have been chosen.
    fn mean(&self, plane: &Plane, [x, y]: [usize; 2], chosen: u128) -> f32 {
        let (mut left, mut sum) = (chosen, 0.0);
        while left != 0 {
            let [across, down] = self.disc[left.trailing_zeros() as usize];
            sum += plane.at(x.wrapping_add_signed(across), y.wrapping_add_signed(down));
            left &= left - 1;
        }
        sum / chosen.count_ones() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Vector3Planes;
    use crate::frame::gap::of_frame::parted;
    use glam::DVec3;

    /// Facing pixels at depth 2, but for `far` of 10 in random places right of column 100, at depth 4.
    fn thicket(far: u32) -> Frame {
        let is_far = |x: usize, y: usize| {
            let noise = (x as u32).wrapping_mul(73_856_093) ^ (y as u32).wrapping_mul(19_349_663);
            x > 100 && (noise.wrapping_mul(2_654_435_769) >> 16) % 10 < far
        };
        let depth = Plane::from_fn(200, 150, |x, y| if is_far(x, y) { 4.0 } else { 2.0 });
        Frame {
            depth: Some(depth),
            ..Frame::of_normals(
                Vector3Planes::from_fn(200, 150, |_, _| DVec3::Z),
                Mask::full(200, 150),
            )
        }
    }

    fn borders(frame: &Frame) -> Plane<[bool; 2]> {
        parted(frame, ShapeParams::default().silhouette).expect("the frame has depth")
    }

    /// How many pixels have a silhouette to the right or below.
    fn silhouettes(frame: &Frame) -> usize {
        let parted = borders(frame);
        let is_any = |&[right, below]: &[bool; 2]| right || below;
        parted.samples().iter().filter(|any| is_any(any)).count()
    }

    #[test]
    fn a_thicket_becomes_one_mass() {
        let frame = thicket(1);
        let calm = frame.calmed(&borders(&frame)).expect("there is clutter");
        // One of three pixels is unlike the others in 1 - .9^3 - .1^3 = .27 of 14,850 places.
        let (before, after) = (silhouettes(&frame), silhouettes(&calm));
        assert!(before > 3_000 && 5 * after < before, "{before} {after}");
        // Nine of ten tell how far it is, but where there happen to be few others; what lies beside it is untouched.
        let far = |frame: &Frame, columns: std::ops::Range<usize>| {
            let depth = frame.depth.as_ref().expect("the frame has depth");
            let row = |y| depth.row(y)[columns.clone()].iter();
            let depths = (10..140).flat_map(row);
            depths.filter(|&&depth| depth != 2.0).count()
        };
        let [before, after] = [&frame, &calm].map(|frame| far(frame, 110..190));
        assert!(before > 1_000 && 20 * after < before, "{before} {after}");
        assert_eq!(far(&calm, 10..90), 0);
    }

    #[test]
    fn specks_become_what_is_around_them() {
        let mut frame = thicket(0);
        let depth = frame.depth.as_mut().expect("the frame has depth");
        depth.row_mut(50)[30] = 1.0;
        depth.row_mut(90)[60..62].fill(1.0);
        depth.row_mut(90)[120..123].fill(1.0);
        // A wire.
        for i in 0..30 {
            depth.row_mut(100 + i)[20 + i] = 1.0;
        }
        let calm = frame.calmed(&borders(&frame)).expect("there are specks");
        let depth = calm.depth.expect("the frame has depth");
        let rest: Vec<usize> = (0..depth.samples().len())
            .filter(|&i| depth.samples()[i] != 2.0)
            .collect();
        // Three in a row are a thing.
        let wire = (0..30).map(|i| (100 + i) * 200 + 20 + i);
        let kept: Vec<usize> = (0..3).map(|i| 90 * 200 + 120 + i).chain(wire).collect();
        assert_eq!(rest, kept);
        // Stars have nothing around them to become.
        let is_star = |x: usize, y: usize| x % 20 == 7 && y % 15 < 2;
        let mut stars = thicket(0);
        stars.mask = Mask::new(Plane::from_fn(200, 150, is_star));
        assert!(stars.calmed(&borders(&stars)).is_none());
    }

    #[test]
    fn a_few_lines_are_no_clutter() {
        let mut frame = thicket(0);
        assert!(frame.calmed(&borders(&frame)).is_none());
        // Bars of three pixels, nine apart: two silhouettes in nine columns, .22.
        let bars = Plane::from_fn(200, 150, |x, _| if x % 9 < 3 { 2.0 } else { 4.0 });
        frame.depth = Some(bars);
        assert!(frame.calmed(&borders(&frame)).is_none());
    }
}
