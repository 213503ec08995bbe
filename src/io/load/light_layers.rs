//! The layers that split the light of a picture, by lobes or light groups.

use super::gloss::{self, LitPicture};
use super::opened::Opened;
use super::recombination::difference;
use super::role_planes::RolePlanes;
use super::sources::RoleSource;
use crate::error::{Error, Result};
use crate::frame::{LightGroup, LightLayers, Lobe, LobeLayer, Mask};
use crate::io::finding::{Finding, Notes};
use crate::io::inputs::{GroupInput, Inputs, LightInputs, LobeChoice};
use crate::io::roles::by_name;
use crate::io::roles::names::{Role, last_word};
use crate::untrusted::Untrusted;
use std::rc::Rc;

/// Passes that differ from their picture by more than this, in the median, do not recombine to it: lossy
/// compression stays well below.
const RECOMBINES: f32 = 0.05;

/// Passes that differ by more than this are those of another picture.
const IS_OF_ANOTHER: f32 = 0.2;

/// The layers of each lobe: direct light, indirect light, all of its light in one layer, and colour, which coat and sheen
/// do without.
const LOBES: [(Lobe, [Role; 3], Option<Role>); 6] = {
    use Role::*;
    [
        (
            Lobe::Diffuse,
            [DiffuseDirect, DiffuseIndirect, Diffuse],
            Some(DiffuseColor),
        ),
        (
            Lobe::Specular,
            [GlossyDirect, GlossyIndirect, Specular],
            Some(GlossyColor),
        ),
        (
            Lobe::Transmission,
            [TransmissionDirect, TransmissionIndirect, Transmission],
            Some(TransmissionColor),
        ),
        (
            Lobe::Subsurface,
            [SubsurfaceDirect, SubsurfaceIndirect, Subsurface],
            Some(SubsurfaceColor),
        ),
        (Lobe::Coat, [CoatDirect, CoatIndirect, Coat], None),
        (Lobe::Sheen, [SheenDirect, SheenIndirect, Sheen], None),
    ]
};

/// Light unaffected by curvature; needed only to compare the sum of the lobes with the picture.
const REST: [Role; 4] = [
    Role::VolumeDirect,
    Role::VolumeIndirect,
    Role::Emission,
    Role::Environment,
];

/// Whether a file holds the light of its picture in passes.
pub(crate) fn has_light_passes(main: &Opened) -> bool {
    let mut roles = LOBES.iter().flat_map(|(_, lights, _)| lights);
    roles.any(|role| by_name(&main.layers, *role).is_some())
}

/// Part of the light held by a layer.
#[derive(Debug, Clone, PartialEq)]
enum Use {
    Lobe(Lobe, LobeLayer),
    Rest,
    Group(GroupInput),
    Occlusion,
    /// Whether the surface's colour is to be multiplied in.
    Gloss(gloss::Holds, bool),
}

/// The layers of light that a run reads.
#[derive(Default)]
pub(crate) struct LightSources {
    uses: Vec<Use>,
    pub(crate) sources: Vec<RoleSource>,
    /// Lobes that exist but are not used.
    unread: Vec<Lobe>,
    findings: Vec<Finding>,
    /// Whether all light was requested, so that its sum can be compared with the picture.
    whole: bool,
    /// Whether they are wanted even of another picture, or were found to be of this one.
    stays: bool,
    picture_is_occlusion: bool,
}

impl LightSources {
    pub(crate) fn resolve(inputs: &Inputs, main: &Rc<Opened>) -> Result<Self> {
        let mut found = Self::default();
        let Some(light) = &inputs.light else {
            return Ok(found);
        };
        found.picture_is_occlusion = picture_is_occlusion(inputs, main)?;
        if light.occlusion && !found.picture_is_occlusion {
            let occlusion =
                RoleSource::resolve(Role::Occlusion, inputs.occlusion.as_deref(), main)?;
            found.add(Use::Occlusion, occlusion);
        }
        if light.gloss && gloss::albedo(main).is_some() {
            for (part, roles) in gloss::LAYERS {
                let find = |role: &Role| RoleSource::by_role(*role, main);
                if let Some(source) = roles.iter().find_map(find) {
                    let bare = is_without_color(source.label());
                    found.add(Use::Gloss(part, bare), Some(source));
                }
            }
        }
        let named = light.diffuse.is_some() || light.specular.is_some();
        let wanted = match light.lobes {
            LobeChoice::Auto => inputs.color.is_none() || named,
            LobeChoice::On => true,
            LobeChoice::Off => false,
        };
        if !light.groups.is_empty() {
            return found.with_groups(light, main);
        }
        found.stays = named || light.lobes == LobeChoice::On;
        if wanted {
            found.find_lobes(light, main)?;
            if light.lobes == LobeChoice::On && !found.has_lobes() {
                return Err(no_lobes(main));
            }
        }
        Ok(found)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.sources.is_empty()
    }

