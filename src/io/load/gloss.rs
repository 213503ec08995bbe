//! The light of metals, glass, hair, lamps and fog, which a diffuse colour does not tell of.
//!
//! Renderers disagree about the colour of gloss: Blender up to 4 writes a grey near 1 on plastic and gold alike, V-Ray and
//! Redshift write such a tint in colour, Blender 5 and Arnold the reflectance itself, near 0.04 on plastic. The median over
//! surfaces with a diffuse colour decides. Of a tint, plastic reflects 0.04, and a metal as much as its highlights show: their
//! own colour pixel by pixel, which came as near to a reference as its mean over 12 pixels (28.7 and 29.1 grey levels).

use super::cryptomatte;
use super::opened::Opened;
use super::sources::RoleSource;
use crate::frame::{ColorPlanes, Gloss, Plane, each_row_of};
use crate::io::exr::{ChannelId, ExrFile};
use crate::io::judge::samples_of_layers::{Band, samples};
use crate::io::roles::{Layer, Match, Role, by_name};
use crate::kernel::quantile::quantile;
use crate::untrusted::{Untrusted, listed};
use std::collections::HashMap;
use std::rc::Rc;

/// What a layer holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Holds {
    /// Colour of mirrored light.
    Color,
    /// Colour of light seen through the surface.
    Passes,
    /// Mirrored lamps.
    Direct,
    /// Mirrored surfaces.
    Indirect,
    /// Light seen through the surface.
    Through,
    /// Light of the surface's own, and of fog.
    Emitted,
}

/// The layers, each with the roles that it may play, the best first.
pub(crate) const LAYERS: [(Holds, &[Role]); 9] = {
    use Role::*;
    [
        (Holds::Color, &[GlossyColor, SpecularAlbedo]),
        (Holds::Passes, &[TransmissionColor, TransmissionAlbedo]),
        (Holds::Direct, &[GlossyDirect, Highlight, Specular]),
        (Holds::Indirect, &[GlossyIndirect, Reflection]),
        (
            Holds::Through,
            &[TransmissionDirect, Transmission, Refraction],
        ),
        (Holds::Through, &[TransmissionIndirect]),
        (Holds::Emitted, &[Emission]),
        (Holds::Emitted, &[VolumeDirect, Volume]),
        (Holds::Emitted, &[VolumeIndirect]),
    ]
};

/// A layer read: what it holds, and whether its colour is still to be multiplied in.
type LayerRead = (Holds, bool, ColorPlanes);

/// The picture that layers of light belong to.
#[derive(Clone, Copy)]
pub(crate) struct LitPicture<'a> {
    pub(crate) color: Option<&'a ColorPlanes>,
    pub(crate) albedo: Option<&'a ColorPlanes>,
    pub(crate) alpha: Option<&'a Plane>,
}

/// Reflectance of plastic, of index 1.5.
const PLASTIC: f32 = 0.04;

/// From this median on colours of gloss are tints.
const TINT: f64 = 0.5;

/// Share of a colour of gloss that goes into its tint: in the dark there is no other.
const IN_THE_DARK: f32 = 1e-3;

/// A diffuse colour below this is none.
const NO_COLOR: f64 = 1e-3;

/// Share of the surface without diffuse colour from which it is told.
const WORTH_TELLING: f64 = 0.002;

/// The layer of the diffuse colour.
pub(crate) fn albedo(main: &Rc<Opened>) -> Option<RoleSource> {
    let find = |role| RoleSource::by_role(role, main);
    find(Role::Albedo).or_else(|| find(Role::DiffuseColor))
}

