//! Relit pictures compared with an upper bound for all their lights together.

use super::{Verdict, largest};
use crate::Result;
use crate::engine::Inputs;
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::light::lights::Illumination;
use crate::params::{Adaptive, Material, Method, RelightParams, ScalingParams, ShapeParams};
use crate::plan::LightKinds;
use crate::plan::{Available, Goal, Plan};
use crate::report::engine;
use crate::report::light::lit::bare;
use crate::report::timing;

/// The parameters of a case; others are at their defaults.
#[derive(Clone)]
pub(super) struct Asked {
    pub(super) shape: ShapeParams,
    pub(super) scaling: ScalingParams,
    pub(super) relight: RelightParams,
    pub(super) light: Illumination,
    /// Whether no light at all should reach the eye.
    pub(super) dark: bool,
}

impl Asked {
    /// A white `material` under `light`, without ambient light.
    pub(super) fn of(material: Material, method: Method, light: Illumination) -> Self {
        Self {
            shape: ShapeParams::default(),
            scaling: ScalingParams {
                curvature_gain: Adaptive::Fixed(12.0),
                ..ScalingParams::default()
            },
            relight: bare(material, method),
            light,
            dark: false,
        }
    }

    /// The largest value that a picture may have.
    ///
    /// The arriving light times the maxima of a lobe, a Jacobian (9), a contrast (3) and a scaling (e^gamma, with the
    /// exponent limited to 60).
    fn bound(&self, frame: &Frame) -> f64 {
        if self.dark {
            return 0.0;
        }
        let factors = [
            if self.relight.method.warps() {
                9.0
            } else {
                1.0
            },
            if self.relight.method.scales() {
                f64::from(self.scaling.scaling.min(60.0)).exp()
            } else {
                1.0
            },
            3.0_f64.powf(self.relight.warping.contrast.abs().into()),
            self.largest_lobes(frame),
            1.0 + ROUNDING,
        ];
        self.arriving() * factors.iter().product::<f64>()
    }

    /// The sum of all intensities. Radiance of at most R from everywhere adds up to 4 pi R / pi.
    fn arriving(&self) -> f64 {
        let brightest = |rgb: [f32; 3]| f64::from(rgb.into_iter().fold(0.0, f32::max));
        let lights = self.light.directional.iter();
        let lights: f64 = lights.map(|light| brightest(light.intensity)).sum();
        let around = self.light.environment.as_ref().map_or(0.0, |map| {
            let rows = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
            let radiances = rows.map(|(x, y)| brightest(map.pixel(x, y)));
            4.0 * radiances.fold(0.0, f64::max)
        });
        lights + around
    }

    /// The maxima of both lobes: 1 each, except for the coat of Ashikhmin and Shirley, whose `n.l / (h.e max(n.l,
    /// n.e))` is at most 1 / h.e, and `h.e >= (n.l + n.e) / 2` since n.h is at most 1.
    fn largest_lobes(&self, frame: &Frame) -> f64 {
        let m = &self.relight.material;
        if m.material != Material::AshikhminShirley {
            return 2.0;
        }
        let covered = frame.mask.plane().samples().iter();
        let facing = frame.normal.z.samples().iter().zip(covered);
        let facing = facing.filter(|&(_, &covered)| covered).map(|(nz, _)| *nz);
        // The kernels limit h.e to at least a millionth.
        let least = f64::from(facing.fold(1.0, f32::min)).max(2e-6);
        let [nu, nv] = m.coat.map(f64::from);
        28.0 / 23.0 + ((nu + 1.0) * (nv + 1.0)).sqrt() / 8.0 * 2.0 / least
    }
}

/// Rounding of single precision over 1e5 lights.
const ROUNDING: f64 = 1e-3;

/// Lights `frame` with the given parameters, and checks the picture against its bound.
pub(super) fn judged(frame: &Frame, asked: &Asked) -> Result<Verdict> {
    let plan = Plan::relight(
        Available::in_frame(frame),
        asked.shape,
        asked.scaling,
        asked.relight,
        LightKinds::in_light(&asked.light),
    )?;
    let outcome = engine::run(&plan, frame, Inputs::lit_by(&asked.light))?;
    let color = outcome.color.as_ref().expect("light makes a picture");
    Ok(held(color, asked.bound(frame)))
}

/// Scales the picture of `frame`, and checks it against its brightest pixel times e^gamma.
pub(super) fn judged_picture(frame: &Frame, warnings: &[String]) -> Result<Verdict> {
    let plan = timing::plan(Goal::Enhance, frame, ShapeParams::default())?;
    let outcome = engine::run(&plan, frame, Inputs::default())?;
    let color = outcome.color.as_ref().expect("enhancing makes a picture");
    let before = frame.color.as_ref().expect("it had a picture");
    let strongest = f64::from(ScalingParams::default().scaling).exp();
    let bound = brightest(before) * strongest * (1.0 + ROUNDING);
    Ok(match (held(color, bound), warnings) {
        (Verdict::Lit { .. }, [_, ..]) => Verdict::WarnedPicture {
            message: warnings.join("; "),
            largest: brightest(color),
            bound,
        },
        (verdict, _) => verdict,
    })
}

fn brightest(color: &ColorPlanes) -> f64 {
    let planes = [&color.r, &color.g, &color.b].map(largest);
    planes
        .into_iter()
        .fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// Verdict on a picture that must be within 0 and `bound`.
fn held(color: &ColorPlanes, bound: f64) -> Verdict {
    let least = |plane: &Plane| plane.samples().iter().copied().fold(0.0, f32::min);
    let darkest = [&color.r, &color.g, &color.b].map(least);
    let darkest = darkest.into_iter().fold(0.0, f32::min);
    let largest = brightest(color);
    // NaN is within no bound.
    if largest <= bound && bound.is_finite() && darkest >= 0.0 {
        Verdict::Lit { largest, bound }
    } else {
        Verdict::Failed {
            what: format!("light is {darkest} to {largest}, which should be 0 to {bound}"),
        }
    }
}
