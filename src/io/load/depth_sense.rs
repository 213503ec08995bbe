//! Whether a layer of depth grows with distance, shrinks with it, or is no distance at all.
//!
//! Nuke writes 1/z, others map near and far to white and black either way round. Where the background is a
//! renderer's infinity there is nothing to ask. Otherwise the normals decide: depth rises the way they lean, and what falls
//! that way is the reverse of a distance. One over it is a distance if its slopes then fit the normals through
//! some lens. What the data leave open, the layer's name and the renderer decide.

use crate::frame::coverage::{self, has_direction};
use crate::frame::depth::{is_distance, to_distances};
use crate::frame::sampling::one_in;
use crate::frame::{Camera, Mask, Plane, Vector3Planes};
use crate::io::camera::{CameraSearch, recover_camera_from_depth};
use crate::io::inputs::{Inputs, StoredDepth};
use crate::io::judge::depth::{Sense, off_tangents};
use crate::io::judge::silhouettes::Silhouettes;
use crate::io::judge::surface::SurfaceSamples;
use crate::io::normal_space::{NormalSamples, is_reversed};
use crate::io::roles::names::Hint;
use crate::kernel::quantile::quantile;
use std::borrow::Cow;

/// Mean angle, in degrees, between the slope of depth and the lean of normals up to which they agree.
const AGREES_DEG: f64 = 35.0;
/// Share of normals that face the viewer in view space.
const FACES: f64 = 0.9;
/// Median angle, in degrees, between normals and the slopes of depth up to which it is a distance.
const DISTANCE_DEG: f64 = 4.0;
/// One of two such angles is clearly less if it is less than this share of the other, and by more than these degrees.
const CLEARLY: f64 = 0.5;
const ALIKE_DEG: f64 = 0.001;
/// Samples of depth that are looked at, about.
const WANTED: usize = 10_000;
/// Depth mapped to 0..1 may exceed 1 by this much.
pub(crate) const ABOVE_ONE: f32 = 1e-3;

/// The layers that the sense of depth is judged from.
pub(crate) struct SenseLayers<'a> {
    pub(crate) inputs: &'a Inputs,
    /// Depth as stored.
    pub(crate) raw: &'a Plane,
    /// Decoded normals.
    pub(crate) normal: &'a Vector3Planes,
    /// The rest; its mask and depth are not looked at.
    pub(crate) surface: SurfaceSamples<'a>,
    pub(crate) alpha: Option<&'a Plane>,
    pub(crate) mask: Option<&'a Plane>,
}

impl SenseLayers<'_> {
    /// Alpha, where it decides on coverage.
    fn alpha(&self) -> Option<&Plane> {
        self.alpha.filter(|_| self.mask.is_none())
    }

    /// Whether a pixel shows a surface, whatever its depth.
    fn shows_surface(&self, x: usize, y: usize) -> bool {
        let shows = |plane: Option<&Plane>| plane.is_none_or(|plane| plane.at(x, y) > 0.5);
        shows(self.alpha()) && shows(self.mask) && has_direction(self.normal.at(x, y).as_vec3())
    }
}

/// Values of depth where a surface was seen, and where none was.
#[derive(Debug)]
struct Range {
    least: f32,
    most: f32,
    /// Whether some are exactly 0 or 1, as clamping leaves them.
    clamped: bool,
    background: Option<f32>,
}

impl Range {
    fn is_unit(&self) -> bool {
        self.least >= 0.0 && self.most <= 1.0 + ABOVE_ONE
    }

    /// Whether the background is what renderers write for an infinite distance.
    fn is_open(&self) -> bool {
        self.background
            .is_some_and(|b| b != 0.0 && !is_distance(b.abs()))
    }

    /// Whether the values look mapped to 0..1 rather than small distances.
    fn looks_mapped(&self) -> bool {
        self.is_unit() && (self.clamped || self.background == Some(1.0))
    }
}

/// Which way depth goes.
#[derive(Clone, Copy, PartialEq)]
enum DepthWay {
    Away,
    Toward,
}

