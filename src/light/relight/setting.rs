//! Requirements of relighting: lights to sum, look-ups, and the shape they need.

use crate::error::{Result, bad};
use crate::light::albedo::AlbedoEstimate;
use crate::light::intensity::White;
use crate::light::lights::LightKinds;
use crate::light::shadows::casting::{Caster, Casters, Casting};
use crate::params::{
    AUTO_SAMPLES, AlbedoSource, Magnitude, Material, Raking, RelightParams, SampleCount,
    ScalingParams, Tangent, WarpBy,
};
use crate::plan::{Available, Plan};

/// Use of an environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum EnvironmentUse {
    /// No environment, or not needed.
    None,
    /// As this many lights, placed where most of its light is.
    Lights(u32),
    /// As what it takes to err by so many grey levels.
    ToError(ToError),
    /// Looked up in this many even directions.
    Lookups(u32),
    /// Prefiltered, with one look-up per lobe.
    Prefiltered,
    /// Looked up in the mirrored or refracted direction.
    Mirrored,
}

/// The error allowed in light from an environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ToError {
    /// Grey levels of 255.
    pub(crate) levels: f32,
    /// Whether each light is warped or scaled by itself, so that no map has their sum.
    pub(crate) apart: bool,
    /// Whether highlights are looked up in directions of each pixel's own.
    pub(crate) glossy: bool,
    /// Strength of light warping, 0 for none.
    pub(crate) warp: f32,
}

/// Source of the albedo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Albedo {
    /// A layer or file.
    Layer,
    /// The picture divided by the best-fitting shading.
    Estimate,
    /// The picture unchanged.
    Picture,
    /// White.
    White,
}

/// Relighting of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Relighting {
    /// The parameters given. Ambient light is off for mirrors, glass and lit spheres, which show all light already.
    pub params: RelightParams,
    /// Whether directions are warped, with a strength other than 0.
    pub warps: bool,
    /// Whether directions are turned to the form, with a strength other than 0.
    pub aligns: bool,
    /// Whether the grain of an occlusion layer is taken off light from all around.
    pub(crate) grainy_occlusion: bool,
    /// Whether lamps are turned about the view axis, region by region.
    pub rakes: bool,
    /// Whether reflected light is scaled, with a magnitude other than 0.
    pub scales: bool,
    /// Whether concavities and convexities differ in contrast.
    pub contrasts: bool,
    /// Whether the mapping of curvature depends on the direction of light.
    pub toward_light: bool,
    /// Whether the grain follows the curvature.
    pub grain: bool,
    /// Whether single lights are summed.
    pub sums: bool,
    /// Whether lights are near the surface.
    pub near: bool,
    /// Use of the environment.
    pub environment: EnvironmentUse,
    /// Number of lit spheres.
    pub lit_spheres: u8,
    /// Whether mirrors and lenses show their traced surroundings.
    pub traced: bool,
    /// The luminance that the intensity of looked-up light is told from.
    pub(crate) white: White,
    /// Whether shadows are cast.
    pub(crate) casting: Casting,
    /// Source of the albedo.
    pub albedo: Albedo,
    /// Whether light is kept and mirrored that the albedo does not tell of.
    pub gloss: bool,
    /// The albedo fit of the whole picture, if the frame is a strip of it.
    pub(crate) estimate: Option<AlbedoEstimate>,
}

impl Relighting {
    /// Whether the surface has the colours of the picture.
    pub(crate) fn takes_picture(&self) -> bool {
        matches!(self.albedo, Albedo::Estimate | Albedo::Picture)
    }