/// The light of a picture that its diffuse colour does not tell of, from the layers read; `None` without any.
pub(crate) fn of(layers: Vec<LayerRead>, is_tint: bool, picture: LitPicture) -> Option<Gloss> {
    let albedo = picture.albedo.filter(|_| !layers.is_empty())?;
    let (width, height) = (albedo.r.width(), albedo.r.height());
    let zero = || ColorPlanes::grey(Plane::filled(width, height, 0.0));
    let mut gloss = Gloss {
        reflectance: zero(),
        mirrored: zero(),
        kept: zero(),
        is_tint,
    };
    let has = |part| layers.iter().any(|(own, ..)| *own == part);
    // Light of lamps and surfaces in one layer is kept as the mirrored scene; all of it where no colour tells what to put in
    // its place.
    let (is_known, is_split) = (has(Holds::Color), has(Holds::Indirect));
    let planes: [_; 9] = {
        let made = [&mut gloss.reflectance, &mut gloss.mirrored, &mut gloss.kept];
        let mut planes = made
            .into_iter()
            .flat_map(|ColorPlanes { r, g, b }| [r, g, b]);
        std::array::from_fn(|_| planes.next().expect("three of three"))
    };
    each_row_of(planes, |y, mut rows| {
        for x in 0..width {
            let color = |wanted| {
                let own = layers.iter().find(|(part, ..)| *part == wanted);
                own.map_or([0.0; 3], |(.., planes)| planes.at(x, y))
            };
            let (mirrors, passes) = (color(Holds::Color), color(Holds::Passes));
            let sum = |wanted, color: [f32; 3]| {
                let own = layers.iter().filter(|(part, ..)| *part == wanted);
                own.fold([0.0; 3], |mut sum, (_, bare, planes)| {
                    let light = planes.at(x, y);
                    for k in 0..3 {
                        sum[k] += light[k] * if *bare { color[k] } else { 1.0 };
                    }
                    sum
                })
            };
            let lamps = sum(Holds::Direct, mirrors);
            let (lamps, scene) = match (is_known, is_split) {
                (true, true) => (lamps, sum(Holds::Indirect, mirrors)),
                (true, false) => ([0.0; 3], lamps),
                (false, _) => ([0.0; 3], [0.0; 3]),
            };
            let cover = picture.alpha.map_or(1.0, |alpha| alpha.at(x, y));
            let pixel = GlossPixel {
                albedo: albedo.at(x, y),
                mirrors,
                passes,
                lamps,
                scene,
                through: sum(Holds::Through, passes),
                emitted: sum(Holds::Emitted, [1.0; 3]),
                picture: picture.color.map(|color| color.at(x, y)),
                per_cover: if cover > 0.0 { 1.0 / cover } else { 1.0 },
            };
            for (row, value) in rows.iter_mut().zip(pixel.gloss(is_tint).as_flattened()) {
                row[x] = if value.is_finite() { *value } else { 0.0 };
            }
        }
    });
    Some(gloss)
}

/// The layers at a pixel; absent ones are 0.
#[derive(Debug, Clone, Copy, Default)]
struct GlossPixel {
    albedo: [f32; 3],
    mirrors: [f32; 3],
    passes: [f32; 3],
    lamps: [f32; 3],
    scene: [f32; 3],
    through: [f32; 3],
    emitted: [f32; 3],
    picture: Option<[f32; 3]>,
    per_cover: f32,
}

impl GlossPixel {
    /// Reflectance, the mirrored scene, and the light that is kept.
    ///
    /// Where there is no diffuse colour, whatever is neither a mirrored lamp nor the mirrored scene is kept, whether layers
    /// tell of it or not; elsewhere, what layers tell of.
    fn gloss(self, is_tint: bool) -> [[f32; 3]; 3] {
        let black = 1.0 - Gloss::share_diffuse(self.albedo.map(|c| c * self.per_cover));
        let clear = (largest(self.passes) * self.per_cover).clamp(0.0, 1.0);
        let metal = black * (1.0 - clear);
        let shown: [f32; 3] = std::array::from_fn(|k| {
            (self.lamps[k] + self.scene[k]).max(0.0) + IN_THE_DARK * self.mirrors[k]
        });
        let full = largest(self.mirrors) / largest(shown).max(f32::MIN_POSITIVE);
        // Colours of clear surfaces are reflectances anyway.
        let of_plastic = (1.0 - metal) * (PLASTIC + (1.0 - PLASTIC) * clear);
        // What mirrors and lets pass more than all light, as Cycles' hair does, tells tints of both: it mirrors as plastic.
        let both = (largest(self.mirrors) + largest(self.passes)) * self.per_cover;
        let real = 1.0 - (both - (1.0 + PLASTIC)).clamp(0.0, 1.0 - PLASTIC);
        let mut gloss = [[0.0; 3], self.scene, [0.0; 3]];
        for k in 0..3 {
            let reflectance = match is_tint {
                true => of_plastic * self.mirrors[k] + metal * full * shown[k],
                false => self.mirrors[k],
            };
            gloss[0][k] = (real * reflectance).max(0.0);
            let told = self.through[k] + self.emitted[k];
            gloss[2][k] = match self.picture {
                Some(picture) => {
                    let rest = picture[k] - self.lamps[k] - self.scene[k];
                    black * rest.max(picture[k].min(0.0)) + (1.0 - black) * told
                }
                None => told,
            };
        }
        gloss
    }
}

