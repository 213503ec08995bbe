//! What the codes of a normal map hold: whether blue says anything, where x and y are, what was done to them by mistake, and
//! the code of a flat surface.

use super::integrability::Curl;
use super::normal_encoding::NEAR_UNIT;
use crate::frame::normals::{is_written, with_rebuilt_z};
use crate::frame::{Mask, Plane, Vector3Planes};
use crate::io::inputs::NormalEncoding;
use crate::io::photo::{CodeMeaning, StoredPhoto};
use crate::io::srgb;
use crate::kernel::quantile::quantile;
use glam::Vec3;
use std::collections::HashMap;

/// Bands of rows that are looked at, and the rows of each.
const BANDS: usize = 5;
const ROWS: usize = 64;

/// Share of the pairs of x and y that lie in the unit disk, up to rounding, if they are two components of unit vectors.
const IN_DISK: f64 = 0.98;
const DISK: f32 = 1.05;
/// Three codes of 8 bits: a constant blue is off by more than rounding.
const CODES: f32 = 3.0 / 127.5;
/// Above this z the slope is too gentle for blue to tell.
const GENTLE_Z: f32 = 0.93;
/// Least share of the pixels that are steeper, for blue to tell.
const LEAST_STEEP: f64 = 0.01;
/// Share of these that fit, below which blue holds something else than z.
const LEAST_FIT: f64 = 0.5;
/// Share of the pixels that a flat surface takes at least, and times that it is as frequent as any code beside it.
const FLAT: (f64, f64) = (0.1, 4.0);

/// A map whose z is not stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    pub(crate) encoding: NormalEncoding,
    pub(crate) why: &'static str,
    /// Whether it can be nothing but a map, by its slopes and constant channels.
    pub(crate) is_sure: bool,
}

/// Vectors whose length is as near to 1 as this fit, with what a curve makes of the rounding of codes.
const FITS: f32 = 0.06;
/// Share of the vectors that fit once a mistake is undone, at least, and as they are, at most.
const ONLY_SO: (f64, f64) = (0.75, 0.3);
/// Filters shorten vectors; both curves make half of them longer than this.
const LONGER: f32 = 1.05;
/// Vectors that are looked at for it, about.
const WANTED: usize = 20_000;

type Curve = fn(f64) -> f64;

/// What was done to the codes of a map as if it were a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mistake {
    /// The curve of sRGB was applied.
    Encoded,
    /// It was undone.
    Decoded,
    /// Red and green were exchanged, as where programs disagree on the order of channels.
    Exchanged,
}

impl Mistake {
    /// The mistakes that are undone by a curve, with it.
    const CURVES: [(Self, Curve); 2] = [
        (Self::Encoded, srgb::decoded),
        (Self::Decoded, srgb::encoded),
    ];

    /// What was done to planes of red, green, blue, and alpha if there is one.
    fn of(planes: &[Plane]) -> Option<Self> {
        let codes = |x, y| [0, 1, 2].map(|channel: usize| planes[channel].at(x, y));
        let covers = |x, y| planes.get(3).is_none_or(|alpha| alpha.at(x, y) > 0.5);
        let is_written = |x, y| covers(x, y) && is_written(codes(x, y));
        let (width, height) = (planes[0].width(), planes[0].height());
        let mask = Mask::new(Plane::from_fn(width, height, is_written));
        let share = |meant: Curve, holds: fn(Vec3) -> bool| {
            let vector = |(x, y)| codes(x, y).map(|v| 2.0 * meant(v.into()) as f32 - 1.0);
            let all: Vec<_> = mask.sample(WANTED).map(vector).collect();
            let held = all.iter().filter(|v| holds(Vec3::from(**v))).count();
            held as f64 / all.len().max(1) as f64
        };
        let as_is = |v| v;
        let fits = |v: Vec3| (v.length() - 1.0).abs() < FITS;
        let (least, most) = ONLY_SO;
        if share(as_is, fits) >= least {
            let [x, y, z] = [0, 1, 2].map(|i| planes[i].map(|code| 2.0 * code - 1.0));
            let faces = share(as_is, |v| v.z > 0.0) >= IN_DISK;
            let is_exchanged = faces && Curl::shows_exchange(&Vector3Planes { x, y, z }, &mask);
            return is_exchanged.then_some(Self::Exchanged);
        }
        let is_off = share(as_is, fits) <= most && share(as_is, |v| v.length() > LONGER) >= 0.5;
        let mut curves = Self::CURVES.into_iter();
        let found = curves.find(|(_, undo)| is_off && share(*undo, fits) >= least);
        found.map(|(mistake, _)| mistake)
    }

