//! Plain backgrounds, which are drawn quieter than the subject: the floor and the walls about it, up to where it stands on
//! them.

use super::{BARE, CLEAR_TURN, activity, lightened};
use crate::frame::{Mask, Plane};
use crate::kernel::quantile::quantile;
use crate::line::background::Backdrop;
use crate::line::direction_field::setting::OPEN;
use crate::line::smooth_step::smooth_step;
use crate::params;

/// How much of the ink on a plain background is left out where it is to be quieter than the subject.
const QUIET: f32 = 0.8;

/// By how much ink is to be darker than it usually is on a plane to be a shadow, the share of that which is drawn, the most
/// ink in it, and how far from the subject it fades, as a share of the picture's size.
const SHADOW_FROM: f32 = 0.04;
const SHADOW: f32 = 0.92;
const MOST_SHADOW: f32 = 0.7;
const SHADOW_REACH: f32 = 1.0 / 7.0;

/// How far shadows are smoothed, and between which distances from the subject a plane has its usual ink, as shares of the
/// picture's size: light that falls off over a wall is no shadow.
const SHADOW_SMOOTHING: f32 = 1.0 / 90.0;
const LIT_BETWEEN: [f32; 2] = [1.0 / 12.0, 1.0 / 4.0];

/// The ink where the subject stands on a plane, and how far from there it fades, as a share of the picture's size.
const CONTACT: f32 = 0.88;
const CONTACT_REACH: f32 = 1.0 / 55.0;

/// The share of ink that fades far behind the subject, and of the reach of the dark line where things stand: they are
/// smaller there.
const FADED: f32 = 0.75;

/// Below this activity the surface counts as plain.
const PLAIN: f32 = 0.5;

/// How far a background reaches into what is active only for the subject beside it, as a share of the picture's size: twice
/// the width by which activity spreads.
const UP_TO_SUBJECT: f32 = 1.0 / 30.0;

/// How much of the activity about a place counts where the place itself is plain: shadows fade out from where a subject
/// stands.
const FADING: f32 = 0.3;

/// The share of ink that a background leaves out where it is plain.
pub(super) fn left_out(background: params::Background) -> f32 {
    match background {
        params::Background::Strokes => 0.0,
        params::Background::Plain => QUIET,
        params::Background::None => 1.0,
    }
}

/// A tone with this share of its ink left out; what is nearly paper then becomes paper.
#[inline(always)]
pub(super) fn quieter(tone: f32, share: f32) -> f32 {
    let tone = lightened(tone, share);
    lightened(tone, share * smooth_step(BARE, tone))
}

/// The ink of cells with planes behind the subject left to the paper, but for its shadow and where it stands on them; what
/// lies far behind it fades. `spread` smooths ink by so many cells where all is open.
pub(super) fn behind_subject(
    ink: Plane,
    background: &Backdrop,
    is_blank: bool,
    spread: impl Fn(Plane, &Plane, f32) -> Plane,
) -> Plane {
    let (width, height) = (ink.width(), ink.height());
    let size = background.size;
    let usual = usual_inks(&ink, background);
    let open = Plane::from_fn(width, height, |x, y| {
        f32::from(u8::from(background.plane(x, y).is_some()))
    });
    let smooth = spread(ink.clone(), &open, SHADOW_SMOOTHING * size);
    Plane::from_fn(width, height, |x, y| {
        let own = ink.at(x, y);
        let left = 1.0 - FADED * background.remote.at(x, y);
        let ink = match background.plane(x, y) {
            Some(_) if is_blank => 0.0,
            Some(plane) => {
                let near = (background.to_subject.at(x, y) / (SHADOW_REACH * size)).powi(2);
                let darker = smooth.at(x, y) - usual[usize::from(plane) - 1] - SHADOW_FROM;
                let shadow = SHADOW * darker.max(0.0) * (-near).exp();
                let contact = background.to_contact.at(x, y) / (CONTACT_REACH * size * left);
                let shadow = shadow.min(MOST_SHADOW).min(own + SHADOW_FROM);
                shadow.max(CONTACT * (-contact).exp())
            }
            None => own,
        };
        ink * left
    })
}

/// The median ink of every plane at some distance from the subject, or of all of it where there is little.
fn usual_inks(ink: &Plane, background: &Backdrop) -> Vec<f32> {
    let [from, to] = LIT_BETWEEN.map(|share| share * background.size);
    let mut inks = vec![[Vec::new(), Vec::new()]; background.count()];
    for y in 0..ink.height() {
        for x in 0..ink.width() {
            if let Some(plane) = background.plane(x, y) {
                let [around, all] = &mut inks[usize::from(plane) - 1];
                all.push(ink.at(x, y));
                let is_around = (from..to).contains(&background.to_subject.at(x, y));
                around.extend(is_around.then_some(ink.at(x, y)));
            }
        }
    }
    let median = |[mut around, mut all]: [Vec<f32>; 2]| {
        let of = if around.len() > 50 {
            &mut around
        } else {
            &mut all
        };
        quantile(of, 0.5, f32::total_cmp).unwrap_or(0.0)
    };
    inks.into_iter().map(median).collect()
}

