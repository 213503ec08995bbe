//! Contents of a file, for `inspect`: headers and names, and pixels only where names give no roles or objects have no names.

use super::bundle::gathered;
use super::objects::{self, ObjectSurvey};
use super::opened::{Holding, Opened, OpenedKind, layers_of};
use crate::error::Result;
use crate::frame::Window;
use crate::io::exr::{ExrFile, Part, SampleType};
use crate::io::inputs::Inputs;
use crate::io::judge::numbers::NUMBERED;
use crate::io::photo::StoredPhoto;
use crate::io::roles::{self, Match, Role};
use serde::Serialize;
#[cfg(feature = "cli")]
use std::path::Path;

/// The contents of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survey {
    /// The pixels meant to be shown.
    pub display_window: Window,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The views of a stereo file, that of the default first; empty where there is but one.
    pub views: Vec<String>,
    /// The view whose layers play the roles.
    pub view: Option<String>,
    /// The groups of layers that show different things, such as view layers, in the order of the file.
    pub groups: Vec<String>,
    /// The group whose layers play the roles; none where they are the layers of all groups, or of no group.
    pub group: Option<String>,
    /// The parts of an EXR; a photo has one.
    pub parts: Vec<PartSurvey>,
    /// Which layer plays which role, by name, or by numbers where no name says so.
    pub roles: Vec<RoleSurvey>,
    /// The objects of Cryptomatte, layer by layer.
    pub objects: Vec<ObjectSurvey>,
}

/// One part of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartSurvey {
    /// Its name, where it has one.
    pub name: Option<String>,
    /// The pixels it holds.
    pub data_window: Window,
    /// How its pixels are compressed.
    pub compression: String,
    /// Its layers.
    pub layers: Vec<LayerSurvey>,
}

/// The channels that share a name up to their component.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerSurvey {
    /// The name; empty for bare channels.
    pub name: String,
    /// Its components, in the order of the file.
    pub components: Vec<String>,
    /// Sample type of its first channel: half, float, uint, u8 or u16.
    pub sample_type: &'static str,
}

/// A role and the layer found for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RoleSurvey {
    /// The role.
    pub role: Role,
    /// The layer's name; empty for bare channels.
    pub layer: String,
    /// Full names of its channels, in the order of the role's components.
    pub channels: Vec<String>,
}

/// Surveys the picture of `inputs`; pixels are read only if layers have meaningless names, or for Cryptomatte without a
/// manifest. Roles are those of the layers of the view and the group that `inputs` name, or of the default ones.
///
/// # Errors
/// Any [`crate::Error`] of opening it.
pub fn survey(inputs: &Inputs) -> Result<Survey> {
    let opened = Opened::open_picture(&gathered(inputs)?.0, Holding::default())?;
    let (display_window, pixel_aspect) = opened.shown(opened.display());
    let (parts, roles) = match &opened.kind {
        OpenedKind::Exr(file) => (part_surveys(file), role_surveys(&opened, file)),
        OpenedKind::Photo(photo) => photo_survey(photo),
    };
    let telling = objects::named(inputs, &opened)?.unwrap_or_else(|| opened.clone());
    let objects = telling.exr().map(objects::surveyed).transpose()?;
    Ok(Survey {
        display_window,
        pixel_aspect,
        views: opened.views.clone(),
        view: opened.view.clone(),
        groups: opened.groups.names.clone(),
        group: opened.groups.taken.clone(),
        parts,
        roles,
        objects: objects.unwrap_or_default(),
    })
}

/// The layers of an EXR, from its header alone; none of a photo.
///
/// # Errors
/// Any [`crate::Error`] of opening it.
#[cfg(feature = "cli")]
pub(crate) fn layers(path: &Path) -> Result<Vec<LayerSurvey>> {
    let opened = Opened::open(path)?;
    let parts = opened.exr().map(part_surveys).unwrap_or_default();
    Ok(parts.into_iter().flat_map(|part| part.layers).collect())
}

/// The groups of layers of an EXR, from its header alone; none of a photo.
///
/// # Errors
/// Any [`crate::Error`] of opening it.
#[cfg(feature = "cli")]
pub(crate) fn groups(path: &Path) -> Result<Vec<String>> {
    Ok(Opened::open(path)?.groups.names.clone())
}

/// The roles that layers play by their names, or else by their numbers.
fn role_surveys(opened: &Opened, file: &ExrFile) -> Vec<RoleSurvey> {
    let mut roles = roles::assign(&opened.layers);
    for role in NUMBERED {
        if roles.iter().all(|(own, _)| *own != role) {
            let found = opened.role_by_numbers(role);
            roles.extend(found.map(|found| (role, found.found.clone())));
        }
    }
    roles.sort_by_key(|(role, _)| *role);
    let survey = |(role, found): (Role, Match)| {
        let channels = &file.parts[found.part].channels;
        let names = found.channels.iter().map(|&c| channels[c].name.clone());
        RoleSurvey {
            role,
            channels: names.collect(),
            layer: found.layer,
        }
    };
    roles.into_iter().map(survey).collect()
}

fn part_surveys(file: &ExrFile) -> Vec<PartSurvey> {
    let survey = |part: &Part| PartSurvey {
        name: part.name.clone(),
        data_window: part.window,
        compression: part.compression.clone(),
        layers: Vec::new(),
    };
    let mut parts: Vec<_> = file.parts.iter().map(survey).collect();
    for layer in layers_of(file) {
        let first = file.parts[layer.part].channels[layer.components[0].1].sample_type;
        parts[layer.part].layers.push(LayerSurvey {
            name: layer.name,
            components: layer.components.into_iter().map(|(c, _)| c).collect(),
            sample_type: match first {
                SampleType::Half => "half",
                SampleType::Float => "float",
                SampleType::Uint => "uint",
            },
        });
    }
    parts
}

/// A photo, and its colour.
fn photo_survey(photo: &StoredPhoto) -> (Vec<PartSurvey>, Vec<RoleSurvey>) {
    let channels: &[&str] = match photo.header.color_channels() {
        1 => &["y"],
        _ => &["r", "g", "b"],
    };
    let channels: Vec<String> = channels.iter().map(|name| (*name).into()).collect();
    let alpha = photo.header.has_alpha().then(|| "a".into());
    let layer = LayerSurvey {
        name: String::new(),
        components: channels.iter().cloned().chain(alpha).collect(),
        sample_type: match photo.header.bits {
            8 => "u8",
            16 => "u16",
            _ => "float",
        },
    };
    let part = PartSurvey {
        name: None,
        data_window: photo.header.window(),
        compression: "photo".into(),
        layers: vec![layer],
    };
    let color = RoleSurvey {
        role: Role::Color,
        layer: String::new(),
        channels,
    };
    (vec![part], vec![color])
}
