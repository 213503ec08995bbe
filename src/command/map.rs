//! The arguments of `map` and `normals`, and the maps that they name.

use super::args::WorkArgs;
use super::axes::NormalAxes;
use super::flags::Section;
use crate::params::table::rows;
use crate::params::words::one_of;
use crate::params::{Group, Scale};
use std::path::PathBuf;

rows! {
    /// The arguments of `map`.
    #[derive(Debug, Clone)]
    #[command(mut_arg("wrap", |wrap| wrap.default_value("auto")), mut_arg("crease", |crease| crease.default_value("15,45")))]
    pub(crate) struct MapArgs {
        pub(crate) work: WorkArgs as flatten;
        _relief: Section<{ Group::Relief as u8 }> as flatten;
        /// Maps to make. Several take {map} in the name of the output, as in -o brick_{map}.png, or an .exr for all.
        pub(crate) maps: Vec<MapKind> =
            [long = "map", value_name = "MAP,..", value_delimiter = ',', default_value = "curvature", value_parser = one_of(MapKind::ALL.map(|map| (map, map.name()))), help_heading = "Maps"];
        /// Bits of a sample: 8 or 16 in PNG and TIFF, 16 by default in PNG; 32 in TIFF, by default: the numbers themselves, as
        /// in .npy.
        pub(crate) bits: Option<String> =
            [long, value_name = "8|16|32", value_parser = ["8", "16", "32"], help_heading = "Maps"];
        /// Axes of the normals that are written: opengl is x right, y up, z toward the viewer; directx has y down, opencv y down
        /// and z away, stablenormal x to the left; world takes a camera, and xy leaves z out.
        pub(crate) axes: NormalAxes =
            [hide_short_help = true, long = "as", value_name = "AXES", default_value = "opengl", value_parser = one_of(NormalAxes::ALL), help_heading = "Maps"];
        /// Normal map of a detail that is laid over the normals, turned with them: of one size with IN, and read as IN is.
        pub(crate) detail: Option<PathBuf> =
            [hide_short_help = true, long, value_name = "FILE", help_heading = "Maps"];
        /// Subtract the bend of the whole surface from the normals, as of a tablet that lies askew or is curved: the quadratic
        /// surface that most slopes below 30 degrees agree on.
        pub(crate) flatten: bool = [hide_short_help = true, long, help_heading = "Maps"];
        /// Adds the curvatures of all scales up to one map, by these weights: one for each, or one for all.
        pub(crate) sum: Vec<f32> =
            [hide_short_help = true, long, value_name = "WEIGHT,..", value_delimiter = ',', allow_hyphen_values = true, help_heading = "Maps"];
    }
}

/// A map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MapKind {
    /// Mapped curvature: 0.5 is flat, brighter convex, darker concave.
    Curvature,
    /// Its convex part: 0 is flat, 1 sharply convex.
    Convex,
    /// Its concave part: 0 is flat, 1 sharply concave.
    Concave,
    /// Edges: 1 where the surface bends, either way, by the larger angle of --crease or more, or depth jumps.
    Edges,
    /// Height: 0 is the lowest, 1 the highest, which are said; as numbers in pixels, or as depth.
    Height,
    /// The share of the sky that is seen over the height: 1 is open, 0 hidden; see --occlusion-radius.
    Occlusion,
    /// Where the height cannot follow the normals, since no surface has them: the change per pixel that is missed.
    Residual,
    /// The normals that all commands use; see --as.
    Normals,
}

/// One map that is made.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapPart {
    /// Its name in files and channels.
    pub(crate) name: String,
    pub(crate) map: MapKind,
    /// Index of the scale or radius it shows; `None` for a map of neither, or of the sum of all scales.
    pub(crate) scale: Option<usize>,
}

impl MapKind {
    const ALL: [Self; 8] = [
        Self::Curvature,
        Self::Convex,
        Self::Concave,
        Self::Edges,
        Self::Height,
        Self::Occlusion,
        Self::Residual,
        Self::Normals,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Curvature => "curvature",
            Self::Convex => "convex",
            Self::Concave => "concave",
            Self::Edges => "edges",
            Self::Height => "height",
            Self::Residual => "residual",
            Self::Occlusion => "occlusion",
            Self::Normals => "normals",
        }
    }

    /// Whether it is made once for each scale.
    pub(crate) fn has_scales(self) -> bool {
        matches!(self, Self::Curvature | Self::Convex | Self::Concave)
    }
}

impl MapArgs {
    /// Whether this plane of a map is a component of normals.
    pub(crate) fn is_of_normals(&self, plane: &str) -> bool {
        self.maps.contains(&MapKind::Normals) && plane.starts_with("normal.")
    }

    /// Bits of a sample of a picture.
    pub(crate) fn bits(&self) -> u8 {
        match self.bits.as_deref() {
            Some("8") => 8,
            _ => 16,
        }
    }

    /// Tells the output what it holds: maps by their names, and in a TIFF their numbers rather than codes.
    pub(super) fn settle(&mut self) {
        let parts = self.parts().into_iter();
        self.work.output.parts = parts.map(|part| part.name).collect();
        self.work.output.tiff_holds_numbers = matches!(self.bits.as_deref(), None | Some("32"));
    }

    /// All scales in pixels, the first one included.
    pub(crate) fn sigmas(&self) -> Vec<f32> {
        let flags = &self.work.flags;
        let first = match flags.params.shape.scale {
            Scale::Sigma(sigma) => sigma,
            _ => flags.params.shape.scale_px() as f32,
        };
        let more = flags.more_scales().iter().copied();
        std::iter::once(first).chain(more).collect()
    }

    /// The maps, each at each scale unless scales are added up.
    pub(crate) fn parts(&self) -> Vec<MapPart> {
        let (sigmas, radii) = (self.sigmas(), &self.work.flags.radii[..]);
        let mut parts: Vec<MapPart> = Vec::new();
        for &map in &self.maps {
            let sizes = match map {
                MapKind::Occlusion => radii,
                _ if map.has_scales() && self.sum.is_empty() => &sigmas,
                _ => &[],
            };
            let one = |scale: Option<usize>, name: String| MapPart { name, map, scale };
            match sizes.len() > 1 {
                true => parts.extend(
                    sizes
                        .iter()
                        .enumerate()
                        .map(|(scale, size)| one(Some(scale), format!("{}_{size}", map.name()))),
                ),
                false => parts.push(one(None, map.name().into())),
            }
        }
        let mut known = Vec::new();
        parts.retain(|part| {
            let is_new = !known.contains(&part.name);
            known.push(part.name.clone());
            is_new
        });
        parts
    }
}