    /// Makes the planes of a photo what was meant.
    pub(crate) fn undo(self, planes: &mut [Plane]) {
        if self == Self::Exchanged {
            planes.swap(0, 1);
        }
        let mut curves = Self::CURVES.into_iter();
        if let Some((_, undo)) = curves.find(|(mistake, _)| *mistake == self) {
            for plane in &mut planes[..3] {
                *plane = plane.map(|code| undo(code.into()) as f32);
            }
        }
    }

    /// What it is, in words.
    pub(crate) fn said(self) -> &'static str {
        match self {
            Self::Encoded => "saved as sRGB light, by their lengths: they are decoded",
            Self::Decoded => "made linear like light, by their lengths: they are encoded",
            Self::Exchanged => "red and green exchanged, by the curl of slopes: they are swapped",
        }
    }
}

/// What was found of a map.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct MapCodes {
    pub(crate) pair: Option<Pair>,
    pub(crate) mistake: Option<Mistake>,
    /// Codes of x and y of a flat surface, 0..1, where they are off the middle.
    pub(crate) flat: Option<[f32; 2]>,
}

impl MapCodes {
    /// Looks at some rows of a photo; finds nothing in one that cannot be decoded, or holds no codes.
    pub(in crate::io) fn of(photo: &StoredPhoto) -> Self {
        if photo.header.is_pair {
            let pair = Pair {
                encoding: NormalEncoding::Xy,
                why: "it has x and y alone",
                is_sure: true,
            };
            return Self {
                pair: Some(pair),
                ..Self::default()
            };
        }
        let planes = match photo.header.may_hold_coded_vectors() {
            true => bands(photo),
            false => None,
        };
        let of = |planes| Self::of_planes(planes, photo.header.bits);
        planes.map_or_else(Self::default, of)
    }

    /// The same of planes of red, green, blue, and alpha if there is one.
    fn of_planes(mut planes: Vec<Plane>, bits: u8) -> Self {
        let mistake = Mistake::of(&planes);
        if let Some(mistake) = mistake {
            mistake.undo(&mut planes);
        }
        let pair = pair_in(&planes);
        let x = match pair {
            Some(pair) if pair.encoding == NormalEncoding::Ag => &planes[3],
            _ => &planes[0],
        };
        let flat = (bits == 8).then(|| flat_code(x, &planes[1])).flatten();
        Self {
            pair,
            mistake,
            flat,
        }
    }
}

/// Bands of a photo's rows, one below the other, with a black row below each.
fn bands(photo: &StoredPhoto) -> Option<Vec<Plane>> {
    let header = &photo.header;
    let rows = ROWS.min(header.height);
    let mut stacked = vec![Vec::new(); header.channels()];
    for i in 0..BANDS {
        let first = (2 * i + 1) * (header.height - rows) / (2 * BANDS);
        let planes = photo
            .planes(first..first + rows, CodeMeaning::Stored)
            .ok()?;
        for (stacked, plane) in stacked.iter_mut().zip(planes) {
            stacked.extend(plane.into_samples());
            stacked.extend(vec![0.0; header.width]);
        }
    }
    let plane = |samples| Plane::from_samples(header.width, BANDS * (rows + 1), samples);
    Some(stacked.into_iter().map(plane).collect())
}

/// The encoding in two of the channels, if only these hold components of unit vectors.
fn pair_in(planes: &[Plane]) -> Option<Pair> {
    let [red, green, blue, alpha @ ..] = planes else {
        return None;
    };
    if let ([alpha], true) = (alpha, is_constant(red))
        && let Some(surface) = surface_of(alpha, green)
    {
        return Some(Pair {
            encoding: NormalEncoding::Ag,
            why: "red is constant, alpha and green hold x and y",
            is_sure: is_surface(&surface),
        });
    }
    let surface = surface_of(red, green)?;
    if is_constant(blue) {
        let (normal, mask) = &surface;
        let pixels = normal.z.samples().iter().zip(blue.samples());
        let pixels = pixels.zip(mask.plane().samples()).filter(|(_, w)| **w);
        let unlike =
            pixels.filter(|((z, blue), _)| ((2.0 * **blue - 1.0).abs() - **z).abs() > CODES);
        let tells = unlike.count() as f64 >= LEAST_STEEP * mask.count() as f64;
        return tells.then(|| Pair {
            encoding: NormalEncoding::Xy,
            why: "blue is constant",
            is_sure: is_surface(&surface),
        });
    }
    let (steep, fit) = steep_and_fit(&surface, blue);
    let is_other = steep >= LEAST_STEEP && fit < LEAST_FIT && is_surface(&surface);
    is_other.then_some(Pair {
        encoding: NormalEncoding::Xy,
        why: "blue does not fit x and y",
        is_sure: false,
    })
}

