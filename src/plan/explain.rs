//! The decision for each stage, with its reason: the rules of the plan, written once.

use super::enhancement::{Enhancement, Subject};
use super::{Available, Goal, Points, Stage};
use crate::params::{
    Adaptive, Bend, LineParams, ScalingParams, ShapeParams, SpecularParams, Style,
};
use crate::plan::relight::Relighting;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use serde::Serialize;

/// Whether a stage runs, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Decision {
    /// The stage.
    pub stage: Stage,
    /// Whether it runs.
    pub kept: bool,
    /// Why, in a few words.
    pub reason: String,
}

impl Stage {
    /// The stages that only relighting has.
    const OF_RELIGHTING: [Self; 9] = [
        Self::AlbedoEstimate,
        Self::EnvironmentLights,
        Self::EnvironmentPrefilter,
        Self::Warping,
        Self::Jacobian,
        Self::LightSum,
        Self::LightLookups,
        Self::Contrast,
        Self::Tones,
    ];

    /// The stage's name as `--explain` and `--timings` print it.
    pub fn name(self) -> &'static str {
        match self {
            Self::DepthSilhouettes => "depth-silhouettes",
            Self::OcclusionSilhouettes => "occlusion-silhouettes",
            Self::BorderSilhouettes => "border-silhouettes",
            Self::Creases => "creases",
            Self::Conductance => "conductance",
            Self::Gradient => "gradient",
            Self::Diffusion => "diffusion",
            Self::Trace => "trace",
            Self::Hessian => "hessian",
            Self::Curvatures => "curvatures",
            Self::Directions => "directions",
            Self::NormalRays => "normal-rays",
            Self::AutoGain => "auto-gain",
            Self::AutoWhite => "auto-white",
            Self::MappedCurvature => "mapped-curvature",
            Self::RadianceScaling => "radiance-scaling",
            Self::LightLobes => "light-lobes",
            Self::LightGroups => "light-groups",
            Self::AmbientOcclusion => "ambient-occlusion",
            Self::CurvatureDisplay => "curvature-display",
            Self::AlbedoEstimate => "albedo-estimate",
            Self::EnvironmentLights => "environment-lights",
            Self::EnvironmentPrefilter => "environment-prefilter",
            Self::Warping => "warping",
            Self::Jacobian => "jacobian",
            Self::LightSum => "light-sum",
            Self::LightLookups => "light-lookups",
            Self::Contrast => "contrast",
            Self::Tones => "tones",
            Self::SpecularTrace => "specular-trace",
            Self::DirectionField => "direction-field",
            Self::TextureCoordinates => "texture-coordinates",
            Self::TonalArtMap => "tonal-art-map",
            Self::Hatching => "hatching",
            Self::Streamlines => "streamlines",
            Self::Contours => "contours",
        }
    }
}

impl std::fmt::Display for Decision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let verdict = if self.kept { "run " } else { "skip" };
        write!(f, "{verdict}  {:<21} {}", self.stage.name(), self.reason)
    }
}

/// What is decided upon.
pub(super) struct Request<'a> {
    pub(super) goal: Goal,
    pub(super) available: Available,
    pub(super) shape: &'a ShapeParams,
    pub(super) sweeps: &'a DiffusionSchedule,
    pub(super) rays: (Points, [usize; 2]),
    pub(super) scaling: &'a ScalingParams,
    pub(super) relighting: Option<&'a Relighting>,
    pub(super) drawing: Option<&'a LineParams>,
}

/// Decides every stage, in the order of execution.
pub(super) fn decide(request: &Request) -> Vec<Decision> {
    let enhancement = Enhancement::new(request.available.light, request.scaling);
    let mut decisions = of_shape(request, &enhancement);
    decisions.extend(light(
        request.goal,
        request.available,
        &enhancement,
        request.scaling,
    ));
    let no_shape = match (request.goal, request.relighting) {
        (Goal::Enhance, _) if enhancement.is_idle() => {
            Some("a magnitude of 0 leaves the picture as it is")
        }
        (Goal::Picture, _) => Some("the picture is taken as it is"),
        (_, Some(relighting)) if !relighting.needs_shape() => {
            Some("light that is not altered asks nothing of shape")
        }
        _ => None,
    };
    if let Some(reason) = no_shape {
        let left = |stage| request.drawing.is_none() || !OF_DRAWN_SHAPE.contains(&stage);
        for decision in decisions.iter_mut().filter(|d| left(d.stage)) {
            *decision = skip(decision.stage, reason);
        }
    }
    match request.relighting {
        Some(relighting) => decisions.extend(relighting.decide()),
        None => {
            let stages = Stage::OF_RELIGHTING.into_iter();
            decisions.extend(stages.map(|stage| skip(stage, "no new light is asked for")));
        }
    }
    decisions.push(specular(request.available.specular));
    decisions.extend(drawing(request.drawing, request.available.moving));
    decisions
}

