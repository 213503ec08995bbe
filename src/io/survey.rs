//! Contents of a file, for `inspect`: headers and names, and pixels only where names give no roles or objects have no names.

use super::bundle::gathered;
use super::exr::{ExrFile, SampleType};
use super::inputs::Inputs;
use super::numbers::NUMBERED;
use super::objects::{self, ObjectSurvey};
use super::opened::{Opened, layers_of};
use super::roles::{self, Match, Role};
use crate::error::Result;
use crate::frame::Window;
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
    let opened = Opened::open_picture(&gathered(inputs)?.0)?;
    let mut survey = match opened.as_ref() {
        Opened::Exr {
            file,
            layers,
            groups,
            views,
            view,
            ..
        } => Survey {
            display_window: file.display_window,
            pixel_aspect: file.pixel_aspect,
            views: views.clone(),
            view: view.clone(),
            groups: groups.names.clone(),
            group: groups.taken.clone(),
            objects: objects::surveyed(file)?,
            parts: part_surveys(file),
            roles: {
                let named = roles::assign(layers);
                let is_open = |role: &Role| named.iter().all(|(own, _)| own != role);
                let by_numbers = NUMBERED.into_iter().filter(is_open);
                let by_numbers = by_numbers
                    .filter_map(|role| Some((role, opened.role_by_numbers(role)?.found.clone())));
                let by_numbers: Vec<_> = by_numbers.collect();
                let mut all: Vec<_> = named.into_iter().chain(by_numbers).collect();
                all.sort_by_key(|(role, _)| *role);
                all.into_iter()
                    .map(|(role, found)| role_survey(file, role, found))
                    .collect()
            },
        },
        Opened::Photo { photo, .. } => photo_survey(photo),
    };
    if let Some(Opened::Exr { file, .. }) = objects::named(inputs, &opened)?.as_deref() {
        survey.objects = objects::surveyed(file)?;
    }
    Ok(survey)
}

/// The layers of an EXR, from its header alone; none of a photo.
///
/// # Errors
/// Any [`crate::Error`] of opening it.
#[cfg(feature = "cli")]
pub(crate) fn layers(path: &Path) -> Result<Vec<LayerSurvey>> {
    Ok(match Opened::open(path)?.as_ref() {
        Opened::Exr { file, .. } => {
            let parts = part_surveys(file).into_iter();
            parts.flat_map(|part| part.layers).collect()
        }
        Opened::Photo { .. } => Vec::new(),
    })
}

/// The groups of layers of an EXR, from its header alone; none of a photo.
///
/// # Errors
/// Any [`crate::Error`] of opening it.
#[cfg(feature = "cli")]
pub(crate) fn groups(path: &Path) -> Result<Vec<String>> {
    Ok(match Opened::open(path)?.as_ref() {
        Opened::Exr { groups, .. } => groups.names.clone(),
        Opened::Photo { .. } => Vec::new(),
    })
}

fn part_surveys(file: &ExrFile) -> Vec<PartSurvey> {
    let all = layers_of(file);
    let parts = 0..file.parts.len();
    parts.map(|part| part_survey(file, &all, part)).collect()
}

fn role_survey(file: &ExrFile, role: Role, found: Match) -> RoleSurvey {
    let channels = found.channels.iter();
    RoleSurvey {
        role,
        channels: channels
            .map(|&channel| file.parts[found.part].channels[channel].name.clone())
            .collect(),
        layer: found.layer,
    }
}

fn part_survey(file: &ExrFile, layers: &[roles::Layer], index: usize) -> PartSurvey {
    let part = &file.parts[index];
    // They are in the order of their parts.
    let first = layers.partition_point(|layer| layer.part < index);
    let of_part = layers[first..].iter().take_while(|l| l.part == index);
    PartSurvey {
        name: part.name.clone(),
        data_window: part.window,
        compression: part.compression.clone(),
        layers: of_part
            .map(|layer| LayerSurvey {
                name: layer.name.clone(),
                components: layer.components.iter().map(|(c, _)| c.clone()).collect(),
                sample_type: match part.channels[layer.components[0].1].sample_type {
                    SampleType::Half => "half",
                    SampleType::Float => "float",
                    SampleType::Uint => "uint",
                },
            })
            .collect(),
    }
}

fn photo_survey(photo: &super::photo::StoredPhoto) -> Survey {
    let window = Window::from_size(photo.header.width, photo.header.height);
    let grey_or_color = if photo.header.color_channels() == 1 {
        &["y"][..]
    } else {
        &["r", "g", "b"][..]
    };
    let alpha = photo.header.has_alpha().then_some(&"a");
    let components: Vec<String> = grey_or_color
        .iter()
        .chain(alpha)
        .map(|c| (*c).to_string())
        .collect();
    let sample_type = match photo.header.bits {
        8 => "u8",
        16 => "u16",
        _ => "float",
    };
    Survey {
        display_window: window,
        pixel_aspect: 1.0,
        views: Vec::new(),
        view: None,
        groups: Vec::new(),
        group: None,
        parts: vec![PartSurvey {
            name: None,
            data_window: window,
            compression: "photo".into(),
            layers: vec![LayerSurvey {
                name: String::new(),
                components,
                sample_type,
            }],
        }],
        objects: Vec::new(),
        roles: vec![RoleSurvey {
            role: Role::Color,
            layer: String::new(),
            channels: grey_or_color.iter().map(|c| (*c).to_string()).collect(),
        }],
    }
}