    fn has_lobes(&self) -> bool {
        let read = |u: &Use| matches!(u, Use::Lobe(_, LobeLayer::Direct | LobeLayer::Indirect));
        !self.unread.is_empty() || self.uses.iter().any(read)
    }

    fn add(&mut self, as_what: Use, source: Option<RoleSource>) {
        if let Some(mut source) = source {
            source.leave_alpha();
            self.uses.push(as_what);
            self.sources.push(source);
        }
    }

    fn with_groups(mut self, light: &LightInputs, main: &Rc<Opened>) -> Result<Self> {
        for group in &light.groups {
            let names = ["Combined_", "RGBA_", ""].map(|prefix| format!("{prefix}{}", group.name));
            let layer = |name: &String| RoleSource::layer(Role::Color, name, main);
            let source = names.iter().find_map(layer);
            let source = source.ok_or_else(|| no_group(main, &group.name))?;
            let directions = match group.to_light.len() {
                1 => "1 direction".into(),
                count => format!("{count} directions"),
            };
            self.findings.push(Finding {
                subject: format!("light group {}", group.name),
                conclusion: format!("{}, {directions}", source.label()),
                evidence: "as given; lobes are left alone".into(),
                flag: "--light-group NAME=AZ,EL".into(),
            });
            self.add(Use::Group(group.clone()), Some(source));
        }
        Ok(self)
    }

    fn find_lobes(&mut self, light: &LightInputs, main: &Rc<Opened>) -> Result<()> {
        for (lobe, lights, color) in LOBES {
            self.find_lobe(lobe, lights, color, light, main)?;
        }
        self.whole = self.has_lobes() && self.unread.is_empty();
        if self.whole {
            for role in REST {
                self.add(Use::Rest, RoleSource::by_role(role, main));
            }
            if !self.sources.iter().any(|s| REST[..2].contains(&s.role)) {
                self.add(Use::Rest, RoleSource::by_role(Role::Volume, main));
            }
        }
        Ok(())
    }

    /// The layers of one lobe: the one named, else those of direct and indirect light, else that of both.
    fn find_lobe(
        &mut self,
        lobe: Lobe,
        [direct, indirect, all]: [Role; 3],
        color: Option<Role>,
        light: &LightInputs,
        main: &Rc<Opened>,
    ) -> Result<()> {
        let (named, named_albedo) = match lobe {
            Lobe::Diffuse => (&light.diffuse, &light.albedo),
            Lobe::Specular => (&light.specular, &None),
            _ => (&None, &None),
        };
        let find = |role| RoleSource::by_role(role, main).filter(|_| named.is_none());
        let mut parts = [direct, indirect].map(find);
        if parts.iter().all(Option::is_none) {
            parts[0] = RoleSource::resolve(all, named.as_deref(), main)?;
        }
        let labels: Vec<&str> = parts.iter().flatten().map(RoleSource::label).collect();
        if labels.is_empty() {
            return Ok(());
        }
        let sum = labels.join(" + ");
        let skipped = match lobe.is_diffuse() {
            true => light.without_diffuse,
            false => light.without_specular,
        };
        if skipped {
            self.unread.push(lobe);
            self.report(lobe, format!("{sum}: not read, its magnitude is 0"), named);
            return Ok(());
        }
        let without_color = named.is_none() && labels.iter().any(|label| is_without_color(label));
        let named_albedo = match named_albedo {
            Some(name) => RoleSource::resolve(Role::Albedo, Some(name), main)?,
            None => None,
        };
        let own_color = color.and_then(find);
        let conclusion = if without_color || own_color.is_some() {
            let Some(color) = named_albedo.or(own_color) else {
                let conclusion = format!("{sum}: not scaled, its color layer is missing");
                self.report(lobe, conclusion, named);
                return Ok(());
            };
            let conclusion = match labels.len() {
                1 => format!("{sum} x {}", color.label()),
                _ => format!("({sum}) x {}", color.label()),
            };
            self.add(Use::Lobe(lobe, LobeLayer::Color), Some(color));
            conclusion
        } else {
            let is_diffuse = lobe == Lobe::Diffuse;
            let own = || RoleSource::by_role(Role::Albedo, main).filter(|_| is_diffuse);
            let albedo = named_albedo.or_else(own);
            let included = albedo
                .as_ref()
                .map(|a| format!(", albedo {} included", a.label()));
            self.add(Use::Lobe(lobe, LobeLayer::Albedo), albedo);
            format!("{sum}{}", included.unwrap_or_default())
        };
        self.report(lobe, conclusion, named);
        let [direct, indirect] = parts;
        self.add(Use::Lobe(lobe, LobeLayer::Direct), direct);
        self.add(Use::Lobe(lobe, LobeLayer::Indirect), indirect);
        Ok(())
    }

