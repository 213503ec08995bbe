//! Radiance scaling of the light layers of a frame: the changes of all terms are summed, then applied to the picture.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::made::{Hessian, Shape};
use crate::engine::gpu::run::Run;
use crate::engine::gpu::surface::{Picture, WIDEST};
use crate::engine::gpu::uniforms::{SizeParams, uniforms};
use crate::engine::gpu::wgsl::Number::F32;
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::frame::{ColorPlanes, Frame};
use crate::light::layers::terms::{LightTerm, light_terms};
use crate::light::layers::{MAX_RADIANCE, MIN_ALBEDO};
use crate::light::radiance_scaling::gpu::RADIANCE_SCALING;
use crate::plan::Plan;
use crate::product::Product;
use crate::shape::curvature::gpu::{MAPPED_CURVATURE, MAPPED_CURVATURE_TOWARD};

/// The light of a lobe.
const LOBE_LIGHT: Wgsl = wgsl!("lobe_light.wgsl", [("MIN_ALBEDO", F32(MIN_ALBEDO))]);

/// The scaling of a term of the light.
const TERM_SCALING: Wgsl = wgsl!("term_scaling.wgsl");

uniforms! {
    /// Uniforms of the kernels that scale a term of the light.
    TermParams {
        width: u32,
        height: u32,
        /// Magnitude gamma, and the invariant point alpha.
        magnitude: f32,
        invariant_point: f32,
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
        gain: f32,
        /// Luminance that counts as intensity 1.
        white: f32,
        anisotropy: f32,
        /// Directions of a light group.
        light_count: u32,
    }
}

bindings! {
    LobeSigmaBuffers {
        covered: &[u32], direct: &[f32], indirect: &[f32], albedo: &[f32], trace: &[f32], sigma: &mut [f32],
    }
    GroupSigmaBuffers {
        covered: &[u32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32],
        /// Entries of the Hessian, or its trace in the first buffer.
        curvature_xx: &[f32], curvature_xy: &[f32], curvature_yy: &[f32],
        /// Unit directions to the lights, consecutively.
        to_light: &[f32], sigma: &mut [f32],
    }
    AddChangeBuffers {
        sigma: &[f32], direct: &[f32], indirect: &[f32], color: &[f32], change: &mut [vec4<f32>],
        layered: &mut [vec4<f32>],
    }
    ChangePictureBuffers {
        covered: &[u32], change: &[vec4<f32>], layered: &[vec4<f32>], red: &mut [f32], green: &mut [f32],
        blue: &mut [f32],
    }
    OccludeBuffers {
        covered: &[u32], trace: &[f32], occlusion: &[f32], red: &mut [f32], green: &mut [f32], blue: &mut [f32],
    }
}

/// The scaling of a lobe.
pub(crate) static LOBE_SIGMA: Kernel = Kernel::new::<TermParams, LobeSigmaBuffers>(
    "LobeSigma",
    &[
        MAPPED_CURVATURE,
        RADIANCE_SCALING,
        TERM_SCALING,
        LOBE_LIGHT,
        wgsl!("lobe_sigma.wgsl"),
    ],
);

/// The scaling of a light group.
pub(crate) static GROUP_SIGMA: Kernel = Kernel::new::<TermParams, GroupSigmaBuffers>(
    "GroupSigma",
    &[
        MAPPED_CURVATURE,
        MAPPED_CURVATURE_TOWARD,
        RADIANCE_SCALING,
        TERM_SCALING,
        wgsl!("group_sigma.wgsl"),
    ],
);

/// Adds the change of a light by its scaling.
pub(crate) static ADD_CHANGE: Kernel = Kernel::new::<TermParams, AddChangeBuffers>(
    "AddChange",
    &[
        RADIANCE_SCALING,
        TERM_SCALING,
        wgsl!("add_change.wgsl", [("MAX_RADIANCE", F32(MAX_RADIANCE))]),
    ],
);

/// Applies the changes to a picture.
pub(crate) static CHANGE_PICTURE: Kernel = Kernel::new::<SizeParams, ChangePictureBuffers>(
    "ChangePicture",
    &[wgsl!("change_picture.wgsl")],
);

/// Scales a picture by its ambient occlusion.
pub(crate) static OCCLUDE: Kernel = Kernel::new::<TermParams, OccludeBuffers>(
    "Occlude",
    &[
        MAPPED_CURVATURE,
        RADIANCE_SCALING,
        TERM_SCALING,
        wgsl!("occlude.wgsl"),
    ],
);

