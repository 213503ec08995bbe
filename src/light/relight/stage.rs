//! Relighting: a single stage, since it is done in one sweep over the pixels.

use crate::light::alignment::SIGMAS_PX;
use crate::light::intensity::White;
use crate::light::relight::albedo_search::AlbedoSearch;
use crate::light::relight::setting::{Albedo, EnvironmentUse, Relighting, ToError};
use crate::light::relight::{grain, raking, relight};
use crate::light::shadows::casting::Casting;
use crate::plan::Plan;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;
use crate::shape::coarse_normals;

/// Partly covered pixels take light from their neighbours.
const RIM_REACH: usize = 1;

/// Shadows may reach over all of a picture.
const SHADOW_REACH: usize = 1 << 20;

/// A step that is left out where no new light is asked for.
macro_rules! lit {
    ($name:expr, $gives:expr, $decide:ident) => {
        step($name, $gives, |plan| in_new_light(plan, $decide))
    };
}

/// New light.
pub(crate) static RELIGHT: Stage = Stage {
    // Ambient light alone has no step.
    also_runs: |plan| plan.relighting().is_some(),
    takes: |plan| {
        let relighting = plan.relighting();
        relighting.map_or_else(Vec::new, |relighting| takes(plan, relighting))
    },
    reach_px: |plan| match plan.relighting() {
        // All around a tile is known from the tile, which is blurred as a whole, with its borders joined.
        Some(relighting) if plan.tile.is_none() => RIM_REACH + reach(plan, relighting),
        _ => RIM_REACH,
    },
    chooses: |plan| {
        let lit = plan.relighting();
        let is_open = lit.is_some_and(|lit| lit.albedo == Albedo::Estimate);
        is_open.then(|| Box::new(AlbedoSearch::default()) as _)
    },
    reads_depth: |plan| {
        let relighting = plan.relighting();
        relighting.is_some_and(|lit| lit.near || lit.traced) || casts(plan)
    },
    // Rays meet a surface whole.
    takes_normals: |plan| plan.specular.is_none(),
    makes: Makes::Picture,
    name: "relight",
    steps: &[
        lit!("albedo-estimate", &[Product::Picture], albedo_estimate),
        lit!("gloss", &[Product::Picture], gloss),
        lit!("environment-lights", &[], environment_lights),
        lit!("environment-prefilter", &[], environment_prefilter),
        lit!(grain::NAME, &[Product::Picture], occlusion_grain),
        lit!("shadows", &[Product::Picture], shadows),
        lit!("warping", &[], warping),
        lit!("jacobian", &[], jacobian),
        lit!("raking", &[], raking),
        lit!("alignment", &[], alignment),
        lit!("light-sum", &[Product::Picture], light_sum),
        lit!("light-lookups", &[Product::Picture], light_lookups),
        lit!("contrast", &[Product::Picture], contrast),
        lit!("tones", &[Product::Picture], tones),
    ],
    cpu: relight,
    #[cfg(feature = "gpu")]
    gpu: Some(super::gpu::relight),
    #[cfg(feature = "gpu")]
    gpu_lacks: |plan| plan.relighting().and_then(gpu_lacks),
    ..Stage::DEFAULT
};

/// How far samples reach that light is turned by, or shadowed.
fn reach(plan: &Plan, relighting: &Relighting) -> usize {
    if relighting.casting.any() {
        return SHADOW_REACH;
    }
    let aligned = match relighting.aligns {
        true => coarse_normals::sweeps(plan, &SIGMAS_PX).count(),
        false => 0,
    };
    let raked = match relighting.rakes {
        true => raking::reach(plan),
        false => 0,
    };
    let quietened = match relighting.grainy_occlusion {
        true => grain::sweeps().count(),
        false => 0,
    };
    aligned.max(raked).max(quietened)
}

