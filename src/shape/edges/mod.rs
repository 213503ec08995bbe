//! Silhouettes, creases, conductance and the depth gradient, in one sweep.

pub(crate) mod cpu;
