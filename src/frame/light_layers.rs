//! The layers of light that add up to a picture.

use super::{ColorPlanes, Plane};
use glam::Vec3;

/// The lobes of a surface's reflectance with separate light layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lobe {
    /// Reflected in all directions.
    Diffuse,
    /// Mirrored, sharp or blurred.
    Specular,
    /// Refracted through the surface.
    Transmission,
    /// Scattered beneath the surface.
    Subsurface,
    /// Mirrored by a clear coat.
    Coat,
    /// Mirrored by fibres.
    Sheen,
}

impl Lobe {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::Specular => "specular",
            Self::Transmission => "transmission",
            Self::Subsurface => "subsurface",
            Self::Coat => "coat",
            Self::Sheen => "sheen",
        }
    }

    /// Whether its light is independent of the view; otherwise it shows the mirrored or refracted world.
    pub fn is_diffuse(self) -> bool {
        matches!(self, Self::Diffuse | Self::Subsurface)
    }
}

/// The layers of one lobe. Its radiance is `(direct + indirect) * color`; an absent layer is 0, an absent colour 1.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeLayers {
    /// Which lobe.
    pub lobe: Lobe,
    /// Light from lights, or all light if the file does not separate it.
    pub direct: Option<ColorPlanes>,
    /// Light from other surfaces.
    pub indirect: Option<ColorPlanes>,
    /// The surface's own colour, for light stored without it.
    pub color: Option<ColorPlanes>,
    /// The surface's own colour, for light that already includes it: used to estimate the light alone.
    pub albedo: Option<ColorPlanes>,
}

/// The part of a lobe held by a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LobeLayer {
    /// [`LobeLayers::direct`].
    Direct,
    /// [`LobeLayers::indirect`].
    Indirect,
    /// [`LobeLayers::color`].
    Color,
    /// [`LobeLayers::albedo`].
    Albedo,
}

/// A light group: the contribution of some lights to the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct LightGroup {
    /// Its name.
    pub name: String,
    /// Its share of the picture.
    pub light: ColorPlanes,
    /// Unit directions in view space to its lights, or to samples of an area light.
    pub to_light: Vec<Vec3>,
}

/// Light that relighting cannot make of a diffuse colour: that of metals, glass, hair, lamps and fog. Premultiplied by
/// coverage.
#[derive(Debug, Clone, PartialEq)]
pub struct Gloss {
    /// Reflectance where the surface faces the viewer.
    pub reflectance: ColorPlanes,
    /// The scene that the surface mirrors; an environment takes its place.
    pub mirrored: ColorPlanes,
    /// All other light that stays as it was rendered.
    pub kept: ColorPlanes,
    /// Whether the file's colours of gloss are tints, white on plastic, and no reflectance.
    pub is_tint: bool,
}

/// From this diffuse colour on, a surface counts as no metal at all.
const DIFFUSE: f32 = 0.05;

impl Gloss {
    /// How much a surface of this diffuse colour counts as diffuse, rather than as metal, glass or lamp: 0..1.
    #[inline(always)]
    pub(crate) fn share_diffuse([r, g, b]: [f32; 3]) -> f32 {
        (r.max(g).max(b) * (1.0 / DIFFUSE)).clamp(0.0, 1.0)
    }
}

/// The light of a picture by lobes or light groups. Empty if the file has no such layers, or none were requested.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LightLayers {
    /// Lobes, at most one entry each.
    pub lobes: Vec<LobeLayers>,
    /// Light groups whose directions are known.
    pub groups: Vec<LightGroup>,
    /// Ambient occlusion, 1 where the surface is open.
    pub occlusion: Option<Plane>,
    /// Light beside that of the diffuse colour, for relighting.
    pub gloss: Option<Gloss>,
    /// Whether the picture is itself ambient occlusion.
    pub picture_is_occlusion: bool,
}

impl LightLayers {
    /// The layers of a lobe; added without layers if new.
    pub(crate) fn lobe_mut(&mut self, lobe: Lobe) -> &mut LobeLayers {
        let at = self.lobes.iter().position(|layers| layers.lobe == lobe);
        let at = at.unwrap_or_else(|| {
            self.lobes.push(LobeLayers {
                lobe,
                direct: None,
                indirect: None,
                color: None,
                albedo: None,
            });
            self.lobes.len() - 1
        });
        &mut self.lobes[at]
    }

    /// One layer of a lobe.
    pub(crate) fn layer_mut(&mut self, lobe: Lobe, layer: LobeLayer) -> &mut Option<ColorPlanes> {
        let layers = self.lobe_mut(lobe);
        match layer {
            LobeLayer::Direct => &mut layers.direct,
            LobeLayer::Indirect => &mut layers.indirect,
            LobeLayer::Color => &mut layers.color,
            LobeLayer::Albedo => &mut layers.albedo,
        }
    }

    /// The same layers with every plane replaced by `plane` of it.
    pub fn map(&self, plane: impl Fn(&Plane) -> Plane) -> Self {
        let color = |c: &ColorPlanes| c.mapped(&plane);
        let lobe = |layers: &LobeLayers| LobeLayers {
            lobe: layers.lobe,
            direct: layers.direct.as_ref().map(color),
            indirect: layers.indirect.as_ref().map(color),
            color: layers.color.as_ref().map(color),
            albedo: layers.albedo.as_ref().map(color),
        };
        let group = |group: &LightGroup| LightGroup {
            name: group.name.clone(),
            light: color(&group.light),
            to_light: group.to_light.clone(),
        };
        let gloss = |gloss: &Gloss| Gloss {
            reflectance: color(&gloss.reflectance),
            mirrored: color(&gloss.mirrored),
            kept: color(&gloss.kept),
            is_tint: gloss.is_tint,
        };
        Self {
            gloss: self.gloss.as_ref().map(gloss),
            lobes: self.lobes.iter().map(lobe).collect(),
            groups: self.groups.iter().map(group).collect(),
            occlusion: self.occlusion.as_ref().map(&plane),
            picture_is_occlusion: self.picture_is_occlusion,
        }
    }
}
