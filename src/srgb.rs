//! The sRGB curve (IEC 61966-2-1).

/// Linear light of an sRGB-encoded value (IEC 61966-2-1), both 0..1.
pub fn decoded(v: f64) -> f64 {
    match v <= 0.04045 {
        true => v / 12.92,
        false => ((v + 0.055) / 1.055).powf(2.4),
    }
}

/// The sRGB encoding of linear light, both 0..1.
pub fn encoded(v: f64) -> f64 {
    match v <= 0.0031308 {
        true => v * 12.92,
        false => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    }
}
