//! `relievo relight`: the layers it needs, its light, and its plan.

use super::output::MadePicture;
use super::relight_args::{LightFlags, Numbers, RelightArgs};
use crate::engine::cpu::strips::StripChoice;
use crate::engine::outcome::Outcome;
use crate::error::{Error, Result};
use crate::frame::{Frame, SpecularScene};
use crate::io::environment::{read_environment_within, read_lit_sphere_within};
use crate::io::inputs::{Inputs, LightInputs, LobeChoice};
use crate::io::{Loaded, Needs, SpecularInputs, load_specular};
use crate::light::environment::Environment;
use crate::light::light_samples::light_disc;
use crate::light::lights::{DirectionalLight, Illumination, LAMP_DEG, PointLight, direction_of};
use crate::light::lit_sphere::LitSphere;
use crate::params::{AUTO_SAMPLES, AlbedoSource, MAX_LIGHTS, RelightParams, Samples, in_range};
use crate::plan::{Available, LightKinds, Plan};
use glam::Vec3;
use std::sync::Arc;

/// The relit picture; it is derived from the frame's own where only a `share` of it is blended in, overall or per
/// pixel.
pub(crate) fn lit<'a>(frame: &'a Frame, outcome: &'a Outcome, share: f32) -> MadePicture<'a> {
    let is_mixed = share != 1.0 || frame.strength.is_some();
    MadePicture {
        color: outcome.color.as_ref().expect("light makes a picture"),
        before: frame.color.as_ref().filter(|_| is_mixed),
        like: frame.color.as_ref().filter(|_| outcome.takes_picture),
    }
}

impl RelightArgs {
    /// The plan for relighting a frame, with choices made on the whole picture if the frame is a strip of it.
    pub(crate) fn plan(
        &self,
        frame: &Frame,
        kinds: LightKinds,
        is_traced: bool,
        found: &StripChoice,
    ) -> Result<Plan> {
        let params = &self.work.flags.params;
        let scaling = found.given(params.scaling);
        let available = Available {
            specular: is_traced.then(|| self.specular.params(params)),
            ..Available::in_frame(frame)
        };
        let mut plan = Plan::relight(available, params.shape, scaling, self.params(), kinds)?;
        if let Some(relighting) = &mut plan.relighting {
            relighting.estimate = found.albedo;
        }
        Ok(plan)
    }

    /// Files and layers to read for relighting a frame.
    pub(crate) fn inputs(&self, frame: Option<i32>) -> Inputs {
        let mut inputs = self.work.inputs(frame);
        inputs.albedo = self.albedo_of_frame(frame);
        inputs.light = Some(LightInputs {
            lobes: LobeChoice::Off,
            occlusion: self.dims_by_occlusion(),
            gloss: self.params().albedo == AlbedoSource::Auto && self.light.lit_sphere.is_empty(),
            ..LightInputs::default()
        });
        inputs
    }
}

/// The scene seen in mirrors and lenses, for materials that are either.
pub(crate) fn specular_scene(
    inputs: &SpecularInputs,
    params: &RelightParams,
    loaded: &mut Loaded,
) -> Result<SpecularScene> {
    let material = params.material.material;
    if !material.shows_surroundings() {
        return Err(Error::BadParameter {
            name: "--material",
            found: "is neither mirror nor glass, and shows nothing of what is around it".into(),
            remedy: "give --material mirror or --material glass, or leave out what it could show"
                .into(),
        });
    }
    if inputs.back.is_some() && !material.is_clear() {
        return Err(Error::BadParameter {
            name: "--back",
            found: "are the back faces of a lens, and --material is mirror".into(),
            remedy: "give --material glass".into(),
        });
    }
    if inputs.hit_position.is_some() {
        return Err(Error::BadParameter {
            name: "--hit-position",
            found: "tells where strokes lie, and not what light has been bent to".into(),
            remedy: "leave it out: new light follows the sight lines itself".into(),
        });
    }
    let mut scene = load_specular(inputs, loaded, None)?;
    scene.fill_from_behind(&mut loaded.frame);
    Ok(scene)
}

