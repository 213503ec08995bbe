//! Conclusions and warnings gathered while a frame is loaded.

use super::frame_sources::FrameSources;
use super::opened::Opened;
use super::sources::WhyChosen;
use crate::error::Result;
use crate::frame::objects::Objects;
use crate::frame::{Frame, Mask, Plane, Vector3Planes, noise_left};
use crate::io::finding::{Finding, Notes};
use crate::io::inputs::{Inputs, NormalEncoding};
use crate::io::judge::normal_encoding::{judge_encoding, refuse_light, refuse_pictures};
use crate::io::roles::Role;
use crate::untrusted::{Untrusted, listed, shown};
use std::rc::Rc;

/// Why a layer was chosen, and the others that could have been.
fn evidence(WhyChosen { why, others }: &WhyChosen) -> String {
    match others.is_empty() {
        true => why.clone(),
        false => format!("{why}; or {}", listed(others)),
    }
}

/// Up to this share of samples of depth that were missing is not worth a word, percent.
const FEW_HOLES_PERCENT: f64 = 0.1;

/// From this share of a surface at depth steps on, the steps are not outlines of objects.
const MANY_STEPS: f64 = 0.15;

/// Neighbours whose depths differ by a larger factor lie on two surfaces.
const STEP: f32 = 1.1;

/// Pixels at which steps are looked for, about.
const WANTED: usize = 10_000;

/// The share of covered pixels at which depth steps to the next one to the right or below.
fn share_at_steps(depth: &Plane, mask: &Mask) -> f64 {
    let is_step = |a: f32, b: f32| a > STEP * b || b > STEP * a;
    let (mut count, mut steps) = (0_usize, 0_usize);
    for (x, y) in mask.sample(WANTED) {
        let steps_to =
            |x: usize, y: usize, here: f32| mask.has(x, y) && is_step(here, depth.at(x, y));
        let here = depth.at(x, y);
        count += 1;
        steps += usize::from(steps_to(x + 1, y, here) || steps_to(x, y + 1, here));
    }
    steps as f64 / count.max(1) as f64
}

impl Notes {
    pub(crate) fn about(sources: &FrameSources, main: &Rc<Opened>) -> Self {
        let findings = sources
            .roles
            .iter()
            // Which layer is motion is judged from two frames.
            .filter(|source| source.role != Role::Motion)
            .map(|source| Finding {
                subject: source.role.name(),
                conclusion: source.label().into(),
                evidence: match &source.chosen {
                    Some(chosen) => evidence(chosen),
                    None => format!("from {}", source.file.path().display()),
                },
                flag: source.flag(),
            })
            .collect();
        let data = [Role::Normal, Role::Depth, Role::Position];
        let lossy = data.into_iter().filter_map(|role| {
            let channels = sources.get(role)?.lossy_channels();
            let lossy = channels.join(", ");
            (!channels.is_empty()).then(|| {
                format!("{lossy} was stored with a lossy compression: expect noise in curvature")
            })
        });
        let mut warnings: Vec<_> = main.groups.note.iter().cloned().collect();
        let files = sources.roles.iter().map(|source| &source.file);
        for file in files.filter(|file| !Rc::ptr_eq(file, main)) {
            let note = file.groups.note.iter();
            warnings.extend(note.map(|note| format!("{}: {note}", shown(file.path()))));
        }
        warnings.dedup();
        warnings.extend(lossy);
        let colors = sources.roles.iter().filter(|source| source.role.is_color());
        warnings.extend(colors.filter_map(|source| {
            let (bits, role) = (source.file.bits_of_floats()?, source.role.name());
            Some(format!(
                "{role}: its whole numbers are taken for codes of {bits} bits, in sRGB unless --colorspace says otherwise"
            ))
        }));
        Self { findings, warnings }
    }

    pub(crate) fn on_coverage(&mut self, mask: &Mask) {
        if mask.count() == 0 {
            self.warnings
                .push("no pixel shows a surface: nothing to do".into());
        }
    }

    /// Warns if normals have noise that would be taken for relief.
    pub(super) fn on_noise(&mut self, normal: &Vector3Planes, mask: &Mask) {
        if let Some(noise) = noise_left(normal, mask) {
            self.warnings.push(format!(
                "normals have noise of {noise:.3} in their slopes, which is taken for relief: compare --scale 8, or denoise them first"
            ));
        }
    }

