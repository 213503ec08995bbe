//! Pictures under the report's environment, timed, and compared with a reference under many lights.

use crate::Result;
use crate::frame::{ColorPlanes, Frame, Mask, Plane, REC709_LUMINANCE};
use crate::light::environment::Environment;
use crate::light::light_samples::uniform_lights;
use crate::light::lights::Illumination;
use crate::params::{
    Adaptive, AlbedoSource, Material, MaterialParams, Method, RelightParams, Samples, ShapeParams,
    WarpBy,
};
use crate::plan::Plan;
use crate::report::compare::{Errors, Tally, compare, covered, larger};
use crate::report::engine::{Inputs, Outcome, Session, relight_plan};
use crate::report::light_reference::lit_at;
use crate::report::timing::{Effort, Times};
use crate::srgb;
use serde::Serialize;

/// A white material with gains of 1, no ambient light and an unscaled environment: its picture has a closed form.
pub(crate) fn bare(material: Material, method: Method) -> RelightParams {
    let base = RelightParams::default();
    RelightParams {
        method,
        albedo: AlbedoSource::White,
        environment_gain: Adaptive::Fixed(1.0),
        material: MaterialParams {
            material,
            ambient: 0.0,
            diffuse_gain: 1.0,
            specular_gain: Some(1.0),
            ..base.material
        },
        ..base
    }
}

/// The materials tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LitMaterial {
    /// White and diffuse.
    Lambert,
    /// Only Phong's lobe, with exponent eta = 32, times (eta + 1) / 2: it shows a constant environment unchanged.
    Glossy,
}

impl LitMaterial {
    /// Both materials.
    pub(crate) const ALL: [Self; 2] = [Self::Lambert, Self::Glossy];

    /// The parameters of relighting it.
    pub(crate) fn params(self, method: Method, warp_by: WarpBy, samples: u32) -> RelightParams {
        let params = match self {
            Self::Lambert => bare(Material::Lambert, method),
            Self::Glossy => {
                let phong = bare(Material::Phong, method);
                RelightParams {
                    material: MaterialParams {
                        diffuse_gain: 0.0,
                        specular_gain: Some(0.5 * (phong.material.shininess + 1.0)),
                        ..phong.material
                    },
                    ..phong
                }
            }
        };
        RelightParams {
            warp_by,
            samples: Samples::Fixed(samples),
            ..params
        }
    }
}

/// A frame under an environment, for repeated lighting in the same memory.
pub(crate) struct LitFrame<'a> {
    pub frame: &'a Frame,
    shape: ShapeParams,
    environment: Illumination,
    effort: Effort,
    session: Session,
}

/// A picture and its times.
pub(crate) struct Picture {
    pub color: ColorPlanes,
    /// Time of lighting with a prepared environment.
    pub relight: Times,
    /// Time of preparing the environment: once per sequence.
    pub environment: Option<Times>,
}

impl<'a> LitFrame<'a> {
    /// The bench for `frame`, with its shape found by `shape`.
    pub(crate) fn new(
        frame: &'a Frame,
        shape: ShapeParams,
        environment: &Environment,
        effort: Effort,
    ) -> Self {
        Self {
            frame,
            shape,
            environment: Illumination {
                environment: Some(environment.clone().into()),
                ..Illumination::default()
            },
            effort,
            session: Session::default(),
        }
    }

    /// The frame under the environment.
    pub(crate) fn in_environment(&self, params: RelightParams) -> Result<Picture> {
        self.timed(params, &self.environment)
    }

    /// The frame under `light`.
    pub(crate) fn timed(&self, params: RelightParams, light: &Illumination) -> Result<Picture> {
        let plan = self.plan(params, light)?;
        let inputs = Inputs::lit_by(light);
        let (outcome, timed) = self.session.measure(&plan, self.frame, inputs, self.effort);
        Ok(Picture {
            color: outcome.color.expect("light makes a picture"),
            relight: timed.stage("relight").expect("light is a stage"),
            environment: timed.stage("environment"),
        })
    }

    fn plan(&self, params: RelightParams, light: &Illumination) -> Result<Plan> {
        relight_plan(self.frame, self.shape, params, light)
    }

    fn run(&self, plan: &Plan, light: &Illumination) -> Outcome {
        self.session.run(plan, self.frame, Inputs::lit_by(light))
    }
}

/// A picture under many lights, for comparison.
pub(crate) struct Reference {
    pub surface: LitMaterial,
    pub method: Method,
    planes: [Plane<f64>; 3],
    /// The 98th percentile of luminance, which errors are relative to.
    pub white: f64,
    pub relight: Times,
    /// Largest error of its own sums against double precision, at some pixels, relative to `white`.
    pub rounding: f64,
}

/// The references of both materials, plain and warped.
pub(crate) struct References(Vec<Reference>);

/// Number of pixels at which a reference is checked against double precision.
const CHECKED: usize = 16;

