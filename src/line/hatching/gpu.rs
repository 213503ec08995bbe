//! Strokes: from tone to density, and a texture along a field of directions.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::recorder::UPLOAD;
use crate::engine::gpu::recording::Recording;
use crate::engine::gpu::surface::Picture;
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::F32;
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::engine::outcome::add_timings;
use crate::error::Result;
use crate::frame::{Frame, Plane};
use crate::line::density::{LEAST_ALPHA, STEPS, density_table};
use crate::line::drawing::{Tone, finish};
use crate::line::hatching::gpu_texture::Texture;
use crate::line::hatching::{CROSSED_FROM, Hatching};
use crate::line::texture_coordinates::gpu::{PLACES, Sheets, TEXTURE_COORDINATES};
use crate::line::tonal_art_map::{ENTRIES, MAX_DENSITY, TonalArtMap};
use crate::params;
use crate::params::ToneParams;
use std::f32::consts::PI;
use std::time::Instant;

/// Strokes along a field of directions.
const HATCHING: Wgsl = wgsl!(
    "hatching.wgsl",
    [
        ("MAX_DENSITY", F32(MAX_DENSITY)),
        ("RESPONSE_ENTRIES", F32(ENTRIES as f32)),
        ("ENTRIES_PER_DENSITY", F32(ENTRIES as f32 / MAX_DENSITY)),
        ("CROSSED_FROM", F32(CROSSED_FROM))
    ]
);

uniforms! {
    /// Uniforms of `density.wgsl`.
    DensityParams {
        width: u32,
        height: u32,
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
        /// Luminance of paper white.
        white: f32,
    }

    /// Uniforms of `hatching.wgsl`.
    StrokeParams {
        width: u32,
        height: u32,
        /// Centre of the first pixel in a fixed texture.
        first_x: f32,
        first_y: f32,
        levels: u32,
        levels_per_radian: f32,
        sets: u32,
        /// 1 over the sets.
        share_of_set: f32,
        /// Index of the family, and number of families.
        family: u32,
        families: u32,
        texture_width: u32,
        texture_height: u32,
        /// Slices of a texture of pictures.
        slices: u32,
    }
}

bindings! {
    DensityBuffers {
        covered: &[u32], red: &[f32], green: &[f32], blue: &[f32],
        /// Any buffer if there is no alpha.
        alpha: &[f32],
        /// Densities at even steps of the square root of luminance, from 0 to white.
        density_table: &[f32], densities: &mut [f32],
    }
    StrokesBuffers {
        covered: &[u32],
        /// Optical density that is wanted in all.
        densities: &[f32], direction_x: &[f32], direction_y: &[f32],
        /// Thresholds at even steps of density.
        thresholds: &[f32],
        /// Level by level, set by set: cosine, sine and offset of the texture rotated to the level's angle.
        turned: &[vec4<f32>], texels: &[u32],
        /// Share of the paper left white; for the last pass, the share inked.
        paper: &mut [f32],
        /// Any buffers if there are no places.
        place_x: &[f32], place_y: &[f32], depth: &[f32], motion_x: &[f32], motion_y: &[f32],
        /// This sheet's share of the drawing; any buffer if it is the only one.
        shares: &[f32],
    }
}

/// The optical density that is wanted of each pixel.
pub(crate) static DENSITY: Kernel = Kernel::new::<DensityParams, DensityBuffers>(
    "Density",
    &[wgsl!(
        "../density.wgsl",
        [
            ("DENSITY_STEPS", F32(STEPS as f32)),
            ("LEAST_ALPHA", F32(LEAST_ALPHA))
        ]
    )],
);

/// Strokes inked by thresholds.
pub(crate) static STROKES: Kernel = Kernel::new::<StrokeParams, StrokesBuffers>(
    "Strokes",
    &[
        TEXTURE_COORDINATES,
        PLACES,
        wgsl!("../stroke_texture.wgsl"),
        HATCHING,
    ],
);

/// Strokes of pictures.
pub(crate) static PICTURE_STROKES: Kernel = Kernel::new::<StrokeParams, StrokesBuffers>(
    "PictureStrokes",
    &[
        TEXTURE_COORDINATES,
        PLACES,
        wgsl!("../slice_texture.wgsl"),
        HATCHING,
    ],
);

/// A texture on the device, and its transform at every level.
pub(crate) struct Strokes {
    texture: Texture,
    /// For each family.
    turned: [Vec<[f32; 4]>; 2],
}

impl Strokes {
    /// Strokes of `texture`, which is a copy of `map`.
    pub(crate) fn new(map: &TonalArtMap, texture: Texture, params: &params::StrokeParams) -> Self {
        let turned = |family| Hatching::new(map, params, family).turned().collect();
        Self {
            texture,
            turned: [turned(0), turned(1)],
        }
    }
}

