//! Layers of normals, positions and depth recognised by their numbers, for files whose names do not tell: normals have
//! unit length, stored directly or encoded as 0..1, and the others fit the surface with these normals.

use super::samples_of_layers::{Sampled, samples};
use super::step_fit::{PointReading, misfit};
use crate::io::exr::ExrFile;
use crate::io::roles::{self, Layer, Match, Role};
use nalgebra::Vector3;

/// The roles that can be found by numbers.
pub(crate) const NUMBERED: [Role; 3] = [Role::Normal, Role::Depth, Role::Position];

/// Most layers that are looked at.
const MOST_LAYERS: usize = 32;
/// A length this near to 1 is that of a unit vector: rounding to 8 bits moves it by 0.01.
const UNIT: f64 = 0.025;
/// Share of the covered pixels that must be unit vectors: filters shorten those at edges.
const UNIT_SHARE: f64 = 0.5;
/// The same of the bare channels that would be a picture.
const MAP_SHARE: f64 = 0.9;
/// Share of the covered pixels that may be longer: nothing lengthens normals but lossy compression.
const LONGER_SHARE: f64 = 0.02;
/// Length of the mean of unit vectors above which they are all alike and give no evidence.
const ALIKE: f64 = 0.9999;
/// Share of the unit vectors that must not be along an axis, as the colours of masks are.
const OFF_AXIS_SHARE: f64 = 0.05;
/// Fewest covered pixels that suffice.
const FEWEST: usize = 16;
/// A misfit up to this is that of one surface.
const AGREES: f64 = 0.1;
/// Factor by which other depth must fit better than depth along the view axis to be preferred.
const USUAL: f64 = 2.0;

/// A role found by the numbers of a layer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RoleByNumbers {
    pub(crate) role: Role,
    pub(crate) found: Match,
    /// The evidence, in a few words.
    pub(crate) why: String,
    /// Names of the other layers that could play it, the best first.
    pub(crate) others: Vec<String>,
}

/// A vector as stored, or decoded from 0..1.
fn decoded(stored: Vector3<f64>, is_unsigned: bool) -> Vector3<f64> {
    match is_unsigned {
        true => 2.0 * stored - Vector3::repeat(1.0),
        false => stored,
    }
}

/// The unit normal that is stored, if it is one.
fn unit(stored: Vector3<f64>, is_unsigned: bool) -> Option<Vector3<f64>> {
    let v = decoded(stored, is_unsigned);
    ((v.norm() - 1.0).abs() < UNIT).then(|| v.normalize())
}

/// A layer of normals.
struct NormalLayer {
    sampled: Sampled,
    /// Whether they are stored as 0..1.
    is_unsigned: bool,
    /// Share of the covered pixels that hold a unit vector, 0..1.
    share: f64,
}

impl NormalLayer {
    /// The layer, if it holds some.
    fn of(sampled: Sampled) -> Option<Self> {
        let (is_unsigned, share) = encoding_of(&sampled)?;
        Some(Self {
            sampled,
            is_unsigned,
            share,
        })
    }
}

/// Roles, not yet given by names, of layers with meaningless names. Layers that cannot be read are skipped.
pub(crate) fn roles_by_numbers(file: &ExrFile, layers: &[Layer]) -> Vec<RoleByNumbers> {
    let picture = roles::find(layers, Role::Color);
    let is_picture = |layer: &Layer| picture.is_some() && layer.matched(Role::Color) == picture;
    let named = roles::find(layers, Role::Normal);
    // Bare channels may be normals themselves: X Y Z, or R G B of what would be the picture.
    let may_be_normals = |layer: &Layer| {
        let is_vector = layer.has(&["x", "y", "z"]) || is_picture(layer);
        named.is_none() && layer.bare && is_vector
    };
    let is_named = |layer: &Layer| named.is_some() && layer.matched(Role::Normal) == named;
    let open = layers
        .iter()
        .filter(|layer| {
            let is_open = layer.is_open(file) && !is_picture(layer);
            layer.is_letter() || is_open || may_be_normals(layer)
        })
        .filter(|layer| layer.is_float(file) && !is_named(layer))
        .take(MOST_LAYERS);
    let (vectors, scalars): (Vec<_>, Vec<_>) =
        open.partition(|layer| layer.matched(Role::Position).is_some());
    let is_missing = |role: Role| roles::find(layers, role).is_none();
    let of = |layers: Vec<&Layer>, role: Role, is_wanted: bool| -> Vec<Match> {
        let found = layers.into_iter().filter_map(|layer| layer.matched(role));
        found.filter(|_| is_wanted).collect()
    };
    let vectors_wanted = named.is_none() || is_missing(Role::Position);
    let vectors = of(vectors, Role::Position, vectors_wanted);
    let scalars = of(scalars, Role::Depth, is_missing(Role::Depth));
    if vectors.is_empty() && scalars.is_empty() {
        return Vec::new();
    }
    // All at once, for each block of the file to be decoded once.
    let all = [&vectors[..], &scalars, named.as_slice()].concat();
    let (mut vectors, rest): (Vec<_>, Vec<_>) = samples(file, &all)
        .into_iter()
        .partition(|sampled| vectors.contains(&sampled.found));
    let (scalars, named_normals): (Vec<_>, Vec<_>) = rest
        .into_iter()
        .partition(|sampled| scalars.contains(&sampled.found));
    // Of what would be a picture, nearly all pixels must be.
    let is_other = |sampled: &Sampled| Some(&sampled.found) != picture.as_ref();
    let is_map =
        |sampled: &Sampled| encoding_of(sampled).is_some_and(|(_, share)| share >= MAP_SHARE);
    vectors.retain(|sampled| is_other(sampled) || is_map(sampled));
    let mut roles = Vec::new();
    let normals = match named {
        Some(_) => {
            // A second layer of normals does not hold positions, although its steps are perpendicular to normals too.
            vectors.retain(|sampled| encoding_of(sampled).is_none());
            named_normals.into_iter().find_map(NormalLayer::of)
        }
        None => take_normals(&mut vectors, &mut roles),
    };
    let Some(normals) = normals else {
        return roles;
    };
    if is_missing(Role::Position) {
        let kinds = [PointReading::Positions];
        roles.extend(best(&normals, Role::Position, vectors, &kinds));
    }
    let kinds = [
        PointReading::Depth,
        PointReading::InverseDepth,
        PointReading::ParallelDepth,
    ];
    roles.extend(best(&normals, Role::Depth, scalars, &kinds));
    roles
}

