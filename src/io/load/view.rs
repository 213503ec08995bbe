//! The turn to view space: which space the normals were in, and why.

use super::sources::RoleSource;
use crate::error::{Error, Result};
use crate::frame::normals;
use crate::frame::{Camera, Mask, NormalSpace, Vector3Planes};
use crate::io::camera::{CAMERA, CameraSearch, FoundCamera};
use crate::io::finding::{Finding, Notes};
use crate::io::inputs::{Flip, Inputs};
use crate::io::judge::axes;
use crate::io::judge::map_writers::MapWriter;
use crate::io::judge::sight_turned::{self, BY_SIGHT};
use crate::io::judge::surface::SurfaceSamples;
use crate::io::normal_space::{
    NormalReading, NormalSamples, NormalSpaceConclusion, NormalSpaceConclusion::Certain,
    NormalSpaceEvidence, NormalSpaceVerdict,
};
use crate::io::roles::names::Hint;
use glam::{DMat3, DVec3};

/// Share of normals that face the viewer in any space but one that is turned to the sight lines.
const FACE: f64 = 0.98;
/// Normals read as view space whose lean is off the slope of depth by more than this, in degrees, could be
/// turned a little: a world with y up, seen from slightly above, leans nearly as a view does.
const STRAIGHT_DEG: f64 = 4.0;
/// A turn by less than this, in degrees, is none.
const LEAST_TURN_DEG: f64 = 1.5;
/// A turn counts from this many standard errors on, and if it leaves less than this share of the angle.
const TURN_ERRORS: f64 = 3.0;
const TURN_LEAVES: f64 = 0.5;

/// The camera, where one was found, and what was concluded.
pub(crate) struct FoundView {
    pub(crate) camera: Option<Camera>,
    /// Whether it is known where in the world the camera stands, and not only how it is turned.
    pub(crate) is_placed: bool,
    /// Whether the camera was recovered from layers, rather than given.
    pub(crate) is_recovered: bool,
    /// How the stored normals were read.
    pub(crate) normals: NormalReading,
}

impl FoundView {
    /// That of a frame without normals: the camera that a file, attributes or positions tell.
    pub(crate) fn of_camera(
        inputs: &Inputs,
        surface: &SurfaceSamples,
        notes: &mut Notes,
    ) -> Result<Self> {
        let none = Vector3Planes::from_fn(0, 0, |_, _| DVec3::ZERO);
        let mask = Mask::full(0, 0);
        let mut search = CameraSearch::new(inputs, surface);
        let camera = search.placed(&NormalSamples::new(&none, &mask, None, None))?;
        notes.findings.append(&mut search.findings);
        Ok(Self {
            is_placed: camera.is_some(),
            is_recovered: search.has_recovered,
            camera: camera.or(inputs.known_camera.map(|known| known.camera)),
            normals: NormalReading::VIEW,
        })
    }
}

/// Turns unit normals to view space, in place. A camera is looked for where it is needed: to turn
/// normals, to know their space, or because the projection is asked for.
pub(crate) fn turn_to_view(
    inputs: &Inputs,
    surface: &SurfaceSamples,
    projection: bool,
    source: &RoleSource,
    normal: &mut Vector3Planes,
    notes: &mut Notes,
) -> Result<FoundView> {
    let samples = NormalSamples::new(normal, surface.mask, surface.position, surface.depth);
    let mut search = CameraSearch::new(inputs, surface);
    let is_needed = projection || inputs.camera.is_some();
    let mut camera = match is_needed {
        true => search.placed(&samples)?,
        false => None,
    };
    let mut reading = Reading::of(inputs, surface, &samples, camera.as_ref());
    if !is_needed && !reading.is_view() {
        // Only now is a camera worth looking for.
        camera = search.placed(&samples)?;
        if camera.is_some() {
            reading = Reading::of(inputs, surface, &samples, camera.as_ref());
        }
    }
    let is_placed = camera.is_some();
    if camera.is_none() && (is_needed || !reading.is_view() || reading.could_be_turned()) {
        let judge = |camera: &Camera| Reading::of(inputs, surface, &samples, Some(camera));
        (camera, reading) = aided_by_depth(&mut search, reading, normal, judge);
        camera = camera.filter(|_| is_needed || !reading.is_view());
    }
    let warnings = &mut notes.warnings;
    if reading.take(&source.hint()) && surface.attributes.is_none() && surface.mask.count() > 0 {
        warnings.push(format!("normals: {}", reading.verdict.reason));
    }
    reading.try_sight(inputs, surface, camera.as_ref(), normal);
    let is_recovered = search.has_recovered;
    let doubt = search.doubt.filter(|_| camera.is_some());
    let findings = search.findings;
    let mut normals = reading.settled(inputs, surface, &findings)?;
    if normals.space != NormalSpace::View && camera.is_none() {
        return Err(no_camera(
            inputs,
            normals.space,
            &reading.verdict.reason,
            &findings,
        ));
    }
    warnings.extend(
        doubt.map(|doubt| format!("the camera is a guess: {doubt}; compare with --camera FILE")),
    );
    if reading.leaves_axes_open(normals, inputs) && surface.mask.count() > 0 {
        let settled = axes::settle(
            normal,
            surface.mask,
            MapWriter::of(source.file.path()).as_ref(),
            source.is_exr() && source.hint() != Default::default(),
        );
        normals.flip.x |= settled.flip.x;
        normals.flip.y |= settled.flip.y;
        let reason = &mut reading.verdict.reason;
        *reason = format!("{reason}; {}", settled.reason);
        warnings.extend(settled.warning);
    }
    notes.findings.extend(findings);
    notes.findings.push(reading.finding(normals, inputs));
    normals::flip_axes(normal, normals.flip);
    if let Some(camera) = &camera {
        normals::turn_to_view(normal, normals.space, camera, surface.data_window);
    }
    Ok(FoundView {
        is_placed,
        is_recovered,
        camera,
        normals,
    })
}

