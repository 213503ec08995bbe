//! Levels of angles and sets of levels: how well strokes follow the field, how long they are, and how uniform their
//! tone is.

use super::{Card, HALF};
use crate::Result;
use crate::frame::{Mask, Plane, Vector2Planes};
use crate::params::{LineParams, MAX_LEVELS, StrokeParams};
use crate::report::asked::On;
use crate::report::compare::Angles;
use crate::report::compare::{Tally, covered};
use crate::report::scenes::Scene;
use crate::report::scenes::angle_deg;
use crate::report::sweeps::directions::vector_at;
use crate::report::timing::Times;
use glam::DVec2;
use serde::Serialize;

/// Numbers of levels tried; the last one is the limit.
pub(crate) const LEVELS: [u32; 8] = [4, 8, 12, 16, 24, 36, 72, MAX_LEVELS];
/// Numbers of sets tried.
pub(crate) const SETS: [u32; 3] = [1, 2, 4];

/// Results of one setting.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct StrokeRow {
    pub levels: u32,
    pub sets: u32,
    /// Angles between the strokes as drawn and the field.
    pub from_field: Angles,
    /// Correlation of ink with that a sixth of a stroke farther along the field, relative to straight strokes.
    pub unbroken: f64,
    /// Root mean square error of tone, 0..1, averaged over about two stroke spacings.
    pub blotches: f64,
    pub stage: Times,
}

/// All settings on one frame.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Sweep {
    #[serde(flatten)]
    pub on: On,
    /// Number of pixels compared, with fully covered neighbourhoods.
    pub pixels: usize,
    /// [`StrokeRow::blotches`] of straight strokes: the part due to chance.
    pub straight_blotches: f64,
    /// By sets, then by levels.
    pub rows: Vec<StrokeRow>,
}

/// Radius in pixels for averaging stroke directions and tones: three box filters, approximately a Gaussian of this
/// standard deviation.
const AROUND_PX: usize = 8;

pub(super) fn sweep(name: &str, bench: &Card) -> Result<Sweep> {
    let card = &bench.card;
    let field = bench.field(LineParams::default().field)?;
    let inner = inner(&card.mask);
    let [straight, straight_blotches] = straight(bench)?;
    let mut rows = Vec::new();
    for sets in SETS {
        for levels in LEVELS {
            let (ink, timed) = bench.timed(of(levels, sets))?;
            rows.push(StrokeRow {
                levels,
                sets,
                from_field: between(&strokes_of(&ink), &field, &inner),
                unbroken: likeness(&ink, &field, &inner) / straight,
                blotches: blotches(&ink, &inner),
                stage: timed.stage("hatching").expect("strokes are drawn"),
            });
        }
    }
    Ok(Sweep {
        on: On::new(name, &card.mask),
        pixels: inner.count(),
        straight_blotches,
        rows,
    })
}

fn of(levels: u32, sets: u32) -> LineParams {
    LineParams {
        strokes: StrokeParams {
            levels,
            sets,
            ..StrokeParams::default()
        },
        ..LineParams::default()
    }
}

/// [`likeness`] and [`blotches`] of straight strokes.
fn straight(bench: &Card) -> Result<[f64; 2]> {
    let frame = Scene::plane(512, 512).frame;
    let bench = Card::new(&frame, bench.shape, bench.effort);
    let ink = bench.ink(LineParams::default())?;
    let field = bench.field(LineParams::default().field)?;
    let inner = inner(&frame.mask);
    Ok([likeness(&ink, &field, &inner), blotches(&ink, &inner)])
}

/// Pixels whose neighbourhood is covered as far as the averages reach.
fn inner(mask: &Mask) -> Mask {
    let covered = Plane::from_fn(mask.width(), mask.height(), |x, y| {
        f32::from(u8::from(mask.at(x, y)))
    });
    let around = bell(&covered, AROUND_PX);
    let reach = 3 * AROUND_PX;
    let (width, height) = (mask.width(), mask.height());
    Mask::new(Plane::from_fn(width, height, |x, y| {
        let inside = |at: usize, length: usize| at >= reach && at + reach < length;
        inside(x, width) && inside(y, height) && around.at(x, y) > 1.0 - 1e-5
    }))
}

