//! The names that renderers give their layers, and what a name implies: tables, a row per role or renderer.
//!
//! A layer is looked up by the last word of its name, in lower case and without punctuation: `ViewLayer.Normal.X` is
//! `normal`, `ray:hitN` is `rayhitn`, `__Nworld.r` is `nworld`. The word or the renderer may imply a space or a kind
//! of depth. That is a hint: the data decide where they can, the hint where they cannot, and flags overrule both.
//!
//! To teach a name, add it to the row of its role, in the place of its preference; to teach what it means, add a row
//! to [`IMPLIED`]; a renderer that marks its files gets a row in [`RENDERERS`].

use super::exr::ExrFile;
use super::inputs::StoredDepth;
use super::roles::{Arity, Role};
use crate::frame::NormalSpace;

/// One row: a role, its arity, and the names that mean it, best first. The empty name is a layer
/// without a name: bare `R`, `G`, `B`, `Z`.
type Rule = (Role, Arity, &'static [&'static str]);

pub(super) const RULES: &[Rule] = &[
    (
        Role::Color,
        Arity::Color,
        &[
            "combined",
            "beauty",
            "rgba",
            "rgb",
            "",
            "image",
            "color",
            "c",
            "ci",
            "finalimage",
            "vraybeauty",
        ],
    ),
    (
        Role::Normal,
        Arity::Vector,
        // Shading normals before those of the facets, and those for a denoiser last.
        &[
            "normal",
            "normals",
            "ns",
            "n",
            "shadingnormal",
            "shadingnormals",
            "shnormal",
            "shnormals",
            "normalsshading",
            "bumpnormals",
            "bumpnormal",
            "nn",
            "nworld",
            "worldnormal",
            "worldnormals",
            "normalworld",
            "normalsworld",
            "worldspacenormal",
            "worldspacenormals",
            "normalsworldspace",
            "cameranormal",
            "cameranormals",
            "normalcamera",
            "viewnormal",
            "viewnormals",
            "normalview",
            "eyenormal",
            "rayhitn",
            "hitn",
            "smoothnormal",
            "smoothnormals",
            "surfacenormal",
            "surfacenormals",
            "geometricnormal",
            "geometricnormals",
            "normalsgeometry",
            "ng",
            "ndenoise",
            "denoisingnormal",
            "denoisenormal",
            "normaldenoise",
            "normaldenoising",
        ],
    ),
    (
        Role::Depth,
        Arity::Scalar,
        &[
            "depth",
            "z",
            "",
            "pz",
            "rayhitpz",
            "hitpz",
            "worlddepth",
            "scenedepth",
            "cameradepth",
            "depthz",
            "distance",
            "rayhitdist",
            "hitdist",
            "zdepth",
            "vrayzdepth",
            "denoisingdepth",
        ],
    ),
    (
        Role::Position,
        Arity::Vector,
        &[
            "position",
            "p",
            "pworld",
            "worldposition",
            "worldpositions",
            "positionworld",
            "worldpos",
            "pos",
            "pointworld",
            "worldpoint",
            "rayhitp",
            "hitp",
        ],
    ),
    (
        Role::HitPosition,
        Arity::Vector,
        &["hitposition", "hitpoint", "hitp"],
    ),
    (
        Role::Occlusion,
        Arity::Color,
        &["ambientocclusion", "ao", "occlusion"],
    ),
    (Role::Importance, Arity::Color, &["importance"]),
    (
        Role::DiffuseDirect,
        Arity::Color,
        &[
            "diffusedirect",
            "diffdir",
            "directdiffuse",
            "diffuselighting",
        ],
    ),
    (
        Role::DiffuseIndirect,
        Arity::Color,
        &["diffuseindirect", "diffind", "indirectdiffuse"],
    ),
    (
        Role::DiffuseColor,
        Arity::Color,
        &["diffusecolor", "diffcol"],
    ),
    (Role::Diffuse, Arity::Color, &["diffuse", "combineddiffuse"]),
    (
        Role::Albedo,
        Arity::Color,
        &["diffusealbedo", "albedo", "diffusefilter"],
    ),
    (
        Role::GlossyDirect,
        Arity::Color,
        &["glossydirect", "glossdir", "speculardirect"],
    ),
    (
        Role::GlossyIndirect,
        Arity::Color,
        &["glossyindirect", "glossind", "specularindirect"],
    ),
    (
        Role::GlossyColor,
        Arity::Color,
        &["glossycolor", "glosscol"],
    ),
    (
        Role::Specular,
        Arity::Color,
        &["specular", "glossyreflection"],
    ),
    (
        Role::TransmissionDirect,
        Arity::Color,
        &["transmissiondirect", "transdir"],
    ),
    (
        Role::TransmissionIndirect,
        Arity::Color,
        &["transmissionindirect", "transind"],
    ),
    (
        Role::TransmissionColor,
        Arity::Color,
        &["transmissioncolor", "transcol"],
    ),
    (Role::Transmission, Arity::Color, &["transmission"]),
    (
        Role::SubsurfaceDirect,
        Arity::Color,
        &["subsurfacedirect", "subsurfacedir", "sssdirect"],
    ),
    (
        Role::SubsurfaceIndirect,
        Arity::Color,
        &["subsurfaceindirect", "subsurfaceind", "sssindirect"],
    ),
    (
        Role::SubsurfaceColor,
        Arity::Color,
        &["subsurfacecolor", "subsurfacecol"],
    ),
    (Role::Subsurface, Arity::Color, &["sss"]),
    (Role::CoatDirect, Arity::Color, &["coatdirect"]),
    (Role::CoatIndirect, Arity::Color, &["coatindirect"]),
    (Role::Coat, Arity::Color, &["coat"]),
    (Role::SheenDirect, Arity::Color, &["sheendirect"]),
    (Role::SheenIndirect, Arity::Color, &["sheenindirect"]),
    (Role::Sheen, Arity::Color, &["sheen"]),
    (
        Role::VolumeDirect,
        Arity::Color,
        &["volumedirect", "volumedir"],
    ),
    (
        Role::VolumeIndirect,
        Arity::Color,
        &["volumeindirect", "volumeind"],
    ),
    (Role::Volume, Arity::Color, &["volume"]),
    (Role::Emission, Arity::Color, &["emission", "emit"]),
    (
        Role::Environment,
        Arity::Color,
        &["environment", "env", "background"],
    ),
    (Role::Shadow, Arity::Color, &["shadow"]),
    (Role::Motion, Arity::Pair, &["vector", "motion", "backward"]),
    (Role::Mist, Arity::Scalar, &["mist"]),
    (Role::TextureCoordinates, Arity::Vector, &["uv", "st"]),
    (
        Role::ObjectIndex,
        Arity::Scalar,
        &["objectindex", "indexob"],
    ),
    (
        Role::MaterialIndex,
        Arity::Scalar,
        &["materialindex", "indexma"],
    ),
];