/// Share of the pixels steep enough for blue to tell, and share of these whose blue could be z.
fn steep_and_fit((normal, mask): &(Vector3Planes, Mask), blue: &Plane) -> (f64, f64) {
    let samples = normal
        .vectors()
        .zip(blue.samples())
        .zip(mask.plane().samples());
    let samples = samples.filter(|(_, written)| **written);
    let zs: Vec<_> = samples
        .map(|((v, blue), _)| (v, (2.0 * blue - 1.0).abs()))
        .collect();
    let length = |(v, z): &(Vec3, f32)| v.truncate().extend(*z).length();
    let mut lengths: Vec<_> = zs.iter().map(length).collect();
    let median = quantile(&mut lengths, 0.5, f32::total_cmp).unwrap_or_default();
    // Filters shorten vectors: then either z or the length is about right.
    let fits = |both: &(Vec3, f32)| {
        (both.1 - both.0.z).abs() < NEAR_UNIT || (length(both) / median - 1.0).abs() < NEAR_UNIT
    };
    let steep: Vec<_> = zs.iter().filter(|(v, z)| z.min(v.z) < GENTLE_Z).collect();
    let fit = steep.iter().filter(|both| fits(both)).count();
    let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
    (share(steep.len(), zs.len()), share(fit, steep.len()))
}

/// Whether its slopes are those of a surface, one axis reversed or not.
fn is_surface((normal, mask): &(Vector3Planes, Mask)) -> bool {
    Curl::finest(normal, mask).y_points_down().is_some()
}

fn is_constant(plane: &Plane) -> bool {
    let mut written = plane.samples().iter().filter(|&&v| v != 0.0);
    let first = written.next();
    written.all(|v| Some(v) == first)
}

/// The normals whose x and y two planes could hold: in the unit disk, each changing; and where they are written.
fn surface_of(x: &Plane, y: &Plane) -> Option<(Vector3Planes, Mask)> {
    let written = |i: usize, j: usize| is_written([x.at(i, j), y.at(i, j), 0.0]);
    let written = Mask::new(Plane::from_fn(x.width(), x.height(), written));
    let mut normal = Vector3Planes {
        x: x.map(|code| 2.0 * code - 1.0),
        y: y.map(|code| 2.0 * code - 1.0),
        z: Plane::filled(x.width(), x.height(), 0.0),
    };
    with_rebuilt_z(&mut normal);
    let vectors = normal.vectors().zip(written.plane().samples());
    let inside = vectors.filter(|(v, written)| **written && v.length() < DISK);
    let is_inside = inside.count() as f64 >= IN_DISK * written.count() as f64;
    (is_inside && !is_constant(x) && !is_constant(y)).then_some((normal, written))
}

/// The code of a flat surface, if it stands out: 127 or 128, where 127.5 would be flat.
fn flat_code(x: &Plane, y: &Plane) -> Option<[f32; 2]> {
    let mut counts: HashMap<[i32; 2], usize> = HashMap::new();
    let code = |v: f32| (255.0 * v).round() as i32;
    for (&x, &y) in x.samples().iter().zip(y.samples()) {
        *counts.entry([code(x), code(y)]).or_default() += 1;
    }
    let of = |codes: [i32; 2]| counts.get(&codes).copied().unwrap_or_default();
    let near = [[127, 127], [127, 128], [128, 127], [128, 128]];
    let flat = near.into_iter().max_by_key(|codes| of(*codes))?;
    let beside = (0..9)
        .filter(|i| *i != 4)
        .map(|i| of([flat[0] + i % 3 - 1, flat[1] + i / 3 - 1]));
    let (share, times) = FLAT;
    let all = x.samples().len() - of([0, 0]);
    let count = of(flat) as f64;
    let stands_out = count >= share * all as f64 && count >= times * beside.max()? as f64;
    stands_out.then(|| flat.map(|code| code as f32 / 255.0))
}