fn specular(params: Option<SpecularParams>) -> Decision {
    let Some(SpecularParams { bend, search }) = params else {
        return skip(
            Stage::SpecularTrace,
            "nothing is known that mirrors or lenses could show",
        );
    };
    let bent = match bend {
        Bend::Mirror => "mirrored".into(),
        Bend::Glass { ior } => format!("refracted by {ior}"),
        Bend::Straight => "straight on".into(),
    };
    keep(
        Stage::SpecularTrace,
        format!("sight lines {bent}, {} search steps", search.steps),
    )
}

/// What of the shape a drawing asks for, whatever its tone is made of.
const OF_DRAWN_SHAPE: [Stage; 6] = [
    Stage::DepthSilhouettes,
    Stage::OcclusionSilhouettes,
    Stage::BorderSilhouettes,
    Stage::Creases,
    Stage::Conductance,
    Stage::NormalRays,
];

fn drawing(params: Option<&LineParams>, moving: bool) -> [Decision; 6] {
    let Some(params) = params else {
        let stages = [
            Stage::DirectionField,
            Stage::TextureCoordinates,
            Stage::TonalArtMap,
            Stage::Hatching,
            Stage::Streamlines,
            Stage::Contours,
        ];
        return stages.map(|stage| skip(stage, "no drawing is asked for"));
    };
    let strokes = &params.strokes;
    let in_lines = strokes.style == Style::Lines;
    let textured = |stage, reason: String| match in_lines {
        true => skip(stage, "strokes are lines"),
        false => keep(stage, reason),
    };
    [
        keep(Stage::DirectionField, "strokes follow the curvature"),
        match moving {
            true => keep(Stage::TextureCoordinates, "strokes move with the surface"),
            false => skip(
                Stage::TextureCoordinates,
                "strokes lie still in the picture",
            ),
        },
        textured(Stage::TonalArtMap, format!("seed {}", strokes.seed)),
        textured(
            Stage::Hatching,
            format!("{} levels, {} sets", strokes.levels, strokes.sets),
        ),
        match in_lines {
            true => keep(Stage::Streamlines, "every stroke is a line of its own"),
            false => skip(Stage::Streamlines, "strokes come from a texture"),
        },
        match params.contours {
            Some(contours) => keep(
                Stage::Contours,
                format!(
                    "lines of {} px along silhouettes and creases",
                    contours.width_px
                ),
            ),
            None => skip(Stage::Contours, "none are asked for"),
        },
    ]
}

/// The stages of shape.
fn of_shape(request: &Request, enhancement: &Enhancement) -> Vec<Decision> {
    let Request {
        goal,
        shape,
        sweeps,
        scaling,
        relighting,
        ..
    } = *request;
    let factor = shape.resolution_factor(request.available.image_height);
    let all = goal == Goal::Layers;
    let along_lights = goal == Goal::Enhance
        && enhancement.subject == Subject::Groups
        && scaling.anisotropy != 0.0;
    let hessian = all || along_lights || relighting.is_some_and(|r| r.needs_hessian());
    let gain = relighting.is_none_or(|r| r.needs_gain());
    let grain = relighting.is_some_and(|r| r.grain);
    let mut decisions = silhouettes(request.available);
    decisions.extend([
        keep(Stage::Creases, "from normals"),
        keep(
            Stage::Conductance,
            "barriers for diffusion, flatness at edges",
        ),
        rule(
            Stage::Gradient,
            gain,
            format!("foreshortening {}", shape.foreshortening),
            "no curvature is needed",
        ),
        rule(
            Stage::Diffusion,
            gain && sweeps.count() > 0,
            format!("{}, {}", scale(shape, factor), sweeps.described()),
            if gain {
                "a scale of 0"
            } else {
                "no curvature is needed"
            },
        ),
        rule(
            Stage::Trace,
            gain && !hessian,
            format!(
                "only the sum of curvatures is needed{}",
                unit(shape, factor)
            ),
            if hessian {
                "part of the hessian"
            } else {
                "no curvature is needed"
            },
        ),
        rule(
            Stage::Hessian,
            hessian,
            format!(
                "{}{}",
                if all {
                    "asked for as layers"
                } else {
                    "light has a direction: so has curvature"
                },
                unit(shape, factor)
            ),
            "its trace is enough: no eigenvectors, no directions",
        ),
        rule(
            Stage::Curvatures,
            all,
            "asked for as layers",
            "their sum is enough",
        ),
        rule(
            Stage::Directions,
            all,
            "asked for as layers",
            "no eigenvectors: what follows a direction uses the hessian itself",
        ),
        rule(
            Stage::NormalRays,
            all || grain || request.drawing.is_some(),
            normal_rays(request.rays),
            "nothing here follows a direction",
        ),
        rule(
            Stage::AutoGain,
            gain && scaling.curvature_gain == Adaptive::Auto,
            "--curvature-gain auto",
            if gain {
                format!("--curvature-gain {}", scaling.curvature_gain)
            } else {
                "no curvature is needed".into()
            },
        ),
    ]);
    decisions
}

