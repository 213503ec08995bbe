//! How far strokes run unbroken and how far they stray from the field they follow, by levels of angles and sets of
//! levels, as one table.
//!
//! The surface is that of the bust, in an even half tone.

use crate::common::load;
use crate::{Outcomes, direction_at, pen, stroke_field};
use glam::DVec2;
use relievo::engine::{Engine, Request, Run};
use relievo::frame::{Frame, Mask, Plane, Vector2Planes};
use relievo::params::{Params, StrokeParams};
use relievo::plan::{Goal, Tone};
use relievo::scenes::{Scene, angle_deg, frames::grey};

const LEVELS: [u32; 8] = [4, 8, 12, 16, 24, 36, 72, 360];

/// Pixels over which directions are averaged, as a standard deviation.
const AROUND_PX: usize = 8;

pub(crate) fn print() -> Outcomes<()> {
    let bust = Card::new(load("fixtures/bust.exr", None)?)?;
    let straight = Card::new(Scene::plane(512, 512).frame)?;
    let usual = StrokeParams::default();
    let straight = straight.likeness(&straight.ink(usual.levels, usual.sets)?);
    println!("| levels | unbroken, 1 set | 2 sets | off the field, 1 set | 2 sets |");
    println!("|---|---|---|---|---|");
    for levels in LEVELS {
        let (mut unbroken, mut strayed) = (String::new(), String::new());
        for sets in [1, 2] {
            let ink = bust.ink(levels, sets)?;
            unbroken += &format!(" {:.0} % |", 100.0 * bust.likeness(&ink) / straight);
            strayed += &format!(" {:.1} |", bust.strayed(&ink));
        }
        println!("| {levels} |{unbroken}{strayed}");
    }
    Ok(())
}

/// A surface in half tone.
struct Card {
    frame: Frame,
    /// The directions that strokes follow.
    field: Vector2Planes,
    /// Pixels whose neighbourhood is covered as far as averages reach.
    inner: Mask,
}

impl Card {
    fn new(frame: Frame) -> Outcomes<Self> {
        let frame = grey(frame, 0.5);
        let covered = frame.mask.plane().map(|is_in| f32::from(u8::from(is_in)));
        Ok(Self {
            field: stroke_field(&frame, &pen(), None)?,
            inner: Mask::new(blurred(&covered, AROUND_PX).map(|share| share > 1.0 - 1e-5)),
            frame,
        })
    }

    fn ink(&self, levels: u32, sets: u32) -> Outcomes<Plane> {
        let mut line = pen();
        line.contours = None;
        (line.strokes.levels, line.strokes.sets) = (levels, sets);
        let request = Request::new(Goal::Hatch(Tone::Picture, line), Params::default());
        let outcome = Engine::cpu().run(&request, &self.frame, &Run::new())?;
        Ok(outcome.drawing.ok_or("a drawing was planned")?.hatching)
    }

    fn pixels(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let rows = (0..self.inner.height()).map(|y| (y, self.inner.runs(y)));
        rows.flat_map(|(y, runs)| runs.flatten().map(move |x| [x, y]))
    }

    /// Correlation of ink with that a sixth of a stroke farther along the field.
    fn likeness(&self, ink: &Plane) -> f64 {
        let steps = (pen().strokes.stroke(1.0).length_px / 6.0).round() as usize;
        let at = |[x, y]: [usize; 2]| f64::from(ink.at(x, y));
        let pair = |from| Some([at(from), at(self.farther(from, steps)?)]);
        let pairs: Vec<[f64; 2]> = self.pixels().filter_map(pair).collect();
        let mean =
            |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
        let [a, b] = [mean(&|pair| pair[0]), mean(&|pair| pair[1])];
        let spread = mean(&|pair| (pair[0] - a).powi(2)) * mean(&|pair| (pair[1] - b).powi(2));
        mean(&|pair| (pair[0] - a) * (pair[1] - b)) / spread.sqrt()
    }

    /// The pixel this many pixel steps along the field; `None` outside the inner ones.
    fn farther(&self, from: [usize; 2], steps: usize) -> Option<[usize; 2]> {
        let mut place = DVec2::new(from[0] as f64, from[1] as f64);
        let (mut pixel, mut ahead) = (from, direction_at(&self.field, from));
        // Rows run down, y up.
        for _ in 0..steps {
            place += DVec2::new(ahead.x, -ahead.y);
            pixel = place.round().to_array().map(|at| at as usize);
            if !self.inner.at(pixel[0], pixel[1]) {
                return None;
            }
            let here = direction_at(&self.field, pixel);
            ahead = if here.dot(ahead) < 0.0 { -here } else { here };
        }
        Some(pixel)
    }

    /// The mean angle in degrees between the field and the directions along which ink varies least.
    fn strayed(&self, ink: &Plane) -> f64 {
        // Differences of neighbours on thin lines are biased toward some angles.
        let soft = blurred(ink, 2);
        let (width, height) = (soft.width(), soft.height());
        // Fourth order: central differences are too small by a sixth for lines six pixels apart.
        let slope = |x: usize, y: usize| {
            let (x, y) = (x.clamp(2, width - 3), y.clamp(2, height - 3));
            let rise = |[a, b, c, d]: [f32; 4]| 8.0 * (c - b) - (d - a);
            let across = [x - 2, x - 1, x + 1, x + 2].map(|x| soft.at(x, y));
            // Rows run down, y up.
            let up = [y + 2, y + 1, y - 1, y - 2].map(|y| soft.at(x, y));
            [rise(across), rise(up)]
        };
        let around = |of: fn([f32; 2]) -> f32| {
            let plane = Plane::from_fn(width, height, |x, y| of(slope(x, y)));
            blurred(&plane, AROUND_PX)
        };
        let difference = around(|[x, y]| x * x - y * y);
        let product = around(|[x, y]| 2.0 * x * y);
        let angle = |at: [usize; 2]| {
            let [product, difference] = [&product, &difference].map(|plane| plane.at(at[0], at[1]));
            let most = DVec2::from_angle(0.5 * f64::from(product.atan2(difference)));
            angle_deg(most.perp(), direction_at(&self.field, at))
        };
        self.pixels().map(angle).sum::<f64>() / self.inner.count() as f64
    }
}

/// Three averages over `2 radius + 1` pixels each way: about a Gaussian whose standard deviation is the radius.
fn blurred(plane: &Plane, radius: usize) -> Plane {
    (0..6).fold(plane.clone(), |plane, _| averaged(&plane, radius))
}

/// Averages along rows, turned: rows become columns. Outside the picture is 0.
fn averaged(plane: &Plane, radius: usize) -> Plane {
    Plane::from_fn(plane.height(), plane.width(), |y, x| {
        let near = x.saturating_sub(radius)..(x + radius + 1).min(plane.width());
        plane.row(y)[near].iter().sum::<f32>() / (2 * radius + 1) as f32
    })
}
