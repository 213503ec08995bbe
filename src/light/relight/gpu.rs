//! Relighting on the device: one kernel for every covered pixel.

use crate::frame::{ColorPlanes, DepthKind, Frame};
use crate::gpu::kernels::Kernel;
use crate::gpu::sight::{is_eye_far, starts, to_eye};
use crate::gpu::uniforms::uniforms;
use crate::gpu::wgsl::Number::F32;
use crate::gpu::wgsl::wgsl;
use crate::light::batch::SHORTEST_TANGENT;
use crate::light::brdf::{BASE_SCALE, FAINTEST, GRAZING};
use crate::light::environment_layout::{LEAST_RADIUS, RIM_PX};
use crate::light::light_warping;
use crate::light::prepared_environment::Used;
use crate::light::radiance_scaling::gpu::RADIANCE_SCALING;
use crate::light::relight::gpu_lights::{Light, PlacedMap, relighting};
use crate::light::relight::rim::light_rims;
use crate::light::relight::setting::{Albedo, Relighting};
use crate::light::sum::exponent::Exponent;
use crate::light::sum::lobes::Lobes;
use crate::light::sum::terms::SHORTEST;
use crate::params::{Magnitudes, Material, Quantisation, Tangent};
use crate::plan::Plan;
use crate::plan::recording::Recording;
use crate::shape::curvature::gpu::{MAPPED_CURVATURE, MAPPED_CURVATURE_TOWARD};

uniforms! {
    /// Uniforms of `relight.wgsl`.
    LightParams {
        /// Lights that represent an environment, even directions it is looked up in, directional lights, and point
        /// lights.
        around_count: u32,
        even_count: u32,
        direction_count: u32,
        point_count: u32,
        /// Intensity of each even direction for a radiance of 1.
        even_share: f32,
        /// The direction to the eye, scaled to z = 1, and the origin of parallel sight lines, as
        /// [`linear`](crate::gpu::sight::linear) has them.
        to_eye: vec4,
        start: vec4,
        /// Whether depth is measured along sight lines rather than along the view axis.
        depth_along_ray: u32,
        ambient: f32,
        diffuse_gain: f32,
        specular_gain: f32,
        /// The lobe's exponent if it is an integer, else 0; and the exponent if it is not.
        whole_power: u32,
        power: f32,
        /// Its other numbers.
        lobe_0: f32,
        lobe_1: f32,
        lobe_2: f32,
        lobe_3: f32,
        /// The grain direction in the picture.
        grain: vec2,
        ior: f32,
        is_thin: u32,
        /// Of mapped curvature.
        gain: f32,
        /// Strength of the warp, before multiplication by the gain.
        warp: f32,
        contrast: f32,
        invariant_point: f32,
        anisotropy: f32,
        /// Of the scaling of ambient, diffuse and specular light on convexities, and on concavities.
        magnitudes: vec3,
        concave_magnitudes: vec3,
        /// Weights of luminance.
        weights: vec3,
        tone_levels: f32,
        tone_softness: f32,
        tone_most: f32,
        environment_gain: f32,
        /// The factor of a map prefiltered by a highlight.
        map_lobe: f32,
        /// Look-up maps: size; rotation in turns, and the numbers of the intensity of its light.
        map_size: vec2u,
        map_light: vec3,
        second_size: vec2u,
        second_light: vec3,
        /// Bits of a NaN, which WGSL cannot express as a literal.
        nan_bits: u32,
    }
}