impl References {
    /// Lights the bench's frame by many lights.
    pub(crate) fn new(bench: &LitFrame) -> Result<Self> {
        let environment = bench.environment.environment.as_ref();
        let environment = environment.expect("a bench has an environment");
        let light = Illumination {
            directional: uniform_lights(environment, super::REFERENCE_LIGHTS),
            ..Illumination::default()
        };
        let cases = LitMaterial::ALL.map(|s| [(s, Method::Plain), (s, Method::Warp)]);
        let references = cases.into_iter().flatten().map(|(surface, method)| {
            let params = surface.params(method, WarpBy::Lights, 1);
            let picture = bench.timed(params, &light)?;
            let ColorPlanes { r, g, b } = &picture.color;
            let planes = [r, g, b].map(|plane| plane.map(f64::from));
            let white = white_of(&planes, &bench.frame.mask);
            let off = rounding(bench, params, &light)?;
            Ok(Reference {
                surface,
                method,
                planes,
                white,
                relight: picture.relight,
                rounding: off / white,
            })
        });
        Ok(Self(references.collect::<Result<_>>()?))
    }

    /// All four.
    pub(crate) fn all(&self) -> &[Reference] {
        &self.0
    }

    /// The reference of one material and method.
    pub(crate) fn of(&self, surface: LitMaterial, method: Method) -> &Reference {
        let mut all = self.0.iter();
        let found = all.find(|r| (r.surface, r.method) == (surface, method));
        found.expect("every case has its reference")
    }
}

/// The 98th percentile of luminance over covered pixels; 1 if nothing is lit.
fn white_of([r, g, b]: &[Plane<f64>; 3], mask: &Mask) -> f64 {
    white(covered(mask).map(|[x, y]| [r, g, b].map(|plane| plane.at(x, y))))
}

/// The 98th percentile of luminance over colours; 1 if nothing is lit.
pub(crate) fn white(colors: impl Iterator<Item = [f64; 3]>) -> f64 {
    let [wr, wg, wb] = REC709_LUMINANCE.map(f64::from);
    let mut tally = Tally::default();
    for [r, g, b] in colors {
        tally.add([0, 0], wr * r + wg * g + wb * b);
    }
    let white = tally.quantile(0.98);
    if white > 0.0 && white.is_finite() {
        white
    } else {
        1.0
    }
}

/// The largest error of sums over lights at some covered pixels.
fn rounding(bench: &LitFrame, params: RelightParams, light: &Illumination) -> Result<f64> {
    let outcome = bench.run(&bench.plan(params, light)?, light);
    let color = outcome.color.as_ref().expect("light makes a picture");
    let gain = outcome.gain.unwrap_or(0.0);
    let pixels = some_covered(&bench.frame.mask, CHECKED);
    // One of so many lights may be on the horizon, where the glossy lobe ends in a step.
    let lights = &light.directional;
    let exact = lit_at(pixels, bench.frame, bench.shape, &params, gain, lights)?;
    let off = exact.iter().map(|(at, exact)| off(color, *at, *exact));
    Ok(off.fold(0.0, f64::max))
}

/// The error of a picture at a pixel, in its worst channel.
pub(crate) fn off(color: &ColorPlanes, [x, y]: [usize; 2], exact: [f64; 3]) -> f64 {
    let found = [&color.r, &color.g, &color.b].map(|plane| f64::from(plane.at(x, y)));
    (0..3)
        .map(|c| (found[c] - exact[c]).abs())
        .fold(0.0, larger)
}

/// Up to `count` covered pixels, evenly spread in row order.
pub(crate) fn some_covered(mask: &Mask, count: usize) -> Vec<[usize; 2]> {
    let step = mask.count().div_ceil(count.max(1)).max(1);
    covered(mask).skip(step / 2).step_by(step).collect()
}

/// The difference of a picture from its reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Difference {
    /// Errors of the worst channel, relative to the reference's 98th percentile of luminance.
    pub errors: Errors,
    /// The 99th percentile in 8-bit steps, with that luminance as white.
    pub grey_p99: f64,
    pub grey_max: f64,
}

impl Reference {
    /// The difference of `color` from the reference.
    pub(crate) fn difference(&self, color: &ColorPlanes, frame: &Frame) -> Difference {
        let (mask, found) = (&frame.mask, [&color.r, &color.g, &color.b]);
        let exact = self.planes.each_ref();
        let errors = compare(found, exact, mask, self.white).in_window(frame.data_window);
        let shown = |v: f64| 255.0 * srgb::encoded((v / self.white).clamp(0.0, 1.0));
        let mut steps = Tally::default();
        for [x, y] in covered(mask) {
            let off = |c: usize| shown(found[c].at(x, y).into()) - shown(exact[c].at(x, y));
            // The errors count NaN.
            steps.add([x, y], (0..3).map(|c| off(c).abs()).fold(0.0, f64::max));
        }
        let steps = steps.errors();
        Difference {
            errors,
            grey_p99: steps.p99,
            grey_max: steps.max,
        }
    }
}
