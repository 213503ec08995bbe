//! Relit pictures and drawings of a device compared with the CPU: errors and times.
//!
//! Relighting has a reference in double precision ([`super::light_reference`]), which starts from the CPU's Hessian and
//! gain. Drawings have none: the device's drawing is compared with the CPU's.

use super::compare::{Errors, Tally, compare_where};
use super::engine::{Inputs, Outcome, Session, hatch_plan, relight_plan};
use super::gpu::{Gpu, GpuTimed, lamp, with_picture};
use super::light::lit::{bare, off, some_covered, white};
use super::light_reference::lit_at;
use super::scenes::environment;
use super::timing::{Effort, Times};
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::light::light_samples::uniform_lights;
use crate::light::lights::Illumination;
use crate::params::{
    AUTO_SAMPLES, LineParams, Material, Method, RelightParams, ShapeParams, Style, WarpBy,
};
use crate::plan::{Available, Plan};
use serde::Serialize;

/// Maximum number of pixels at which relit pictures are compared.
pub(super) const COMPARED: usize = 4096;

/// The reference of errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Reference {
    /// Double precision.
    DoublePrecision,
    /// The result of the CPU.
    Cpu,
}

/// A picture from the CPU.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct OnCpu {
    /// Its errors; `None` if it is the reference.
    pub errors: Option<Errors>,
    pub whole: Times,
}

/// A picture from a device.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct OnGpu {
    pub errors: Errors,
    /// Times of copies, kernels and the total.
    #[serde(flatten)]
    pub timed: GpuTimed,
}

/// A picture from both.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct PictureRow {
    /// The picture in words.
    pub picture: String,
    /// The reference of errors. Errors of relit pictures are of the worst channel, relative to the reference's 98th
    /// percentile of luminance; errors of drawings are of ink, 0..1.
    pub reference: Reference,
    pub on_cpu: OnCpu,
    pub on_gpu: OnGpu,
}

/// Relit pictures and drawings of `frame`, with its shape found by `shape`; without those that failed on the device.
pub(super) fn rows(
    gpu: &Gpu,
    frame: &Frame,
    shape: ShapeParams,
    effort: Effort,
) -> Result<Vec<PictureRow>> {
    let bench = BothBackends { gpu, shape, effort };
    // The reference is for white, opaque surfaces.
    let white = Frame {
        color: None,
        albedo: None,
        alpha: None,
        importance: None,
        ..frame.clone()
    };
    let lights = AUTO_SAMPLES as usize;
    let room = Illumination {
        directional: uniform_lights(&environment(), lights),
        ..Illumination::default()
    };
    let rows = [
        bench.relit("one lamp, scaled".into(), &white, Method::Scale, &lamp())?,
        bench.relit(
            format!("{lights} lights, warped"),
            &white,
            Method::Warp,
            &room,
        )?,
        bench.hatched(&with_picture(frame))?,
    ];
    Ok(rows.into_iter().flatten().collect())
}

struct BothBackends<'a> {
    gpu: &'a Gpu<'a>,
    shape: ShapeParams,
    effort: Effort,
}

