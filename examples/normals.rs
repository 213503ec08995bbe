//! Error and run time of normals made from heights, on known surfaces in several kinds of storage: one table.
//!
//! `cargo run --release -p examples --example normals -- [SIDE [ROUNDS]]`
//!
//! Beside the angle to the exact normals stand that of central differences of the same heights, and the error of curvature:
//! that of the divergence of slopes (scale 2), against that of the exact normals, over its root mean square.

use common::{Outcome, write_npy};
use half::f16;
use relievo::engine::{Engine, Request, Run};
use relievo::frame::{Frame, Plane, StoredDepth, Vector3Planes};
use relievo::io::inputs::Inputs;
use relievo::io::{Needs, load};
use relievo::params::Params;
use relievo::scenes::frames::grey;
use std::process::ExitCode;

mod common;

/// Pixels at the border and beside steps that do not count.
const MARGIN: usize = 4;

/// Height at pixels from the middle, and its slopes to the right and down.
type Surface = fn(f64, f64) -> [f64; 3];

const SURFACES: [(&str, Surface); 6] = [
    ("plane", |x, y| [0.31 * x + 0.13 * y, 0.31, 0.13]),
    ("ball on a plane", |x, y| {
        let square = 1e4 - x * x - y * y;
        match square > 400.0 {
            true => [square.sqrt(), -x / square.sqrt(), -y / square.sqrt()],
            false => [0.0; 3],
        }
    }),
    ("cone", |x, y| {
        let radius = x.hypot(y);
        match radius < 120.0 {
            true => [72.0 - 0.6 * radius, -0.6 * x / radius, -0.6 * y / radius],
            false => [0.0; 3],
        }
    }),
    ("roof", |x, _| [-0.5 * x.abs(), -0.5 * x.signum(), 0.0]),
    ("waves and a step", |x, y| {
        let step = if x > 0.3 * y { 30.0 } else { 0.0 };
        let ([sx, cx], [sy, cy]) = ((0.1 * x).sin_cos().into(), (0.07 * y).sin_cos().into());
        [3.0 * sx * cy + step, 0.3 * cx * cy, -0.21 * sx * sy]
    }),
    ("fine and flat", |x, _| {
        let wave = std::f64::consts::TAU / 12.0;
        match x < 0.0 {
            true => [2.0 * (wave * x).sin(), 2.0 * wave * (wave * x).cos(), 0.0],
            false => [0.0; 3],
        }
    }),
];

/// How heights are stored.
#[derive(Clone, Copy)]
enum Storage {
    Float,
    /// Between 2 and 3, where halves are .002 apart.
    Half,
    Codes(u32),
    /// Floats with noise of this deviation, in pixels.
    Noisy(f64),
}

const STORAGES: [(&str, Storage); 6] = [
    ("float", Storage::Float),
    ("half", Storage::Half),
    ("16 bits", Storage::Codes(65535)),
    ("8 bits", Storage::Codes(255)),
    ("noise .02", Storage::Noisy(0.02)),
    ("noise .2", Storage::Noisy(0.2)),
];

fn main() -> ExitCode {
    common::run(table)
}

fn table(arguments: &[&str]) -> Outcome<()> {
    let numbers = arguments.iter().map(|a| a.parse());
    let (side, rounds) = match numbers.collect::<Result<Vec<usize>, _>>()?[..] {
        [] => (320, 5),
        [side] => (side, 5),
        [side, rounds] if rounds > 0 => (side, rounds),
        _ => return Err("usage: normals [SIDE [ROUNDS]]".into()),
    };
    println!(
        "{side}x{side}, {} threads, medians of {rounds} rounds\n",
        rayon::current_num_threads()
    );
    println!("| surface | stored as | degrees off | central differences | curvature off | ms |");
    println!("|---|---|---|---|---|---|");
    let desk = tempfile::tempdir()?;
    let path = desk.path().join("heights.npy");
    for (surface, height) in SURFACES {
        for (name, storage) in STORAGES {
            let scene = Scene { side, height };
            let (values, scale) = scene.stored(storage);
            let (kind, bytes) = storage.bytes(&values);
            write_npy(&path, kind, &[side, side], &bytes)?;
            let inputs = Inputs {
                picture: path.clone(),
                depth: Some(path.to_string_lossy().into_owned()),
                depth_kind: Some(StoredDepth::Height),
                height_scale: Some(scale as f32),
                ..Inputs::default()
            };
            let mut times = Vec::new();
            let mut frame = None;
            for _ in 0..rounds {
                let loaded = load(&inputs, Needs::default())?;
                times.extend(loaded.normals_made.map(|took| 1e3 * took.as_secs_f64()));
                frame = Some(loaded.frame);
            }
            let frame = frame.ok_or("no rounds")?;
            times.sort_by(f64::total_cmp);
            let central = scene.central(&values, scale);
            println!(
                "| {surface} | {name} | {:.3} | {:.3} | {:.3} | {:.2} |",
                scene.angle(|x, y| frame.normal.at(x, y)),
                scene.angle(central),
                scene.curvature_error(&frame)?,
                times[times.len() / 2],
            );
        }
    }
    Ok(())
}

struct Scene {
    side: usize,
    height: Surface,
}