/// How much cells are plain background, 0..1: plain ones that the border of a picture of this `size` in cells reaches over
/// plain ones. `turn` is that of normals, in radians over the picture's size, and `active` its activity around cells.
pub(super) fn plainness(
    mask: &Mask,
    size: f32,
    turn: &Plane,
    active: &Plane,
    conductance: &Plane,
) -> Plane {
    let (width, height) = (mask.width(), mask.height());
    let own = |x: usize, y: usize| activity(turn.at(x, y) / CLEAR_TURN);
    let around = |x: usize, y: usize| active.at(x, y);
    let is_open = |&[x, y]: &[usize; 2]| conductance.at(x, y) > OPEN;
    let cells = || (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let on_border = |&[x, y]: &[usize; 2]| {
        (x == 0 || y == 0 || x + 1 == width || y + 1 == height)
            && mask.at(x, y)
            && around(x, y) < PLAIN
    };
    let mut found = Plane::filled(width, height, false);
    let mut front: Vec<[usize; 2]> = cells().filter(on_border).collect();
    for &[x, y] in &front {
        found.row_mut(y)[x] = true;
    }
    // Edges are reached, and lead no farther.
    while !front.is_empty() {
        front.retain(is_open);
        front = reached_beside(&front, &mut found, mask, around);
    }
    front = cells().filter(|&[x, y]| found.at(x, y)).collect();
    for _ in 0..(UP_TO_SUBJECT * size).ceil() as usize {
        front.retain(is_open);
        front = reached_beside(&front, &mut found, mask, own);
    }
    Plane::from_fn(width, height, |x, y| match found.at(x, y) {
        true => 1.0 - own(x, y).max(FADING * around(x, y)).min(around(x, y)),
        false => 0.0,
    })
}

/// The plain cells beside a front that were not found so far; now they are.
fn reached_beside(
    front: &[[usize; 2]],
    found: &mut Plane<bool>,
    mask: &Mask,
    activity: impl Fn(usize, usize) -> f32,
) -> Vec<[usize; 2]> {
    let beside = front.iter().flat_map(|&[x, y]| {
        [
            [x.wrapping_sub(1), y],
            [x + 1, y],
            [x, y.wrapping_sub(1)],
            [x, y + 1],
        ]
    });
    let is_new = |&[x, y]: &[usize; 2]| {
        let is_plain = mask.has(x, y) && !found.at(x, y) && activity(x, y) < PLAIN;
        if is_plain {
            found.row_mut(y)[x] = true;
        }
        is_plain
    };
    beside.filter(is_new).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_floor_is_plain_up_to_what_stands_on_it() {
        // A rough square on a floor, 120 cells wide, so that the floor reaches 4 cells into what is active for the square
        // beside it. A plain window in the square is none of it.
        let within = |range: std::ops::Range<usize>, x: usize, y: usize| {
            range.contains(&x) && range.contains(&y)
        };
        let cells = |f: &dyn Fn(usize, usize) -> bool| {
            Plane::from_fn(120, 120, |x, y| f32::from(u8::from(f(x, y))))
        };
        let turn = cells(&|x, y| within(50..70, x, y) && !within(57..63, x, y)).map(|v| 30.0 * v);
        let active = cells(&|x, y| within(46..74, x, y));
        let open = cells(&|x, _| x != 20);
        let plain = plainness(&Mask::full(120, 120), 120.0, &turn, &active, &open);
        let row = |y| [30, 45, 46, 49, 50, 60].map(|x| plain.at(x, y));
        let beside = 1.0 - FADING;
        assert_eq!(row(60), [1.0, 1.0, beside, beside, 0.0, 0.0]);
        assert_eq!(row(10), [1.0; 6]);
        assert_eq!(plain.at(20, 60), 1.0);
    }

    #[test]
    fn what_is_behind_an_edge_is_no_background() {
        // Columns 4 and 5 are closed all round by an edge; column 3 is the edge itself, which is reached.
        let flat = Plane::filled(10, 10, 0.0);
        let inside = |x: usize, y: usize| (3..7).contains(&x) && (3..7).contains(&y);
        let core = |x: usize, y: usize| (4..6).contains(&x) && (4..6).contains(&y);
        let open = Plane::from_fn(10, 10, |x, y| {
            f32::from(u8::from(!inside(x, y) || core(x, y)))
        });
        let plain = plainness(&Mask::full(10, 10), 10.0, &flat, &flat, &open);
        assert_eq!(
            [2, 3, 4, 5, 6, 7].map(|x| plain.at(x, 4)),
            [1.0, 1.0, 0.0, 0.0, 1.0, 1.0]
        );
    }

    #[test]
    fn what_is_nearly_paper_becomes_paper() {
        // Half of the ink: 0.96 and then 8/9 of the way from 0.88 to 0.97, of which the smooth step is 0.967.
        assert!((quieter(0.92, 0.5) - (0.96 + 0.5 * 0.967 * 0.04)).abs() < 1e-4);
        assert_eq!(quieter(0.3, 0.0), 0.3);
        assert_eq!(quieter(0.3, 1.0), 1.0);
    }
}