/// The quantity that the layer holds instead of a plain distance. A placed camera is searched for only if the normals
/// as stored leave it open.
///
/// # Errors
/// Those of reading the camera's file.
pub(crate) fn judge_sense(
    layers: &SenseLayers,
    (hint, by): (Hint, String),
) -> crate::Result<Sense> {
    let Some(range) = range(layers) else {
        return Ok(None);
    };
    let hinted = hint.depth.filter(|stored| match stored {
        StoredDepth::WhiteFar | StoredDepth::NormalizedNearIsOne => range.is_unit(),
        _ => true,
    });
    if range.is_open() {
        return Ok(None);
    }
    let judged = JudgedSense {
        layers,
        covered: coverage::of_normals(layers.normal, Some(layers.raw), layers.alpha(), layers.mask),
        range: range.most - range.least,
    };
    let implied = match hinted {
        Some(StoredDepth::Inverse | StoredDepth::NormalizedNearIsOne) => Some(DepthWay::Toward),
        Some(_) => Some(DepthWay::Away),
        // Beyond 1 it was not mapped, and distances are what most programs write.
        None => (!range.is_unit()).then_some(DepthWay::Away),
    };
    let (way, why, camera) = judged.way(implied)?;
    Ok(match way {
        Some(DepthWay::Toward) => {
            let stored = match hinted {
                Some(stored @ (StoredDepth::Inverse | StoredDepth::NormalizedNearIsOne)) => stored,
                _ if !range.is_unit() => StoredDepth::Inverse,
                _ if range.looks_mapped() => StoredDepth::NormalizedNearIsOne,
                _ if judged.is_distance(StoredDepth::Inverse, camera.as_ref()) => {
                    StoredDepth::Inverse
                }
                _ => StoredDepth::NormalizedNearIsOne,
            };
            Some((stored, format!("it falls where {why}")))
        }
        Some(DepthWay::Away) if range.looks_mapped() => {
            let is_distance = judged.is_distance(StoredDepth::Planar, camera.as_ref());
            (!is_distance).then(|| {
                let why = format!("it rises where {why}, and lies between 0 and 1");
                (StoredDepth::WhiteFar, why)
            })
        }
        Some(DepthWay::Away) => None,
        None => hinted
            .filter(|stored| !matches!(stored, StoredDepth::Planar | StoredDepth::Ray))
            .map(|stored| (stored, format!("{by}; the normals leave it open"))),
    })
}

/// The values of depth, where any surface was seen at all: those of a sample, unless all lie between 0 and 1, which takes
/// all values to be sure of.
fn range(layers: &SenseLayers) -> Option<Range> {
    let (width, height) = (layers.raw.width(), layers.raw.height());
    let of = |area: f64| range_of(layers, one_in(area, 0..width, 0..height));
    let sampled = of((width * height) as f64 / WANTED as f64);
    let is_clear = |range: &Range| range.is_open() || !range.is_unit();
    sampled.filter(is_clear).or_else(|| of(1.0))
}

/// The values of depth at some pixels.
fn range_of(layers: &SenseLayers, pixels: impl Iterator<Item = (usize, usize)>) -> Option<Range> {
    let mut range = Range {
        least: f32::INFINITY,
        most: f32::NEG_INFINITY,
        clamped: false,
        background: None,
    };
    let mut outside = Vec::new();
    for (x, y) in pixels {
        let d = layers.raw.at(x, y);
        if (d == 0.0 || is_distance(d.abs())) && layers.shows_surface(x, y) {
            range.least = range.least.min(d);
            range.most = range.most.max(d);
            range.clamped |= d == 0.0 || d == 1.0;
        } else if !d.is_nan() {
            // A renderer's infinity inside the surface is its background too.
            outside.push(d);
        }
    }
    range.background = quantile(&mut outside, 0.5, f32::total_cmp);
    (range.least <= range.most).then_some(range)
}

struct JudgedSense<'a> {
    layers: &'a SenseLayers<'a>,
    /// The surface, where it has a depth.
    covered: Mask,
    /// The largest less the smallest of it.
    range: f32,
}

const POINT_OUTWARD: &str = "the normals lean toward what is far, and point outward at outlines";

