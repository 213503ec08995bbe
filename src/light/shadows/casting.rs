//! Whether shadows are cast, and by what.

use crate::error::{Result, bad};
use crate::params::{RelightParams, Shadows};
use crate::plan::available::Available;

/// What the height of the surface is known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Caster {
    /// Normals alone.
    Normals,
    /// Heights over a plane.
    Heights,
    /// Depth, where surfaces hide others.
    Depth,
}

/// Whether shadows are cast in some light, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cast {
    pub(crate) is_cast: bool,
    pub(crate) why: &'static str,
    /// Whether it was chosen for the frame.
    is_chosen: bool,
}

/// What shadows are cast in new light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Casting {
    pub(crate) by: Caster,
    /// Those of lamps.
    pub(crate) lamps: Cast,
    /// What the surface hides of light from all around.
    pub(crate) sky: Cast,
}

/// New light that could cast shadows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Casters {
    /// Lamps whose light is summed.
    pub(crate) lamps: bool,
    /// Lamps that have another azimuth in each region.
    pub(crate) rakes: bool,
    /// An environment, or ambient light.
    pub(crate) sky: bool,
    /// An environment.
    pub(crate) environment: bool,
}

impl Casting {
    /// Which of the light that is there casts shadows on what is available.
    ///
    /// # Errors
    /// [`Error::BadParameter`] where shadows are asked for of light that casts none.
    pub(crate) fn new(
        params: &RelightParams,
        available: Available,
        light: Casters,
    ) -> Result<Self> {
        Ok(Self {
            by: match (available.positions, available.is_map) {
                (true, true) => Caster::Heights,
                (true, false) => Caster::Depth,
                (false, _) => Caster::Normals,
            },
            lamps: of_lamps(params.shadows, available, light)?,
            sky: of_sky(params.sky_shadows, available, light)?,
        })
    }

    /// Whether those of lamps and of the sky are cast, where that was chosen.
    pub(crate) fn choices(&self) -> [Option<bool>; 2] {
        [self.lamps, self.sky].map(|cast| cast.choice())
    }

    /// Whether any are cast.
    pub(crate) fn any(&self) -> bool {
        self.lamps.is_cast || self.sky.is_cast
    }
}

impl Cast {
    fn chosen(is_cast: bool, why: &'static str) -> Self {
        Self {
            is_cast,
            why,
            is_chosen: true,
        }
    }

    fn given(is_cast: bool, why: &'static str) -> Self {
        Self {
            is_cast,
            why,
            is_chosen: false,
        }
    }

    fn choice(&self) -> Option<bool> {
        self.is_chosen.then_some(self.is_cast)
    }
}

/// Why nothing is cast on what is no map.
const RENDER: &str = "a render, with depth, light passes or perspective";

fn of_lamps(asked: Shadows, available: Available, light: Casters) -> Result<Cast> {
    let refused = |found: &str, remedy: &str| Err(bad("--shadows", found, remedy));
    match asked {
        Shadows::On if light.rakes => refused(
            "is on, and --raking best lights each region from another side",
            "leave one of them out",
        ),
        Shadows::On if !light.lamps => refused(
            "is on, and no lamp lights the surface",
            "give a --light AZ,EL, or leave it out: --sky-shadows on is for environments",
        ),
        Shadows::On => Ok(Cast::given(true, "--shadows on")),
        Shadows::Off => Ok(Cast::given(false, "--shadows off")),
        Shadows::Auto if !light.lamps => Ok(Cast::given(false, "no lamp lights the surface")),
        Shadows::Auto => Ok(match available {
            _ if !available.is_map => Cast::chosen(false, RENDER),
            _ if light.rakes => Cast::chosen(false, "each region is lit from another side"),
            _ if !available.new_light.raking => Cast::chosen(false, "no light is below 45 degrees"),
            _ => Cast::chosen(true, "a photo or map under a light below 45 degrees"),
        }),
    }
}

fn of_sky(asked: Shadows, available: Available, light: Casters) -> Result<Cast> {
    match asked {
        Shadows::On if !light.sky => Err(bad(
            "--sky-shadows",
            "is on, and no light from all around is scattered",
            "give --environment FILE and a --material that scatters light",
        )),
        Shadows::On => Ok(Cast::given(true, "--sky-shadows on")),
        Shadows::Off => Ok(Cast::given(false, "--sky-shadows off")),
        Shadows::Auto if !light.sky || !light.environment => {
            Ok(Cast::given(false, "no environment"))
        }
        Shadows::Auto => Ok(match available {
            _ if !available.is_map => Cast::chosen(false, RENDER),
            _ if available.light.occlusion => Cast::chosen(false, "a layer tells the occlusion"),
            _ => Cast::chosen(true, "a photo or map in an environment"),
        }),
    }
}