/// Change of the picture by the terms so far, and their light.
struct Changes {
    change: wgpu::Buffer,
    layered: wgpu::Buffer,
    is_empty: bool,
}

/// The layers of a term on the device, each as three consecutive planes.
struct Layers {
    direct: Option<wgpu::Buffer>,
    indirect: Option<wgpu::Buffer>,
    color: Option<wgpu::Buffer>,
    albedo: Option<wgpu::Buffer>,
}

const WITH_CURVATURE: &str = "scaling takes curvature";

/// Scales the picture by the lobes of its light.
pub(crate) fn scale_lobes(run: &mut Run) {
    run.change_picture(|run, shape, picture| {
        run.scale_lobes(run.plan, run.frame, shape, picture);
    });
}

/// Scales the picture by light groups.
pub(crate) fn scale_groups(run: &mut Run) {
    run.change_picture(|run, shape, picture| run.scale_groups(run.plan, run.frame, shape, picture));
}

/// Scales the picture by ambient occlusion.
pub(crate) fn scale_by_occlusion(run: &mut Run) {
    run.change_picture(|run, shape, picture| {
        run.scale_by_occlusion(run.plan, run.frame, shape, picture);
    });
}

impl Run<'_> {
    fn scale_lobes(&mut self, plan: &Plan, frame: &Frame, shape: &Shape, picture: &Picture) {
        let hessian = shape.hessian.as_ref().expect(WITH_CURVATURE);
        let mut changes = self.no_changes();
        let sigma = self.take(self.surface.plane_bytes());
        let whites = self.host.outcome.term_white_levels.clone();
        let white_of = |name| {
            let mut whites = whites.iter();
            whites
                .find(|(of, _)| *of == name)
                .map_or(1.0, |(_, white)| *white)
        };
        for term in light_terms(&frame.light.lobes, &plan.scaling) {
            let params = TermParams {
                magnitude: term.magnitude,
                white: white_of(term.name),
                ..self.term_params(plan, frame)
            };
            let layers = self.layers(&term);
            let [direct, indirect, albedo] = bound(
                [&layers.direct, &layers.indirect, &layers.albedo],
                &self.surface.covered,
            );
            self.recorder.over_pixels(
                "light-lobes",
                (&LOBE_SIGMA, &layers.lobe_switches()),
                &params,
                &LobeSigmaBuffers {
                    covered: &self.surface.covered,
                    direct,
                    indirect,
                    albedo,
                    trace: &hessian.trace,
                    sigma: &sigma,
                },
                self.surface.size,
            );
            self.add_changes("light-lobes", &mut changes, &sigma, &layers, &params);
        }
        self.change(picture, changes);
        self.buffers.recycle([sigma]);
    }

    fn scale_groups(&mut self, plan: &Plan, frame: &Frame, shape: &Shape, picture: &Picture) {
        let Hessian { trace, entries } = shape.hessian.as_ref().expect(WITH_CURVATURE);
        let mut changes = self.no_changes();
        let sigma = self.take(self.surface.plane_bytes());
        let toward_light = plan.wants(Product::Hessian);
        for group in &frame.light.groups {
            let to_light: Vec<f32> = group.to_light.iter().flat_map(|l| l.to_array()).collect();
            let params = TermParams {
                magnitude: plan.scaling.magnitudes().diffuse,
                light_count: group.to_light.len() as u32,
                ..self.term_params(plan, frame)
            };
            let to_light = self.uploaded(&to_light);
            let [x, y, z] = &self.surface.normal;
            let [xx, xy, yy] = match entries {
                Some(entries) => entries.each_ref(),
                None => [trace; 3],
            };
            self.recorder.over_pixels(
                "light-groups",
                (&GROUP_SIGMA, &[("TOWARD_LIGHT", toward_light)]),
                &params,
                &GroupSigmaBuffers {
                    covered: &self.surface.covered,
                    normal_x: x,
                    normal_y: y,
                    normal_z: z,
                    curvature_xx: xx,
                    curvature_xy: xy,
                    curvature_yy: yy,
                    to_light: &to_light,
                    sigma: &sigma,
                },
                self.surface.size,
            );
            let layers = Layers {
                direct: Some(self.hold_color(&group.light)),
                indirect: None,
                color: None,
                albedo: None,
            };
            self.add_changes("light-groups", &mut changes, &sigma, &layers, &params);
        }
        self.change(picture, changes);
        self.buffers.recycle([sigma]);
    }

    fn scale_by_occlusion(&mut self, plan: &Plan, frame: &Frame, shape: &Shape, picture: &Picture) {
        let hessian = shape.hessian.as_ref().expect(WITH_CURVATURE);
        let occlusion = frame.light.occlusion.as_ref();
        let occlusion = occlusion.expect("the plan has seen occlusion");
        let occlusion = self.uploaded(occlusion.samples());
        let params = TermParams {
            magnitude: plan.scaling.magnitudes().ambient,
            ..self.term_params(plan, frame)
        };
        let [red, green, blue] = picture;
        self.recorder.over_pixels(
            "ambient-occlusion",
            (&OCCLUDE, &[]),
            &params,
            &OccludeBuffers {
                covered: &self.surface.covered,
                trace: &hessian.trace,
                occlusion: &occlusion,
                red,
                green,
                blue,
            },
            self.surface.size,
        );
    }

    /// Uniforms shared by all terms.
    fn term_params(&self, plan: &Plan, frame: &Frame) -> TermParams {
        let [width, height] = self.surface.size;
        let [weight_r, weight_g, weight_b] = frame.luminance_weights();
        TermParams {
            width,
            height,
            magnitude: 0.0,
            invariant_point: plan.scaling.invariant_point,
            weight_r,
            weight_g,
            weight_b,
            gain: self.gain(),
            white: 1.0,
            anisotropy: plan.scaling.anisotropy,
            light_count: 0,
        }
    }

    /// Copies a colour to the device as three consecutive planes.
    fn hold_color(&mut self, color: &ColorPlanes) -> wgpu::Buffer {
        let planes = [&color.r, &color.g, &color.b].map(|plane| plane.samples());
        self.uploaded(&planes.concat())
    }

    fn layers(&mut self, term: &LightTerm) -> Layers {
        let mut held = |color: Option<&ColorPlanes>| color.map(|color| self.hold_color(color));
        Layers {
            direct: held(term.direct),
            indirect: held(term.indirect),
            color: held(term.color),
            albedo: held(term.albedo),
        }
    }

    fn no_changes(&self) -> Changes {
        let [change, layered] = [(); 2].map(|()| self.take(WIDEST * self.surface.plane_bytes()));
        Changes {
            change,
            layered,
            is_empty: true,
        }
    }

    /// Adds the change of a light by `sigma`.
    fn add_changes(
        &mut self,
        stage: &'static str,
        changes: &mut Changes,
        sigma: &wgpu::Buffer,
        layers: &Layers,
        params: &TermParams,
    ) {
        let [direct, indirect, color] =
            bound([&layers.direct, &layers.indirect, &layers.color], sigma);
        let switches = [
            ("HAS_DIRECT", layers.direct.is_some()),
            ("HAS_INDIRECT", layers.indirect.is_some()),
            ("HAS_COLOR", layers.color.is_some()),
            ("IS_FIRST", changes.is_empty),
        ];
        self.recorder.over_pixels(
            stage,
            (&ADD_CHANGE, &switches),
            params,
            &AddChangeBuffers {
                sigma,
                direct,
                indirect,
                color,
                change: &changes.change,
                layered: &changes.layered,
            },
            self.surface.size,
        );
        changes.is_empty = false;
    }

    /// Applies the changes to a picture in place.
    fn change(&mut self, picture: &Picture, changes: Changes) {
        let [width, height] = self.surface.size;
        let [red, green, blue] = picture;
        if !changes.is_empty {
            self.recorder.over_pixels(
                "changes",
                (&CHANGE_PICTURE, &[]),
                &SizeParams { width, height },
                &ChangePictureBuffers {
                    covered: &self.surface.covered,
                    change: &changes.change,
                    layered: &changes.layered,
                    red,
                    green,
                    blue,
                },
                [width, height],
            );
        }
        self.buffers.recycle([changes.change, changes.layered]);
    }
}

impl Layers {
    /// The switches of kernels that read layers of light.
    fn lobe_switches(&self) -> [(&'static str, bool); 3] {
        [
            ("HAS_DIRECT", self.direct.is_some()),
            ("HAS_INDIRECT", self.indirect.is_some()),
            ("HAS_ALBEDO", self.albedo.is_some()),
        ]
    }
}

/// Buffers to bind for layers: `any` in place of absent ones, which no kernel reads.
fn bound<'b>(
    layers: [&'b Option<wgpu::Buffer>; 3],
    any: &'b wgpu::Buffer,
) -> [&'b wgpu::Buffer; 3] {
    layers.map(|layer| layer.as_ref().unwrap_or(any))
}