/// Removes the layers of normals from `vectors`; returns the best of them.
fn take_normals(vectors: &mut Vec<Sampled>, roles: &mut Vec<RoleByNumbers>) -> Option<NormalLayer> {
    let found = vectors.extract_if(.., |sampled| encoding_of(sampled).is_some());
    let mut found: Vec<NormalLayer> = found.filter_map(NormalLayer::of).collect();
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    let mut found = found.into_iter();
    let best = found.next()?;
    roles.push(RoleByNumbers {
        role: Role::Normal,
        found: best.sampled.found.clone(),
        why: format!("{:.0} % are of unit length", 100.0 * best.share),
        others: found.map(|normals| normals.sampled.found.layer).collect(),
    });
    Some(best)
}

/// Whether the vectors are unit normals once decoded from 0..1 or as they are, with the share of those that are; `None` if there is none.
fn encoding_of(sampled: &Sampled) -> Option<(bool, f64)> {
    let written = sampled.vectors().filter(|v| *v != Vector3::zeros());
    let stored: Vec<_> = written.collect();
    let is_positive = stored.iter().all(|v| v.min() >= 0.0 && v.max() < 1.01);
    let share = |is_unsigned: bool| {
        let lengths = || stored.iter().map(|v| decoded(*v, is_unsigned).norm());
        let covered = lengths().filter(|length| *length > UNIT).count() as f64;
        let longer = lengths().filter(|length| *length > 1.0 + UNIT).count() as f64;
        let unit = stored.iter().filter_map(|v| unit(*v, is_unsigned));
        let unit: Vec<_> = unit.collect();
        let count = unit.len() as f64;
        let oblique = unit.iter().filter(|v| v.amax() < 1.0 - UNIT).count() as f64;
        let mean = unit.iter().sum::<Vector3<f64>>() / count.max(1.0);
        let tells = unit.len() >= FEWEST
            && count >= UNIT_SHARE * covered
            && longer <= LONGER_SHARE * covered
            && oblique >= OFF_AXIS_SHARE * count
            && mean.norm() < ALIKE;
        tells.then(|| (is_unsigned, count / covered))
    };
    share(false).or_else(|| share(true).filter(|_| is_positive))
}

/// The layer whose points, of one of the `kinds` (the usual one first), best fit the surface with these `normals`.
fn best(
    normals: &NormalLayer,
    role: Role,
    layers: Vec<Sampled>,
    kinds: &[PointReading],
) -> Option<RoleByNumbers> {
    let mut found: Vec<(f64, Match)> = Vec::new();
    for layer in layers {
        let normal = |stored| unit(stored, normals.is_unsigned);
        let fits = kinds.iter().enumerate().filter_map(|(i, kind)| {
            let misfit = misfit(&normals.sampled, normal, &layer, *kind)?;
            Some(if i == 0 { misfit } else { USUAL * misfit })
        });
        let least = fits.min_by(f64::total_cmp);
        if let Some(least) = least.filter(|least| *least <= AGREES) {
            found.push((least, layer.found));
        }
    }
    found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut found = found.into_iter();
    let (_, layer) = found.next()?;
    Some(RoleByNumbers {
        role,
        found: layer,
        why: "they fit the normals".into(),
        others: found.map(|(_, other)| other.layer).collect(),
    })
}
