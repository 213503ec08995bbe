//! Number formats of the page.

/// A time in milliseconds, to three digits.
pub(crate) fn milliseconds(seconds: f64) -> String {
    format!("{} ms", rounded(1e3 * seconds))
}

/// A number to three digits without an exponent, down to a thousandth.
pub(crate) fn rounded(value: f64) -> String {
    match value.abs() {
        v if v >= 100.0 || !v.is_finite() => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        v if v >= 1.0 => format!("{value:.2}"),
        v if v == 0.0 || v >= 0.001 => format!("{value:.3}"),
        _ => "< 0.001".into(),
    }
}

/// A number as 1.2e-4; 0 as 0.
pub(crate) fn scientific(value: f64) -> String {
    if value == 0.0 {
        "0".into()
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits() {
        for (value, text) in [
            (1234.5, "1234"),
            (23.45, "23.4"),
            (0.0456, "0.046"),
            (0.0, "0.000"),
            (1e-9, "< 0.001"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(rounded(value), text);
        }
        assert_eq!(
            (scientific(0.000_123), scientific(0.0)),
            ("1.2e-4".into(), "0".into())
        );
    }
}
