// Reflectance: the share of the light from one direction that is reflected toward the eye.

// The lobes; the cosine or a power of it if none is set.
override PHONG: bool;
override BLINN_PHONG: bool;
override ASHIKHMIN_SHIRLEY: bool;

// A light reflected by the lobes, for a weight of 1, and the intensities that radiance scaling takes of it.
struct Reflected {
    cosine: f32,
    lobe: f32,
    diffuse: f32,
    specular: f32,
}

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
    return ashikhmin_shirley_leaving(ne) * entering(nl);
}

// The coat.
fn ashikhmin_shirley_specular(c: Cosines) -> f32 {
    let uu = c.hu * c.hu;
    let vv = c.hv * c.hv;
    let lobe = exp_of(ashikhmin_shirley_log_lobe(1.0 - (uu + vv), ashikhmin_shirley_exponent(uu, vv)));
    let per_ne = 1.0 / max(c.ne, GRAZING);
    let per_he = 1.0 / max(c.he, GRAZING);
    return params.lobe_2 * lobe * (ashikhmin_shirley_reflected(c.he) * share_seen(c.nl, per_ne, per_he));
}

// Share of the light in the base that leaves at an angle of this cosine.
fn ashikhmin_shirley_leaving(cosine: f32) -> f32 {
    return BASE_SCALE * (1.0 - params.lobe_3) * passed(cosine);
}

// The exponent of the square of n.h, for the squares of the components of h along the grain and across it.
fn ashikhmin_shirley_exponent(uu: f32, vv: f32) -> f32 {
    if params.lobe_0 == params.lobe_1 {
        return 0.5 * params.lobe_0;
    }
    return 0.5 * (params.lobe_0 * uu + params.lobe_1 * vv) / max(uu + vv, MIN_POSITIVE);
}

// The logarithm of the lobe from the square of n.h and its exponent.
fn ashikhmin_shirley_log_lobe(nh_squared: f32, exponent: f32) -> f32 {
    return max(exponent * ln(max(nh_squared, MIN_POSITIVE)), FAINTEST);
}

// Share of the light that the coat reflects, for the cosine of incidence.
fn ashikhmin_shirley_reflected(he: f32) -> f32 {
    return params.lobe_3 + (1.0 - params.lobe_3) * fifth_power(1.0 - he);
}

// The coat's n.l / (h.e max(n.l, n.e)), from the reciprocals of n.e and h.e.
fn share_seen(nl: f32, per_ne: f32, per_he: f32) -> f32 {
    return min(nl * per_ne, 1.0) * per_he;
}

// The light that enters the base from a light of this cosine.
fn entering(nl: f32) -> f32 {
    return passed(nl) * nl;
}

// Reflects a light by the lobes.
fn reflect_by_lobes(light: Arriving, arrived: Incidence) -> Reflected {
    let cosine = arrived.cosine;
    if ASHIKHMIN_SHIRLEY {
        return coat(light, arrived);
    }
    if PHONG {
        let lobe = exponent_raise(at_most_1(positive(product(light, arrived.inverse, pixel.mirrored))));
        return Reflected(cosine, lobe, cosine, lobe);
    }
    if BLINN_PHONG {
        var lobe = arrived.lobe;
        if !FAR_EYE {
            let light_eye = product(light, arrived.inverse, pixel.to_eye);
            // Recomputed, since the stored cosine may be limited.
            let light_normal = product(light, arrived.inverse, pixel.normal);
            lobe = half_way(light_eye, light_normal, scalar_product(pixel.normal.vector, pixel.to_eye.vector));
        }
        lobe = exponent_raise(lobe);
        return Reflected(cosine, lobe, cosine, cosine * lobe);
    }
    let power = exponent_raise(cosine);
    return Reflected(power, arrived.lobe, power, 0.0);
}

// Both terms of the coated model.
fn coat(light: Arriving, arrived: Incidence) -> Reflected {
    let eye = pixel.to_eye.vector;
    let le = product(light, arrived.inverse, pixel.to_eye);
    let lu = product(light, arrived.inverse, pixel.along);
    let lv = product(light, arrived.inverse, pixel.across);
    // h = (l + e) / |l + e|, |l + e|^2 = 2 + 2 l.e.
    let inverse = 1.0 / sqrt(max(2.0 + 2.0 * le, SHORTEST));
    let ne = min(positive(scalar_product(pixel.normal.vector, eye)), 1.0);
    let cosines = Cosines(
        arrived.cosine,
        ne,
        clamp((1.0 + le) * inverse, 0.0, 1.0),
        (lu + scalar_product(pixel.along.vector, eye)) * inverse,
        (lv + scalar_product(pixel.across.vector, eye)) * inverse,
    );
    // n . h, from the parts of h along and across the grain.
    let aside = cosines.hu * cosines.hu + cosines.hv * cosines.hv;
    let lobe = sqrt(positive(1.0 - aside));
    let diffuse = ashikhmin_shirley_diffuse(cosines.nl, ne);
    return Reflected(cosines.nl, lobe, diffuse, ashikhmin_shirley_specular(cosines));
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
