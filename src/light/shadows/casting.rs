//! Whether shadows are cast, and by what.

use crate::error::{Error, Result};
use crate::params::{RelightParams, Shadows};
use crate::plan::available::Available;

/// What the height of the surface is known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Caster {
    /// Normals alone.
    Normals,
    /// Depth, or heights.
    Depth,
}

/// Whether shadows are cast in new light, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Casting {
    /// None where none are cast.
    pub(crate) by: Option<Caster>,
    pub(crate) why: &'static str,
    /// Whether it was chosen for the frame.
    pub(crate) is_chosen: bool,
}

impl Casting {
    /// Shadows of lamps; `has_lamps` tells whether light of them is summed, and `rakes` whether they have another azimuth in
    /// each region.
    ///
    /// # Errors
    /// [`Error::BadParameter`] where shadows are asked for of light that casts none.
    pub(crate) fn new(
        params: &RelightParams,
        available: Available,
        has_lamps: bool,
        rakes: bool,
    ) -> Result<Self> {
        let chosen = |casts, why| Ok(Self::of(available, casts, why, true));
        match params.shadows {
            Shadows::Off => Ok(Self::of(available, false, "--shadows off", false)),
            Shadows::On if rakes => Err(Error::BadParameter {
                name: "--shadows",
                found: "is on, and --raking best lights each region from another side".into(),
                remedy: "leave one of them out".into(),
            }),
            Shadows::On if has_lamps => Ok(Self::of(available, true, "--shadows on", false)),
            Shadows::On => Err(Error::BadParameter {
                name: "--shadows",
                found: "is on, and no lamp lights the surface".into(),
                remedy: "give a --light AZ,EL, or leave it out: environments cast no shadows"
                    .into(),
            }),
            Shadows::Auto if !has_lamps => Ok(Self::of(
                available,
                false,
                "no lamp lights the surface",
                false,
            )),
            Shadows::Auto if !available.is_map => {
                chosen(false, "a render, with depth or light passes")
            }
            Shadows::Auto if rakes => chosen(false, "each region is lit from another side"),
            Shadows::Auto if !available.new_light.raking => {
                chosen(false, "no light is below 45 degrees")
            }
            Shadows::Auto => chosen(true, "a photo or map under a light below 45 degrees"),
        }
    }

    /// Whether shadows are cast, if that was chosen.
    pub(crate) fn choice(&self) -> Option<bool> {
        self.is_chosen.then_some(self.by.is_some())
    }

    fn of(available: Available, casts: bool, why: &'static str, is_chosen: bool) -> Self {
        let caster = match available.positions {
            true => Caster::Depth,
            false => Caster::Normals,
        };
        Self {
            by: casts.then_some(caster),
            why,
            is_chosen,
        }
    }
}