/// What the names of some renderers start with, before the word that counts.
const PREFIXES: &[&str] = &[
    "finalimagemovierenderqueue",
    "cgeometry",
    "vrayre",
    "rendererinfo",
];

/// The word that the tables know a layer by, from the last word of its name.
pub(super) fn key(word: &str) -> String {
    let word: String = word
        .chars()
        .filter(char::is_ascii_alphanumeric)
        .collect::<String>()
        .to_ascii_lowercase();
    let rest = PREFIXES.iter().find_map(|prefix| word.strip_prefix(prefix));
    match rest.filter(|rest| !rest.is_empty()) {
        Some(rest) => rest.into(),
        None => word,
    }
}

/// What a name or a renderer implies of a layer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Hint {
    /// The space of normals.
    pub(super) space: Option<NormalSpace>,
    /// What depth holds.
    pub(super) depth: Option<StoredDepth>,
}

const WORLD: Hint = Hint {
    space: Some(NormalSpace::World),
    depth: None,
};
const VIEW: Hint = Hint {
    space: Some(NormalSpace::View),
    depth: None,
};

const fn depth(stored: StoredDepth) -> Hint {
    Hint {
        space: None,
        depth: Some(stored),
    }
}

/// Names that mean the same whoever wrote them.
const IMPLIED: &[(&str, Hint)] = &[
    ("nworld", WORLD),
    ("worldnormal", WORLD),
    ("worldnormals", WORLD),
    ("normalworld", WORLD),
    ("normalsworld", WORLD),
    ("worldspacenormal", WORLD),
    ("worldspacenormals", WORLD),
    ("normalsworldspace", WORLD),
    ("rayhitn", WORLD),
    ("nn", VIEW),
    ("cameranormal", VIEW),
    ("cameranormals", VIEW),
    ("normalcamera", VIEW),
    ("viewnormal", VIEW),
    ("viewnormals", VIEW),
    ("normalview", VIEW),
    ("eyenormal", VIEW),
    ("denoisingnormal", VIEW),
    ("pz", depth(StoredDepth::Planar)),
    ("rayhitpz", depth(StoredDepth::Planar)),
    ("hitpz", depth(StoredDepth::Planar)),
    ("worlddepth", depth(StoredDepth::Planar)),
    ("distance", depth(StoredDepth::Ray)),
    ("rayhitdist", depth(StoredDepth::Ray)),
    ("hitdist", depth(StoredDepth::Ray)),
    ("zdepth", depth(StoredDepth::WhiteNear)),
    ("vrayzdepth", depth(StoredDepth::WhiteNear)),
];