/// The scale in pixels of the picture, and what it was in those of the reference.
fn scale(shape: &ShapeParams, factor: f64) -> String {
    let sigma = shape.scale_px();
    let here = format!("scale {:.2} px", sigma * factor);
    match shape.reference_height {
        None => here,
        Some(height) => format!("{here} ({sigma:.2} px at a height of {height})"),
    }
}

/// The unit of curvature, where it is not the picture's own.
fn unit(shape: &ShapeParams, factor: f64) -> String {
    match shape.reference_height {
        None => String::new(),
        Some(height) => format!(", times {factor:.4}: per pixel at a height of {height}"),
    }
}

fn normal_rays((points, [least, most]): (Points, [usize; 2])) -> String {
    let points = match points {
        Points::Depth => "points from depth and camera",
        Points::Normals => "no depth with a camera to trust: points from normals alone",
    };
    let step = match least == most {
        true => format!("{least}"),
        false => format!("{least} to {most}"),
    };
    format!("{points}, {step} px away")
}

/// One source of silhouettes: depth before occlusion before the mere border.
fn silhouettes(available: Available) -> Vec<Decision> {
    let Available {
        depth, occlusion, ..
    } = available;
    let no_occlusion = if depth {
        "depth serves"
    } else {
        "no occlusion map, no alpha"
    };
    vec![
        rule(
            Stage::DepthSilhouettes,
            depth,
            "relative depth jumps",
            "no depth",
        ),
        rule(
            Stage::OcclusionSilhouettes,
            !depth && occlusion,
            "no depth: jumps of occlusion or alpha",
            no_occlusion,
        ),
        rule(
            Stage::BorderSilhouettes,
            !depth && !occlusion,
            "no depth: the border of the mask",
            "a map tells more",
        ),
    ]
}

fn light(
    goal: Goal,
    available: Available,
    enhancement: &Enhancement,
    scaling: &ScalingParams,
) -> Vec<Decision> {
    let enhance = goal == Goal::Enhance;
    let not_light = "no light is asked for";
    let (subject, light) = (enhancement.subject, available.light);
    let scaled = enhance && enhancement.magnitude > 0.0;
    let of = |one: Subject, why_not: &str| match (enhance, subject == one) {
        (false, _) => not_light.to_string(),
        (true, true) => "a magnitude of 0".into(),
        (true, false) => why_not.into(),
    };
    let by_layers = match subject {
        Subject::Groups => "light groups are scaled instead",
        _ => "its lobes are scaled instead",
    };
    let no_lobes = match light.diffuse || light.specular {
        true => "light groups go before lobes",
        false => "no lobes told apart, or one layer named",
    };
    let white = match subject {
        _ if !enhance => not_light.to_string(),
        Subject::Groups => "intensity is the cosine to the light".into(),
        Subject::Picture if light.picture_is_occlusion => "1: the picture is occlusion".into(),
        _ => format!("--white-level {}", scaling.white_level),
    };
    let has_white =
        subject == Subject::Lobes || (subject == Subject::Picture && !light.picture_is_occlusion);
    let no_occlusion = match scaling.scaling_ambient {
        _ if !enhance => not_light,
        None => "no --scaling-ambient",
        Some(_) if light.picture_is_occlusion => "the picture is occlusion",
        Some(0.0) => "--scaling-ambient 0",
        Some(_) if !light.occlusion => "no occlusion layer",
        Some(_) => "in the diffuse light from other surfaces, which is scaled by it",
    };
    let magnitudes = scaling.magnitudes();
    let terms = match (scaling.scaling_ambient, light.diffuse_indirect) {
        (Some(ambient), true) => format!(", ambient {ambient}"),
        _ => String::new(),
    };
    vec![
        rule(
            Stage::AutoWhite,
            scaled && has_white && scaling.white_level == Adaptive::Auto,
            "--white-level auto",
            white,
        ),
        rule(
            Stage::MappedCurvature,
            goal == Goal::Layers,
            "asked for as a layer",
            "made on the fly where it is used",
        ),
        rule(
            Stage::RadianceScaling,
            scaled && subject == Subject::Picture,
            format!("magnitude {}", enhancement.magnitude),
            of(Subject::Picture, by_layers),
        ),
        rule(
            Stage::LightLobes,
            scaled && subject == Subject::Lobes,
            format!(
                "magnitude diffuse {}, specular {}{terms}",
                magnitudes.diffuse, magnitudes.specular
            ),
            of(Subject::Lobes, no_lobes),
        ),
        rule(
            Stage::LightGroups,
            scaled && subject == Subject::Groups,
            format!("magnitude {}, by directions", enhancement.magnitude),
            of(Subject::Groups, "no --light-group"),
        ),
        rule(
            Stage::AmbientOcclusion,
            enhance && enhancement.occlusion > 0.0,
            format!("magnitude {}", enhancement.occlusion),
            no_occlusion,
        ),
        rule(
            Stage::CurvatureDisplay,
            goal == Goal::Display,
            "a picture of the descriptor",
            "no display is asked for",
        ),
    ]
}

