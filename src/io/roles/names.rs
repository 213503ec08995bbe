//! Layer names of renderers, and their implications: tables with a row per role or renderer.
//!
//! A layer is looked up by the last word of its name, in lower case and without punctuation: `ViewLayer.Normal.X` is
//! `normal`, `ray:hitN` is `rayhitn`, `__Nworld.r` is `nworld`. The word or the renderer may imply a space or a kind of
//! depth. That is a hint: data decide where they can, the hint where they cannot, and flags override both.
//!
//! To add a name, add it to the row of its role, in order of preference; to add an implication, add a row to
//! [`IMPLIED`]; to recognise a renderer by its attributes, add a row to [`RENDERERS`].

use crate::frame::NormalSpace;
use crate::frame::StoredDepth::{self, Inverse, NormalizedNearIsOne, Planar, Ray};
use crate::io::exr::ExrFile;
use crate::io::text::is_one_of;
use serde::Serialize;
use std::path::Path;

/// Number of values per pixel of a role.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arity {
    /// One.
    Scalar,
    /// Two: x, y.
    Pair,
    /// Three: x, y, z.
    Vector,
    /// Three: red, green, blue; or one grey.
    Color,
}

/// One row: a role, its arity, and the names that mean it, best first. The empty name is a layer
/// without a name: bare `R`, `G`, `B`, `Z`.
type Rule = (Role, Arity, &'static [&'static str]);

/// Makes [`Role`] and [`RULES`] of one table.
macro_rules! roles {
    ($($role:ident: $arity:ident = $($name:literal)*;)*) => {
        /// Purpose of a layer.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        #[serde(rename_all = "kebab-case")]
        #[expect(
            missing_docs,
            reason = "each variant is the pass it names, as renderers call it"
        )]
        pub enum Role {
            $($role,)*
        }

        pub(crate) const RULES: &[Rule] = &[$((Role::$role, Arity::$arity, &[$($name),*]),)*];
    };
}

roles! {
    Color: Color = "combined" "beauty" "rgba" "rgb" "" "image" "color" "c" "ci" "finalimage"
        "vraybeauty";
    // Shading normals before geometric ones, and those for a denoiser last.
    Normal: Vector = "normal" "normals" "ns" "n" "shadingnormal" "shadingnormals" "shnormal"
        "shnormals" "normalsshading" "bumpnormals" "bumpnormal" "nn" "nworld" "worldnormal"
        "worldnormals" "normalworld" "normalsworld" "worldspacenormal" "worldspacenormals"
        "normalsworldspace" "cameranormal" "cameranormals" "normalcamera" "viewnormal" "viewnormals"
        "normalview" "eyenormal" "rayhitn" "hitn" "smoothnormal" "smoothnormals" "surfacenormal"
        "surfacenormals" "geometricnormal" "geometricnormals" "normalsgeometry" "ng" "ndenoise"
        "denoisingnormal" "denoisenormal" "normaldenoise" "normaldenoising";
    Depth: Scalar = "depth" "z" "" "pz" "rayhitpz" "hitpz" "worlddepth" "scenedepth" "cameradepth"
        "depthz" "distance" "rayhitdist" "hitdist" "zdepth" "vrayzdepth" "denoisingdepth" "disparity"
        "inversedepth" "invdepth" "depthinverse";
    Position: Vector = "position" "p" "pworld" "worldposition" "worldpositions" "positionworld"
        "worldpos" "pos" "pointworld" "worldpoint" "rayhitp" "hitp";
    HitPosition: Vector = "hitposition" "hitpoint" "hitp";
    Occlusion: Color = "ambientocclusion" "ao" "occlusion";
    // Only flags name these.
    Mask: Color =;
    Coverage: Color =;
    SpecularMask: Color =;
    Importance: Color = "importance";
    DiffuseDirect: Color = "diffusedirect" "diffdir" "directdiffuse" "diffuselighting";
    DiffuseIndirect: Color = "diffuseindirect" "diffind" "indirectdiffuse";
    DiffuseColor: Color = "diffusecolor" "diffcol";
    Diffuse: Color = "diffuse" "combineddiffuse";
    Albedo: Color = "diffusealbedo" "albedo" "diffusefilter";
    GlossyDirect: Color = "glossydirect" "glossdir" "speculardirect";
    GlossyIndirect: Color = "glossyindirect" "glossind" "specularindirect";
    GlossyColor: Color = "glossycolor" "glosscol";
    Specular: Color = "specular" "glossyreflection";
    TransmissionDirect: Color = "transmissiondirect" "transdir";
    TransmissionIndirect: Color = "transmissionindirect" "transind";
    TransmissionColor: Color = "transmissioncolor" "transcol";
    Transmission: Color = "transmission";
    SubsurfaceDirect: Color = "subsurfacedirect" "subsurfacedir" "sssdirect";
    SubsurfaceIndirect: Color = "subsurfaceindirect" "subsurfaceind" "sssindirect";
    SubsurfaceColor: Color = "subsurfacecolor" "subsurfacecol";
    Subsurface: Color = "sss";
    CoatDirect: Color = "coatdirect";
    CoatIndirect: Color = "coatindirect";
    Coat: Color = "coat";
    SheenDirect: Color = "sheendirect";
    SheenIndirect: Color = "sheenindirect";
    Sheen: Color = "sheen";
    // Colours and light of gloss that only relighting takes: the light of lobes is not multiplied by these.
    SpecularAlbedo: Color = "specularalbedo" "reflectionfilter" "reflectionsfilter" "reflectfilter"
        "vrayreflectionfilter";
    TransmissionAlbedo: Color = "transmissionalbedo" "refractionfilter" "refractionsfilter"
        "refractfilter" "vrayrefractionfilter";
    Highlight: Color = "specularlighting" "directspecular" "vrayspecular";
    Reflection: Color = "reflection" "reflections" "indirectspecular" "vrayreflection";
    Refraction: Color = "refraction" "refractions" "transmissive" "vrayrefraction";
    VolumeDirect: Color = "volumedirect" "volumedir";
    VolumeIndirect: Color = "volumeindirect" "volumeind";
    Volume: Color = "volume";
    Emission: Color = "emission" "emit" "emissive" "selfillumination" "selfillum"
        "vrayselfillumination";
    Environment: Color = "environment" "env" "background";
    Shadow: Color = "shadow";
    Motion: Pair = "vector" "motion" "backward";
    Mist: Scalar = "mist";
    TextureCoordinates: Vector = "uv" "st";
    ObjectIndex: Scalar = "objectindex" "indexob" "objectid" "vrayobjectid" "nodeid" "vraynodeid";
    MaterialIndex: Scalar = "materialindex" "indexma" "materialid" "mtlid" "vraymtlid"
        "vraymaterialid";
}

