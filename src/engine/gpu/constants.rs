//! The numbers that Rust and WGSL share, each with its only value.

use crate::fast_math::circular::{ATAN, COT_EIGHTH_PI, PI_2_LOW, TAN, TAN_EIGHTH_PI};
use crate::fast_math::exponential::{EXP, LN, LN2_HIGH, LN2_LOW};
use crate::frame::MIN_SEEN;
use crate::light::brdf::{BASE_SCALE, GRAZING};
use crate::light::environment_layout::{LEAST_RADIUS, RIM_PX};
use crate::light::layers::{MAX_RADIANCE, MIN_ALBEDO};
use crate::light::light_warping;
use crate::light::light_warping::MOST_BRIGHTENED;
use crate::light::radiance_scaling::{INVARIANT_MARGIN, MAX_EXPONENT};
use crate::light::relight::shade::SHORTEST_TANGENT;
use crate::light::sum::terms::SHORTEST;
use crate::line::contours::HALF_PLAIN_JUMP;
use crate::line::contours::crack::KINK;
use crate::line::contours::cracks::LEAST_STEP;
use crate::line::density::{LEAST_ALPHA, STEPS};
use crate::line::direction_field::setting as stroke_field;
use crate::line::hatching::CROSSED_FROM;
use crate::line::normal_rays::setting as surface_rays;
use crate::line::texture_coordinates::{DEPTH_STEP, JUMP, MOTION_STEP};
use crate::line::tonal_art_map::{ENTRIES, MAX_DENSITY};
use crate::line::{direction, direction_field, normal_rays, paper};
use crate::shape::auto_levels::MAX_GAIN;
use crate::shape::curvature::UMBILIC;
use crate::shape::curvature_display::palette;
use crate::shape::hessian::RIDGE;
use std::f32::consts;
use std::fmt::Write;

/// Columns and rows of a workgroup that makes a pixel per invocation.
pub(crate) const GROUP: [u32; 2] = [64, 4];

/// Columns and rows that a workgroup of `diffusion.wgsl` holds, its rim included.
pub(crate) const REGION: [u32; 2] = [64, 32];

/// Rows of that region which one invocation makes.
const ROWS_PER_INVOCATION: u32 = 8;

/// Rows of invocations of such a workgroup.
pub(crate) const REGION_GROUP_ROWS: u32 = REGION[1] / ROWS_PER_INVOCATION;

/// Sweeps between which the tiles of a device do not look at their neighbours: an even number, as terms are added
/// up in pairs. More read the frame less often, and waste more work on the rims of tiles.
pub(crate) const SWEEPS_PER_PASS: usize = 6;

/// Rows that one invocation makes of kernels that look at neighbours: each row serves the next one.
pub(crate) const STRIP_ROWS: u32 = 16;

/// Cells of a run, along which chains of patches are summed up at a time.
pub(crate) const RUN_CELLS: u32 = 16;

/// Invocations of a workgroup that goes through a list of pixels.
pub(crate) const LIST_INVOCATIONS: u32 = 64;

/// Workgroups that go through such a list, however long it is.
pub(crate) const LIST_GROUPS: u32 = 256;

/// Invocations of a workgroup that searches for a percentile.
pub(crate) const SEARCH_INVOCATIONS: u32 = 256;

/// Workgroups that count in that search, at the most; each takes every so-manieth row. Each also sets all bins to 0
/// and adds them up.
pub(crate) const MOST_COUNTING_GROUPS: u32 = 1024;

/// Bits that a pass of that search finds out, and how many passes find all 32.
pub(crate) const SEARCH_BITS: u32 = 11;
pub(crate) const SEARCH_PASSES: u32 = u32::BITS.div_ceil(SEARCH_BITS);

/// Bins that it counts.
pub(crate) const SEARCH_BINS: u32 = 1 << SEARCH_BITS;

/// Where the numbers stand that are chosen from the whole picture.
pub(crate) const GAIN: u32 = 0;
pub(crate) const WHITE: u32 = 1;

/// Where the numbers stand of cracks that silhouettes may pass, of those they do, and of creases.
pub(crate) const CANDIDATES: u32 = 0;
pub(crate) const CRACKS: u32 = 1;
pub(crate) const CREASES: u32 = 2;

/// Where the lengths stand of the lists of pixels that lack a direction: open ones, where they are told from those on
/// edges, and those.
pub(crate) const OPEN_COUNT: u32 = 0;
pub(crate) const CLOSED_COUNT: u32 = 1;