/// The directions along which ink varies least.
fn strokes_of(ink: &Plane) -> Vector2Planes {
    // Differences of adjacent pixels on thin lines are biased toward some angles.
    let soft = bell(ink, 2);
    let (width, height) = (ink.width(), ink.height());
    let at = |x: isize, y: isize| {
        let inside = |at: isize, length: usize| at.clamp(0, length as isize - 1) as usize;
        soft.at(inside(x, width), inside(y, height))
    };
    // Fourth order: central differences are too small by a sixth for lines six pixels apart.
    let slope = |x: usize, y: usize| {
        let (x, y) = (x as isize, y as isize);
        let rise = |of: &dyn Fn(isize) -> f32| 8.0 * (of(1) - of(-1)) - (of(2) - of(-2));
        [rise(&|i| at(x + i, y)), rise(&|i| at(x, y - i))]
    };
    let tensor = |of: fn([f32; 2]) -> f32| {
        let plane = Plane::from_fn(width, height, |x, y| of(slope(x, y)));
        bell(&plane, AROUND_PX)
    };
    let difference = tensor(|[x, y]| x * x - y * y);
    let twice_product = tensor(|[x, y]| 2.0 * x * y);
    let along = |x: usize, y: usize| {
        let twice = f32::atan2(twice_product.at(x, y), difference.at(x, y));
        // Perpendicular to the direction of most change.
        let most = 0.5 * twice;
        [-most.sin(), most.cos()]
    };
    Vector2Planes {
        x: Plane::from_fn(width, height, |x, y| along(x, y)[0]),
        y: Plane::from_fn(width, height, |x, y| along(x, y)[1]),
    }
}

fn between(found: &Vector2Planes, wanted: &Vector2Planes, inner: &Mask) -> Angles {
    let mut tally = Tally::default();
    for at in covered(inner) {
        tally.add(at, angle_deg(vector_at(found, at), vector_at(wanted, at)));
    }
    Angles::of(tally)
}

/// Correlation of ink with that a sixth of a stroke farther along the field.
fn likeness(ink: &Plane, field: &Vector2Planes, inner: &Mask) -> f64 {
    let steps = (StrokeParams::default().stroke(1.0).length_px / 6.0).round() as usize;
    let mut sums = [0.0; 5];
    let mut count = 0.0;
    for [x, y] in covered(inner) {
        if let Some([u, v]) = followed(field, inner, [x, y], steps) {
            let (a, b) = (f64::from(ink.at(x, y)), f64::from(ink.at(u, v)));
            for (sum, value) in sums.iter_mut().zip([a, b, a * a, b * b, a * b]) {
                *sum += value;
            }
            count += 1.0;
        }
    }
    let [a, b, aa, bb, ab] = sums.map(|sum| sum / f64::max(count, 1.0));
    let spread = ((aa - a * a) * (bb - b * b)).sqrt();
    if spread > 0.0 {
        (ab - a * b) / spread
    } else {
        0.0
    }
}

/// The pixel this many pixel steps along the field; `None` outside `inner`.
fn followed(
    field: &Vector2Planes,
    inner: &Mask,
    [x, y]: [usize; 2],
    steps: usize,
) -> Option<[usize; 2]> {
    let mut place = DVec2::new(x as f64, y as f64);
    let mut ahead = vector_at(field, [x, y]);
    for _ in 0..steps {
        // Rows run down, y up.
        place += DVec2::new(ahead.x, -ahead.y);
        let [u, v] = [place.x.round() as usize, place.y.round() as usize];
        if u >= inner.width() || v >= inner.height() || !inner.at(u, v) {
            return None;
        }
        let here = vector_at(field, [u, v]);
        ahead = if here.dot(ahead) < 0.0 { -here } else { here };
    }
    Some([place.x.round() as usize, place.y.round() as usize])
}