    /// Resolves how to light a frame with `available` inputs.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for a number outside its range, no light at all, and lights or materials that lack
    /// required inputs.
    pub(crate) fn new(
        mut params: RelightParams,
        scaling: &ScalingParams,
        available: Available,
    ) -> Result<Self> {
        params.validate()?;
        let kinds = available.new_light;
        refuse_what_lacks(&params, available)?;
        if shows_all_light(params.material.material, kinds) {
            params.material.ambient = 0.0;
        }
        let magnitudes = scaling.magnitudes();
        let strongest = [magnitudes.ambient, magnitudes.diffuse, magnitudes.specular];
        let strongest = strongest
            .map(Magnitude::largest)
            .into_iter()
            .fold(0.0, f32::max);
        let warps = params.method.warps() && params.warping.warp > 0.0;
        let scales = params.method.scales() && strongest > 0.0;
        let rakes = params.raking == Raking::Best;
        let aligns = params.method.aligns() && params.align > 0.0;
        let lights = kinds.directional || kinds.points;
        let reflects = !params.material.material.shows_surroundings() && kinds.lit_spheres == 0;
        let casters = Casters {
            lamps: reflects && lights,
            rakes,
            sky: reflects && (kinds.environment || params.material.ambient > 0.0),
            environment: kinds.environment,
        };
        let casting = Casting::new(&params, available, casters)?;
        let environment = match kinds.environment && kinds.lit_spheres == 0 {
            true => environment_use(
                &params,
                (warps, aligns, casting.sky.is_cast),
                (scales, scaling.anisotropy != 0.0),
            )?,
            false => EnvironmentUse::None,
        };
        let sampled = matches!(
            environment,
            EnvironmentUse::Lights(_) | EnvironmentUse::ToError(_) | EnvironmentUse::Lookups(_)
        );
        let sums = reflects && (lights || sampled);
        let coat = params.material.coat;
        let albedo = albedo(&params, available)?;
        Ok(Self {
            params,
            warps,
            aligns,
            grainy_occlusion: available.grainy_occlusion && casters.sky && !casting.sky.is_cast,
            rakes,
            scales,
            contrasts: warps && params.warping.contrast != 0.0,
            toward_light: scales && sums && scaling.anisotropy != 0.0,
            grain: sums
                && params.material.material.has_coat()
                && params.material.tangent == Tangent::Curvature
                && coat[0] != coat[1],
            sums,
            near: kinds.points,
            environment,
            lit_spheres: kinds.lit_spheres,
            traced: params.material.material.shows_surroundings()
                && kinds.lit_spheres == 0
                && available.specular.is_some(),
            casting,
            white: White::given(scaling.white_level, params.middle_light),
            albedo,
            gloss: available.gloss
                && albedo == Albedo::Layer
                && params.albedo == AlbedoSource::Auto,
            estimate: None,
        })
    }

    /// Whether any shape is needed.
    pub(crate) fn needs_shape(&self) -> bool {
        let is_altered =
            self.warps || self.aligns || self.scales || self.grain || self.lit_spheres == 2;
        is_altered || self.casts_from_normals() || self.grainy_occlusion
    }

    /// Whether shadows are cast by the height that the normals tell.
    pub(crate) fn casts_from_normals(&self) -> bool {
        self.casting.any() && self.casting.by == Caster::Normals
    }

    /// Whether the full Hessian is needed rather than its trace.
    pub(crate) fn needs_hessian(&self) -> bool {
        self.warps || self.toward_light
    }

    /// Whether curvature is mapped by a gain.
    pub(crate) fn needs_gain(&self) -> bool {
        self.warps || self.scales || self.lit_spheres == 2
    }

    /// Whether the Jacobian of the inverse warp is needed: for lights sampled beforehand.
    pub(crate) fn has_jacobian(&self) -> bool {
        self.warps && self.sums && !matches!(self.environment, EnvironmentUse::Lookups(_))
    }
}

impl Plan {
    /// Relighting, if any.
    pub(crate) fn relighting(&self) -> Option<&Relighting> {
        self.settings.get()
    }

