//! Strokes: from tone to density, and a texture along a field of directions.

use crate::error::{Error, Result};
use crate::frame::{Frame, Plane};
use crate::gpu::kernels::Kernel;
use crate::gpu::recorder::UPLOAD;
use crate::gpu::uniforms::uniforms;
use crate::gpu::wgsl::Number::F32;
use crate::gpu::wgsl::{Wgsl, wgsl};
use crate::kernel::last::Last;
use crate::kernel::timings::add_timings;
use crate::line::density::{LEAST_ALPHA, STEPS, density_table};
use crate::line::drawing::{DrawnTone, finish};
use crate::line::hatching::gpu_texture::DeviceTexture;
use crate::line::hatching::{CROSSED_FROM, Hatching};
use crate::line::texture_coordinates::gpu::{PLACES, Sheets, TEXTURE_COORDINATES};
use crate::line::tonal_art_map::{ENTRIES, MAX_DENSITY, TonalArtMap};
use crate::params;
use crate::params::ToneParams;
use crate::plan::recording::{PICTURE, Recording};
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
        /// Weights of luminance.
        weights: vec3,
        /// Luminance of paper white.
        white: f32,
    }

    /// Uniforms of `hatching.wgsl`.
    StrokeParams {
        /// Centre of the first pixel in a fixed texture.
        first: vec2,
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

/// Densities wanted in all; thresholds at even steps of density; level by level, set by set, cosine, sine and offset of the
/// texture rotated to the level's angle; the share of the paper left white, and for the last pass the share inked; this
/// sheet's share of the drawing.
const STROKES_BUFFERS: &str = "covered: u32; densities, direction_x, direction_y, thresholds: f32; turned: vec4<f32>; \
     texels: u32; paper: mut f32; place_x?, place_y?, depth?, motion_x?, motion_y?, shares?: f32";

/// The optical density that is wanted of each pixel.
pub(crate) static DENSITY: Kernel = Kernel::new::<DensityParams>(
    "Density",
    // The table holds densities at even steps of the square root of luminance, from 0 to white.
    "covered: u32; red, green, blue, alpha?, density_table: f32; densities: mut f32",
    &[wgsl!(
        "../density.wgsl",
        [
            ("DENSITY_STEPS", F32(STEPS as f32)),
            ("LEAST_ALPHA", F32(LEAST_ALPHA))
        ]
    )],
);

/// Strokes inked by thresholds.
pub(crate) static STROKES: Kernel = Kernel::new::<StrokeParams>(
    "Strokes",
    STROKES_BUFFERS,
    &[
        TEXTURE_COORDINATES,
        PLACES,
        wgsl!("../stroke_texture.wgsl"),
        HATCHING,
    ],
);

/// Strokes of pictures.
pub(crate) static PICTURE_STROKES: Kernel = Kernel::new::<StrokeParams>(
    "PictureStrokes",
    STROKES_BUFFERS,
    &[
        TEXTURE_COORDINATES,
        PLACES,
        wgsl!("../slice_texture.wgsl"),
        HATCHING,
    ],
);

/// A texture on the device, and its transform at every level.
pub(crate) struct Strokes {
    texture: DeviceTexture,
    /// For each family.
    turned: [Vec<[f32; 4]>; 2],
}

impl Strokes {
    /// Strokes of `texture`, which is a copy of `map`.
    pub(crate) fn new(
        map: &TonalArtMap,
        texture: DeviceTexture,
        params: &params::StrokeParams,
    ) -> Self {
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
    let tone = DrawnTone::taken(&mut run.host);
    let start = Instant::now();
    // The picture made so far, or that of the frame.
    if let Some(color) = frame.color.as_ref().filter(|_| !run.has(PICTURE[0])) {
        run.upload_picture(color);
    }
    let strokes = &params.strokes;
    let strokes = match &run.host.canvas().art_map {
        Some(map) => {
            let copied = run.lent.get::<Last<TonalArtMap, DeviceTexture>>();
            let copied = copied.expect("a runner lends it");
            let copied = copied.of(map, || {
                Ok::<_, Error>(DeviceTexture::new(map, run.upload()))
            })?;
            Strokes::new(map, copied, strokes)
        }
        None => {
            let map = run.host.given_art_map();
            let map = map.expect("strokes of pictures come with them");
            Strokes::new(map, DeviceTexture::new(map, run.upload()), strokes)
        }
    };
    let canvas = std::mem::take(run.host.canvas_mut());
    let sheets = run.sheets(canvas.coordinates.as_ref());
    let directions = canvas.directions.iter();
    let directions: Vec<_> = directions.map(|field| run.hold_field(field)).collect();
    *run.host.canvas_mut() = canvas;
    add_timings(&mut run.waited, &[(UPLOAD, start.elapsed())]);
    run.find_densities(&params.tone, tone.white);
    run.hatched(&params.strokes, &directions, &strokes, &sheets);
    let ink = run.plane("paper");
    let read = run.read_all(&[&ink])?.remove(0);
    let ink = Plane::from_samples(frame.mask.width(), frame.mask.height(), read);
    finish(&mut run.host, tone, ink, Vec::new());
    Ok(())
}

impl Recording<'_> {
    /// The optical density wanted of each pixel of the picture, with this paper white.
    fn find_densities(&mut self, params: &ToneParams, white: f32) {
        let frame = self.frame;
        let table = self.uploaded(&density_table(params));
        let has_alpha = self.upload_as("alpha", frame.alpha.as_ref());
        let params = DensityParams {
            weights: frame.luminance_weights(),
            white,
        };
        let kernel: (&Kernel, &[_]) = (&DENSITY, &[("HAS_ALPHA", has_alpha)]);
        self.over_pixels("density", kernel, &params, &[("density_table", &table)]);
    }

    /// Coverage of the paper by strokes along one field of directions, x and y, for each of their families.
    fn hatched(
        &mut self,
        params: &params::StrokeParams,
        directions: &[[wgpu::Buffer; 2]],
        strokes: &Strokes,
        sheets: &Sheets,
    ) {
        let Strokes { texture, turned } = strokes;
        let turned = turned
            .each_ref()
            .map(|turned| self.uploaded(turned.as_flattened()));
        let families = directions.len();
        let layers = sheets.each.iter().flat_map(|sheet| {
            let families = directions.iter().zip(&turned).enumerate();
            families.map(move |family| (sheet, family))
        });
        let kernel = match texture.slices {
            0 => &STROKES,
            _ => &PICTURE_STROKES,
        };
        let count = sheets.each.len() * families;
        for (layer, (sheet, (family, ([x, y], turned)))) in layers.enumerate() {
            let switches = [
                ("MOVES", sheet.place.is_some()),
                ("HAS_DEPTH", sheets.depth.is_some()),
                ("HAS_MOTION", sheets.motion.is_some()),
                ("HAS_SHARE", sheet.share.is_some()),
                ("IS_FIRST", layer == 0),
                ("IS_LAST", layer + 1 == count),
            ];
            let mut named = vec![
                ("direction_x", x),
                ("direction_y", y),
                ("thresholds", &texture.thresholds),
                ("turned", turned),
                ("texels", &texture.texels),
            ];
            let place = sheet.place.iter().flatten();
            named.extend(["place_x", "place_y"].into_iter().zip(place));
            let motion = sheets.motion.iter().flatten();
            named.extend(["motion_x", "motion_y"].into_iter().zip(motion));
            named.extend(sheets.depth.iter().map(|depth| ("depth", depth)));
            named.extend(sheet.share.iter().map(|share| ("shares", share)));
            let family = [family, families];
            let params = stroke_params(params, self.frame, texture, sheet.origin, family);
            self.over_pixels("hatching", (kernel, &switches), &params, &named);
        }
    }
}

/// The uniforms of one of several families of strokes, with the texture offset by `origin` if it is fixed.
fn stroke_params(
    params: &params::StrokeParams,
    frame: &Frame,
    texture: &DeviceTexture,
    origin: [f32; 2],
    [family, families]: [usize; 2],
) -> StrokeParams {
    let window = frame.data_window;
    StrokeParams {
        first: [
            window.x0 as f32 + 0.5 + origin[0],
            window.y0 as f32 + 0.5 + origin[1],
        ],
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