pub(super) fn rule(
    stage: Stage,
    kept: bool,
    why_kept: impl Into<String>,
    why_not: impl Into<String>,
) -> Decision {
    if kept {
        keep(stage, why_kept)
    } else {
        skip(stage, why_not)
    }
}

pub(super) fn keep(stage: Stage, reason: impl Into<String>) -> Decision {
    Decision {
        stage,
        kept: true,
        reason: reason.into(),
    }
}

pub(super) fn skip(stage: Stage, reason: impl Into<String>) -> Decision {
    Decision {
        stage,
        kept: false,
        reason: reason.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;
    use crate::plan::enhancement::LightAvailable;

    fn plan(goal: Goal, available: Available, iterations: u32) -> Plan {
        let shape = ShapeParams {
            scale: crate::params::Scale::Iterations(iterations),
            ..ShapeParams::default()
        };
        Plan::new(goal, available, shape, ScalingParams::default()).unwrap()
    }

    const DEPTH: Available = Available {
        depth: true,
        color: true,
        albedo: false,
        occlusion: true,
        importance: false,
        image_height: 1080,
        positions: true,
        normal_rounding: 0.0,
        moving: false,
        specular: None,
        light: LightAvailable::NONE,
    };
    const NOTHING: Available = Available {
        depth: false,
        color: true,
        albedo: false,
        occlusion: false,
        importance: false,
        image_height: 1080,
        positions: false,
        normal_rounding: 0.0,
        moving: false,
        specular: None,
        light: LightAvailable::NONE,
    };

    #[test]
    fn a_run_pays_only_for_what_it_needs() {
        assert!(plan(Goal::Enhance, DEPTH, 50).has(Stage::Diffusion));
        assert!(!plan(Goal::Enhance, DEPTH, 0).has(Stage::Diffusion));
        assert!(!plan(Goal::Enhance, NOTHING, 50).has(Stage::DepthSilhouettes));
        assert!(!plan(Goal::Enhance, DEPTH, 50).has(Stage::OcclusionSilhouettes));
        for stage in [Stage::Directions, Stage::Curvatures, Stage::Hessian] {
            assert!(!plan(Goal::Enhance, DEPTH, 50).has(stage));
            assert!(plan(Goal::Layers, DEPTH, 50).has(stage));
        }
    }

    #[test]
    fn scaling_by_zero_computes_nothing() {
        let idle = ScalingParams {
            scaling: 0.0,
            ..ScalingParams::default()
        };
        let plan = Plan::new(Goal::Enhance, DEPTH, ShapeParams::default(), idle).unwrap();
        assert!(plan.stages().is_empty());
    }

    #[test]
    fn every_stage_is_decided_once_and_in_order() {
        let decisions = plan(Goal::Layers, DEPTH, 1).decisions().to_vec();
        assert!(
            decisions
                .windows(2)
                .all(|pair| pair[0].stage < pair[1].stage)
        );
        assert_eq!(decisions.last().unwrap().stage, Stage::Contours);
        assert_eq!(decisions.len(), Stage::Contours as usize + 1);
    }
}