/// Draws strokes of a texture in the tone of the picture, along the directions that the CPU found.
pub(crate) fn hatch(run: &mut Recording) -> Result<()> {
    let (plan, frame) = (run.plan, run.frame);
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let tone = Tone::taken(&mut run.host);
    let start = Instant::now();
    let picture = run.drawn_picture();
    let (strokes, texture) = (&params.strokes, run.texture);
    let strokes = match &run.host.canvas.art_map {
        Some(map) => Strokes::new(map, texture.of(map, run.upload()), strokes),
        None => {
            let map = run.host.inputs.art_map;
            let map = map.expect("strokes of pictures come with them");
            Strokes::new(map, Texture::new(map, run.upload()), strokes)
        }
    };
    let canvas = std::mem::take(&mut run.host.canvas);
    let sheets = run.sheets(canvas.coordinates.as_ref());
    let directions = canvas.directions.iter();
    let directions: Vec<_> = directions.map(|field| run.hold_field(field)).collect();
    run.host.canvas = canvas;
    add_timings(&mut run.waited, &[(UPLOAD, start.elapsed())]);
    let densities = run.densities(&params.tone, frame, &picture, tone.white);
    let ink = run.hatched(
        &params.strokes,
        frame,
        &densities,
        &directions,
        &strokes,
        &sheets,
    );
    let read = run.read_all(&[&ink])?.remove(0);
    run.buffers.recycle([densities, ink]);
    let ink = Plane::from_samples(frame.mask.width(), frame.mask.height(), read);
    finish(&mut run.host, tone, ink, Vec::new());
    Ok(())
}

impl Recording<'_> {
    /// The picture made so far, or that of the frame.
    fn drawn_picture(&mut self) -> Picture {
        self.made.picture.clone().unwrap_or_else(|| {
            let color = self.frame.color.as_ref();
            let color = color.expect("a drawing is planned with its tone");
            let picture = self.upload().color(color);
            self.held.extend(picture.iter().cloned());
            picture
        })
    }

    /// The optical density wanted of each pixel of a picture with this paper white.
    fn densities(
        &mut self,
        params: &ToneParams,
        frame: &Frame,
        [red, green, blue]: &Picture,
        white: f32,
    ) -> wgpu::Buffer {
        let [width, height] = self.surface.size;
        let [weight_r, weight_g, weight_b] = frame.luminance_weights();
        let densities = self.take(self.surface.plane_bytes());
        let table = self.uploaded(&density_table(params));
        let alpha = frame
            .alpha
            .as_ref()
            .map(|alpha| self.uploaded(alpha.samples()));
        self.recorder.over_pixels(
            "density",
            (&DENSITY, &[("HAS_ALPHA", alpha.is_some())]),
            &DensityParams {
                width,
                height,
                weight_r,
                weight_g,
                weight_b,
                white,
            },
            &DensityBuffers {
                covered: &self.surface.covered,
                red,
                green,
                blue,
                alpha: alpha.as_ref().unwrap_or(red),
                density_table: &table,
                densities: &densities,
            },
            [width, height],
        );
        densities
    }

    /// Coverage of the paper by strokes along one field of directions, x and y, for each of their families.
    fn hatched(
        &mut self,
        params: &params::StrokeParams,
        frame: &Frame,
        densities: &wgpu::Buffer,
        directions: &[[wgpu::Buffer; 2]],
        strokes: &Strokes,
        sheets: &Sheets,
    ) -> wgpu::Buffer {
        let paper = self.take(self.surface.plane_bytes());
        let Strokes { texture, turned } = strokes;
        let turned = turned
            .each_ref()
            .map(|turned| self.uploaded(turned.as_flattened()));
        let families = directions.len();
        let layers = sheets.each.iter().flat_map(|sheet| {
            let families = directions.iter().zip(&turned).enumerate();
            families.map(move |family| (sheet, family))
        });
        let count = sheets.each.len() * families;
        for (layer, (sheet, (family, ([x, y], turned)))) in layers.enumerate() {
            let kernel = match texture.slices {
                0 => &STROKES,
                _ => &PICTURE_STROKES,
            };
            let switches = [
                ("MOVES", sheet.place.is_some()),
                ("HAS_DEPTH", sheets.depth.is_some()),
                ("HAS_MOTION", sheets.motion.is_some()),
                ("HAS_SHARE", sheet.share.is_some()),
                ("IS_FIRST", layer == 0),
                ("IS_LAST", layer + 1 == count),
            ];
            let [place_x, place_y] = sheet
                .place
                .as_ref()
                .map_or([x, y], |place| place.each_ref());
            let motion = sheets.motion.as_ref();
            let [motion_x, motion_y] = motion.map_or([x, y], |motion| motion.each_ref());
            self.recorder.over_pixels(
                "hatching",
                (kernel, &switches),
                &stroke_params(params, frame, texture, sheet.origin, [family, families]),
                &StrokesBuffers {
                    covered: &self.surface.covered,
                    densities,
                    direction_x: x,
                    direction_y: y,
                    thresholds: &texture.thresholds,
                    turned,
                    texels: &texture.texels,
                    paper: &paper,
                    place_x,
                    place_y,
                    depth: sheets.depth.as_ref().unwrap_or(x),
                    motion_x,
                    motion_y,
                    shares: sheet.share.as_ref().unwrap_or(x),
                },
                self.surface.size,
            );
        }
        paper
    }
}

/// The uniforms of one of several families of strokes, with the texture offset by `origin` if it is fixed.
fn stroke_params(
    params: &params::StrokeParams,
    frame: &Frame,
    texture: &Texture,
    origin: [f32; 2],
    [family, families]: [usize; 2],
) -> StrokeParams {
    let window = frame.data_window;
    StrokeParams {
        width: frame.mask.width() as u32,
        height: frame.mask.height() as u32,
        first_x: window.x0 as f32 + 0.5 + origin[0],
        first_y: window.y0 as f32 + 0.5 + origin[1],
        levels: params.levels,
        levels_per_radian: params.levels as f32 / PI,
        sets: params.sets,
        share_of_set: 1.0 / params.sets as f32,
        family: family as u32,
        families: families as u32,
        texture_width: texture.size[0],
        texture_height: texture.size[1],
        slices: texture.slices,
    }
}
