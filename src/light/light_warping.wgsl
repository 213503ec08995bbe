// Light warping: incoming light bent by curvature. A warp is linear in half vectors, the symmetric matrix Lambda that
// acts on their x and y: (xx, xy, yy).

// The factor by which a principal curvature k scales stereographic coordinates along its direction.
fn scale_factor(k: f32, alpha: f32) -> f32 {
    let product = alpha * k;
    let x = select(clamp(product, -F32_MAX, F32_MAX), 0.0, is_nan(product));
    let size = abs(x);
    let steep = size > COT_EIGHTH_PI;
    let middle = size > TAN_EIGHTH_PI;
    let y = rest_of_tangent(size);
    let whole = select(select(1.0, FACTOR_OF_1, middle), LARGEST_FACTOR, steep);
    // The tangent of a sum of angles: that of the factor there, and a sixth of atan y.
    let t = y * polynomial_sixth(y * y);
    let more = whole + t;
    let less = 1.0 - whole * t;
    return select(more, less, x < 0.0) / select(less, more, x < 0.0);
}

fn bounded_entry(entry: f32) -> f32 {
    return select(clamp(entry, -LARGEST_ENTRY, LARGEST_ENTRY), 0.0, is_nan(entry));
}

// The warp of strength alpha where the Hessian is (xx, xy, yy).
fn warp_of(hessian: vec3<f32>, alpha: f32) -> vec3<f32> {
    let xx = bounded_entry(hessian.x);
    let xy = bounded_entry(hessian.y);
    let yy = bounded_entry(hessian.z);
    // In units of the largest entry, so that squares neither overflow nor vanish.
    let size = max(max(abs(xx), abs(xy)), abs(yy));
    let unit = 1.0 / max(size, MIN_POSITIVE);
    let mean = 0.5 * (xx + yy) * unit;
    let difference = 0.5 * (xx - yy) * unit;
    let cross_term = xy * unit;
    let spread = sqrt(difference * difference + cross_term * cross_term);
    // Overflow is clamped to finite values, so that 0 times it is 0.
    let strength = clamp(clamp(alpha, -F32_MAX, F32_MAX) * size, -F32_MAX, F32_MAX);
    let u = scale_factor(mean + spread, strength);
    let v = scale_factor(mean - spread, strength);
    let turn = 0.5 * (u - v) / max(spread, MIN_POSITIVE);
    let middle = 0.5 * (u + v);
    return vec3<f32>(middle + turn * difference, turn * cross_term, middle - turn * difference);
}

fn warp_determinant(warp: vec3<f32>) -> f32 {
    return warp.x * warp.z - warp.y * warp.y;
}

fn warp_inverse(warp: vec3<f32>) -> vec3<f32> {
    let unit = 1.0 / warp_determinant(warp);
    return vec3<f32>(warp.z * unit, -warp.y * unit, warp.x * unit);
}

// x and y of a warped half vector.
fn warp_apply(warp: vec3<f32>, v: vec3<f32>) -> vec2<f32> {
    return vec2<f32>(warp.x * v.x + warp.y * v.y, warp.y * v.x + warp.z * v.y);
}

// The image of the direction with half vector `half`, as a unit vector.
fn warp_direction(warp: vec3<f32>, half: vec3<f32>) -> vec3<f32> {
    let xy = warp_apply(warp, half);
    let across = xy.x * xy.x + xy.y * xy.y;
    let along = half.z * half.z;
    let unit = 1.0 / (across + along);
    let twice = 2.0 * half.z * unit;
    return vec3<f32>(twice * xy.x, twice * xy.y, (along - across) * unit);
}

// Unit half vector between a unit direction and z; for -z itself, x.
fn half_vector(direction: vec3<f32>) -> vec3<f32> {
    let squared = direction.x * direction.x + direction.y * direction.y;
    let across = sqrt(squared);
    let along = 1.0 + abs(direction.z);
    // The half vector is (l_xy, 1 + l_z), and below the horizon, where 1 + l_z loses digits, the same times
    // |l_xy| / (1 + l_z) = (1 - l_z) / |l_xy|.
    let lean = along / max(across, MIN_POSITIVE);
    let below = direction.z < 0.0;
    var half = vec3<f32>(direction.xy, along);
    if below {
        half = vec3<f32>(direction.x * lean, direction.y * lean, across);
        if squared < MIN_POSITIVE {
            half = vec3<f32>(along, 0.0, across);
        }
    }
    let length_squared = along * along + squared;
    // Non-finite directions count as z.
    return select(vec3<f32>(0.0, 0.0, 1.0), half * (1.0 / sqrt(length_squared)), is_finite(length_squared));
}

// Factor of the reflected light for the warp `warp`: its determinant to the power gamma.
fn contrast(warp: vec3<f32>, gamma: f32) -> f32 {
    return exp_of(clamp(gamma * ln(warp_determinant(warp)), -MAX_CONTRAST_EXPONENT, MAX_CONTRAST_EXPONENT));
}