/// Relights each pixel.
pub(crate) static RELIGHT: Kernel = Kernel::new::<LightParams>(
    "Relight",
    // The first entry of the Hessian may be its trace. `lights` are three vectors per directional light: direction, half
    // vector with z, colour; two per point light: position, colour; one per even direction. The picture is the albedo, if
    // it is not white, and then the resulting colour.
    "covered: u32; normal_x, normal_y, normal_z, hessian_xx?, hessian_xy?, hessian_yy?, occlusion?, alpha?, depth?: f32; \
     lights, texels: vec4<f32>; red, green, blue: mut f32",
    &[
        MAPPED_CURVATURE,
        MAPPED_CURVATURE_TOWARD,
        RADIANCE_SCALING,
        wgsl!(
            "../light_warping.wgsl",
            [
                ("LARGEST_ENTRY", F32(light_warping::LARGEST)),
                ("MAX_CONTRAST_EXPONENT", F32(light_warping::MAX_EXPONENT)),
                ("FACTOR_OF_1", F32(light_warping::FACTOR_OF_1)),
                ("LARGEST_FACTOR", F32(light_warping::LARGEST_FACTOR))
            ]
        ),
        wgsl!("../sum/pixel.wgsl"),
        wgsl!(
            "../brdf.wgsl",
            [
                ("GRAZING", F32(GRAZING)),
                ("BASE_SCALE", F32(BASE_SCALE)),
                ("FAINTEST", F32(FAINTEST))
            ]
        ),
        wgsl!(
            "../sum/terms.wgsl",
            [
                ("MOST_BRIGHTENED", F32(light_warping::MOST_BRIGHTENED)),
                ("SHORTEST", F32(SHORTEST))
            ]
        ),
        wgsl!(
            "../environment.wgsl",
            [("RIM_PX", F32(RIM_PX)), ("LEAST_RADIUS", F32(LEAST_RADIUS))]
        ),
        wgsl!("../tones.wgsl"),
        wgsl!(
            "relight.wgsl",
            [("SHORTEST_TANGENT", F32(SHORTEST_TANGENT))]
        ),
    ],
);

/// Relights the frame, with its albedo if that is not white: the resulting colours of covered pixels.
pub(crate) fn relight(run: &mut Recording) {
    let (plan, frame) = (run.plan, run.frame);
    let light = run.lent.get::<Light>().expect("new light has lights");
    let relighting = relighting(plan);
    let (has_hessian, has_trace) = (run.has("hessian_xx"), run.has("trace"));
    let depth = frame.depth.as_ref().filter(|_| light.counts.points > 0);
    run.upload_as("depth", depth);
    let of_frame = [
        ("FAR_EYE", is_eye_far(frame)),
        ("HAS_HESSIAN", has_hessian),
        ("HAS_TRACE", has_trace),
        (
            "HAS_OCCLUSION",
            run.upload_as("occlusion", frame.light.occlusion.as_ref()),
        ),
        ("HAS_ALPHA", run.upload_as("alpha", frame.alpha.as_ref())),
        ("HAS_ALBEDO", run.has("red")),
    ];
    let of_lobes = Lobes::switches(Lobes::of(&relighting.params.material, is_eye_far(frame)));
    let switches = [&of_light(relighting, light)[..], &of_lobes, &of_frame].concat();
    let params = light_params(plan, frame, light, run.gain());
    let trace = (has_trace && !has_hessian).then(|| run.plane("trace"));
    let mut named = vec![("lights", &light.lights), ("texels", &light.texels)];
    named.extend(trace.iter().map(|trace| ("hessian_xx", trace)));
    run.over_pixels("relight", (&RELIGHT, &switches), &params, &named);
}

/// Completes the lit pixels: unlit ones get the frame's picture, or black, and partly covered rims the light of their
/// neighbours.
pub(crate) fn frame_lit(color: &mut ColorPlanes, frame: &Frame) {
    let mask = &frame.mask;
    let picture = frame.color.as_ref();
    let kept = picture.map(|picture| [&picture.r, &picture.g, &picture.b]);
    let planes = [&mut color.r, &mut color.g, &mut color.b];
    for (k, plane) in planes.into_iter().enumerate() {
        for y in 0..mask.height() {
            let row = plane.row_mut(y);
            for gap in mask.gaps(y) {
                match kept {
                    Some(kept) => row[gap.clone()].copy_from_slice(&kept[k].row(y)[gap]),
                    None => row[gap].fill(0.0),
                }
            }
        }
    }
    if let Some(alpha) = &frame.alpha
        && mask.count() < alpha.samples().len()
    {
        light_rims(color, alpha, mask);
    }
}