/// Products of the shape stages that relighting needs; none where the light is not modified by shape.
fn takes(plan: &Plan, relighting: &Relighting) -> Vec<Product> {
    let slopes = [Product::Gradient, Product::Conductance];
    let mut takes = match (relighting.needs_hessian(), relighting.needs_gain()) {
        (true, _) => vec![Product::Hessian],
        (false, true) => vec![Product::Trace],
        (false, false) => Vec::new(),
    };
    // Curvature is computed row by row, unless the gain was chosen from it.
    if !takes.is_empty() && (relighting.needs_hessian() || !plan.chooses_gain()) {
        takes.extend(slopes);
    }
    takes.extend(relighting.casts_from_normals().then_some(Product::Height));
    let spreads = relighting.aligns || relighting.grainy_occlusion;
    if spreads && !takes.contains(&Product::Conductance) {
        takes.push(Product::Conductance);
    }
    takes.extend(relighting.grain.then_some(Product::Direction));
    takes
}

#[cfg(feature = "gpu")]
fn gpu_lacks(relighting: &Relighting) -> Option<&'static str> {
    match relighting.environment {
        _ if relighting.traced => Some("mirrors and lenses that show what is traced"),
        _ if relighting.casting.any() => Some("shadows"),
        _ if relighting.grain => Some("a grain along the curvature"),
        _ if relighting.rakes => Some("lamps turned by region"),
        _ if relighting.grainy_occlusion => Some("occlusion with grain"),
        _ if relighting.aligns => Some("light turned to the form"),
        _ if relighting.gloss => Some("metals, glass and lamps by their layers"),
        EnvironmentUse::ToError(ToError { glossy: true, .. }) => {
            Some("samples of an environment, which --samples 54 makes lights")
        }
        _ => None,
    }
}

/// Whether new light casts shadows.
fn casts(plan: &Plan) -> bool {
    let relighting = plan.relighting();
    relighting.is_some_and(|relighting| relighting.casting.any())
}

fn in_new_light(plan: &Plan, decide: fn(&Relighting) -> Verdict) -> Verdict {
    match plan.relighting() {
        Some(relighting) => decide(relighting),
        None => Verdict::left_out("no new light is asked for"),
    }
}

fn runs_if(runs: bool, why: impl Into<String>, why_not: &str) -> Verdict {
    match runs {
        true => Verdict::runs(why),
        false => Verdict::left_out(why_not),
    }
}

fn albedo_estimate(relighting: &Relighting) -> Verdict {
    Verdict::left_out(match relighting.albedo {
        Albedo::Estimate => return Verdict::runs("the picture over the shading that fits it best"),
        Albedo::Layer => "a layer tells it",
        Albedo::Picture => "the picture as it is",
        Albedo::White => "white",
    })
}

fn gloss(relighting: &Relighting) -> Verdict {
    let why = "new light is mirrored, and the rest of the light beyond the albedo stays";
    runs_if(relighting.gloss, why, "no layers of it, or --albedo-from")
}

fn environment_lights(relighting: &Relighting) -> Verdict {
    match relighting.environment {
        EnvironmentUse::Lights(count) => Verdict::runs(format!("{count} lights, by median cut")),
        EnvironmentUse::ToError(ToError { levels, glossy, .. }) => {
            let samples = if glossy { " and samples" } else { "" };
            Verdict::runs(format!(
                "lights{samples} to an error of {levels} grey levels"
            ))
        }
        EnvironmentUse::None => Verdict::left_out("no environment, or none that is asked for"),
        _ => Verdict::left_out("the environment is looked up"),
    }
}

fn environment_prefilter(relighting: &Relighting) -> Verdict {
    match relighting.environment {
        EnvironmentUse::Prefiltered => Verdict::runs("one look-up per lobe and pixel serves"),
        EnvironmentUse::None => Verdict::left_out("lights have directions"),
        _ => Verdict::left_out("sampled, or looked up as it is"),
    }
}

fn shadows(relighting: &Relighting) -> Verdict {
    let Casting { lamps, sky, .. } = relighting.casting;
    match [lamps.is_cast, sky.is_cast] {
        [true, true] => Verdict::runs(format!("{}; {}", lamps.why, sky.why)),
        [false, true] => Verdict::runs(sky.why),
        [is_cast, false] => runs_if(is_cast, lamps.why, lamps.why),
    }
}

fn occlusion_grain(relighting: &Relighting) -> Verdict {
    let why = "few samples show in the layer: they are spread up to edges";
    runs_if(
        relighting.grainy_occlusion,
        why,
        "no layer with grain dims light",
    )
}