impl BothBackends<'_> {
    /// A glossy surface under directional lights.
    fn relit(
        &self,
        picture: String,
        frame: &Frame,
        method: Method,
        light: &Illumination,
    ) -> Result<Option<PictureRow>> {
        let params = RelightParams {
            warp_by: WarpBy::Lights,
            ..bare(Material::BlinnPhong, method)
        };
        let plan = relight_plan(frame, self.shape, params, light)?;
        let session = Session::default();
        let (expected, on_cpu) = session.measure(&plan, frame, Inputs::lit_by(light), self.effort);
        let exact = lit_at(
            some_covered(&frame.mask, COMPARED),
            frame,
            self.shape,
            &params,
            expected.gain.unwrap_or(0.0),
            &light.directional,
        )?;
        let errors = |outcome: &Outcome| {
            let color = outcome.color.as_ref().expect("light makes a picture");
            errors_of_light(color, &exact).in_window(frame.data_window)
        };
        let on_gpu = self.on_gpu(&plan, frame, light, errors);
        Ok(on_gpu.map(|on_gpu| PictureRow {
            picture,
            reference: Reference::DoublePrecision,
            on_cpu: OnCpu {
                errors: Some(errors(&expected)),
                whole: on_cpu.whole,
            },
            on_gpu,
        }))
    }

    /// Hatching and contours in pen.
    fn hatched(&self, frame: &Frame) -> Result<Option<PictureRow>> {
        let mut line = LineParams::default();
        line.strokes.style = Style::Pen;
        let plan = hatch_plan(Available::in_frame(frame), self.shape, line)?;
        let inputs = Inputs::default();
        let (expected, on_cpu) = Session::default().measure(&plan, frame, inputs, self.effort);
        let expected = ink(&expected).map(|plane| plane.map(f64::from));
        let errors = |outcome: &Outcome| {
            let exact = expected.each_ref();
            // Contours also lie outside the mask.
            compare_where(ink(outcome), exact, 1.0, |_, _| true).in_window(frame.data_window)
        };
        let on_gpu = self.on_gpu(&plan, frame, &Illumination::default(), errors);
        Ok(on_gpu.map(|on_gpu| PictureRow {
            picture: "hatching with contours, pen".into(),
            reference: Reference::Cpu,
            on_cpu: OnCpu {
                errors: None,
                whole: on_cpu.whole,
            },
            on_gpu,
        }))
    }

    fn on_gpu(
        &self,
        plan: &Plan,
        frame: &Frame,
        light: &Illumination,
        errors: impl Fn(&Outcome) -> Errors,
    ) -> Option<OnGpu> {
        let outcome = self.gpu.run(plan, frame, light)?;
        let timed = self.gpu.measure(plan, frame, light, self.effort)?;
        Some(OnGpu {
            errors: errors(&outcome),
            timed,
        })
    }
}

fn errors_of_light(color: &ColorPlanes, exact: &[([usize; 2], [f64; 3])]) -> Errors {
    let white = white(exact.iter().map(|(_, color)| *color));
    let mut tally = Tally::default();
    for (at, exact) in exact {
        tally.add(*at, off(color, *at, *exact) / white);
    }
    tally.errors()
}

/// Strokes and contours.
fn ink(outcome: &Outcome) -> [&Plane; 2] {
    let drawing = outcome.drawing.as_ref().expect("it is drawn");
    let contours = drawing.contours.as_ref();
    [&drawing.hatching, contours.expect("with contours")]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::scenes::Scene;

    fn on_cpu(plan: &Plan, frame: &Frame, light: &Illumination) -> Outcome {
        Session::default().run(plan, frame, Inputs::lit_by(light))
    }

    fn rows_of(off: f32) -> Vec<PictureRow> {
        let run = |plan: &Plan, frame: &Frame, light: &Illumination| {
            let mut outcome = on_cpu(plan, frame, light);
            if let Some(color) = &mut outcome.color {
                color.g = color.g.map(|g| g + off);
            }
            if let Some(drawing) = &mut outcome.drawing {
                drawing.hatching.row_mut(7)[9] += off;
            }
            Ok(outcome)
        };
        let gpu = Gpu::new("test".into(), true, true, &run);
        let frame = Scene::waves(60, 50).frame;
        rows(&gpu, &frame, ShapeParams::default(), Effort::new(2, 1)).unwrap()
    }

    #[test]
    fn light_is_held_against_double_precision_and_ink_against_the_cpu() {
        let same = rows_of(0.0);
        assert_eq!(same.len(), 3);
        for row in &same[..2] {
            let errors = row.on_cpu.errors.unwrap();
            assert_eq!(row.reference, Reference::DoublePrecision);
            assert_eq!(row.on_gpu.errors, errors);
            // Pixels lit at grazing angles have no reference.
            assert!((2990..=3000).contains(&errors.pixels), "{errors:?}");
            // Single precision, for a lobe with exponent 32: 32 roundings of 2^-23.
            assert!(errors.max > 0.0 && errors.max < 4e-6, "{errors:?}");
        }
        assert_eq!(same[2].reference, Reference::Cpu);
        assert!(same[2].on_cpu.errors.is_none());
        assert_eq!(same[2].on_gpu.errors.max, 0.0);
        let off = rows_of(0.25);
        for (off, same) in off.iter().zip(&same).take(2) {
            // All of green is off by a quarter, relative to white; the CPU's errors are unchanged.
            let errors = off.on_gpu.errors;
            assert!(
                errors.mean > 0.9 * errors.max && errors.max > 0.1,
                "{errors:?}"
            );
            assert_eq!(off.on_cpu.errors, same.on_cpu.errors);
        }
        let ink = off[2].on_gpu.errors;
        assert_eq!((ink.max, ink.worst), (0.25, Some([9, 7])));
    }
}