fn largest(color: [f32; 3]) -> f32 {
    color.into_iter().fold(0.0, f32::max)
}

/// What a sample of the file tells: whether colours of gloss are tints, and a warning where a share of the surface has no
/// diffuse colour.
pub(crate) fn judge(main: &Rc<Opened>, layers: &[LayerRead]) -> Option<(bool, Option<String>)> {
    let file = main.exr()?;
    let found = |source: RoleSource| source.found().cloned();
    let find = |role| RoleSource::by_role(role, main).and_then(found);
    let albedo = albedo(main).and_then(found)?;
    let color = find(Role::Color).and_then(|color| {
        let alpha = color.alpha?;
        Some(Match {
            channels: vec![alpha],
            alpha: None,
            ..color
        })
    });
    let mirrors = find(Role::GlossyColor).or_else(|| find(Role::SpecularAlbedo));
    let label = mirrors.as_ref().map(|found| found.layer.clone());
    let (numbers, names) = objects(file, &main.layers);
    let window = |found: &Match| file.parts[found.part].window;
    let own = window(&albedo);
    let beside = [find(Role::Normal), color, mirrors, numbers];
    let beside = beside.map(|found| found.filter(|found| window(found) == own));
    let wanted = std::iter::once(&albedo).chain(beside.iter().flatten());
    let read = samples(file, &wanted.cloned().collect::<Vec<_>>()).into_iter();
    let mut read = read.map(|sampled| sampled.bands);
    let albedo = read.next()?;
    let beside = beside.map(|found| found.and_then(|_| read.next()));
    let [normal, alpha, mirrors, number] = &beside;
    let at = |bands: &Option<Vec<Band>>, [band, x, y]: [usize; 3]| {
        Some(bands.as_ref()?.get(band)?.at(x, y))
    };
    let (mut glossy, mut any_glossy) = (Vec::new(), Vec::new());
    let (mut covered, mut dark) = (0_usize, HashMap::<u32, usize>::new());
    for (band, rows) in albedo.iter().enumerate() {
        for [x, y] in rows.pixels() {
            let place = [band, x, y];
            let shows = at(normal, place).is_none_or(|n| n.norm_squared() > 0.25)
                && at(alpha, place).is_none_or(|alpha| alpha.x > 0.5);
            let diffuse = rows.at(x, y).max();
            let mirrored = at(mirrors, place).filter(|_| shows);
            if let Some(color) = mirrored.map(|color| color.max()) {
                if Gloss::share_diffuse([diffuse as f32; 3]) == 1.0 {
                    glossy.push(color);
                } else if color > 0.0 {
                    any_glossy.push(color);
                }
            }
            covered += usize::from(shows);
            if shows && diffuse < NO_COLOR {
                let number = at(number, place).map_or(0, |number| (number.x as f32).to_bits());
                *dark.entry(number).or_default() += 1;
            }
        }
    }
    let median = |colors: &mut Vec<f64>| quantile(colors, 0.5, f64::total_cmp);
    let median = median(&mut glossy).or_else(|| median(&mut any_glossy));
    let is_tint = median.is_some_and(|median| median > TINT);
    let share = dark.values().sum::<usize>() as f64 / covered.max(1) as f64;
    let mut dark: Vec<_> = dark.into_iter().collect();
    dark.retain(|(number, _)| *number != 0);
    dark.sort_by_key(|&(number, count)| (std::cmp::Reverse(count), number));
    let names: Vec<String> = dark.into_iter().map(|(number, _)| names(number)).collect();
    let warning = (share > WORTH_TELLING).then(|| warning(share, &names, label, layers));
    Some((is_tint, warning))
}