/// The camera recovered from depth, and how the normals read with it: `judge` reads them by a camera.
fn aided_by_depth(
    search: &mut CameraSearch,
    mut unaided: Reading,
    normal: &Vector3Planes,
    judge: impl Fn(&Camera) -> Reading,
) -> (Option<Camera>, Reading) {
    let flip = unaided.certain().filter(|n| n.space == NormalSpace::View);
    if let Some(NormalReading { flip, .. }) = flip {
        let turned = (flip != Flip::NONE).then(|| {
            let mut turned = normal.clone();
            normals::flip_axes(&mut turned, flip);
            turned
        });
        let found = search.by_depth(turned.as_ref().unwrap_or(normal));
        let is_turned = found.as_ref().is_some_and(|found| unaided.is_turned(found));
        if !is_turned {
            search.report(found.as_ref());
            return (found.map(|found| found.camera), unaided);
        }
    }
    let found = search.by_depth(normal);
    search.report(found.as_ref());
    let camera = found.map(|found| found.camera);
    let reading = match &camera {
        None => unaided,
        Some(_) if unaided.is_given => unaided,
        Some(camera) if flip.is_some() => {
            let reason = format!(
                "world: turned by {:.1} degrees, the normals follow the slopes of depth",
                turn_deg(camera.view_from_world.matrix3)
            );
            unaided.read(NormalReading::WORLD, reason);
            unaided
        }
        Some(camera) => judge(camera),
    };
    (camera, reading)
}

