//! Silhouettes, creases, conductance and the depth gradient, in one sweep.

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