    /// Takes the albedo by the fit of a whole picture.
    pub(crate) fn set_estimate(&mut self, estimate: AlbedoEstimate) {
        if let Some(&relighting) = self.relighting() {
            self.settings.put(Relighting {
                estimate: Some(estimate),
                ..relighting
            });
        }
    }

    /// Whether it takes the frame whole, and not in strips: for heights, skies, shadows, or light turned to the form.
    pub(crate) fn takes_whole(&self) -> bool {
        let is_lit_whole = |lit: &Relighting| lit.casting.any() || lit.aligns || lit.rakes;
        self.relighting().is_some_and(is_lit_whole)
            || self.wanted.iter().any(|product| product.row().on_request)
    }

    /// Whether the picture is computed rather than copied from the input.
    #[cfg(feature = "gpu")]
    pub(crate) fn makes_picture(&self) -> bool {
        self.enhancement()
            .is_some_and(|enhancement| !enhancement.is_idle())
            || self.relighting().is_some()
            || self.display
    }
}

/// Errors allowed in light from an environment by default, in grey levels: bright highlights hide more.
const DIFFUSE_ERROR: f32 = 2.0;
const COAT_ERROR: f32 = 4.0;

/// Whether look-ups give the complete result.
fn shows_all_light(material: Material, kinds: LightKinds) -> bool {
    material.shows_surroundings() || kinds.lit_spheres > 0
}

fn refuse_what_lacks(params: &RelightParams, available: Available) -> Result<()> {
    let kinds = available.new_light;
    let is_specular = params.material.material.shows_surroundings();
    let surrounded = kinds.environment || kinds.lit_spheres > 0 || available.specular.is_some();
    if is_specular && !surrounded {
        return Err(bad(
            "--material",
            "mirrors what is around it, and nothing is",
            "give --environment FILE, --surroundings FILE or --behind FILE",
        ));
    }
    if is_specular && (kinds.directional || kinds.points) {
        return Err(bad(
            "--light",
            "is no larger than a point: mirrors and glass do not show it",
            "leave it out, or choose another --material",
        ));
    }
    let traced = is_specular && available.specular.is_some();
    let any =
        traced || kinds.directional || kinds.points || kinds.environment || kinds.lit_spheres > 0;
    if !any && params.material.ambient == 0.0 {
        return Err(bad(
            "--light",
            "is missing: there is no light",
            "give --light AZ,EL, --environment FILE or --lit-sphere FILE",
        ));
    }
    let has_lights = kinds.directional || kinds.points || kinds.environment;
    let turns = has_lights && !is_specular && kinds.lit_spheres == 0;
    if params.method.aligns() && params.align > 0.0 && !turns {
        return Err(bad(
            "--method",
            "is align, which turns lamps and environments on surfaces that scatter light",
            "leave it out, or choose another --material or --light",
        ));
    }
    if params.raking == Raking::Best && (!kinds.directional || is_specular) {
        return Err(bad(
            "--raking",
            "turns lamps, and there are none that scatter light",
            "give a --light AZ,EL, or leave it out",
        ));
    }
    if params.raking == Raking::Best && !available.is_flat {
        return Err(bad(
            "--raking",
            "is for flat work, and this surface turns away: regions would have borders on it",
            "leave it out; --method align turns light on any surface",
        ));
    }
    if kinds.points && !available.positions {
        return Err(bad(
            "--point-light",
            "needs to know where the surface is",
            "give depth and a camera, or a --light AZ,EL far away",
        ));
    }
    if kinds.lit_spheres > 0 && (kinds.directional || kinds.points || kinds.environment) {
        return Err(bad(
            "--lit-sphere",
            "holds all light there is",
            "leave out the other lights",
        ));
    }
    Ok(())
}

