//! How far sliders reach. A value beyond can be typed; what is refused is said by the parameters themselves.

use crate::params::MAX_FIELD_PASSES;

/// The range of a setting's slider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    /// The flag.
    pub(super) name: &'static str,
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// Whether equal ways on the slider are equal factors.
    pub(crate) is_logarithmic: bool,
}

const fn even(name: &'static str, from: f64, to: f64) -> Range {
    Range {
        name,
        from,
        to,
        is_logarithmic: false,
    }
}

const fn by_factors(name: &'static str, from: f64, to: f64) -> Range {
    Range {
        name,
        from,
        to,
        is_logarithmic: true,
    }
}

/// All of them.
pub(super) const RANGES: [Range; 41] = [
    even("iterations", 0.0, 200.0),
    by_factors("scale", 0.5, 64.0),
    even("foreshortening", 0.0, 2.0),
    by_factors("tolerance", 1e-6, 1e-2),
    by_factors("curvature-gain", 0.1, 200.0),
    by_factors("reference-height", 256.0, 8192.0),
    even("direction-step", 1.0, 32.0),
    even("scaling", 0.0, 4.0),
    even("scaling-ambient", 0.0, 4.0),
    even("scaling-diffuse", 0.0, 4.0),
    even("scaling-specular", 0.0, 4.0),
    even("invariant-point", 0.01, 0.99),
    even("anisotropy", -1.0, 1.0),
    by_factors("white-level", 0.01, 10.0),
    even("environment-rotate", -180.0, 180.0),
    by_factors("environment-gain", 0.01, 10.0),
    even("samples", 0.0, 256.0),
    even("ambient", 0.0, 1.0),
    even("warp", 0.0, 20.0),
    even("contrast", -1.0, 1.0),
    even("diffuse-gain", 0.0, 2.0),
    even("specular-gain", 0.0, 2.0),
    by_factors("shininess", 1.0, 500.0),
    even("flatness", 0.0, 1.0),
    even("reflectance", 0.0, 1.0),
    even("ior", 1.0, 3.0),
    even("toon-levels", 1.0, 12.0),
    even("toon-softness", 0.0, 1.0),
    by_factors("white-point", 0.01, 10.0),
    even("black-point", 0.0, 0.9),
    even("tone-gamma", 0.2, 3.0),
    even("passes", 0.0, MAX_FIELD_PASSES as f64),
    even("smoothing", 1.0, 16.0),
    even("stroke-width", 0.2, 10.0),
    even("stroke-spacing", 1.0, 40.0),
    even("wobble", 0.0, 1.0),
    even("pressure", 0.0, 1.0),
    even("levels", 2.0, 64.0),
    even("contour-width", 0.2, 10.0),
    even("crease-width", 0.0, 1.0),
    even("depth-emphasis", 0.0, 1.0),
];