fn blotches(ink: &Plane, inner: &Mask) -> f64 {
    let tone = bell(ink, AROUND_PX);
    let squares = covered(inner).map(|[x, y]| f64::from(tone.at(x, y) - (1.0 - HALF)).powi(2));
    (squares.sum::<f64>() / inner.count().max(1) as f64).sqrt()
}

/// Three box filters of width `2 radius + 1`: approximately a Gaussian whose standard deviation is the radius. Borders
/// are repeated.
fn bell(plane: &Plane, radius: usize) -> Plane {
    (0..3).fold(plane.clone(), |plane, _| {
        turned(&along_rows(&turned(&along_rows(&plane, radius)), radius))
    })
}

fn along_rows(plane: &Plane, radius: usize) -> Plane {
    let mut mean = plane.clone();
    let width = plane.width();
    mean.each_row(|y, out| {
        let row = plane.row(y);
        let inside = |x: isize| f64::from(row[x.clamp(0, width as isize - 1) as usize]);
        let reach = radius as isize;
        let mut sum: f64 = (-reach..=reach).map(inside).sum();
        for (x, out) in out.iter_mut().enumerate() {
            *out = (sum / (2 * radius + 1) as f64) as f32;
            let x = x as isize;
            sum += inside(x + reach + 1) - inside(x - reach);
        }
    });
    mean
}

fn turned(plane: &Plane) -> Plane {
    Plane::from_fn(plane.height(), plane.width(), |x, y| plane.at(y, x))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines 6 pixels apart at an angle.
    fn lines(angle: f64) -> Plane {
        Plane::from_fn(200, 150, |x, y| {
            let across = y as f64 * angle.cos() + x as f64 * angle.sin();
            (0.5 + 0.5 * (across * std::f64::consts::TAU / 6.0).sin()) as f32
        })
    }

    #[test]
    fn lines_are_found_where_they_run() {
        for degrees in [0.0_f64, 20.0, 90.0, 135.0] {
            let angle = degrees.to_radians();
            let ink = lines(angle);
            let exact = DVec2::from_angle(angle);
            let filled = |v: f64| Plane::filled(200, 150, v as f32);
            let field = Vector2Planes {
                x: filled(exact.x),
                y: filled(exact.y),
            };
            let inner = inner(&Mask::full(200, 150));
            assert_eq!(inner.count(), (200 - 48) * (150 - 48));
            let angles = between(&strokes_of(&ink), &field, &inner);
            assert!(angles.max < 1.0, "{degrees}: {angles:?}");
            // Rounding to whole pixels moves by at most half of one: a root mean square error of 0.3 px is 17 degrees
            // of a wave of 6.
            assert!(likeness(&ink, &field, &inner) > 0.9, "{degrees}");
            // Waves of 6 pixels average out over 8, to a mean of a half.
            assert!(blotches(&ink, &inner) < 1e-3);
        }
    }

    #[test]
    fn ink_across_the_field_is_no_stroke() {
        let (zero, one) = (Plane::filled(200, 150, 0.0), Plane::filled(200, 150, 1.0));
        let up = Vector2Planes { x: zero, y: one };
        // Waves of 7 pixels: the 10th pixel on is 3/7 of a turn on.
        let ink = Plane::from_fn(200, 150, |_, y| {
            (y as f32 * std::f32::consts::TAU / 7.0).sin()
        });
        let inner = inner(&Mask::full(200, 150));
        let expected = (std::f64::consts::TAU * 10.0 / 7.0).cos();
        assert!((likeness(&ink, &up, &inner) - expected).abs() < 0.02);
        assert!((between(&strokes_of(&ink), &up, &inner).mean - 90.0).abs() < 1e-3);
    }
}
