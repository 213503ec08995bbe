//! The kernels: their WGSL, put together of shared parts.

use crate::engine::gpu::constants::constants;
use crate::engine::gpu::uniforms::{
    CountParams, CrackParams, DensityParams, DiffusionParams, DirectionParams, EdgeParams,
    HessianParams, LightParams, LineCoverageParams, NarrowParams, RayParams, ScaleParams,
    SizeParams, SpreadParams, StrokeParams, TermParams, Uniforms,
};

/// A kernel, named after its file; both kinds of strokes are of `hatching.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Kernel {
    LogDepth,
    Edges,
    EdgeLists,
    Cracks,
    Diffusion,
    Faces,
    Sweep,
    Hessian,
    Curvatures,
    Count,
    Narrow,
    ScalePicture,
    ScaleByGradient,
    LobeLuminance,
    LobeSigma,
    GroupSigma,
    AddChange,
    ChangePicture,
    Occlude,
    CurvatureDisplay,
    NormalRays,
    SpreadDirections,
    FindPatches,
    LinkPatches,
    FindRuns,
    SumRuns,
    ChainMeans,
    PatchForms,
    PatchDirections,
    SettlePatches,
    BetweenPatches,
    Density,
    Strokes,
    PictureStrokes,
    LineCoverage,
    Relight,
}

macro_rules! wgsl {
    ($name:literal) => {
        include_str!(concat!("shaders/", $name, ".wgsl"))
    };
}

impl Kernel {
    /// All there are.
    pub(super) const ALL: [Self; 36] = [
        Self::LogDepth,
        Self::Edges,
        Self::EdgeLists,
        Self::Cracks,
        Self::Diffusion,
        Self::Faces,
        Self::Sweep,
        Self::Hessian,
        Self::Curvatures,
        Self::Count,
        Self::Narrow,
        Self::ScalePicture,
        Self::ScaleByGradient,
        Self::LobeLuminance,
        Self::LobeSigma,
        Self::GroupSigma,
        Self::AddChange,
        Self::ChangePicture,
        Self::Occlude,
        Self::CurvatureDisplay,
        Self::NormalRays,
        Self::SpreadDirections,
        Self::FindPatches,
        Self::LinkPatches,
        Self::FindRuns,
        Self::SumRuns,
        Self::ChainMeans,
        Self::PatchForms,
        Self::PatchDirections,
        Self::SettlePatches,
        Self::BetweenPatches,
        Self::Density,
        Self::Strokes,
        Self::PictureStrokes,
        Self::LineCoverage,
        Self::Relight,
    ];