/// All of them, and the polynomials, as WGSL.
pub(crate) fn constants() -> String {
    let mut text = String::new();
    let whole = [
        ("GROUP_COLUMNS", GROUP[0]),
        ("GROUP_ROWS", GROUP[1]),
        ("REGION_COLUMNS", REGION[0]),
        ("REGION_ROWS", REGION[1]),
        ("REGION_PIXELS", REGION[0] * REGION[1]),
        ("REGION_GROUP_ROWS", REGION_GROUP_ROWS),
        ("ROWS_PER_INVOCATION", ROWS_PER_INVOCATION),
        ("STRIP_ROWS", STRIP_ROWS),
        ("SEARCH_INVOCATIONS", SEARCH_INVOCATIONS),
        ("SEARCH_BINS", SEARCH_BINS),
        ("RUN_CELLS", RUN_CELLS),
        ("LIST_INVOCATIONS", LIST_INVOCATIONS),
        ("GAIN", GAIN),
        ("WHITE", WHITE),
        ("OPEN_COUNT", OPEN_COUNT),
        ("CLOSED_COUNT", CLOSED_COUNT),
        ("FRAC_1_SQRT_2_BITS", consts::FRAC_1_SQRT_2.to_bits()),
        ("HASH_ROUNDS", paper::HASH_ROUNDS),
        ("HASH_FACTOR_LOW", paper::HASH_FACTOR as u32),
        ("HASH_FACTOR_HIGH", (paper::HASH_FACTOR >> 32) as u32),
        ("CANDIDATES", CANDIDATES),
        ("CRACKS", CRACKS),
        ("CREASES", CREASES),
        // No key of a finite number.
        ("NOTHING", u32::MAX),
    ];
    for (name, value) in whole {
        line(&mut text, format_args!("const {name}: u32 = {value}u;"));
    }
    line(
        &mut text,
        format_args!("const STEP_GROWTH: i32 = {};", surface_rays::STEP_GROWTH),
    );
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
        ("RIDGE", RIDGE),
        ("UMBILIC", UMBILIC),
        ("MAX_GAIN", MAX_GAIN),
        ("INVARIANT_MARGIN", INVARIANT_MARGIN),
        ("MAX_EXPONENT", MAX_EXPONENT),
        ("LARGEST_ENTRY", light_warping::LARGEST),
        ("MAX_CONTRAST_EXPONENT", light_warping::MAX_EXPONENT),
        ("MOST_BRIGHTENED", MOST_BRIGHTENED),
        ("SHORTEST", SHORTEST),
        ("SHORTEST_TANGENT", SHORTEST_TANGENT),
        ("GRAZING", GRAZING),
        ("BASE_SCALE", BASE_SCALE),
        ("RIM_PX", RIM_PX),
        ("LEAST_RADIUS", LEAST_RADIUS),
        ("MAX_RADIANCE", MAX_RADIANCE),
        ("MIN_ALBEDO", MIN_ALBEDO),
        ("OPEN", stroke_field::OPEN),
        ("FACING", stroke_field::FACING as f32),
        ("FALLBACK", stroke_field::FALLBACK),
        ("FREE", stroke_field::FREE),
        ("NEAR", stroke_field::NEAR),
        ("FAR", stroke_field::FAR),
        ("ROUND", direction_field::ROUND as f32),
        ("AGREE_FROM", direction_field::AGREE.start),
        ("AGREE_TO", direction_field::AGREE.end),
        ("LEAST_LENGTH", direction_field::LEAST_LENGTH),
        ("CANCELLED", direction::CANCELLED),
        ("ALONG", direction::ALONG as f32),
        ("MIN_SEEN", MIN_SEEN as f32),
        ("MIN_COSINE", normal_rays::MIN_COSINE as f32),
        ("MIN_SINE", normal_rays::MIN_SINE as f32),
        ("MIN_UPRIGHT", normal_rays::MIN_UPRIGHT as f32),
        ("PLANAR_TURN", normal_rays::PLANAR_TURN as f32),
        ("ALIKE", normal_rays::UMBILIC as f32),
        ("CERTAINTY", normal_rays::CERTAINTY as f32),
        ("DENSITY_STEPS", STEPS as f32),
        ("LEAST_ALPHA", LEAST_ALPHA),
        ("MAX_DENSITY", MAX_DENSITY),
        ("RESPONSE_ENTRIES", ENTRIES as f32),
        ("ENTRIES_PER_DENSITY", ENTRIES as f32 / MAX_DENSITY),
        ("CROSSED_FROM", CROSSED_FROM),
        ("KINK", KINK),
        ("HALF_PLAIN_JUMP", HALF_PLAIN_JUMP),
        ("LEAST_STEP", LEAST_STEP),
        ("JUMP", JUMP),
        ("DEPTH_STEP", DEPTH_STEP),
        ("MOTION_STEP_PX", MOTION_STEP[0]),
        ("MOTION_STEP_SHARE", MOTION_STEP[1]),
        ("GRAIN_HERE", paper::HERE),
        ("GRAIN_BESIDE", paper::BESIDE),
        ("GRAIN_SPREAD", paper::SPREAD),
        ("GRIP", paper::GRIP),
        ("LIGHTEST_BLACK", paper::LIGHTEST_BLACK),
    ];
    for (name, value) in real {
        line(&mut text, format_args!("const {name}: f32 = {value:e}f;"));
    }
    let colors = [
        ("NEUTRAL", palette::NEUTRAL),
        ("CONCAVE", palette::CONCAVE),
        ("CONVEX", palette::CONVEX),
        ("BACKGROUND", palette::BACKGROUND),
    ];
    for (name, [r, g, b]) in colors {
        let color = format_args!("const {name} = vec3<f32>({r:e}f, {g:e}f, {b:e}f);");
        line(&mut text, color);
    }
    add_polynomial(&mut text, "exp", &EXP);
    add_polynomial(&mut text, "ln", &LN);
    add_polynomial(&mut text, "atan", &ATAN);
    add_polynomial(&mut text, "tan", &TAN);
    text
}

/// A polynomial with these coefficients, the constant first, as a function.
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