impl Role {
    /// The role as messages and `--json` name it.
    pub fn name(self) -> String {
        match serde_json::to_value(self) {
            Ok(serde_json::Value::String(name)) => name,
            _ => unreachable!("a unit variant serialises to its name"),
        }
    }

    /// Whether the role is a colour or light, as opposed to data. Names of light passes mean light.
    pub(crate) fn is_color(self) -> bool {
        use Role::{Color, DiffuseDirect, Environment};
        self == Color || (DiffuseDirect..=Environment).contains(&self)
    }

    pub(crate) fn arity(self) -> Arity {
        RULES[self as usize].1
    }

    /// The names that mean it, best first.
    pub(crate) fn names(self) -> &'static [&'static str] {
        RULES[self as usize].2
    }
}

/// The last word of a layer's name, the eye of a stereo pair left out.
pub(crate) fn last_word(name: &str) -> &str {
    split_last_word(name).1
}

/// What comes before the last word of a layer's name, without a dot, and that word.
pub(crate) fn split_last_word(name: &str) -> (&str, &str) {
    let split = |name| str::rsplit_once(name, '.').unwrap_or(("", name));
    match split(name) {
        (rest, "left" | "right") if !rest.is_empty() => split(rest),
        parts => parts,
    }
}

/// Prefixes that some renderers put before the significant word.
const PREFIXES: &[&str] = &[
    "finalimagemovierenderqueue",
    "cgeometry",
    "vrayre",
    "rendererinfo",
];

/// The key of a layer in the tables, from the last word of its name.
pub(crate) fn key(word: &str) -> String {
    let word: String = word
        .chars()
        .filter(char::is_ascii_alphanumeric)
        .collect::<String>()
        .to_ascii_lowercase();
    let rest = PREFIXES.iter().find_map(|prefix| word.strip_prefix(prefix));
    // `VRayReflection` is no element called `flection`.
    match rest.filter(|rest| !rest.is_empty() && !word.starts_with("vrayref")) {
        Some(rest) => rest.into(),
        None => word,
    }
}

/// Implications of a layer's name or renderer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Hint {
    /// The space of normals.
    pub(crate) space: Option<NormalSpace>,
    /// Kind of depth.
    pub(crate) depth: Option<StoredDepth>,
}

impl Hint {
    const NONE: Self = Self {
        space: None,
        depth: None,
    };
    const VIEW: Self = Self {
        space: Some(NormalSpace::View),
        ..Self::NONE
    };
    const WORLD: Self = Self {
        space: Some(NormalSpace::World),
        ..Self::NONE
    };

    const fn and(self, stored: StoredDepth) -> Self {
        Self {
            depth: Some(stored),
            ..self
        }
    }

    const fn depth(stored: StoredDepth) -> Self {
        Self::NONE.and(stored)
    }
}