/// The picture is needed for estimating an albedo, and for the surroundings of the surface.
pub(crate) fn needs(params: &RelightParams, illumination: &Illumination) -> Needs {
    let own_color = params.albedo == AlbedoSource::White;
    Needs {
        color: matches!(
            params.albedo,
            AlbedoSource::Estimate | AlbedoSource::Picture
        ),
        color_if_any: true,
        albedo: !own_color && illumination.lit_spheres.is_empty(),
        projection: true,
        motion: false,
        strength: true,
        objects: false,
        confidence: false,
        confidence_if_any: true,
    }
}

/// The light; each image it reads may take `most_bytes`.
pub(crate) fn illumination(args: &RelightArgs, most_bytes: u64) -> Result<Illumination> {
    Ok(Illumination {
        environment: environment(args, most_bytes)?,
        lit_spheres: lit_spheres(&args.light, most_bytes)?,
        ..lights(args)?
    })
}

/// The light, with a lamp in place of none, and what is to be said of that.
pub(crate) fn light_or_lamp(
    args: &RelightArgs,
    mut light: Illumination,
) -> (Illumination, Option<String>) {
    if !args.is_dark(&light) {
        return (light, None);
    }
    light.directional.push(DirectionalLight::white(LAMP_DEG));
    let [azimuth, elevation] = LAMP_DEG;
    let said = format!(
        "no light is given: --light {azimuth},{elevation}, from the upper left, takes its place"
    );
    (light, Some(said))
}

/// The environment, if any.
pub(super) fn environment(args: &RelightArgs, most_bytes: u64) -> Result<Option<Arc<Environment>>> {
    let read = |path| read_environment_within(path, most_bytes);
    let environment = args.light.environment.as_deref().map(read);
    let turned = |e: Environment| {
        e.rotated_deg(args.work.flags.params.environment_rotate_deg)
            .into()
    };
    Ok(environment.transpose()?.map(turned))
}

/// The lit spheres, if any.
pub(super) fn lit_spheres(flags: &LightFlags, most_bytes: u64) -> Result<Vec<LitSphere>> {
    let spheres = flags.lit_sphere.iter();
    spheres
        .map(|path| read_lit_sphere_within(path, most_bytes))
        .collect()
}

/// The lights given by flags rather than files.
pub(super) fn lights(args: &RelightArgs) -> Result<Illumination> {
    let flags = &args.light;
    let mut directional: Vec<DirectionalLight> = flags
        .light
        .iter()
        .map(|light| {
            let Numbers([azimuth, elevation], _) = *light;
            DirectionalLight {
                to_light: direction_of(azimuth, elevation),
                intensity: light.color(),
            }
        })
        .collect();
    let samples = match args.params().samples {
        Samples::Fixed(count) if count > 0 => count,
        _ => AUTO_SAMPLES,
    };
    let count = directional.len() + flags.point_light.len();
    let count = count as u64 + flags.area_light.len() as u64 * u64::from(samples);
    if count > u64::from(MAX_LIGHTS) {
        return Err(Error::BadParameter {
            name: "--light",
            found: format!("makes {count} lights"),
            remedy: format!("give at most {MAX_LIGHTS} in all"),
        });
    }
    for light in &flags.area_light {
        in_range("--area-light", light.0[2], 0.0..=180.0)?;
        directional.extend(area_light(light, samples));
    }
    let points = flags.point_light.iter().map(|light| PointLight {
        position: Vec3::from_array(light.0),
        intensity: light.color(),
    });
    let lights = Illumination {
        points: points.collect(),
        directional,
        ..Illumination::default()
    };
    lights.validate()?;
    Ok(lights)
}

/// A disc light as `count` directional lights that together have its brightness.
fn area_light(light: &Numbers<3>, count: u32) -> impl Iterator<Item = DirectionalLight> + use<> {
    let [azimuth, elevation, radius] = light.0;
    let center = direction_of(azimuth, elevation);
    let intensity = light.color().map(|channel| channel / count as f32);
    let directions = light_disc(center, radius.to_radians(), count as usize);
    directions
        .into_iter()
        .map(move |to_light| DirectionalLight {
            to_light,
            intensity,
        })
}