/// Angle of a turn, in degrees; of a mirrored one 180.
fn turn_deg(turn: DMat3) -> f64 {
    let trace = turn.x_axis.x + turn.y_axis.y + turn.z_axis.z;
    match turn.determinant() > 0.0 {
        true => (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos().to_degrees(),
        false => 180.0,
    }
}

/// Knowledge so far on how to read the stored normals.
#[derive(Clone)]
struct Reading {
    verdict: NormalSpaceVerdict,
    is_given: bool,
}

impl Reading {
    /// The reading that was asked for, else the one that the data show.
    fn of(
        inputs: &Inputs,
        surface: &SurfaceSamples,
        samples: &NormalSamples,
        camera: Option<&Camera>,
    ) -> Self {
        if let Some(space) = inputs.normal_space {
            let verdict = NormalSpaceVerdict {
                conclusion: Certain(NormalReading::of(space)),
                evidence: NormalSpaceEvidence::default(),
                reason: "as given".into(),
            };
            return Self {
                verdict,
                is_given: true,
            };
        }
        let mut verdict = samples.judge(camera, surface.data_window);
        if let Certain(reading) = &mut verdict.conclusion
            && inputs.normal_flip.is_some()
        {
            // Where axes were given, only z is still flipped toward the viewer.
            (reading.flip.x, reading.flip.y) = (false, false);
        }
        Self {
            verdict,
            is_given: false,
        }
    }

    fn certain(&self) -> Option<NormalReading> {
        match self.verdict.conclusion {
            Certain(reading) => Some(reading),
            _ => None,
        }
    }

    /// Takes a reading, for this reason.
    fn read(&mut self, reading: NormalReading, reason: String) {
        self.verdict.conclusion = Certain(reading);
        self.verdict.reason = reason;
    }

    fn is_view(&self) -> bool {
        self.certain().is_some_and(|n| n.space == NormalSpace::View)
    }

    /// Whether the normals lean near enough to the slope of depth for view space, but not quite along it.
    fn could_be_turned(&self) -> bool {
        let slope = self.verdict.evidence.view.slope_deg;
        !self.is_given && slope.is_some_and(|deg| deg > STRAIGHT_DEG)
    }

    /// Whether the camera found from depth and normals, taken for view space, is turned after all.
    fn is_turned(&self, found: &FoundCamera) -> bool {
        let turn = turn_deg(found.camera.view_from_world.matrix3);
        let slope = self.verdict.evidence.view.slope_deg;
        let (Some(found), Some(slope)) = (found.by_depth, slope) else {
            return false;
        };
        self.could_be_turned()
            && turn > LEAST_TURN_DEG.max(TURN_ERRORS * found.rotation_uncertainty_deg)
            && found.residual_deg_median < TURN_LEAVES * slope
    }

    /// Takes the reading implied by a name or the renderer, if the data leave it open; whether they did.
    fn take(&mut self, (hint, by): &(Hint, String)) -> bool {
        let open = self.verdict.conclusion == NormalSpaceConclusion::Ambiguous;
        let Some(space) = hint.space.filter(|_| open) else {
            return false;
        };
        let evidence = &self.verdict.evidence;
        let is_flipped = evidence.flipped.facing > evidence.view.facing;
        let reading = match space {
            NormalSpace::View if is_flipped => NormalReading::FLIPPED,
            space => NormalReading::of(space),
        };
        self.read(reading, format!("{by}; {}", self.verdict.reason));
        true
    }

    /// Reads normals as V-Ray writes them where too many are averted otherwise, and surfaces then hang together.
    fn try_sight(
        &mut self,
        inputs: &Inputs,
        surface: &SurfaceSamples,
        camera: Option<&Camera>,
        normal: &Vector3Planes,
    ) {
        let e = &self.verdict.evidence;
        let facing = e.facing_view().max(e.world.facing);
        let is_judged = self.is_given || inputs.normal_flip.is_some() || e.is_judged_by_depth();
        let Some(camera) = camera.filter(|_| !is_judged && facing < FACE) else {
            return;
        };
        let now = self.certain().unwrap_or(NormalReading::WORLD);
        let stored = |x: usize, y: usize| normal.at(x, y);
        let Some([by_sight, other]) = sight_turned::shows(surface, camera, stored, now) else {
            return;
        };
        let reason = format!(
            "turned to the sight lines with x to the left, as V-Ray writes them: the slopes then have a curl of \
             {by_sight:.2}, otherwise {other:.2}; {}",
            self.verdict.reason
        );
        self.read(BY_SIGHT, reason);
    }

    /// The reading, or why there is none.
    fn settled(
        &self,
        inputs: &Inputs,
        surface: &SurfaceSamples,
        findings: &[Finding],
    ) -> Result<NormalReading> {
        let reason = &self.verdict.reason;
        match self.verdict.conclusion {
            Certain(reading) => Ok(reading),
            NormalSpaceConclusion::WorldWithoutCamera => {
                Err(no_camera(inputs, NormalSpace::World, reason, findings))
            }
            // An empty mask has no normals to be read either way.
            NormalSpaceConclusion::Ambiguous if surface.mask.count() == 0 => {
                Ok(NormalReading::VIEW)
            }
            NormalSpaceConclusion::Ambiguous => Err(Error::Undetermined {
                path: inputs.picture.clone(),
                found: format!("the space of the normals is unclear ({reason})"),
                remedy: "name it with --normal-space view or --normal-space world".into(),
            }),
        }
    }

    /// Whether neither flags nor depth nor positions show which way x and y point, or noisy depth shows that not as they are.
    fn leaves_axes_open(&self, normals: NormalReading, inputs: &Inputs) -> bool {
        let evidence = &self.verdict.evidence;
        let is_turned = normals.flip.x | normals.flip.y;
        let is_contradicted = evidence.is_contradicted_by_depth() && !is_turned;
        normals.space == NormalSpace::View
            && inputs.normal_flip.is_none()
            && (!evidence.is_judged_by_depth() || is_contradicted)
            && !self.is_given
    }

    /// The finding on it.
    fn finding(&self, normals: NormalReading, inputs: &Inputs) -> Finding {
        let name = normals.space.name();
        let flip = inputs.normal_flip.unwrap_or_default().and(normals.flip);
        let (conclusion, flag) = match flip {
            Flip::NONE => (name.into(), format!("--normal-space {name}")),
            axes => (
                format!("{name}, {axes} reversed"),
                format!("--normal-space {name} --normal-flip {axes}"),
            ),
        };
        Finding {
            subject: "normal space".into(),
            conclusion,
            evidence: self.verdict.reason.clone(),
            flag,
        }
    }
}

/// Normals that no camera can turn; says what was tried to find a camera.
fn no_camera(inputs: &Inputs, space: NormalSpace, reason: &str, findings: &[Finding]) -> Error {
    let tried: Vec<_> = findings
        .iter()
        .filter(|f| f.subject == CAMERA)
        .map(|f| format!("; {}", f.evidence))
        .collect();
    Error::Undetermined {
        path: inputs.picture.clone(),
        found: format!(
            "normals in {} space, and no camera ({reason}{})",
            space.name(),
            tried.concat()
        ),
        remedy: "give --camera FILE, or --normal-space view if they are not".into(),
    }
}
