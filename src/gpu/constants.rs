//! Workgroup sizes, and the constants that every kernel takes from Rust.

use crate::gpu::wgsl::Number;
use crate::kernel::fast_math::circular::{ATAN, COT_EIGHTH_PI, PI_2_LOW, SIXTH, TAN_EIGHTH_PI};
use crate::kernel::fast_math::exponential::{EXP, LN, LN2_HIGH, LN2_LOW};
use std::f32::consts;
use std::fmt::Write;

/// Columns and rows of a workgroup with one pixel per invocation.
pub(crate) const GROUP: [u32; 2] = [64, 4];

/// Columns and rows held by a workgroup of `diffusion.wgsl`, rim included.
pub(crate) const REGION: [u32; 2] = [64, 32];

/// Rows of that region per invocation.
pub(crate) const ROWS_PER_INVOCATION: u32 = 8;

/// Rows of invocations in such a workgroup.
pub(crate) const REGION_GROUP_ROWS: u32 = REGION[1] / ROWS_PER_INVOCATION;

/// Sweeps between exchanges of neighbouring tiles on the device: an even number, since terms are added in pairs. More
/// read the frame less often, and waste more work on the rims of tiles.
pub(crate) const SWEEPS_PER_PASS: usize = 6;

/// Rows per invocation in kernels that read neighbours: each row reuses the previous one.
pub(crate) const STRIP_ROWS: u32 = 16;

/// WGSL text of the constants and of the polynomials of elementary functions, for every kernel.
pub(crate) fn constants() -> String {
    let mut text = String::new();
    let whole = [
        ("GROUP_COLUMNS", GROUP[0]),
        ("GROUP_ROWS", GROUP[1]),
        ("STRIP_ROWS", STRIP_ROWS),
        ("FRAC_1_SQRT_2_BITS", consts::FRAC_1_SQRT_2.to_bits()),
        // Neither a count nor an index.
        ("NOTHING", u32::MAX),
    ];
    let real = [
        ("LOG2_E", consts::LOG2_E),
        ("PI", consts::PI),
        ("FRAC_PI_2", consts::FRAC_PI_2),
        ("FRAC_PI_4", consts::FRAC_PI_4),
        ("PI_2_LOW", PI_2_LOW),
        ("F32_MAX", f32::MAX),
        ("MIN_POSITIVE", f32::MIN_POSITIVE),
        ("LN2_HIGH", LN2_HIGH),
        ("LN2_LOW", LN2_LOW),
        ("TAN_EIGHTH_PI", TAN_EIGHTH_PI),
        ("COT_EIGHTH_PI", COT_EIGHTH_PI),
    ];
    for (name, value) in whole {
        text += &Number::U32(value).declared(name);
    }
    for (name, value) in real {
        text += &Number::F32(value).declared(name);
    }
    add_polynomial(&mut text, "exp", &EXP);
    add_polynomial(&mut text, "ln", &LN);
    add_polynomial(&mut text, "atan", &ATAN);
    add_polynomial(&mut text, "sixth", &SIXTH);
    text
}

/// A polynomial with these coefficients, the constant first, as a WGSL function.
fn add_polynomial(text: &mut String, name: &str, coefficients: &[f32]) {
    line(text, format_args!("fn polynomial_{name}(x: f32) -> f32 {{"));
    line(text, format_args!("    var sum = 0.0;"));
    for coefficient in coefficients.iter().rev() {
        line(text, format_args!("    sum = sum * x + {coefficient:e}f;"));
    }
    line(text, format_args!("    return sum;\n}}"));
}

fn line(text: &mut String, line: std::fmt::Arguments) {
    writeln!(text, "{line}").expect("a string takes all");
}