/// The layer that numbers objects, and their names.
fn objects(file: &ExrFile, layers: &[Layer]) -> (Option<Match>, impl Fn(u32) -> String) {
    let mut hashed = cryptomatte::layers(file).unwrap_or_default();
    hashed.retain(|layer| layer.spoilt(file).is_none());
    let of_objects =
        |layer: &cryptomatte::Cryptomatte| layer.layer.to_lowercase().contains("object");
    let best = hashed.iter().position(of_objects).unwrap_or(0);
    let hashed = (best < hashed.len()).then(|| hashed.swap_remove(best));
    let numbers = hashed.as_ref().and_then(|hashed| {
        let ChannelId { part, channel } = *hashed.channels().first()?;
        Some(Match {
            layer: hashed.layer.clone(),
            part,
            channels: vec![channel],
            alpha: None,
        })
    });
    let names = move |number: u32| match &hashed {
        Some(hashed) => {
            let named = hashed.manifest.iter().find(|(_, own)| **own == number);
            named.map_or_else(|| format!("#{number:08x}"), |(name, _)| name.clone())
        }
        None => format!("object {}", f32::from_bits(number)),
    };
    let numbers = numbers.or_else(|| by_name(layers, Role::ObjectIndex));
    (numbers, names)
}

fn warning(share: f64, names: &[String], mirrors: Option<String>, layers: &[LayerRead]) -> String {
    let percent = 100.0 * share;
    let share = format!("{percent:.1} % of the surface has no diffuse colour");
    let names = match names {
        [] => String::new(),
        names => format!(" ({})", listed(names)),
    };
    let what = match (layers.is_empty(), mirrors) {
        (true, _) => {
            "and turns black: layers of glossy color, glossy light and emission would light it"
                .into()
        }
        (false, Some(layer)) => format!(
            "new highlights there follow {}, all other light stays as rendered",
            Untrusted(&layer)
        ),
        (false, None) => "it stays as rendered; a layer of glossy color would light it anew".into(),
    };
    let joint = if layers.is_empty() { " " } else { ": " };
    format!("{share}{names}{joint}{what}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOLD: [f32; 3] = [1.0, 0.6, 0.2];

    /// A metal that shows one part of mirrored lamps and one of the scene.
    fn metal(mirrors: [f32; 3], light: [f32; 3]) -> GlossPixel {
        GlossPixel {
            mirrors,
            lamps: light,
            scene: light,
            picture: Some(light.map(|light| 2.0 * light)),
            per_cover: 1.0,
            ..GlossPixel::default()
        }
    }

    fn assert_near(found: [f32; 3], expected: [f32; 3]) {
        let pairs = found.into_iter().zip(expected);
        let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-3, "{found:?}, not {expected:?}");
    }

    #[test]
    fn a_metal_has_its_own_colour_by_either_convention() {
        for (mirrors, is_tint) in [([1.0; 3], true), (GOLD, true), (GOLD, false)] {
            let [reflectance, mirrored, kept] = metal(mirrors, GOLD).gloss(is_tint);
            assert_near(reflectance, GOLD);
            assert_eq!((mirrored, kept), (GOLD, [0.0; 3]));
        }
        // In the dark the colour of the layer is all there is.
        assert_near(metal([0.5; 3], [0.0; 3]).gloss(true)[0], [0.5; 3]);
    }

    #[test]
    fn plastic_reflects_as_plastic_does_and_keeps_what_layers_tell() {
        let plastic = |mirrors| GlossPixel {
            albedo: [0.3; 3],
            through: [0.1; 3],
            emitted: [0.2; 3],
            ..metal(mirrors, [0.01; 3])
        };
        for (mirrors, is_tint) in [([1.0; 3], true), ([0.04; 3], false)] {
            let [reflectance, _, kept] = plastic(mirrors).gloss(is_tint);
            assert_near(reflectance, [0.04; 3]);
            assert_near(kept, [0.3; 3]);
        }
    }

    #[test]
    fn a_lamp_keeps_its_bits_and_clear_glass_its_reflectance() {
        let picture = [1.5, 0.7, -0.01];
        let lamp = GlossPixel {
            emitted: [9.0; 3],
            picture: Some(picture),
            per_cover: 4.0,
            ..GlossPixel::default()
        };
        assert_eq!(lamp.gloss(true), [[0.0; 3], [0.0; 3], picture]);
        let glass = GlossPixel {
            passes: [1.0; 3],
            ..metal([0.04; 3], [0.02; 3])
        };
        assert_near(glass.gloss(true)[0], [0.04; 3]);
        // Hair tells 1 of both colours, which no surface reflects and lets pass.
        let hair = GlossPixel {
            passes: [1.0; 3],
            ..metal([1.0; 3], [0.02; 3])
        };
        for is_tint in [true, false] {
            assert_near(hair.gloss(is_tint)[0], [0.04; 3]);
        }
    }
}
