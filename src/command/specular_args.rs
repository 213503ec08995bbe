//! Arguments for the scene seen in mirrors and lenses.

use super::named::{Named, given};
use crate::io::SpecularInputs;
use crate::params::{Bend, Params, SpecularParams};
use clap::Args;
use std::path::PathBuf;

/// Arguments for the scene seen in mirrors and lenses.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Mirrors and lenses")]
pub(crate) struct SpecularFlags {
    /// Pixels of mirrors or lenses, above one half: a layer of IN or a file; all covered pixels if not given.
    #[arg(hide_short_help = true, long, value_name = "NAME|FILE")]
    specular_mask: Option<String>,
    /// Back faces of a lens, normals and depth from the same camera: sight lines are refracted twice, by --ior.
    #[arg(hide_short_help = true, long, value_name = "FILE")]
    back: Option<PathBuf>,
    /// The scene without its mirrors and lenses, from the same camera: depth, and normals and colour if any.
    #[arg(hide_short_help = true, long, value_name = "FILE")]
    behind: Option<PathBuf>,
    /// The view in all directions around the mirror or lens, equirectangular: positions (or distances), and normals and
    /// colour if any.
    #[arg(hide_short_help = true, long, value_name = "FILE")]
    surroundings: Option<PathBuf>,
    /// Viewpoint of surroundings without positions: a camera file with world_to_camera.
    #[arg(hide_short_help = true, long, value_name = "FILE")]
    surroundings_camera: Option<PathBuf>,
    /// World-space points hit by mirrored or refracted sight lines, if the renderer writes them: a layer of IN or a
    /// file. No search is made then.
    #[arg(hide_short_help = true, long, value_name = "NAME|FILE")]
    hit_position: Option<String>,
}

impl SpecularFlags {
    /// The layers and files named.
    pub(crate) fn inputs(&self) -> SpecularInputs {
        SpecularInputs {
            mask: self.specular_mask.clone(),
            back: self.back.clone(),
            behind: self.behind.clone(),
            surroundings: self.surroundings.clone(),
            surroundings_camera: self.surroundings_camera.clone(),
            hit_position: self.hit_position.clone(),
        }
    }

    /// The bend of sight lines: refracted if back faces are named or the material is glass, else mirrored.
    pub(crate) fn params(&self, params: &Params) -> SpecularParams {
        let material = &params.relight.material;
        let is_glass = self.back.is_some() || material.material.is_clear();
        let bend = match (is_glass, material.thin) {
            (false, _) => Bend::Mirror,
            (true, true) => Bend::Straight,
            (true, false) => Bend::Glass { ior: material.ior },
        };
        SpecularParams {
            bend,
            search: params.search,
        }
    }

    /// The layers and files that are named.
    pub(crate) fn names(&mut self) -> Vec<Named<'_>> {
        given(
            [&mut self.specular_mask, &mut self.hit_position],
            [
                &mut self.back,
                &mut self.behind,
                &mut self.surroundings,
                &mut self.surroundings_camera,
            ],
        )
    }
}