fn warping(relighting: &Relighting) -> Verdict {
    let why_not = match relighting.params.method.warps() {
        true => "--warp 0 bends nothing",
        false => "the method does not bend light",
    };
    let strength = relighting.params.warping.warp;
    runs_if(relighting.warps, format!("strength {strength}"), why_not)
}

fn raking(relighting: &Relighting) -> Verdict {
    let why = "lamps from the azimuth that shows most of each region's detail";
    runs_if(relighting.rakes, why, "lamps shine as they are given")
}

fn alignment(relighting: &Relighting) -> Verdict {
    let why_not = match relighting.params.method.aligns() {
        true => "--align 0 turns nothing",
        false => "the method does not turn light to the form",
    };
    let (share, [a, b, c]) = (relighting.params.align, SIGMAS_PX);
    let why = format!("diffuse light, {share} of the way to the detail of {a}, {b} and {c} px");
    runs_if(relighting.aligns, why, why_not)
}

fn jacobian(relighting: &Relighting) -> Verdict {
    let why_not = match relighting.warps {
        true => "look-ups are warped (equation 1): no density changes",
        false => "nothing is warped",
    };
    let why = "lights were sampled before they were warped (equation 2)";
    runs_if(relighting.has_jacobian(), why, why_not)
}

fn light_sum(relighting: &Relighting) -> Verdict {
    let scaled = match (relighting.scales, relighting.toward_light) {
        (false, _) => "",
        (true, false) => ", each scaled by curvature",
        (true, true) => ", each scaled by the curvature toward it",
    };
    let summed = match relighting.environment {
        EnvironmentUse::Lookups(count) => {
            format!("{count} even directions, looked up at every pixel{scaled}")
        }
        _ => format!("light by light{scaled}"),
    };
    runs_if(relighting.sums, summed, "no light has to be summed")
}

fn light_lookups(relighting: &Relighting) -> Verdict {
    let looked_up = matches!(
        relighting.environment,
        EnvironmentUse::Prefiltered | EnvironmentUse::Mirrored
    );
    let what = match (relighting.lit_spheres, relighting.environment) {
        _ if relighting.traced => "what mirrored or refracted sight lines meet",
        (0, EnvironmentUse::Mirrored) => "where mirrored or refracted sight lines lead",
        (0, _) => "prefiltered light about the normal and the mirrored view",
        (1, _) => "a lit sphere, by the normal",
        _ => "two lit spheres, by the normal, mixed by curvature",
    };
    let runs = looked_up || relighting.lit_spheres > 0 || relighting.traced;
    let scaled = match relighting.scales {
        true => format!("; {}", intensity(relighting)),
        false => String::new(),
    };
    runs_if(runs, format!("{what}{scaled}"), "nothing to look up")
}

/// How radiance scaling takes the intensity of looked-up light.
fn intensity(relighting: &Relighting) -> String {
    let has_highlight = relighting.params.material.material.has_highlight();
    let is_diffuse = relighting.environment == EnvironmentUse::Prefiltered && !relighting.traced;
    let unlimited = "intensity 1/2 at the median";
    let limited = "intensity 1 at the largest luminance";
    match relighting.white {
        White::Level(level) => format!("intensity 1 at luminance {level}, by --white-level"),
        White::Auto if relighting.lit_spheres > 0 => {
            format!("{limited}, of HDR {unlimited}")
        }
        _ if is_diffuse && !has_highlight => limited.into(),
        White::Auto if is_diffuse => format!("{limited}, of highlights {unlimited}"),
        White::Auto => unlimited.into(),
        White::Middle(middle) => format!("intensity 1/2 at luminance {middle}, by --middle-light"),
    }
}

fn contrast(relighting: &Relighting) -> Verdict {
    let contrast = relighting.params.warping.contrast;
    let why_not = match contrast == 0.0 {
        true => "--contrast 0",
        false => "it follows the warp, and there is none",
    };
    runs_if(relighting.contrasts, contrast.to_string(), why_not)
}

fn tones(relighting: &Relighting) -> Verdict {
    match relighting.params.tones() {
        Some(tones) => Verdict::runs(format!(
            "{} levels, softness {}",
            tones.levels, tones.softness
        )),
        None => Verdict::left_out("all tones are wanted"),
    }
}