    /// The whole module.
    pub(crate) fn source(self) -> String {
        let index = wgsl!("index");
        let around = wgsl!("around");
        let covered = wgsl!("coverage");
        let mapped = wgsl!("mapped_curvature");
        let places = wgsl!("places");
        let plane_fit = wgsl!("plane_fit");
        let scaling = wgsl!("radiance_scaling");
        let term_scaling = wgsl!("term_scaling");
        let patches = wgsl!("patches");
        let (runs, sums) = (wgsl!("runs"), wgsl!("sums"));
        let (sight_lines, patch_lines) = (wgsl!("sight_lines"), wgsl!("patch_lines"));
        let (normal_ray, fallback) = (wgsl!("normal_ray"), wgsl!("fallback"));
        let doubled = wgsl!("doubled");
        let over_patches = wgsl!("over_patches");
        let texture_coordinates = wgsl!("texture_coordinates");
        let (uniforms, parts): (&str, &[&str]) = match self {
            Self::LogDepth => (SizeParams::WGSL, &[index, covered, wgsl!("log_depth")]),
            Self::Edges => (
                EdgeParams::WGSL,
                &[
                    index,
                    around,
                    covered,
                    wgsl!("soft_threshold"),
                    wgsl!("facing"),
                    wgsl!("edges"),
                ],
            ),
            Self::EdgeLists => (SizeParams::WGSL, &[index, wgsl!("edge_lists")]),
            Self::Cracks => (
                CrackParams::WGSL,
                &[
                    index,
                    covered,
                    wgsl!("facing"),
                    wgsl!("crack"),
                    wgsl!("cracks"),
                ],
            ),
            Self::Diffusion => (
                DiffusionParams::WGSL,
                &[
                    index,
                    covered,
                    wgsl!("face_conductance"),
                    wgsl!("flux"),
                    wgsl!("diffusion"),
                ],
            ),
            Self::Faces => (
                SizeParams::WGSL,
                &[index, wgsl!("face_conductance"), wgsl!("faces")],
            ),
            Self::Sweep => (
                DiffusionParams::WGSL,
                &[index, wgsl!("flux"), wgsl!("sweep")],
            ),
            Self::Hessian => (
                HessianParams::WGSL,
                &[index, around, covered, plane_fit, wgsl!("hessian")],
            ),
            Self::Curvatures => (
                SizeParams::WGSL,
                &[index, covered, mapped, wgsl!("curvatures")],
            ),
            Self::Count => (
                CountParams::WGSL,
                &[index, covered, wgsl!("keys"), wgsl!("count")],
            ),
            Self::Narrow => (NarrowParams::WGSL, &[wgsl!("keys"), wgsl!("narrow")]),
            Self::ScalePicture => (
                ScaleParams::WGSL,
                &[
                    index,
                    covered,
                    mapped,
                    scaling,
                    wgsl!("scaled_pixel"),
                    wgsl!("scale_picture"),
                ],
            ),
            Self::ScaleByGradient => (
                ScaleParams::WGSL,
                &[
                    index,
                    around,
                    covered,
                    plane_fit,
                    mapped,
                    scaling,
                    wgsl!("scaled_pixel"),
                    wgsl!("scale_by_gradient"),
                ],
            ),
            Self::LobeLuminance => (
                TermParams::WGSL,
                &[index, covered, wgsl!("lobe_light"), wgsl!("lobe_luminance")],
            ),
            Self::LobeSigma => (
                TermParams::WGSL,
                &[
                    index,
                    covered,
                    mapped,
                    scaling,
                    term_scaling,
                    wgsl!("lobe_light"),
                    wgsl!("lobe_sigma"),
                ],
            ),
            Self::GroupSigma => (
                TermParams::WGSL,
                &[
                    index,
                    covered,
                    mapped,
                    wgsl!("mapped_curvature_toward"),
                    scaling,
                    term_scaling,
                    wgsl!("group_sigma"),
                ],
            ),
            Self::AddChange => (
                TermParams::WGSL,
                &[index, scaling, term_scaling, wgsl!("add_change")],
            ),
            Self::ChangePicture => (SizeParams::WGSL, &[index, covered, wgsl!("change_picture")]),
            Self::Occlude => (
                TermParams::WGSL,
                &[
                    index,
                    covered,
                    mapped,
                    scaling,
                    term_scaling,
                    wgsl!("occlude"),
                ],
            ),
            Self::CurvatureDisplay => (
                SizeParams::WGSL,
                &[index, covered, mapped, wgsl!("curvature_display")],
            ),
            Self::NormalRays => (
                RayParams::WGSL,
                &[
                    index,
                    covered,
                    sight_lines,
                    normal_ray,
                    wgsl!("normal_rays"),
                ],
            ),
            Self::SpreadDirections => (
                SpreadParams::WGSL,
                &[
                    index,
                    wgsl!("face_conductance"),
                    sight_lines,
                    fallback,
                    doubled,
                    wgsl!("spread_directions"),
                ],
            ),
            Self::FindPatches => (
                DirectionParams::WGSL,
                &[index, patches, wgsl!("find_patches")],
            ),
            Self::LinkPatches => (DirectionParams::WGSL, &[patches, wgsl!("link_patches")]),
            Self::FindRuns => (DirectionParams::WGSL, &[patches, runs, wgsl!("find_runs")]),
            Self::SumRuns => (
                DirectionParams::WGSL,
                &[patches, runs, sums, wgsl!("sum_runs")],
            ),
            Self::ChainMeans => (
                DirectionParams::WGSL,
                &[patches, sums, over_patches, wgsl!("chain_means")],
            ),
            Self::PatchForms => (
                DirectionParams::WGSL,
                &[
                    patches,
                    sight_lines,
                    patch_lines,
                    normal_ray,
                    over_patches,
                    wgsl!("patch_forms"),
                ],
            ),
            Self::PatchDirections => (
                DirectionParams::WGSL,
                &[
                    patches,
                    sight_lines,
                    patch_lines,
                    fallback,
                    doubled,
                    over_patches,
                    wgsl!("patch_directions"),
                ],
            ),
            Self::SettlePatches => (
                DirectionParams::WGSL,
                &[
                    patches,
                    sight_lines,
                    patch_lines,
                    fallback,
                    doubled,
                    over_patches,
                    wgsl!("settle_patches"),
                ],
            ),
            Self::BetweenPatches => (
                DirectionParams::WGSL,
                &[index, covered, patches, doubled, wgsl!("between_patches")],
            ),
            Self::Density => (DensityParams::WGSL, &[index, covered, wgsl!("density")]),
            Self::Strokes => (
                StrokeParams::WGSL,
                &[
                    index,
                    covered,
                    texture_coordinates,
                    places,
                    wgsl!("stroke_texture"),
                    wgsl!("hatching"),
                ],
            ),
            Self::PictureStrokes => (
                StrokeParams::WGSL,
                &[
                    index,
                    covered,
                    texture_coordinates,
                    places,
                    wgsl!("slice_texture"),
                    wgsl!("hatching"),
                ],
            ),
            Self::LineCoverage => (
                LineCoverageParams::WGSL,
                &[
                    index,
                    covered,
                    wgsl!("round_stroke"),
                    wgsl!("paper"),
                    wgsl!("line_coverage"),
                ],
            ),
            Self::Relight => (
                LightParams::WGSL,
                &[
                    index,
                    covered,
                    mapped,
                    wgsl!("mapped_curvature_toward"),
                    scaling,
                    wgsl!("light_warping"),
                    wgsl!("pixel"),
                    wgsl!("brdf"),
                    wgsl!("terms"),
                    wgsl!("environment"),
                    wgsl!("tones"),
                    wgsl!("relight"),
                ],
            ),
        };
        let mut source = constants();
        source += uniforms;
        source += wgsl!("fast_math");
        for part in parts {
            source += part;
        }
        source
    }

    /// The names of what is bound, in the order of their numbers.
    pub(super) fn bindings(self) -> Vec<String> {
        let source = self.source();
        let mut bound: Vec<(u32, String)> = source.lines().filter_map(binding).collect();
        bound.sort();
        bound.into_iter().map(|(_, name)| name).collect()
    }
}

/// The number and the name of the variable that a line of WGSL binds: `@group(0) @binding(1) var<storage> covered: array<u32>;`.
fn binding(line: &str) -> Option<(u32, String)> {
    let (number, variable) = line.strip_prefix("@group(0) @binding(")?.split_once(')')?;
    let (_, named) = variable.split_once("> ")?;
    let (name, _) = named.split_once(':')?;
    Some((number.parse().ok()?, name.into()))
}

/// The name and the WGSL of every kernel, whole as a device is given it.
pub fn kernel_sources() -> impl Iterator<Item = (String, String)> {
    let all = Kernel::ALL.into_iter();
    all.map(|kernel| (format!("{kernel:?}"), kernel.source()))
}
