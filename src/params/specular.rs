//! What the trace of mirrors and lenses can be told.

use crate::error::{Error, Result};
use serde::Serialize;

/// How sight lines go on at specular surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Bend {
    /// Mirrored.
    Mirror,
    /// Refracted, twice where back faces are known, else once.
    Glass {
        /// Index of refraction.
        ior: f32,
    },
    /// Straight on, as through a thin sheet.
    Straight,
}

/// How specular pixels are traced.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpecularParams {
    /// How sight lines go on.
    pub bend: Bend,
    /// How what they meet is searched for.
    pub search: SearchParams,
}

/// How what a bent ray meets is searched for, from a coarse look along it to the point itself ([LA] section 5.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SearchParams {
    /// Even steps along the way, 1 to [`MAX_SEARCH_STEPS`]: fewer miss thin things, more take longer.
    pub steps: u32,
    /// Steps of the secant rule once the surface lies between two steps, 1 to 64: each takes many times closer.
    pub refinements: u32,
}

/// Most steps of a search.
pub const MAX_SEARCH_STEPS: u32 = 4096;

impl Default for SearchParams {
    fn default() -> Self {
        Self {
            steps: 128,
            refinements: 12,
        }
    }
}

impl SearchParams {
    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`].
    pub fn validate(&self) -> Result<()> {
        if (1..=MAX_SEARCH_STEPS).contains(&self.steps) && (1..=64).contains(&self.refinements) {
            return Ok(());
        }
        Err(Error::BadParameter {
            name: "--search-steps",
            found: format!("is {}", self.steps),
            remedy: format!("give 1 to {MAX_SEARCH_STEPS}"),
        })
    }
}