/// Names with the same meaning from any program.
const IMPLIED: &[(Hint, &str)] = &[
    (
        Hint::WORLD,
        "nworld worldnormal worldnormals normalworld normalsworld worldspacenormal worldspacenormals normalsworldspace \
         rayhitn",
    ),
    (
        Hint::VIEW,
        "nn cameranormal cameranormals normalcamera viewnormal viewnormals normalview eyenormal denoisingnormal",
    ),
    (Hint::depth(Planar), "pz rayhitpz hitpz worlddepth"),
    (Hint::depth(Ray), "distance rayhitdist hitdist"),
    (Hint::depth(NormalizedNearIsOne), "zdepth vrayzdepth"),
    (Hint::depth(Inverse), DISPARITY),
];

/// Names of one over the distance, up to a factor, as stereo and estimators give it; disp is displacement as often.
const DISPARITY: &str = "disparity inversedepth invdepth depthinverse";

/// What the name of a file that holds depth alone implies, by its words.
pub(crate) fn hint_of_depth_file(path: &Path) -> (Hint, String) {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let words: Vec<_> = stem
        .split(|c: char| !c.is_alphanumeric())
        .map(key)
        .collect();
    let pairs = words.windows(2).map(|pair| pair.concat());
    let mut names = words.iter().cloned().chain(pairs);
    match names.find(|name| is_one_of(name, DISPARITY)) {
        Some(name) => (Hint::depth(Inverse), format!("by its name, {name}")),
        None => (Hint::default(), String::new()),
    }
}

/// A program that writes layers, the prefixes of the names of attributes in its files, in lower case, and the defaults for
/// its layers unless a name is more specific.
type Renderer = (&'static str, &'static [&'static str], Hint);

/// Renderers recognised by attributes, or by their names in those of [`MAKERS`], with the implications for their layers.
const RENDERERS: &[Renderer] = &[
    ("Blender", &["cycles."], Hint::WORLD.and(Planar)),
    ("Arnold", &["arnold/"], Hint::WORLD.and(Planar)),
    (
        "V-Ray",
        &["vray", "camerafov"],
        Hint::VIEW.and(NormalizedNearIsOne),
    ),
    ("RenderMan", &["rman"], Hint::depth(Planar)),
    ("Redshift", &["rs/"], Hint::WORLD.and(Planar)),
    ("Karma", &["karma"], Hint::WORLD),
    ("Mantra", &["mantra"], Hint::VIEW.and(Planar)),
    ("Octane", &["octane"], Hint::depth(Ray)),
    ("Corona", &["corona"], Hint::VIEW),
    ("Mitsuba", &["mitsuba"], Hint::WORLD.and(Ray)),
    (
        "pbrt",
        &["rendertimeseconds", "samplesperpixel"],
        Hint::VIEW,
    ),
    ("Nuke", &["nuke/"], Hint::depth(Inverse)),
    ("Unreal", &["unreal/"], Hint::WORLD.and(Planar)),
];

/// Attributes that name the program a file was made with.
const MAKERS: &str = "software renderer generatedby creator generator";

/// Removes the prefix Nuke adds to attributes of files it has read.
pub(crate) fn plain_attribute(name: &str) -> &str {
    name.strip_prefix("exr/").unwrap_or(name)
}

/// The renderer whose marks a file bears, if any.
fn renderer_of(file: &ExrFile) -> Option<&'static Renderer> {
    let attributes = file.attributes.iter();
    let attributes: Vec<_> = attributes
        .map(|(name, text)| (plain_attribute(name).to_ascii_lowercase(), text))
        .collect();
    // A file rewritten by Nuke still has its renderer's layers.
    RENDERERS.iter().find(|(renderer, prefixes, _)| {
        attributes.iter().any(|(name, text)| {
            prefixes.iter().any(|mark| name.starts_with(mark))
                || is_one_of(name, MAKERS)
                    && text
                        .to_ascii_lowercase()
                        .contains(&renderer.to_ascii_lowercase())
        })
    })
}

/// Implications of a layer's name, or of a `space` among its words, or else of the renderer of its file; with their
/// origin in words.
pub(crate) fn hint(layer: &str, space: Option<NormalSpace>, file: &ExrFile) -> (Hint, String) {
    let word = key(last_word(layer));
    if let Some((hint, _)) = IMPLIED.iter().find(|(_, names)| is_one_of(&word, names)) {
        return (*hint, format!("by its name, {word}"));
    }
    let renderer = renderer_of(file);
    if space.is_some() {
        let depth = renderer.and_then(|(.., hint)| hint.depth);
        return (Hint { space, depth }, format!("by its name, {word}"));
    }
    match renderer {
        Some((name, _, hint)) => (*hint, format!("as {name} writes it")),
        None => (Hint::default(), String::new()),
    }
}
