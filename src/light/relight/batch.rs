//! Gathering covered pixels from the planes, and scattering their results.

use crate::frame::{ColorPlanes, DepthKind, Plane};
use crate::light::alignment::{Detail, SIGMAS_PX};
use crate::light::batch::{BATCH, Lanes, LitPixels, Vectors};
use crate::light::relight::curvature::{CurvatureRow, CurvedBy};
use crate::light::relight::scene::LitScene;
use crate::light::shadows::cast::WHOLE;
use crate::light::shadows::horizons::{AZIMUTHS, Bearing, HorizonLanes, see_sky};
use crate::light::sum::{LightSum, LightSums};
use glam::DVec3;
use std::ops::Range;

/// Neighbouring pixels of a row in neighbouring lanes.
#[derive(Debug, Clone)]
struct RowPiece {
    y: usize,
    columns: Range<usize>,
    lane: usize,
}

/// The shape of a row.
#[derive(Clone, Copy)]
pub(crate) struct RowShape<'a> {
    pub(crate) normal: [&'a [f32]; 3],
    pub(crate) curvature: &'a CurvatureRow,
}

/// Light that the albedo does not tell of.
#[repr(C, align(64))]
pub(crate) struct GlossLanes {
    /// Mirrored light: as diffuse what follows the reflectance, as specular that of grazing angles.
    pub(crate) sums: LightSums,
    /// Reflectance where the surface faces the viewer.
    pub(crate) reflectance: [Lanes; 3],
    /// Light that stays as it was rendered.
    pub(crate) kept: [Lanes; 3],
}

/// A batch in progress.
#[repr(C, align(64))]
pub(crate) struct Batch {
    pub(crate) pixels: LitPixels,
    pub(crate) sum: LightSum,
    /// Trace of the Hessian.
    pub(crate) trace: Lanes,
    /// Mapped curvature.
    pub(crate) kappa: Lanes,
    pub(crate) albedo: [Lanes; 3],
    /// Surfaces with gloss of their own.
    pub(crate) gloss: GlossLanes,
    /// Ambient occlusion, 1 for no occlusion: it dims ambient light and the diffuse light of an environment.
    pub(crate) occlusion: Lanes,
    /// Coverage, applied to the result.
    pub(crate) alpha: Lanes,
    /// Grain direction in the picture.
    pub(crate) grain: [Lanes; 2],
    /// The turn of lamps about the view axis, as cosine and sine.
    pub(crate) turn: [Lanes; 2],
    /// Places of the normals at coarser scales, and the detail beyond each.
    pub(crate) coarse: [[Lanes; 2]; SCALES],
    pub(crate) details: [Detail; SCALES],
    /// Elevations of horizons, for light from all around.
    pub(crate) horizons: HorizonLanes,
    /// Points of the surface, for lights near it.
    pub(crate) points: [Lanes; 3],
    /// Directions to a light near the surface, and the share that arrives.
    pub(crate) near: ([Lanes; 3], Lanes),
    /// Directions of look-ups.
    pub(crate) toward: Vectors,
    /// Weight of the look-ups.
    pub(crate) share: Lanes,
    /// Results of look-ups.
    pub(crate) looked_up: [Lanes; 3],
    /// Resulting colours.
    pub(crate) shown: [Lanes; 3],
    pieces: Vec<RowPiece>,
}

const SCALES: usize = SIGMAS_PX.len();

const ZERO: Lanes = [0.0; BATCH];
const ONE: Lanes = [1.0; BATCH];

impl Batch {
    pub(crate) fn new() -> Self {
        Self {
            pieces: Vec::new(),
            pixels: LitPixels::new(),
            sum: LightSum::new(),
            trace: ZERO,
            kappa: ZERO,
            albedo: [ONE; 3],
            gloss: GlossLanes {
                sums: LightSums::NONE,
                reflectance: [ZERO; 3],
                kept: [ZERO; 3],
            },
            occlusion: ONE,
            alpha: ONE,
            grain: [ZERO; 2],
            turn: [ZERO; 2],
            coarse: [[ZERO; 2]; SCALES],
            details: [Detail::NONE; SCALES],
            horizons: [ZERO; AZIMUTHS],
            points: [ZERO; 3],
            near: ([ZERO; 3], ZERO),
            toward: [ZERO; 3],
            share: ZERO,
            looked_up: [ZERO; 3],
            shown: [ZERO; 3],
        }
    }