/// Switches of `relight.wgsl` shared by all frames in this light.
fn of_light(relighting: &Relighting, light: &Light) -> [(&'static str, bool); 14] {
    let is = |kind: Material| relighting.params.material.material == kind;
    let used = &light.ready.used;
    let lobes = Lobes::of(&relighting.params.material, false);
    let is_covered = matches!(relighting.albedo, Albedo::Layer | Albedo::Picture);
    [
        ("WARPS", relighting.warps),
        ("HAS_JACOBIAN", relighting.has_jacobian()),
        ("SCALES", relighting.scales),
        ("GLOSSY", lobes.is_some_and(|lobes| lobes.are_glossy())),
        ("TOWARD_LIGHT", relighting.toward_light),
        ("ALBEDO_IS_COVERED", is_covered),
        ("PREFILTERED", matches!(used, Used::Prefiltered { .. })),
        ("MIRRORED", matches!(used, Used::Mirrored(_))),
        ("GLASS", is(Material::Glass)),
        ("LIT_SPHERE", matches!(used, Used::LitSpheres(_))),
        ("TWO_SPHERES", light.spheres == 2),
        ("HAS_CONTRAST", relighting.contrasts),
        ("FEW_TONES", relighting.params.tones().is_some()),
        ("TOON", is(Material::Toon)),
    ]
}

fn light_params(plan: &Plan, frame: &Frame, light: &Light, gain: f32) -> LightParams {
    let relighting = relighting(plan);
    let params = &relighting.params;
    let (material, scaling) = (&params.material, &plan.scaling);
    let Magnitudes {
        ambient,
        diffuse,
        specular,
    } = scaling.magnitudes();
    let magnitudes = [ambient, diffuse, specular];
    // Mirrors and glass are not summed over lights.
    let lobes = Lobes::of(material, is_eye_far(frame));
    let (whole_power, power) = match lobes.map(|lobes| lobes.exponent()) {
        Some(Exponent::Integer(whole)) => (whole, 0.0),
        Some(Exponent::Real(any)) => (0, any),
        None => (1, 0.0),
    };
    let [lobe_0, lobe_1, lobe_2, lobe_3] = lobes.map_or([0.0; 4], |lobes| lobes.numbers());
    let grain = match material.tangent {
        Tangent::Degrees(angle) => angle.to_radians(),
        Tangent::Curvature => 0.0,
    };
    let tones = params.tones().unwrap_or(Quantisation {
        levels: 1,
        softness: 0.0,
    });
    let [map, second] = light.maps;
    let placed = |map: PlacedMap| [map.turn, map.intensity.bend, map.intensity.level];
    LightParams {
        around_count: light.counts.around,
        even_count: light.counts.even,
        direction_count: light.counts.directions,
        point_count: light.counts.points,
        even_share: light.around().looked_up().map_or(0.0, |(_, share)| share),
        to_eye: to_eye(frame),
        start: starts(frame),
        depth_along_ray: u32::from(frame.source.depth_kind == DepthKind::Ray),
        ambient: material.ambient,
        diffuse_gain: material.diffuse_gain,
        specular_gain: material.specular(),
        whole_power,
        power,
        lobe_0,
        lobe_1,
        lobe_2,
        lobe_3,
        grain: [grain.cos(), grain.sin()],
        ior: material.ior,
        is_thin: u32::from(material.thin),
        gain,
        warp: params.warping.warp,
        contrast: params.warping.contrast,
        invariant_point: scaling.invariant_point,
        anisotropy: scaling.anisotropy,
        magnitudes: magnitudes.map(|magnitude| magnitude.convex),
        concave_magnitudes: magnitudes.map(|magnitude| magnitude.concave),
        weights: frame.luminance_weights(),
        tone_levels: tones.levels as f32,
        tone_softness: tones.softness,
        tone_most: light.most_tone,
        environment_gain: light.around().gain().unwrap_or(1.0),
        map_lobe: 2.0 / (material.shininess + 1.0),
        map_size: map.size,
        map_light: placed(map),
        second_size: second.size,
        second_light: placed(second),
        nan_bits: f32::NAN.to_bits(),
    }
}
