// Principal curvatures, the direction of the larger by magnitude, and mapped curvature, from the Hessian.

// The length of a vector whose square may exceed the range of f32.
fn hypot(a: f32, b: f32) -> f32 {
    let large = max(abs(a), abs(b));
    let small = min(abs(a), abs(b));
    if large == 0.0 {
        return 0.0;
    }
    let ratio = small / large;
    return large * sqrt(1.0 + ratio * ratio);
}

// Principal curvatures, the larger first, of the Hessian [xx, xy, yy].
fn principal_curvatures(hessian: vec3<f32>) -> vec2<f32> {
    let mean = 0.5 * (hessian.x + hessian.z);
    let spread = hypot(0.5 * (hessian.x - hessian.z), hessian.y);
    return vec2<f32>(mean + spread, mean - spread);
}

// Unit direction of the larger principal curvature by magnitude; 0 if both are equal.
fn principal_direction(hessian: vec3<f32>) -> vec2<f32> {
    let half_difference = 0.5 * (hessian.x - hessian.z);
    let mean = 0.5 * (hessian.x + hessian.z);
    let xy = hessian.y;
    let spread = hypot(half_difference, xy);
    if spread <= UMBILIC * abs(mean) || spread == 0.0 {
        return vec2<f32>(0.0);
    }
    // cos^2 = (1 + cos 2a) / 2 gives the larger of sine and cosine; sin 2a gives the other.
    let cosine = half_difference / spread;
    let sine = xy / spread;
    let larger = sqrt(0.5 * (1.0 + abs(cosine)));
    let lesser = 0.5 * sine / larger;
    var t = vec2<f32>(larger, lesser);
    if cosine < 0.0 {
        t = vec2<f32>(abs(lesser), copysign(larger, sine));
    }
    if mean < 0.0 {
        t = vec2<f32>(-t.y, t.x);
    }
    return t;
}

fn at_pixel(id: vec2<u32>, i: u32) {
    if !is_covered(id.x, id.y) {
        curvature[i] = vec4<f32>(0.0);
        direction[i] = vec2<f32>(0.0);
        return;
    }
    let hessian = vec3<f32>(hessian_xx[i], hessian_xy[i], hessian_yy[i]);
    let mean = 0.5 * (hessian.x + hessian.z);
    let kappa = mapped_curvature(2.0 * mean, params.gain);
    curvature[i] = vec4<f32>(principal_curvatures(hessian), mean, kappa);
    direction[i] = principal_direction(hessian);
}