    /// Adds a run of covered pixels; calls `full` whenever the batch is full.
    pub(crate) fn take_run(
        &mut self,
        scene: &LitScene,
        RowShape { normal, curvature }: RowShape,
        y: usize,
        mut columns: Range<usize>,
        mut full: impl FnMut(&mut Self),
    ) {
        while !columns.is_empty() {
            let count = columns.len().min(BATCH - self.pixels.count);
            let piece = columns.start..columns.start + count;
            columns.start += count;
            self.gather(scene, RowShape { normal, curvature }, y, piece);
            if self.pixels.count == BATCH {
                full(self);
                self.empty();
            }
        }
    }

    /// Calls `light` for the remaining pixels.
    pub(crate) fn finish(&mut self, light: impl FnOnce(&mut Self)) {
        if self.pixels.count > 0 {
            light(self);
            self.empty();
        }
    }

    fn empty(&mut self) {
        self.pieces.clear();
        self.pixels.count = 0;
    }

    /// Copies the samples of the pixels at `columns` of row `y` to the next lanes.
    fn gather(
        &mut self,
        scene: &LitScene,
        RowShape { normal, curvature }: RowShape,
        y: usize,
        columns: Range<usize>,
    ) {
        let lane = self.pixels.count;
        let lanes = lane..lane + columns.len();
        let copy_row = |to: &mut Lanes, from: &[f32]| {
            to[lanes.clone()].copy_from_slice(&from[columns.clone()]);
        };
        let copy = |to: &mut Lanes, from: &Plane| copy_row(to, from.row(y));
        let frame = scene.frame;
        for (lanes, row) in self.pixels.normal.vector.iter_mut().zip(normal) {
            copy_row(lanes, row);
        }
        match scene.curvature {
            Some(CurvedBy::Hessian(_)) => {
                for (k, lanes) in self.pixels.hessian.iter_mut().enumerate() {
                    copy_row(lanes, curvature.entry(k));
                }
            }
            Some(CurvedBy::Trace(_) | CurvedBy::Made(_)) => {
                copy_row(&mut self.trace, curvature.entry(0))
            }
            None => {}
        }
        if let Some(color) = scene.albedo {
            let [r, g, b] = &mut self.albedo;
            copy(r, &color.r);
            copy(g, &color.g);
            copy(b, &color.b);
        }
        if let Some(gloss) = scene.gloss {
            let [own, mirrored, kept] = [&gloss.reflectance, &gloss.mirrored, &gloss.kept]
                .map(|ColorPlanes { r, g, b }| [r, g, b].map(|plane| plane.row(y)));
            for k in 0..3 {
                copy_row(&mut self.gloss.reflectance[k], own[k]);
                copy_row(&mut self.gloss.kept[k], kept[k]);
                if scene.keeps_mirrored {
                    let light = mirrored[k][columns.clone()].iter();
                    let kept = self.gloss.kept[k][lanes.clone()].iter_mut();
                    kept.zip(light).for_each(|(kept, light)| *kept += light);
                }
            }
        }
        if let Some(occlusion) = &scene.occlusion {
            copy(&mut self.occlusion, occlusion);
        }
        if let Some(alpha) = &frame.alpha {
            copy(&mut self.alpha, alpha);
        }
        if let Some(grain) = scene.grain {
            let [x, y] = &mut self.grain;
            copy(x, &grain.x);
            copy(y, &grain.y);
        }
        if let Some(turns) = &scene.turns {
            let [cosine, sine] = &mut self.turn;
            copy(cosine, &turns.x);
            copy(sine, &turns.y);
        }
        if let Some(aligned) = &scene.aligned {
            for ([x, y], from) in self.coarse.iter_mut().zip(&aligned.coarse) {
                copy(x, &from.x);
                copy(y, &from.y);
            }
        }
        if let Some(horizons) = &scene.shadows.horizons {
            horizons.copy_to(&mut self.horizons, lanes.start, (y, columns.clone()));
        }
        if let Some([eye_x, eye_y]) = &scene.eye {
            let [x_lanes, y_lanes, _] = &mut self.pixels.to_eye.vector;
            x_lanes[lanes.clone()].copy_from_slice(&eye_x[columns.clone()]);
            y_lanes[lanes.clone()].fill(eye_y[y]);
        }
        if !scene.points.is_empty() {
            self.find_points(scene, y, columns.clone());
        }
        self.pixels.count += columns.len();
        self.pieces.push(RowPiece { y, columns, lane });
    }

