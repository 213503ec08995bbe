//! Relighting on the device: one kernel for every covered pixel.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::made::Shape;
use crate::engine::gpu::recording::Recording;
use crate::engine::gpu::sight::{is_eye_far, starts, to_eye};
use crate::engine::gpu::surface::Picture;
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::F32;
use crate::engine::gpu::wgsl::wgsl;
use crate::frame::{ColorPlanes, DepthKind, Frame};
use crate::light::batch::SHORTEST_TANGENT;
use crate::light::brdf::{BASE_SCALE, FAINTEST, GRAZING, Lobes};
use crate::light::environment_layout::{LEAST_RADIUS, RIM_PX};
use crate::light::light_warping;
use crate::light::prepared_environment::Used;
use crate::light::radiance_scaling::gpu::RADIANCE_SCALING;
use crate::light::relight::gpu_lights::{Light, relighting};
use crate::light::relight::rim::light_rims;
use crate::light::sum::exponent::Exponent;
use crate::light::sum::terms::SHORTEST;
use crate::params::{Material, Quantisation, Tangent};
use crate::plan::{Albedo, Plan, Relighting};
use crate::shape::curvature::gpu::{MAPPED_CURVATURE, MAPPED_CURVATURE_TOWARD};

uniforms! {
    /// Uniforms of `relight.wgsl`.
    LightParams {
        width: u32,
        height: u32,
        /// Lights that represent an environment, even directions it is looked up in, directional lights, and point
        /// lights.
        around_count: u32,
        even_count: u32,
        direction_count: u32,
        point_count: u32,
        /// Intensity of each even direction for a radiance of 1.
        even_share: f32,
        /// The direction to the eye, scaled to z = 1: at the first column and row, and its increments per column and
        /// row.
        to_eye_x: f32,
        to_eye_x_step: f32,
        to_eye_y: f32,
        to_eye_y_step: f32,
        /// Origin of parallel sight lines, in the same form.
        start_x: f32,
        start_x_step: f32,
        start_y: f32,
        start_y_step: f32,
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
        grain_x: f32,
        grain_y: f32,
        ior: f32,
        is_thin: u32,
        /// Of mapped curvature.
        gain: f32,
        /// Strength of the warp, before multiplication by the gain.
        warp: f32,
        contrast: f32,
        invariant_point: f32,
        anisotropy: f32,
        ambient_magnitude: f32,
        diffuse_magnitude: f32,
        specular_magnitude: f32,
        /// Weights of luminance.
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
        tone_levels: f32,
        tone_softness: f32,
        tone_most: f32,
        environment_gain: f32,
        /// The factor of a map prefiltered by a highlight.
        map_lobe: f32,
        /// Look-up map: size, rotation in turns, the intensity of its light.
        map_width: u32,
        map_height: u32,
        map_turn: f32,
        map_bend: f32,
        map_level: f32,
        second_width: u32,
        second_height: u32,
        second_turn: f32,
        second_bend: f32,
        second_level: f32,
        /// Bits of a NaN, which WGSL cannot express as a literal.
        nan_bits: u32,
    }
}

bindings! {
    RelightBuffers {
        covered: &[u32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32],
        /// The Hessian, or its trace in the first buffer.
        hessian_xx: &[f32], hessian_xy: &[f32], hessian_yy: &[f32], occlusion: &[f32], alpha: &[f32], depth: &[f32],
        /// Three vectors per directional light: direction, half vector with z, colour. Two per point light: position,
        /// colour. One per even direction.
        lights: &[vec4<f32>],
        /// Texels of look-up maps.
        texels: &[vec4<f32>],
        /// Albedo, if it is not white; then the resulting colour.
        red: &mut [f32], green: &mut [f32], blue: &mut [f32],
    }
}

