// Reflectance: the share of the light from one direction that is reflected toward the eye.

// Cosines between unit vectors: n the normal, l to the light, e to the eye, h the half vector; u along the grain, v
// across it.
struct Cosines {
    nl: f32,
    ne: f32,
    he: f32,
    hu: f32,
    hv: f32,
}

fn fifth_power(x: f32) -> f32 {
    let square = x * x;
    return square * square * x;
}

fn passed(cosine: f32) -> f32 {
    return 1.0 - fifth_power(1.0 - 0.5 * cosine);
}

// The base under the coat, of albedo 1.
fn ashikhmin_shirley_diffuse(nl: f32, ne: f32) -> f32 {
    return BASE_SCALE * (1.0 - params.reflectance) * passed(nl) * passed(ne) * nl;
}

// The coat.
fn ashikhmin_shirley_specular(c: Cosines) -> f32 {
    let uu = c.hu * c.hu;
    let vv = c.hv * c.hv;
    // The exponent of n.h is (nu uu + nv vv) / (1 - n.h^2), where 1 - n.h^2 = uu + vv.
    let aside = clamp(uu + vv, MIN_POSITIVE, 1.0);
    let exponent = 0.5 * (params.coat_along * uu + params.coat_across * vv) / aside;
    let logarithm = select(-F32_MAX, ln(1.0 - aside), aside < 1.0);
    let lobe = exp_of(exponent * logarithm);
    let reflected = params.reflectance + (1.0 - params.reflectance) * fifth_power(1.0 - c.he);
    let seen = c.nl / (max(c.he, GRAZING) * max(max(c.nl, c.ne), GRAZING));
    return params.coat_normalisation * lobe * reflected * seen;
}

// Share of unpolarised light reflected by a clear surface.
fn fresnel(incidence: f32, ior: f32) -> f32 {
    let cosine = clamp(incidence, 0.0, 1.0);
    let inside_squared = 1.0 - (1.0 - cosine * cosine) / (ior * ior);
    if inside_squared <= 0.0 {
        return 1.0;
    }
    let inside = sqrt(inside_squared);
    let parallel = (ior * cosine - inside) / (ior * cosine + inside);
    let across = (cosine - ior * inside) / (cosine + ior * inside);
    return 0.5 * (parallel * parallel + across * across);
}

// The direction to the eye mirrored at the unit normal n.
fn mirrored(n: vec3<f32>, to_eye: vec3<f32>) -> vec3<f32> {
    let twice = 2.0 * scalar_product(n, to_eye);
    return twice * n - to_eye;
}

// Reflectance of a glass sheet between two parallel surfaces that each reflect the share r.
fn thin_sheet(r: f32) -> f32 {
    return 2.0 * r / (1.0 + r);
}