    /// Reports the number of filled depth samples.
    pub(crate) fn on_filled(&mut self, filled: usize, mask: &Mask) {
        let share = 100.0 * filled as f64 / mask.count().max(1) as f64;
        if share > FEW_HOLES_PERCENT {
            self.warnings.push(format!(
                "depth lacked {filled} samples inside surfaces ({share:.1} %), as fog or glass leaves it: they are filled"
            ));
        }
    }

    /// Warns if so much of a surface is at depth steps that little of it is left.
    pub(crate) fn on_steps(&mut self, frame: &Frame) {
        let Some(depth) = &frame.depth else {
            return;
        };
        let share = share_at_steps(depth, &frame.mask);
        if share > MANY_STEPS {
            self.warnings.push(format!(
                "{:.0} % of the surface lies at steps of depth, and is taken for silhouettes: try --depth none",
                100.0 * share
            ));
        }
    }

    /// Warns if the chosen objects are not in the picture.
    pub(crate) fn on_strength(&mut self, strength: &Plane, is_part: bool) {
        if !is_part && strength.samples().iter().all(|&share| share == 0.0) {
            self.warnings
                .push("nothing of what is chosen is in the picture: it stays as it is".into());
        }
    }

    /// The objects that were found, for lines between them, and what is said of them.
    pub(crate) fn objects(&mut self, found: Result<Option<(String, Objects)>>) -> Option<Plane> {
        const LEFT_OUT: &str = "no lines are drawn between objects";
        match found {
            Ok(None | Some((_, Objects::Alike))) => None,
            Ok(Some((layer, Objects::Apart(count, numbers)))) => {
                self.findings.push(Finding {
                    subject: "objects".into(),
                    conclusion: format!("{count}, with lines between those that touch"),
                    evidence: format!("by {}", Untrusted(&layer)),
                    flag: "--object-lines auto".into(),
                });
                Some(numbers)
            }
            Ok(Some((layer, Objects::Mesh))) => {
                self.warnings.push(format!(
                    "{}: its objects are so small that lines would fill the picture: {LEFT_OUT}, as by --object-lines off",
                    Untrusted(&layer)
                ));
                None
            }
            Err(error) => {
                self.warnings.push(format!("{error}: {LEFT_OUT}"));
                None
            }
        }
    }

    /// The encoding of `stored` normals, judged where the `alphas` of map and picture cover them.
    pub(crate) fn encoding(
        &mut self,
        inputs: &Inputs,
        sources: &FrameSources,
        stored: &Vector3Planes,
        alphas: [Option<&Plane>; 2],
    ) -> Result<NormalEncoding> {
        let source = &sources.roles[0];
        let integers = source.holds_codes();
        let known = source.encoding();
        if integers && known.is_none() && inputs.rows.is_none() {
            let is_named = source.chosen.is_none();
            let length = refuse_pictures(stored, alphas, is_named, source.file.path())?;
            self.warnings.extend(length.map(|length| {
                format!("normals: their vectors are {length:.2} long, and are brought to length 1")
            }));
        }
        if !integers && known.is_none() && inputs.rows.is_none() {
            refuse_light(stored, source.file.path())?;
        }
        self.warnings.extend(source.mistake().map(|mistake| {
            format!(
                "normals: {}; --normal-encoding unsigned takes them as they are",
                mistake.said()
            )
        }));
        if let (true, None, Some((_, why))) = (integers, inputs.normal_encoding, known) {
            self.warnings.push(format!(
                "normals: {why}: z is rebuilt from x and y; --normal-encoding unsigned takes all three as they are"
            ));
        }
        let (encoding, evidence) = match known {
            Some(known) => known,
            None if integers => (NormalEncoding::Unsigned, "stored as integers"),
            None => (judge_encoding(stored), "from lengths and signs"),
        };
        let (conclusion, name) = match encoding {
            NormalEncoding::Signed => ("signed, -1..1", "signed"),
            NormalEncoding::Unsigned => ("unsigned, 0..1", "unsigned"),
            NormalEncoding::Xy => ("x and y, z rebuilt", "xy"),
            NormalEncoding::Ag => ("x in alpha and y in green, z rebuilt", "ag"),
            NormalEncoding::Oct => ("octahedral", "oct"),
        };
        self.findings.push(Finding {
            subject: "normal encoding".into(),
            conclusion: conclusion.into(),
            evidence: evidence.into(),
            flag: format!("--normal-encoding {name}"),
        });
        Ok(encoding)
    }
}