/// Relights each pixel.
pub(crate) static RELIGHT: Kernel = Kernel::new::<LightParams, RelightBuffers>(
    "Relight",
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

/// Relights the frame, with its albedo if that is not white.
pub(crate) fn relight(run: &mut Recording) {
    let light = run.light.expect("new light has lights");
    let (shape, albedo) = (run.made.shape.take(), run.made.picture.take());
    let lit = run.relight(run.plan, run.frame, light, shape.as_ref(), albedo);
    (run.made.shape, run.made.picture) = (shape, Some(lit));
}

impl Recording<'_> {
    /// Relights a frame whose albedo, if not white, is in `albedo`: the resulting colours of covered pixels.
    pub(crate) fn relight(
        &mut self,
        plan: &Plan,
        frame: &Frame,
        light: &Light,
        shape: Option<&Shape>,
        albedo: Option<Picture>,
    ) -> Picture {
        let relighting = relighting(plan);
        let has_albedo = albedo.is_some();
        let picture =
            albedo.unwrap_or_else(|| [(); 3].map(|()| self.take(self.surface.plane_bytes())));
        let hessian = shape.and_then(|shape| shape.hessian.as_ref());
        let [normal_x, normal_y, normal_z] = self.surface.normal.clone();
        let entries = match hessian.map(|hessian| (hessian, &hessian.entries)) {
            Some((_, Some(entries))) => entries.each_ref(),
            Some((hessian, None)) => [&hessian.trace; 3],
            None => [&normal_x; 3],
        };
        let occlusion = frame.light.occlusion.as_ref();
        let depth = frame.depth.as_ref().filter(|_| light.counts.points > 0);
        let [occlusion, alpha, depth] = [occlusion, frame.alpha.as_ref(), depth]
            .map(|plane| plane.map(|plane| self.uploaded(plane.samples())));
        let of_frame = [
            ("FAR_EYE", is_eye_far(frame)),
            (
                "HAS_HESSIAN",
                hessian.is_some_and(|hessian| hessian.entries.is_some()),
            ),
            ("HAS_TRACE", hessian.is_some()),
            ("HAS_OCCLUSION", occlusion.is_some()),
            ("HAS_ALPHA", alpha.is_some()),
            ("HAS_ALBEDO", has_albedo),
        ];
        let of_lobes = Lobes::switches(Lobes::of(&relighting.params.material, is_eye_far(frame)));
        let switches = [&of_light(relighting, light)[..], &of_lobes, &of_frame].concat();
        let [red, green, blue] = &picture;
        let params = light_params(plan, frame, light, self.gain());
        let [xx, xy, yy] = entries;
        self.recorder.over_pixels(
            "relight",
            (&RELIGHT, &switches),
            &params,
            &RelightBuffers {
                covered: &self.surface.covered,
                normal_x: &normal_x,
                normal_y: &normal_y,
                normal_z: &normal_z,
                hessian_xx: xx,
                hessian_xy: xy,
                hessian_yy: yy,
                occlusion: occlusion.as_ref().unwrap_or(&normal_x),
                alpha: alpha.as_ref().unwrap_or(&normal_x),
                depth: depth.as_ref().unwrap_or(&normal_x),
                lights: &light.lights,
                texels: &light.texels,
                red,
                green,
                blue,
            },
            self.surface.size,
        );
        picture
    }
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
    let used = &light.around.ready.used;
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
        ("TWO_SPHERES", light.around.spheres.len() == 2),
        ("HAS_CONTRAST", relighting.contrasts),
        ("FEW_TONES", relighting.params.tones().is_some()),
        ("TOON", is(Material::Toon)),
    ]
}

fn light_params(plan: &Plan, frame: &Frame, light: &Light, gain: f32) -> LightParams {
    let relighting = relighting(plan);
    let params = &relighting.params;
    let (material, scaling) = (&params.material, &plan.scaling);
    let magnitudes = scaling.magnitudes();
    let weights = frame.luminance_weights();
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
    let (to_eye, start) = (to_eye(frame), starts(frame));
    let [map, second] = light.maps;
    LightParams {
        width: frame.mask.width() as u32,
        height: frame.mask.height() as u32,
        around_count: light.counts.around,
        even_count: light.counts.even,
        direction_count: light.counts.directions,
        point_count: light.counts.points,
        even_share: light.around.looked_up().map_or(0.0, |(_, share)| share),
        to_eye_x: to_eye.first[0],
        to_eye_x_step: to_eye.step[0],
        to_eye_y: to_eye.first[1],
        to_eye_y_step: to_eye.step[1],
        start_x: start.first[0],
        start_x_step: start.step[0],
        start_y: start.first[1],
        start_y_step: start.step[1],
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
        grain_x: grain.cos(),
        grain_y: grain.sin(),
        ior: material.ior,
        is_thin: u32::from(material.thin),
        gain,
        warp: params.warping.warp,
        contrast: params.warping.contrast,
        invariant_point: scaling.invariant_point,
        anisotropy: scaling.anisotropy,
        ambient_magnitude: magnitudes.ambient,
        diffuse_magnitude: magnitudes.diffuse,
        specular_magnitude: magnitudes.specular,
        weight_r: weights[0],
        weight_g: weights[1],
        weight_b: weights[2],
        tone_levels: tones.levels as f32,
        tone_softness: tones.softness,
        tone_most: light.most_tone,
        environment_gain: light.around.gain().unwrap_or(1.0),
        map_lobe: 2.0 / (material.shininess + 1.0),
        map_width: map.size[0],
        map_height: map.size[1],
        map_turn: map.turn,
        map_bend: map.intensity.bend,
        map_level: map.intensity.level,
        second_width: second.size[0],
        second_height: second.size[1],
        second_turn: second.turn,
        second_bend: second.intensity.bend,
        second_level: second.intensity.level,
        nan_bits: f32::NAN.to_bits(),
    }
}
