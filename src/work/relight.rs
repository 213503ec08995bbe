//! `relievo relight`: new light.

use super::{FrameSeen, FrameWork, dark_rims};
use crate::command::args::WorkArgs;
use crate::command::named::{Named, given};
use crate::command::relight_args::{LightNumbers, RelightArgs};
use crate::engine::request::{Request, is_dark};
use crate::error::{Result, bad};
use crate::frame::Frame;
use crate::io::environment::{read_environment_within, read_lit_sphere_within};
use crate::io::inputs::{Inputs, LightInputs, LobeChoice, Wrap};
use crate::io::output::picture::MadePicture;
use crate::io::{Needs, SpecularInputs, picture_size};
use crate::light::environment::Environment;
use crate::light::light_samples::light_disc;
use crate::light::lights::{DirectionalLight, Illumination, LAMP_DEG, PointLight, direction_of};
use crate::light::lit_sphere::LitSphere;
use crate::params::{
    AUTO_SAMPLES, AlbedoSource, Bend, MAX_LIGHTS, Params, Raking, RelightParams, SampleCount,
    Shadows, SpecularParams, in_range,
};
use crate::plan::outcome::Outcome;
use crate::plan::{Available, Goal, Plan};
use glam::Vec3;
use std::path::Path;
use std::sync::Arc;

/// Bytes per pixel of a tile for its repetition, which casts shadows: nine times its area at most. Measured at 4 megapixels
/// beyond the frame: 46 for the sky, 117 for a lamp of 3 degrees.
const AROUND_PER_PIXEL: u64 = 120;

impl FrameWork for RelightArgs {
    fn args(&self) -> &WorkArgs {
        &self.work
    }

    fn args_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn names(&mut self) -> Vec<Named<'_>> {
        let mut all = self.work.names();
        let shown = &mut self.specular;
        let layers = [
            &mut self.surface.albedo,
            &mut shown.mask,
            &mut shown.hit_position,
        ];
        let files = [
            &mut shown.back,
            &mut shown.behind,
            &mut shown.surroundings,
            &mut shown.surroundings_camera,
        ];
        all.extend(given(layers, files));
        let lights = self.light.environment.iter().chain(&self.light.lit_sphere);
        all.extend(lights.map(|path| Named::Shared(path)));
        all
    }

    fn light(&self) -> Option<&RelightArgs> {
        Some(self)
    }

    fn check_specular(&self, inputs: &SpecularInputs) -> Result<()> {
        let material = self.params().material.material;
        if !material.shows_surroundings() {
            let found = "is neither mirror nor glass, and shows nothing of what is around it";
            let remedy =
                "give --material mirror or --material glass, or leave out what it could show";
            return Err(bad("--material", found, remedy));
        }
        if inputs.back.is_some() && !material.is_clear() {
            let found = "are the back faces of a lens, and --material is mirror";
            return Err(bad("--back", found, "give --material glass"));
        }
        if inputs.hit_position.is_some() {
            let found = "tells where strokes lie, and not what light has been bent to";
            let remedy = "leave it out: new light follows the sight lines itself";
            return Err(bad("--hit-position", found, remedy));
        }
        Ok(())
    }

    fn warnings(&self) -> Vec<String> {
        let scaling = Some(self.work.flags.params.scaling);
        let scaling = scaling.filter(|_| self.params().method.scales());
        let rims = scaling.iter().flat_map(dark_rims);
        let idle = self.idle_turns();
        rims.chain(self.past_the_zenith()).chain(idle).collect()
    }

    fn warnings_on(&self, frame: &Frame) -> Vec<String> {
        self.unrisen(frame).chain(self.filled(frame)).collect()
    }

    fn add_lamp(&self, light: &mut Illumination) -> Option<String> {
        if !is_dark(&self.params(), light.kinds()) {
            return None;
        }
        light.directional.push(DirectionalLight::white(LAMP_DEG));
        let [azimuth, elevation] = LAMP_DEG;
        Some(format!(
            "no light is given: --light {azimuth},{elevation}, from the upper left, takes its place"
        ))
    }

    fn reading(&self, light: &Illumination) -> Result<(Inputs, Needs)> {
        Ok((self.inputs(), needs(&self.params(), light)))
    }

    fn takes_whole(&self) -> bool {
        let params = self.params();
        let is_turned = params.method.aligns() || params.raking == Raking::Best;
        is_turned || !self.specular.is_empty()
    }

    fn refuse_too_large(&self, picture: &Path) -> Result<()> {
        let around = self.bytes_around_tile(picture);
        self.work
            .refuse_above(picture, around, "needs the picture whole")
    }

    fn bytes_around_tile(&self, picture: &Path) -> u64 {
        let (params, light) = (self.params(), &self.light);
        let casts = |how, is_asked| how == Shadows::On || how == Shadows::Auto && is_asked;
        let casts = casts(
            params.shadows,
            light
                .light
                .iter()
                .any(|lamp| DirectionalLight::white(lamp.0).is_raking()),
        ) || casts(params.sky_shadows, light.environment.is_some());
        let is_tile = self.work.roles.named.wrap != Wrap::None;
        let size = picture_size(picture).filter(|_| casts && is_tile);
        size.map_or(0, |size| size.pixels.saturating_mul(AROUND_PER_PIXEL))
    }

    fn plans(&self, seen: &mut FrameSeen) -> Result<Vec<Plan>> {
        let params = self.work.flags.params;
        let available = Available {
            specular: seen.is_specular.then(|| self.tracing(&params)),
            ..Available::in_frame(seen.frame).lit_by(&seen.light)
        };
        let request = Request::new(Goal::Relight(self.params()), params);
        Ok(vec![request.plan(available)?])
    }

    fn picture<'a>(&self, frame: &'a Frame, outcome: &'a Outcome) -> Option<MadePicture<'a>> {
        MadePicture::relit(frame, outcome, &self.work.flags.params)
    }
}

