//! The parameters of the trace of mirrors and lenses.

use serde::Serialize;

/// Continuation of sight lines at specular surfaces.
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
    /// Undeflected, as through a thin sheet.
    Straight,
}

/// Tracing of specular pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpecularParams {
    /// Continuation of sight lines.
    pub bend: Bend,
    /// Search for their hit points.
    pub search: SearchParams,
}

params! {
    /// Search for the hit point of a bent ray: coarse steps along it, then refinement ([LA] section 5.2).
    #[derive(Eq)]
    pub struct SearchParams in Specular {
        /// Steps of the search along mirrored and refracted sight lines: fewer miss thin objects.
        ///
        /// They are evenly spaced; more take longer.
        steps: u32 = 128, flag: "--search-steps", form: "N", valid: 1.0..=MAX_SEARCH_STEPS as f32;
        /// Steps of the secant rule once the surface is bracketed between two steps.
        refinements: u32 = 12, valid: 1.0..=64.0;
    }
}

/// Maximum number of search steps.
pub(crate) const MAX_SEARCH_STEPS: u32 = 4096;