impl Scene {
    fn at(&self, x: usize, y: usize) -> [f64; 3] {
        let from_middle = |i: usize| i as f64 + 0.5 - 0.5 * self.side as f64;
        (self.height)(from_middle(x), from_middle(y))
    }

    fn pixels(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let side = self.side;
        (0..side).flat_map(move |y| (0..side).map(move |x| (x, y)))
    }

    fn normal(&self, x: usize, y: usize) -> glam::DVec3 {
        let [_, right, down] = self.at(x, y);
        glam::DVec3::new(-right, down, 1.0).normalize()
    }

    /// Values as stored, and the pixels that a value of 1 is high.
    fn stored(&self, storage: Storage) -> (Vec<f64>, f64) {
        let heights: Vec<f64> = self.pixels().map(|(x, y)| self.at(x, y)[0]).collect();
        let low = heights.iter().copied().fold(f64::MAX, f64::min);
        let range = heights.iter().copied().fold(f64::MIN, f64::max) - low;
        let share = |h: &f64| (h - low) / range;
        match storage {
            Storage::Float => (heights, 1.0),
            Storage::Half => {
                let half = |h: &f64| f16::from_f64(2.0 + share(h)).to_f64();
                (heights.iter().map(half).collect(), range)
            }
            Storage::Codes(most) => {
                let most = f64::from(most);
                let codes = heights.iter().map(|h| (most * share(h)).round());
                (codes.collect(), range / most)
            }
            Storage::Noisy(deviation) => {
                let mut state = 1_u64;
                let mut uniform = || {
                    state = state
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    (state >> 40) as f64 / f64::from(1 << 24) - 0.5
                };
                // The sum of twelve uniform numbers has a deviation of 1.
                let mut noise = || deviation * (0..12).map(|_| uniform()).sum::<f64>();
                (heights.iter().map(|h| h + noise()).collect(), 1.0)
            }
        }
    }

    fn central(&self, values: &[f64], scale: f64) -> impl Fn(usize, usize) -> glam::DVec3 {
        let side = self.side;
        move |x, y| {
            let at = |x: usize, y: usize| scale * values[y * side + x];
            let right = 0.5 * (at(x + 1, y) - at(x - 1, y));
            let down = 0.5 * (at(x, y + 1) - at(x, y - 1));
            glam::DVec3::new(-right, down, 1.0).normalize()
        }
    }

    /// Pixels away from the border and from steps, where slopes are not those of one surface.
    fn counted(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let inside = MARGIN..self.side - MARGIN;
        let is_inside = move |&(x, y): &(usize, usize)| inside.contains(&x) && inside.contains(&y);
        let is_smooth = |&(x, y): &(usize, usize)| {
            [(MARGIN, 0), (0, MARGIN)].into_iter().all(|(dx, dy)| {
                let [before, after] = [self.at(x - dx, y - dy), self.at(x + dx, y + dy)];
                (after[0] - before[0]).abs() < 15.0
            })
        };
        self.pixels().filter(is_inside).filter(is_smooth)
    }

    /// The mean angle to the exact normals, in degrees.
    fn angle(&self, found: impl Fn(usize, usize) -> glam::DVec3) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (x, y) in self.counted() {
            let (found, exact) = (found(x, y), self.normal(x, y));
            // 0 where none was found.
            sum += match found == glam::DVec3::ZERO {
                true => 90.0,
                false => found.angle_between(exact).to_degrees(),
            };
            count += 1;
        }
        sum / f64::from(count.max(1))
    }

    /// The root mean square error of the divergence of slopes, over that of the exact normals; absolute where that is 0.
    fn curvature_error(&self, frame: &Frame) -> Outcome<f64> {
        let exact = Vector3Planes::from_fn(self.side, self.side, |x, y| self.normal(x, y));
        let exact = Frame::of_normals(exact, frame.mask.clone());
        let (found, exact) = (trace(frame)?, trace(&exact)?);
        let (mut error, mut size) = (0.0, 0.0);
        for (x, y) in self.counted() {
            let truth = f64::from(exact.at(x, y));
            error += (f64::from(found.at(x, y)) - truth).powi(2);
            size += truth * truth;
        }
        Ok((error / if size > 0.0 { size } else { 1.0 }).sqrt())
    }
}

/// The divergence of slopes at scale 2.
fn trace(frame: &Frame) -> Outcome<Plane> {
    // Depth would tell silhouettes, which the exact normals do not have.
    let frame = Frame::of_normals(frame.normal.clone(), frame.mask.clone());
    let request = Request::enhance(Params::default());
    let outcome = Engine::cpu().run(&request, &grey(frame, 0.5), &Run::new())?;
    Ok(outcome.shape.trace.ok_or("enhancing needs the trace")?)
}

impl Storage {
    /// Values as NumPy stores them, and its name for that.
    fn bytes(self, values: &[f64]) -> (&'static str, Vec<u8>) {
        let all = |one: fn(f64) -> Vec<u8>| values.iter().flat_map(|&v| one(v)).collect();
        match self {
            Self::Float | Self::Noisy(_) => ("<f4", all(|v| (v as f32).to_le_bytes().into())),
            Self::Half => ("<f2", all(|v| f16::from_f64(v).to_le_bytes().into())),
            Self::Codes(255) => ("|u1", all(|v| vec![v as u8])),
            Self::Codes(_) => ("<u2", all(|v| (v as u16).to_le_bytes().into())),
        }
    }
}