/// A program that writes layers, how its files are known, and what their layers hold unless a name says more.
struct Renderer {
    name: &'static str,
    /// How the name of an attribute of its files starts, in lower case.
    attributes: &'static [&'static str],
    /// A word in what its files say of their maker, in lower case.
    maker: &'static str,
    hint: Hint,
}

/// Who marks files, and what those hold.
const RENDERERS: &[Renderer] = &[
    Renderer {
        name: "Blender",
        attributes: &["cycles."],
        maker: "blender",
        hint: Hint {
            space: Some(NormalSpace::World),
            depth: Some(StoredDepth::Planar),
        },
    },
    Renderer {
        name: "Arnold",
        attributes: &["arnold/"],
        maker: "arnold",
        hint: Hint {
            space: Some(NormalSpace::World),
            depth: Some(StoredDepth::Planar),
        },
    },
    Renderer {
        name: "V-Ray",
        attributes: &["vray", "camerafov"],
        maker: "v-ray",
        hint: Hint {
            space: Some(NormalSpace::View),
            depth: Some(StoredDepth::WhiteNear),
        },
    },
    Renderer {
        name: "RenderMan",
        attributes: &["rman"],
        maker: "renderman",
        hint: Hint {
            space: None,
            depth: Some(StoredDepth::Planar),
        },
    },
    Renderer {
        name: "Redshift",
        attributes: &["rs/"],
        maker: "redshift",
        hint: Hint {
            space: Some(NormalSpace::World),
            depth: Some(StoredDepth::Planar),
        },
    },
    Renderer {
        name: "Karma",
        attributes: &["karma"],
        maker: "karma",
        hint: Hint {
            space: Some(NormalSpace::World),
            depth: None,
        },
    },
    Renderer {
        name: "Mantra",
        attributes: &["mantra"],
        maker: "mantra",
        hint: Hint {
            space: Some(NormalSpace::View),
            depth: Some(StoredDepth::Planar),
        },
    },
    Renderer {
        name: "Octane",
        attributes: &["octane"],
        maker: "octane",
        hint: depth(StoredDepth::Ray),
    },
    Renderer {
        name: "Corona",
        attributes: &["corona"],
        maker: "corona",
        hint: VIEW,
    },
    Renderer {
        name: "Mitsuba",
        attributes: &["mitsuba"],
        maker: "mitsuba",
        hint: Hint {
            space: Some(NormalSpace::World),
            depth: Some(StoredDepth::Ray),
        },
    },
    Renderer {
        name: "pbrt",
        attributes: &["rendertimeseconds", "samplesperpixel"],
        maker: "pbrt",
        hint: VIEW,
    },
    Renderer {
        name: "Nuke",
        attributes: &["nuke/"],
        maker: "nuke",
        hint: depth(StoredDepth::Inverse),
    },
    Renderer {
        name: "Unreal",
        attributes: &["unreal/"],
        maker: "unreal",
        hint: Hint {
            space: Some(NormalSpace::World),
            depth: Some(StoredDepth::Planar),
        },
    },
];

/// Attributes in which files say who made them.
const MAKERS: &[&str] = &[
    "software",
    "renderer",
    "generatedby",
    "creator",
    "generator",
];

/// What Nuke puts before the attributes of files that it has read.
pub(super) fn plain_attribute(name: &str) -> &str {
    name.strip_prefix("exr/").unwrap_or(name)
}

/// The renderer whose marks a file bears, if any.
fn renderer(file: &ExrFile) -> Option<&'static Renderer> {
    let attributes = || {
        file.attributes
            .iter()
            .map(|(name, text)| (plain_attribute(name).to_ascii_lowercase(), text))
    };
    // A file that Nuke has written again is still its renderer's in what the layers hold.
    RENDERERS.iter().find(|renderer| {
        attributes().any(|(name, text)| {
            let starts = |mark: &&str| name.starts_with(mark);
            renderer.attributes.iter().any(starts)
                || MAKERS.contains(&name.as_str())
                    && text.to_ascii_lowercase().contains(renderer.maker)
        })
    })
}

/// What the name of a layer implies, or else the renderer of its file; with who says so.
pub(super) fn hint(layer: &str, file: &ExrFile) -> (Hint, String) {
    let word = key(super::roles::last_word(layer));
    if let Some((name, hint)) = IMPLIED.iter().find(|(name, _)| *name == word) {
        return (*hint, format!("by its name, {name}"));
    }
    match renderer(file) {
        Some(renderer) => (renderer.hint, format!("as {} writes it", renderer.name)),
        None => (Hint::default(), String::new()),
    }
}