/// The cheapest use of the environment that material and method allow, unless one was given.
fn environment_use(
    params: &RelightParams,
    (warps, aligns, is_hidden): (bool, bool, bool),
    (scales, is_anisotropic): (bool, bool),
) -> Result<EnvironmentUse> {
    let material = params.material.material;
    let toward_light = scales && is_anisotropic;
    if material.shows_surroundings() {
        return Ok(EnvironmentUse::Mirrored);
    }
    let can_prefilter = material.can_prefilter() && !toward_light;
    if params.samples == SampleCount::Fixed(0) && !can_prefilter {
        return Err(bad(
            "--samples",
            "0 looks prefiltered light up, which only lambert, toon and phong without --anisotropy can",
            "give a number, or another --material",
        ));
    }
    if params.samples == SampleCount::Fixed(0) && aligns {
        return Err(bad(
            "--samples",
            "0 looks light up, and --method align turns lights",
            "give a number, or another --method",
        ));
    }
    let is_glossy = material.has_highlight();
    let by_lookups = warps && params.warp_by == WarpBy::Lookups;
    Ok(match params.samples {
        SampleCount::Fixed(0) => EnvironmentUse::Prefiltered,
        SampleCount::Fixed(count) if by_lookups => EnvironmentUse::Lookups(count),
        SampleCount::Fixed(count) => EnvironmentUse::Lights(count),
        SampleCount::Auto if by_lookups && can_prefilter => EnvironmentUse::Prefiltered,
        SampleCount::Auto if by_lookups => EnvironmentUse::Lookups(AUTO_SAMPLES),
        SampleCount::Auto if can_prefilter && !warps && !aligns && !is_hidden => {
            EnvironmentUse::Prefiltered
        }
        // The curves of samples do not depend on their directions.
        SampleCount::Auto if toward_light && is_glossy => EnvironmentUse::Lights(AUTO_SAMPLES),
        SampleCount::Auto => EnvironmentUse::ToError(ToError {
            levels: params.light_error.unwrap_or(match material.has_coat() {
                true => COAT_ERROR,
                false => DIFFUSE_ERROR,
            }),
            apart: warps || scales || aligns || is_hidden,
            glossy: is_glossy,
            warp: if warps { params.warping.warp } else { 0.0 },
        }),
    })
}

fn albedo(params: &RelightParams, available: Available) -> Result<Albedo> {
    let missing = |found| bad("--albedo-from", found, "give one, or --albedo-from white");
    let own_color = shows_all_light(params.material.material, available.new_light);
    match params.albedo {
        AlbedoSource::White => Ok(Albedo::White),
        AlbedoSource::Auto if available.albedo && !own_color => Ok(Albedo::Layer),
        AlbedoSource::Auto if own_color || !available.color => Ok(Albedo::White),
        AlbedoSource::Layer if available.albedo => Ok(Albedo::Layer),
        AlbedoSource::Layer => Err(missing("names an albedo layer, and there is none")),
        _ if !available.color => Err(missing("names the picture, and there is none")),
        AlbedoSource::Picture => Ok(Albedo::Picture),
        AlbedoSource::Auto | AlbedoSource::Estimate => Ok(Albedo::Estimate),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The remaining ambient light, if 0.1 was given.
    fn even_light(material: Material, kinds: LightKinds) -> f32 {
        let mut params = RelightParams::default();
        params.material.material = material;
        params.material.ambient = 0.1;
        let scaling = ScalingParams::default();
        let available = Available {
            new_light: kinds,
            ..Available::default()
        };
        let made = Relighting::new(params, &scaling, available).unwrap();
        made.params.material.ambient
    }

    #[test]
    fn what_shows_all_light_gets_no_even_light() {
        let around = LightKinds {
            environment: true,
            ..LightKinds::default()
        };
        let sphere = LightKinds {
            lit_spheres: 1,
            ..LightKinds::default()
        };
        assert_eq!(even_light(Material::Mirror, around), 0.0);
        assert_eq!(even_light(Material::Glass, around), 0.0);
        assert_eq!(even_light(Material::Lambert, sphere), 0.0);
        assert_eq!(even_light(Material::Lambert, around), 0.1);
    }
}