impl JudgedSense<'_> {
    fn surface<'a>(&'a self, depth: &'a Plane) -> SurfaceSamples<'a> {
        SurfaceSamples {
            mask: &self.covered,
            depth: Some(depth),
            ..self.layers.surface
        }
    }

    /// Which way depth goes, why, and the camera that was found for it.
    ///
    /// Depth that falls beside normals with x reversed leans as depth that rises beside normals with y reversed, and the
    /// other way round. Where it comes to that, the way is the `implied` one; where none is, the one that outlines show;
    /// else y is taken to be reversed, as in all that DirectX uses, and hardly anything reverses x.
    fn way(
        &self,
        implied: Option<DepthWay>,
    ) -> crate::Result<(Option<DepthWay>, &'static str, Option<Camera>)> {
        let way_of = |angle: f64| match angle {
            a if a <= AGREES_DEG => Some(DepthWay::Away),
            a if a >= 180.0 - AGREES_DEG => Some(DepthWay::Toward),
            _ => None,
        };
        let raw = self.layers.raw;
        let surface = self.surface(raw);
        let samples = NormalSamples::new(self.layers.normal, &self.covered, None, Some(raw));
        let evidence = |camera| samples.judge(camera, surface.data_window).evidence;
        let unaided = evidence(None);
        let faces = unaided.facing_view() >= FACES;
        let [as_is, x, y, _] = unaided.slope_reversed_deg.unwrap_or([90.0; 4]);
        let reversed = [y, x].map(way_of);
        // Half a picture of floor leans with depth whichever way one of the axes goes.
        let off = |angle: f64| angle.min(180.0 - angle);
        let as_is = way_of(as_is).filter(|_| !is_reversed(off(as_is), off(y)));
        let leaning = "the normals lean toward what is far";
        let both = |way: DepthWay| {
            // As stored, they lean as beside depth that goes the other way.
            let agree = self.outlines().agree(way == DepthWay::Away, [true, true]);
            (agree == Some(true)).then_some((way, POINT_OUTWARD))
        };
        let other = implied.filter(|implied| as_is.is_some_and(|way| way != *implied));
        let mut view = other.and_then(both).or(as_is.map(|way| (way, leaning)));
        if view.is_none() && faces {
            view = self.way_of_reversed(reversed, implied, leaning);
        }
        if let Some((way, why)) = view.filter(|_| faces) {
            return Ok((Some(way), why, None));
        }
        let mut search = CameraSearch::new(self.layers.inputs, &surface);
        if let Some(camera) = search.placed(&samples)? {
            let slope = evidence(Some(&camera)).world.slope_deg;
            let way = slope.and_then(way_of);
            return Ok((
                way,
                "the turned normals lean toward what is far",
                Some(camera),
            ));
        }
        // Without a camera one has to be found either way.
        let residual = |stored| self.recovered_deg(stored).unwrap_or(90.0);
        // Both are tried: the inverse of a plane's distance in perspective is that of another plane in parallel.
        let [away, toward] = [StoredDepth::Planar, StoredDepth::Inverse].map(residual);
        let clearly = |less: f64, more: f64| less < CLEARLY * more && more - less > ALIKE_DEG;
        let way = match away.min(toward) <= DISTANCE_DEG {
            true if clearly(away, toward) => Some(DepthWay::Away),
            true if clearly(toward, away) => Some(DepthWay::Toward),
            // Both fit, as they do a surface that is nearly flat: the simpler one is believed.
            true => implied.or(Some(DepthWay::Away)),
            false => None,
        };
        Ok((
            way,
            "the normals, turned to fit, lean toward what is far",
            None,
        ))
    }

    /// The sense of depth, and why, if depth agrees with the normals either with y reversed, in the first sense of
    /// `reversed`, or with x reversed, in the second.
    fn way_of_reversed(
        &self,
        reversed: [Option<DepthWay>; 2],
        implied: Option<DepthWay>,
        leaning: &'static str,
    ) -> Option<(DepthWay, &'static str)> {
        let [y, x] = reversed;
        if let Some(way) = implied.filter(|_| reversed.contains(&implied)) {
            return Some((way, leaning));
        }
        let outlines = self.outlines();
        let shows = |way: Option<DepthWay>, axes| {
            outlines
                .agree(way? == DepthWay::Away, axes)
                .filter(|agree| *agree)
        };
        match (shows(y, [false, true]), shows(x, [true, false])) {
            (Some(_), None) => Some((y?, POINT_OUTWARD)),
            (None, Some(_)) => Some((x?, POINT_OUTWARD)),
            _ => Some((y.or(x)?, leaning)),
        }
    }

    fn outlines(&self) -> Silhouettes {
        let depth = Some((self.layers.raw, self.range));
        Silhouettes::of(self.layers.normal, &self.covered, depth)
    }

    /// The layer as distances, if it holds what is `stored`.
    fn distances(&self, stored: StoredDepth) -> Cow<'_, Plane> {
        let mut depth = Cow::Borrowed(self.layers.raw);
        if stored != StoredDepth::Planar {
            to_distances(depth.to_mut(), stored);
        }
        depth
    }

    /// The angle left between normals and depth by the camera recovered from them, in degrees.
    fn recovered_deg(&self, stored: StoredDepth) -> Option<f64> {
        let depth = self.distances(stored);
        let surface = self.surface(&depth);
        let found = recover_camera_from_depth(
            self.layers.normal,
            &depth,
            &self.covered,
            surface.data_window,
            surface.display_window,
            surface.pixel_aspect,
        );
        found.ok().map(|found| found.residual_deg_median)
    }

    /// Whether the layer, read so, is a distance through this camera, or through any.
    fn is_distance(&self, stored: StoredDepth, camera: Option<&Camera>) -> bool {
        let Some(camera) = camera else {
            return self
                .recovered_deg(stored)
                .is_some_and(|deg| deg <= DISTANCE_DEG);
        };
        let depth = self.distances(stored);
        let surface = self.surface(&depth);
        let off = off_tangents(&surface, self.layers.normal, &depth, camera);
        off.is_some_and(|deg| deg <= DISTANCE_DEG)
    }
}