impl RelightArgs {
    /// The bend of sight lines: refracted if back faces are named or the material is glass, else mirrored.
    pub(super) fn tracing(&self, params: &Params) -> SpecularParams {
        let material = &params.relight.material;
        let is_glass = self.specular.back.is_some() || material.material.is_clear();
        let bend = match (is_glass, material.thin) {
            (false, _) => Bend::Mirror,
            (true, true) => Bend::Straight,
            (true, false) => Bend::Glass { ior: material.ior },
        };
        SpecularParams {
            bend,
            search: params.search,
        }
    }

    /// Files and layers to read for new light.
    pub(super) fn inputs(&self) -> Inputs {
        let inputs = self.work.inputs();
        let is_computed = self.work.roles.computes_occlusion();
        Inputs {
            albedo: self.surface.albedo.clone(),
            occlusion: is_computed
                .then(|| Inputs::NONE.into())
                .or(inputs.occlusion),
            light: Some(LightInputs {
                lobes: LobeChoice::Off,
                // Of light that comes from all directions.
                occlusion: self.light.environment.is_some() || self.params().material.ambient > 0.0,
                gloss: self.params().albedo == AlbedoSource::Auto
                    && self.light.lit_sphere.is_empty(),
                ..LightInputs::default()
            }),
            ..inputs
        }
    }
}

/// The picture is needed for estimating an albedo, and for the surroundings of the surface.
pub(super) fn needs(params: &RelightParams, illumination: &Illumination) -> Needs {
    let own_color = params.albedo == AlbedoSource::White;
    Needs {
        color: matches!(
            params.albedo,
            AlbedoSource::Estimate | AlbedoSource::Picture
        ),
        color_if_any: true,
        albedo: !own_color && illumination.lit_spheres.is_empty(),
        projection: true,
        strength: true,
        confidence_if_any: true,
        ..Needs::default()
    }
}

/// The light; its images may take their part of the memory limit.
pub(crate) fn illumination(args: &RelightArgs) -> Result<Illumination> {
    Ok(Illumination {
        environment: environment(args)?,
        lit_spheres: lit_spheres(args)?,
        ..lights(args)?
    })
}

/// The environment, if any.
fn environment(args: &RelightArgs) -> Result<Option<Arc<Environment>>> {
    let most = args.work.run.max_memory.for_light();
    let read = |path| read_environment_within(path, most);
    let environment = args.light.environment.as_deref().map(read);
    let turned = |e: Environment| {
        e.rotated_deg(args.work.flags.params.environment_rotate_deg)
            .into()
    };
    Ok(environment.transpose()?.map(turned))
}

/// The lit spheres, if any.
fn lit_spheres(args: &RelightArgs) -> Result<Vec<LitSphere>> {
    let most = args.work.run.max_memory.for_light();
    let spheres = args.light.lit_sphere.iter();
    spheres
        .map(|path| read_lit_sphere_within(path, most))
        .collect()
}

/// The lights given by flags rather than files.
pub(crate) fn lights(args: &RelightArgs) -> Result<Illumination> {
    let flags = &args.light;
    let mut directional: Vec<DirectionalLight> = flags
        .light
        .iter()
        .map(|light| {
            let LightNumbers([azimuth, elevation], _) = *light;
            DirectionalLight {
                to_light: direction_of(azimuth, elevation),
                intensity: light.color(),
            }
        })
        .collect();
    let samples = match args.params().samples {
        SampleCount::Fixed(count) if count > 0 => count,
        _ => AUTO_SAMPLES,
    };
    let count = directional.len() + flags.point_light.len();
    let count = count as u64 + flags.area_light.len() as u64 * u64::from(samples);
    if count > u64::from(MAX_LIGHTS) {
        return Err(bad(
            "--light",
            format!("makes {count} lights"),
            format!("give at most {MAX_LIGHTS} in all"),
        ));
    }
    let mut widths_deg = vec![None; directional.len()];
    for light in &flags.area_light {
        let radius = light.0[2];
        in_range("--area-light", radius, 0.0..=180.0)?;
        directional.extend(area_light(light, samples));
        // Of a disc as large as a sample's share.
        let width = 2.0 * radius / (samples as f32).sqrt();
        widths_deg.resize(directional.len(), Some(width.min(90.0)));
    }
    let points = flags.point_light.iter().map(|light| PointLight {
        position: Vec3::from_array(light.0),
        intensity: light.color(),
    });
    let lights = Illumination {
        points: points.collect(),
        directional,
        widths_deg,
        ..Illumination::default()
    };
    lights.validate()?;
    Ok(lights)
}

/// A disc light as `count` directional lights that together have its brightness.
fn area_light(
    light: &LightNumbers<3>,
    count: u32,
) -> impl Iterator<Item = DirectionalLight> + use<> {
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