    fn report(&mut self, lobe: Lobe, conclusion: String, named: &Option<String>) {
        let evidence = match named {
            Some(_) => "as given",
            None => "from names",
        };
        let flag = match lobe {
            Lobe::Diffuse => "--diffuse NAME|FILE",
            Lobe::Specular => "--specular NAME|FILE",
            _ => "--lobes on|off",
        };
        self.findings.push(Finding {
            subject: format!("{} lobe", lobe.name()),
            conclusion,
            evidence: evidence.into(),
            flag: flag.into(),
        });
    }

    /// Layers of the planes that were read of [`LightSources::sources`].
    pub(crate) fn assemble(
        self,
        read: Vec<RolePlanes>,
        picture: LitPicture,
        mask: &Mask,
        (inputs, main): (&Inputs, &Rc<Opened>),
        notes: &mut Notes,
    ) -> LightLayers {
        notes.findings.extend(self.findings);
        let mut layers = LightLayers {
            picture_is_occlusion: self.picture_is_occlusion,
            ..LightLayers::default()
        };
        let (mut rest, mut replaced) = (Vec::new(), 0);
        let mut glossy = Vec::new();
        for lobe in self.unread {
            layers.lobe_mut(lobe);
        }
        for (as_what, mut read) in self.uses.into_iter().zip(read) {
            read.alpha = None;
            replaced += read.sanitise();
            match as_what {
                Use::Occlusion => layers.occlusion = Some(read.into_scalar()),
                Use::Lobe(lobe, layer) => *layers.layer_mut(lobe, layer) = Some(read.into_color()),
                Use::Rest => rest.push(read.into_color()),
                Use::Gloss(part, bare) => glossy.push((part, bare, read.into_color())),
                Use::Group(GroupInput { name, to_light }) => layers.groups.push(LightGroup {
                    name,
                    light: read.into_color(),
                    to_light,
                }),
            }
        }
        if replaced > 0 {
            notes.warnings.push(format!(
                "{replaced} samples of light were not finite: NaN became 0, infinity 65504"
            ));
        }
        if let Some(wanted) = inputs.light.as_ref().filter(|light| light.gloss)
            && picture.albedo.is_some()
        {
            let known = wanted.gloss_is_tint;
            let judged = match known {
                Some(is_tint) => (is_tint, None),
                None => gloss::judge(main, &glossy).unwrap_or_default(),
            };
            layers.gloss = gloss::of(glossy, judged.0, picture);
            notes.warnings.extend(judged.1);
        }
        let compared = picture.color.filter(|_| self.whole);
        let difference = compared.and_then(|p| difference(p, &layers.lobes, &rest, mask));
        if let Some(difference) = difference {
            let leaves = difference > IS_OF_ANOTHER && !self.stays;
            if leaves {
                layers.lobes.clear();
            }
            report_difference(difference, leaves, notes);
        }
        layers
    }
}

fn report_difference(difference: f32, leaves: bool, notes: &mut Notes) {
    let percent = format!("{:.2} %", 100.0 * difference);
    let recombine = difference <= RECOMBINES;
    notes.findings.push(Finding {
        subject: "light passes".into(),
        conclusion: match recombine {
            true => "recombine to the picture".into(),
            false => "do not recombine to the picture".into(),
        },
        evidence: format!("differ from it by {percent} in the median"),
        flag: "--lobes on|off".into(),
    });
    if !recombine {
        let what = match leaves {
            true => "they are left out; --lobes on scales them",
            false => {
                "what they do not tell stays as it is; --lobes off scales the picture as a whole"
            }
        };
        notes.warnings.push(format!(
            "the light passes differ from the picture by {percent} in the median: {what}"
        ));
    }
}

/// Blender's names of light without the surface's colour, `DiffDir` or `Diffuse Direct`; Arnold's `diffuse_direct`
/// includes it.
fn is_without_color(label: &str) -> bool {
    let word = last_word(label);
    word.contains(' ') || word.ends_with("Dir") || word.ends_with("Ind")
}

/// Whether a layer named as the picture is the one of ambient occlusion.
fn picture_is_occlusion(inputs: &Inputs, main: &Rc<Opened>) -> Result<bool> {
    let Some(name) = &inputs.color else {
        return Ok(false);
    };
    let occlusion = RoleSource::resolve(Role::Occlusion, inputs.occlusion.as_deref(), main)?;
    let picture = RoleSource::layer(Role::Color, name, main);
    Ok(occlusion
        .zip(picture)
        .is_some_and(|(o, p)| o.is_layer_of(&p)))
}

fn no_lobes(main: &Opened) -> Error {
    Error::MissingAov {
        path: main.path().to_path_buf(),
        found: format!("has no light passes (found {})", main.found("no layers")),
        remedy: "name them with --diffuse and --specular, or leave out --lobes on".into(),
    }
}

fn no_group(main: &Opened, name: &str) -> Error {
    Error::MissingAov {
        path: main.path().to_path_buf(),
        found: format!(
            "no light group called {} (found {})",
            Untrusted(name),
            main.found("no layers")
        ),
        remedy: "give --light-group the NAME of a layer Combined_NAME or RGBA_NAME".into(),
    }
}
