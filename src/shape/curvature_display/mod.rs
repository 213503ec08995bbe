//! The coloured curvature display of [LW] figure 6.

pub(crate) mod palette;