    /// Sets the light that arrives to one of this direction everywhere.
    #[inline(always)]
    pub(crate) fn face(&mut self, direction: [f32; 3]) {
        let (directions, share) = &mut self.near;
        for (lanes, component) in directions.iter_mut().zip(direction) {
            lanes.fill(component);
        }
        share.fill(1.0);
    }

    /// Turns the light that arrives as lamps are turned.
    #[inline(always)]
    pub(crate) fn rake(&mut self) {
        let ([x, y, _], _) = &mut self.near;
        let [cosine, sine] = &self.turn;
        for i in 0..BATCH {
            let (along, across) = (x[i], y[i]);
            x[i] = cosine[i] * along - sine[i] * across;
            y[i] = sine[i] * along + cosine[i] * across;
        }
    }

    /// Computes view-space positions of the surface.
    fn find_points(&mut self, scene: &LitScene, y: usize, columns: Range<usize>) {
        let frame = scene.frame;
        let depth = frame.depth.as_ref().expect("points are planned with depth");
        let kind: DepthKind = frame.source.depth_kind;
        let (x0, y0) = (frame.data_window.x0, frame.data_window.y0);
        for (i, x) in columns.enumerate() {
            let lane = self.pixels.count + i;
            let position = [f64::from(x0) + x as f64, f64::from(y0) + y as f64].map(|p| p + 0.5);
            let depth = f64::from(depth.at(x, y));
            let point = scene.sight.point(position[0], position[1], depth, kind);
            let DVec3 { x, y, z } = point;
            (
                self.points[0][lane],
                self.points[1][lane],
                self.points[2][lane],
            ) = (x as f32, y as f32, z as f32);
        }
    }

    /// Takes off what horizons hide of light from this direction.
    #[inline(always)]
    pub(crate) fn hide(&mut self, direction: [f32; 3]) {
        Bearing::of(direction).hide(&self.horizons, &mut self.near.1);
    }

    /// Takes off what horizons hide of light that was looked up for this direction.
    #[inline(always)]
    pub(crate) fn hide_looked_up(&mut self, direction: [f32; 3]) {
        self.face(direction);
        self.hide(direction);
        for channel in &mut self.looked_up {
            let pairs = channel.iter_mut().zip(&self.near.1);
            pairs.for_each(|(light, share)| *light *= share);
        }
    }

    /// Takes what horizons leave of an even sky for the occlusion.
    #[inline(always)]
    pub(crate) fn find_sky(&mut self) {
        see_sky(
            &self.horizons,
            &self.pixels.normal.vector,
            &mut self.occlusion,
        );
    }

    /// Takes off what does not arrive of the light of a lamp.
    pub(crate) fn shade(&mut self, share: &Plane<u16>) {
        for RowPiece { y, columns, lane } in &self.pieces {
            let shares = &share.row(*y)[columns.clone()];
            let lanes = self.near.1[*lane..].iter_mut().zip(shares);
            lanes.for_each(|(light, &share)| *light *= f32::from(share) / WHOLE);
        }
    }

    /// The lane, column and row of every pixel.
    pub(crate) fn places(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        self.pieces.iter().flat_map(|piece| {
            let columns = piece.columns.clone().enumerate();
            columns.map(|(i, x)| (piece.lane + i, x, piece.y))
        })
    }

    /// Writes the resulting colours to rows that start with row `first` of the frame.
    pub(crate) fn scatter(&self, rows: &mut [&mut [f32]; 3], first: usize, width: usize) {
        for RowPiece { y, columns, lane } in &self.pieces {
            let start = (y - first) * width + columns.start;
            for (row, shown) in rows.iter_mut().zip(&self.shown) {
                row[start..start + columns.len()]
                    .copy_from_slice(&shown[*lane..lane + columns.len()]);
            }
        }
    }
}
