// Elementary functions: the polynomials of the CPU, so that results agree within a few roundings. Built-in functions of
// devices err by 1e-5 and more.

fn power_of_two(n: i32) -> f32 {
    return bitcast<f32>(u32(n + 127) << 23u);
}

// Whether the number is neither infinite nor NaN, by its exponent bits: float comparisons may assume finite math.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

// `size` with the sign of `sign`.
fn copysign(size: f32, sign: f32) -> f32 {
    return bitcast<f32>((bitcast<u32>(size) & 0x7fffffffu) | (bitcast<u32>(sign) & 0x80000000u));
}

struct SplitExp {
    n: i32,
    p: f32,
}

// e^x = 2^n (1 + p) for x from -104 to 89.
fn split_exp(x: f32) -> SplitExp {
    let n = round(x * LOG2_E);
    let r = (x - n * LN2_HIGH) - n * LN2_LOW;
    return SplitExp(i32(n), r + r * r * polynomial_exp(r));
}

fn exp_of(x: f32) -> f32 {
    let split = split_exp(clamp(x, -104.0, 89.0));
    // In two factors, since 2^n alone leaves the range of f32 before the result does.
    let half = split.n >> 1u;
    return (1.0 + split.p) * power_of_two(half) * power_of_two(split.n - half);
}

// The natural logarithm of a positive, finite, normal x.
fn ln(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    // x = 2^e m with m between sqrt(1/2) and sqrt(2).
    let e = bitcast<i32>(bits - FRAC_1_SQRT_2_BITS) >> 23u;
    let f = bitcast<f32>(bits - bitcast<u32>(e << 23u)) - 1.0;
    let square = f * f;
    let exponent = f32(e);
    let small = square * f * polynomial_ln(f) + exponent * LN2_LOW - 0.5 * square;
    return (f + small) + exponent * LN2_HIGH;
}

fn tanh_of(x: f32) -> f32 {
    // With q = e^-2|x| - 1, tanh |x| is -q / (q + 2), without cancellation near 0. At 10 it is 1.
    let split = split_exp(-2.0 * min(abs(x), 10.0));
    let scale = power_of_two(split.n);
    let q = scale * split.p + (scale - 1.0);
    return copysign(q / (q + 2.0), x);
}

// The t whose arc tangent is left of that of size without that of infinity, 1 or 0.
fn rest_of_tangent(size: f32) -> f32 {
    let steep = size > COT_EIGHTH_PI;
    let middle = size > TAN_EIGHTH_PI;
    let above = select(select(size, size - 1.0, middle), -1.0, steep);
    let below = select(select(1.0, size + 1.0, middle), size, steep);
    return above / below;
}

fn atan_of(x: f32) -> f32 {
    let size = abs(x);
    let steep = size > COT_EIGHTH_PI;
    let middle = size > TAN_EIGHTH_PI;
    let t = rest_of_tangent(size);
    let whole = select(select(0.0, FRAC_PI_4, middle), FRAC_PI_2, steep);
    let lost = select(select(0.0, 0.5 * PI_2_LOW, middle), PI_2_LOW, steep);
    let square = t * t;
    let small = square * t * polynomial_atan(square) + lost;
    return copysign(whole + (small + t), x);
}

// The angle, -pi to pi, of the vector (x, y) from the x axis; 0 for a zero vector.
fn atan2_of(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    let steep = ay > ax;
    let small = select(ay, ax, steep);
    let large = select(ax, ay, steep);
    let ratio = small / select(1.0, large, large > 0.0);
    // NaN, for two infinite components, fails the comparison and gives the half-way angle.
    let to_axis = atan_of(select(1.0, ratio, ratio < 1.0));
    let angle = select(to_axis, FRAC_PI_2 - to_axis, steep);
    return copysign(select(angle, PI - angle, x < 0.0), y);
}
