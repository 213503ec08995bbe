//! The parameters of the trace of mirrors and lenses.

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

params! {
    /// How what a bent ray meets is searched for, from a coarse look along it to the point itself ([LA] section 5.2).
    #[derive(Eq)]
    pub struct SearchParams in Specular {
        /// Steps of the search along mirrored and refracted sight lines: fewer miss thin things.
        ///
        /// They are even, and more take longer.
        steps: u32 = 128, flag: "--search-steps", form: "N", valid: 1.0..=MAX_SEARCH_STEPS as f32;
        /// Steps of the secant rule once the surface lies between two steps: each takes many times closer.
        refinements: u32 = 12, valid: 1.0..=64.0;
    }
}

/// Most steps of a search.
pub(crate) const MAX_SEARCH_STEPS: u32 = 4096;
