//! Colours of the curvature display in [LW] figure 6, sRGB-encoded 0..1.

pub(crate) const NEUTRAL: [f32; 3] = [0.90, 0.90, 0.88];
pub(crate) const CONCAVE: [f32; 3] = [0.86, 0.22, 0.08];
pub(crate) const CONVEX: [f32; 3] = [0.08, 0.32, 0.78];
pub(crate) const BACKGROUND: [f32; 3] = [1.0, 1.0, 1.0];
