// The terms of one light at a pixel, before its colour: arrival, reflection by the lobes, scaling.

// Whether the eye is far away, along z at every pixel.
override FAR_EYE: bool;
// Whether the mapping of curvature depends on the direction of light.
override TOWARD_LIGHT: bool;

// A light: its direction, its half vector with z, its attenuation.
struct Arriving {
    direction: vec3<f32>,
    half: vec3<f32>,
    share: f32,
}

struct Terms {
    diffuse: f32,
    specular: f32,
}

// Inputs of the terms of a light.
struct Incidence {
    // Jacobian, without the pixel's factor, and attenuation.
    weight: f32,
    // n . l, at most MOST_BRIGHTENED times that of the light as given.
    cosine: f32,
    // One over the squared length of the half vector under the inverse warp.
    inverse: f32,
    // The square of n . h for an eye on the axis.
    lobe: f32,
}

fn positive(x: f32) -> f32 {
    return select(0.0, x, x > 0.0);
}

fn at_most_1(x: f32) -> f32 {
    return select(1.0, x, x < 1.0);
}

// The square of n . h for an eye on the axis.
fn half_vector_lobe(normal: vec3<f32>, half: vec3<f32>) -> f32 {
    let along = positive(scalar_product(normal, half));
    return at_most_1(along * along);
}

// Unwarps a light, with its Jacobian, for the given normal and square of the inverse of Lambda (xx, twice xy, yy).
fn arrive_unwarped(light: Arriving, normal: Axis, squared: vec3<f32>) -> Incidence {
    let n = normal.vector;
    let g = normal.unwarped;
    let x = light.half.x;
    let y = light.half.y;
    let z = light.half.z;
    let length = z * z + squared.x * (x * x) + squared.y * (x * y) + squared.z * (y * y);
    let inverse = 1.0 / length;
    let along = g.x * x + g.y * y + n.z * z;
    let part = along * inverse;
    let cosine = 2.0 * z * part - n.z;
    let most = MOST_BRIGHTENED * scalar_product(n, light.direction);
    return Incidence(
        light.share * (inverse * inverse),
        select(most, cosine, cosine < most),
        inverse,
        at_most_1(positive(along) * part),
    );
}

// The dot product of the direction of light, unwarped if warping is on, with a vector.
fn product(light: Arriving, inverse: f32, axis: Axis) -> f32 {
    if !HAS_JACOBIAN {
        return scalar_product(axis.vector, light.direction);
    }
    let h = light.half;
    let along = axis.unwarped.x * h.x + axis.unwarped.y * h.y + axis.vector.z * h.z;
    return 2.0 * h.z * inverse * along - axis.vector.z;
}

// The square of n . h, with h half-way between light and an eye off the axis.
fn half_way(light_eye: f32, light_normal: f32, normal_eye: f32) -> f32 {
    let along = positive(light_normal + normal_eye);
    let squared = 2.0 + 2.0 * light_eye;
    return at_most_1(along * along / max(squared, SHORTEST));
}

// A number from 0 to 1 raised to the lobe's exponent; 0 stays 0.
fn exponent_raise(x: f32) -> f32 {
    if params.whole_power == 0u {
        let power = exp_of(params.power * ln(max(x, MIN_POSITIVE)));
        return select(0.0, power, x > 0.0);
    }
    // From the highest bit of the exponent on.
    var power = x;
    for (var digit = firstLeadingBit(params.whole_power); digit > 0u; digit--) {
        power *= power;
        if ((params.whole_power >> (digit - 1u)) & 1u) == 1u {
            power *= x;
        }
    }
    return power;
}

// x and y of the unwarped direction of light, with `inverse` from Incidence.
fn unwarped_xy(unwarp: vec3<f32>, half: vec3<f32>, inverse: f32) -> vec2<f32> {
    let twice = 2.0 * half.z * inverse;
    return twice * warp_apply(unwarp, half);
}

// Computes the diffuse and specular terms of a light.
fn reflect_light(light: Arriving) -> Terms {
    var arrived: Incidence;
    if HAS_JACOBIAN {
        arrived = arrive_unwarped(light, pixel.normal, pixel.unwarp_squared);
    } else {
        let n = pixel.normal.vector;
        arrived = Incidence(light.share, scalar_product(n, light.direction), 1.0, 0.0);
        if BLINN_PHONG && FAR_EYE {
            arrived.lobe = half_vector_lobe(n, light.half);
        }
    }
    if !(arrived.cosine > 0.0) {
        return Terms(0.0, 0.0);
    }
    var diffuse_curve = pixel.diffuse_curve;
    var specular_curve = pixel.specular_curve;
    if TOWARD_LIGHT {
        var l = light.direction.xy;
        if HAS_JACOBIAN {
            l = unwarped_xy(pixel.unwarp, light.half, arrived.inverse);
        }
        let kappa = mapped_curvature_toward(pixel.hessian, l, params.gain, params.anisotropy);
        let exponents = exponents_of(kappa);
        diffuse_curve = scaling_curve_of(exponents.y);
        specular_curve = scaling_curve_of(exponents.z);
    }
    let reflected = reflect_by_lobes(light, arrived);
    var diffuse = arrived.weight * reflected.diffuse;
    var specular = arrived.weight * reflected.specular;
    if SCALES {
        diffuse *= scaling_curve_at(diffuse_curve, reflected.cosine, params.invariant_point);
        specular *= scaling_curve_at(specular_curve, reflected.lobe, params.invariant_point);
    }
    return Terms(diffuse, specular);
}

// The exponents gamma kappa of ambient, diffuse and specular light.
fn exponents_of(kappa: f32) -> vec3<f32> {
    return select(params.concave_magnitudes, params.magnitudes, kappa >= 0.0) * kappa;
}
