//! Silhouettes, creases, conductance and the depth gradient, in one sweep.

pub(crate) mod cpu;
pub(crate) mod stage;

use crate::plan::Plan;

/// The plane that silhouettes are found in: depth, else occlusion, else the border of the mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SilhouetteSource {
    /// Jumps of depth.
    Depth,
    /// Jumps of an occlusion map or of alpha.
    Occlusion,
    /// Only the border of coverage.
    Border,
}

impl SilhouetteSource {
    /// The source used by a plan.
    pub(crate) fn of(plan: &Plan) -> Self {
        match (plan.available.depth, plan.available.occlusion) {
            (true, _) => Self::Depth,
            (false, true) => Self::Occlusion,
            (false, false) => Self::Border,
        }
    }
}
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
