//! Strokes that move with the surface: the maps that place the texture, on the device.

use crate::gpu::wgsl::Number::F32;
use crate::gpu::wgsl::{Wgsl, wgsl};
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::line::texture_coordinates::sheet::PlacedTexture;
use crate::line::texture_coordinates::{DEPTH_STEP, JUMP, MOTION_STEP};
use crate::plan::recording::Recording;

/// Placement of a texture on a moving surface.
pub(crate) const TEXTURE_COORDINATES: Wgsl =
    wgsl!("texture_coordinates.wgsl", [("JUMP", F32(JUMP))]);

/// Placement of the texture at each pixel.
pub(crate) const PLACES: Wgsl = wgsl!(
    "places.wgsl",
    [
        ("DEPTH_STEP", F32(DEPTH_STEP)),
        ("MOTION_STEP_PX", F32(MOTION_STEP[0])),
        ("MOTION_STEP_SHARE", F32(MOTION_STEP[1]))
    ]
);

/// The drawings that share a hatching.
pub(crate) struct Sheets {
    pub(crate) each: Vec<BoundTexture>,
    /// Depth, which separates moving surfaces.
    pub(crate) depth: Option<wgpu::Buffer>,
    pub(crate) motion: Option<[wgpu::Buffer; 2]>,
}

/// A [`PlacedTexture`] on the device.
pub(crate) struct BoundTexture {
    pub(crate) place: Option<[wgpu::Buffer; 2]>,
    pub(crate) origin: [f32; 2],
    pub(crate) share: Option<wgpu::Buffer>,
}

impl Recording<'_> {
    /// The sheets of a drawing; without coordinates its texture is fixed in the picture.
    pub(crate) fn sheets(&mut self, coordinates: Option<&TextureCoordinates>) -> Sheets {
        let sheets = coordinates.map_or(vec![PlacedTexture::STILL], TextureCoordinates::sheets);
        let surface = sheets.iter().find_map(|sheet| sheet.place);
        let surface = surface.map(|(_, surface)| surface);
        let depth = surface.and_then(|surface| surface.depth);
        let motion = surface.and_then(|surface| surface.motion);
        Sheets {
            each: sheets.iter().map(|sheet| self.laid(sheet)).collect(),
            depth: depth.map(|depth| self.uploaded(depth.samples())),
            motion: motion.map(|motion| self.hold_field(motion)),
        }
    }

    fn laid(&mut self, sheet: &PlacedTexture) -> BoundTexture {
        BoundTexture {
            place: sheet.place.map(|(place, _)| self.hold_field(place)),
            origin: sheet.origin,
            share: sheet.share.map(|share| self.uploaded(share.samples())),
        }
    }
}
