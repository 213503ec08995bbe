// Relighting: prepare, sum, look up, compose.

override HAS_HESSIAN: bool;
override HAS_TRACE: bool;
override HAS_OCCLUSION: bool;
override HAS_ALPHA: bool;
override HAS_ALBEDO: bool;
// Whether the albedo is premultiplied by coverage.
override ALBEDO_IS_COVERED: bool;
// Look-ups made once per pixel.
override PREFILTERED: bool;
override MIRRORED: bool;
override GLASS: bool;
override LIT_SPHERE: bool;
override TWO_SPHERES: bool;
override HAS_CONTRAST: bool;
// Whether single lights have a specular term.
override GLOSSY: bool;
override FEW_TONES: bool;
override TOON: bool;

// Red, green and blue of reflected light, of albedo 1.
var<private> diffuse: vec3<f32>;
var<private> specular: vec3<f32>;

fn luminance(rgb: vec3<f32>) -> f32 {
    return rgb.x * params.weights.x + rgb.y * params.weights.y + rgb.z * params.weights.z;
}

// Unit tangents along the grain and across it.
fn set_grain() {
    let n = pixel.normal.vector;
    let x = params.grain.x;
    let y = params.grain.y;
    // The part of (x, y, 0) perpendicular to the normal; if that vanishes any tangent will do.
    let along = x * n.x + y * n.y;
    let tangent = vec3<f32>(x - along * n.x, y - along * n.y, -along * n.z);
    let square = scalar_product(tangent, tangent);
    var u = vec3<f32>(0.0, 0.0, 1.0);
    if square > SHORTEST_TANGENT {
        u = tangent * (1.0 / sqrt(square));
    }
    pixel.along.vector = u;
    pixel.across.vector = vec3<f32>(
        n.y * u.z - n.z * u.y,
        n.z * u.x - n.x * u.z,
        n.x * u.y - n.y * u.x,
    );
}

fn find_kappa(i: u32) {
    var trace = hessian_xx[i];
    if HAS_HESSIAN {
        trace = pixel.hessian.x + pixel.hessian.z;
    }
    pixel.kappa = mapped_curvature(trace, params.gain);
}

// Prepares the light-independent state of the pixel.
fn prepare(i: u32, column: u32, row: u32) {
    pixel.normal.vector = vec3<f32>(normal_x[i], normal_y[i], normal_z[i]);
    let to_eye = vec2<f32>(
        params.to_eye.x + f32(column) * params.to_eye.z,
        params.to_eye.y + f32(row) * params.to_eye.w,
    );
    let inverse = 1.0 / sqrt(to_eye.x * to_eye.x + to_eye.y * to_eye.y + 1.0);
    pixel.to_eye.vector = vec3<f32>(to_eye, 1.0) * inverse;
    if params.point_count > 0u {
        let line = vec3<f32>(-to_eye, -1.0);
        let start = vec3<f32>(
            params.start.x + f32(column) * params.start.z,
            params.start.y + f32(row) * params.start.w,
            0.0,
        );
        let planar = depth[i] * select(1.0, inverse, params.depth_along_ray == 1u);
        pixel.point = start + planar * line;
    }
    pixel.occlusion = 1.0;
    if HAS_OCCLUSION {
        pixel.occlusion = occlusion[i];
    }
    if PHONG || PREFILTERED || MIRRORED {
        pixel.mirrored.vector = mirrored(pixel.normal.vector, pixel.to_eye.vector);
    }
    if ASHIKHMIN_SHIRLEY {
        set_grain();
    }
    if HAS_HESSIAN {
        pixel.hessian = vec3<f32>(hessian_xx[i], hessian_xy[i], hessian_yy[i]);
    }
    if WARPS {
        pixel.unwarp = warp_of(pixel.hessian, -params.warp * params.gain);
        let xx = pixel.unwarp.x;
        let xy = pixel.unwarp.y;
        let yy = pixel.unwarp.z;
        pixel.unwarp_squared = vec3<f32>(xx * xx + xy * xy, 2.0 * xy * (xx + yy), xy * xy + yy * yy);
        pixel.spread = warp_determinant(pixel.unwarp);
        pixel.normal.unwarped = warp_apply(pixel.unwarp, pixel.normal.vector);
        pixel.to_eye.unwarped = warp_apply(pixel.unwarp, pixel.to_eye.vector);
        pixel.mirrored.unwarped = warp_apply(pixel.unwarp, pixel.mirrored.vector);
        pixel.along.unwarped = warp_apply(pixel.unwarp, pixel.along.vector);
        pixel.across.unwarped = warp_apply(pixel.unwarp, pixel.across.vector);
    }
    if HAS_HESSIAN || HAS_TRACE {
        find_kappa(i);
    }
    if SCALES {
        let exponents = exponents_of(pixel.kappa);
        pixel.ambient_curve = scaling_curve_of(exponents.x);
        pixel.diffuse_curve = scaling_curve_of(exponents.y);
        pixel.specular_curve = scaling_curve_of(exponents.z);
    }
}

// Adds one light of this colour.
fn add(light: Arriving, color: vec3<f32>) {
    let terms = reflect_light(light);
    diffuse += terms.diffuse * color;
    if GLOSSY {
        specular += terms.specular * color;
    }
}

// Adds lights of uniform intensity.
fn add_even(first: u32, count: u32) {
    for (var k = 0u; k < count; k++) {
        let at = first + 3u * k;
        let light = Arriving(lights[at].xyz, lights[at + 1u].xyz, 1.0);
        add(light, lights[at + 2u].rgb);
    }
}

// Adds a point light.
fn add_near(position: vec3<f32>, color: vec3<f32>) {
    let to = position - pixel.point;
    let square = scalar_product(to, to);
    // A light on the surface itself has no direction.
    var inverse = 0.0;
    if square > MIN_POSITIVE {
        inverse = 1.0 / square;
    }
    let direction = to * sqrt(inverse);
    add(Arriving(direction, half_vector(direction), inverse), color);
}

// The warped direction of a look-up.
fn warped_lookup(toward: vec3<f32>) -> vec3<f32> {
    if !WARPS {
        return toward;
    }
    return warp_direction(warp_inverse(pixel.unwarp), half_vector(toward));
}

// The intensity of one of the even directions, looked up where it is warped to, with its cosine limited by
// MOST_BRIGHTENED.
fn look_even_up(direction: vec3<f32>) -> vec3<f32> {
    let toward = warped_lookup(direction);
    let n = pixel.normal.vector;
    let cosine = scalar_product(n, direction);
    let warped = scalar_product(n, toward);
    let held = max(MOST_BRIGHTENED * warped, 0.0);
    var share = params.even_share;
    if WARPS && held < cosine {
        share *= held / cosine;
    }
    return share * radiance(first_map(), toward);
}

// The sum over single lights.
fn add_lights() {
    // Light from all around comes first: occlusion dims only that.
    var at = 0u;
    add_even(at, params.around_count);
    at += 3u * params.around_count;
    for (var k = 0u; k < params.even_count; k++) {
        let direction = lights[at + k].xyz;
        if scalar_product(pixel.normal.vector, direction) > 0.0 {
            add(Arriving(direction, half_vector(direction), 1.0), look_even_up(direction));
        }
    }
    at += params.even_count;
    if HAS_OCCLUSION {
        diffuse *= pixel.occlusion;
    }
    add_even(at, params.direction_count);
    at += 3u * params.direction_count;
    for (var k = 0u; k < params.point_count; k++) {
        add_near(lights[at + 2u * k].xyz, lights[at + 2u * k + 1u].rgb);
    }
    if HAS_JACOBIAN {
        diffuse *= pixel.spread;
        specular *= pixel.spread;
    }
}

// The intensity of looked-up light: its luminance l over a level, or against a median.
fn intensity_of(l: f32, bend: f32, level: f32) -> f32 {
    return l / (bend * l + level);
}

// The radiance of a map from a warped direction, times a share, scaled by its own brightness.
fn seen(map: Map, direction: vec3<f32>, share: f32, curve: vec2<f32>) -> vec3<f32> {
    let found = radiance(map, warped_lookup(direction));
    var counts = share;
    if SCALES {
        let intensity = intensity_of(luminance(found), map.bend, map.level);
        counts *= scaling_curve_at(curve, intensity, params.invariant_point);
    }
    return found * counts;
}

// Adds light refracted through glass; returns the reflected share.
fn add_refracted(share: f32) -> f32 {
    let n = pixel.normal.vector;
    let eye = pixel.to_eye.vector;
    let cosine = scalar_product(n, eye);
    var mirrored_share = fresnel(cosine, params.ior);
    var through = -eye;
    if params.is_thin == 1u {
        mirrored_share = thin_sheet(mirrored_share);
    } else {
        let inside = 1.0 - (1.0 - cosine * cosine) / (params.ior * params.ior);
        if inside >= 0.0 {
            // Snell: the component along the surface shrinks by the index.
            let along = cosine / params.ior - sqrt(inside);
            through = along * n - eye / params.ior;
        } else {
            mirrored_share = 1.0;
        }
    }
    specular += seen(first_map(), through, share * (1.0 - mirrored_share), pixel.specular_curve);
    return share * mirrored_share;
}

// Adds the colours of the lit sphere, or of both blended by curvature. They include gains of their own.
fn add_spheres() {
    let own = 1.0 / max(params.diffuse_gain, MIN_POSITIVE);
    let toward = warped_lookup(pixel.normal.vector);
    let map = first_map();
    var color = on_disc(map, toward.xy);
    if TWO_SPHERES {
        let share = 0.5 + 0.5 * pixel.kappa;
        let concave = on_disc(second_map(), toward.xy);
        color = concave + share * (color - concave);
    }
    var sigma = 1.0;
    if SCALES {
        let intensity = intensity_of(luminance(color), map.bend, map.level);
        sigma = scaling_curve_at(pixel.diffuse_curve, intensity, params.invariant_point);
    }
    diffuse += color * sigma * own;
}

// Adds the look-ups of the pixel to the sums.
fn add_lookups() {
    let gain = params.environment_gain;
    if PREFILTERED {
        diffuse += seen(first_map(), pixel.normal.vector, gain * pixel.occlusion, pixel.diffuse_curve);
        if PHONG {
            // In a sum over lights the lobe peaks at 1; in the map it has the energy of a cosine.
            specular += seen(second_map(), pixel.mirrored.vector, gain * params.map_lobe, pixel.specular_curve);
        }
    }
    if MIRRORED {
        var share = gain;
        if GLASS {
            share = add_refracted(share);
        }
        specular += seen(first_map(), pixel.mirrored.vector, share, pixel.specular_curve);
    }
    if LIT_SPHERE {
        add_spheres();
    }
}

// Premultiplies, and clamps to finite values.
fn premultiplied(shown: f32, coverage: f32) -> f32 {
    let covering = shown * coverage;
    if is_nan(covering) {
        return bitcast<f32>(params.nan_bits);
    }
    return clamp(covering, -F32_MAX, F32_MAX);
}

// Combines the terms: gains, contrast, tones, coverage.
fn compose(i: u32) {
    add_lookups();
    // The intensity of ambient light is 1 in the open, else the occlusion.
    var ambient = params.ambient * pixel.occlusion;
    if SCALES {
        ambient *= scaling_curve_at(pixel.ambient_curve, pixel.occlusion, params.invariant_point);
    }
    var shown = ambient + params.diffuse_gain * diffuse;
    if HAS_CONTRAST {
        // The contrast of a warp is the reciprocal of that of its inverse.
        let factor = contrast(pixel.unwarp, -params.contrast);
        shown *= factor;
        specular *= factor;
    }
    // Toon quantises the light; for other materials the visible colour is quantised.
    if FEW_TONES && TOON {
        shown *= tone_factor(luminance(shown));
    }
    var coverage = 1.0;
    if HAS_ALPHA {
        coverage = alpha[i];
    }
    if HAS_ALBEDO {
        var albedo = vec3<f32>(red[i], green[i], blue[i]);
        if ALBEDO_IS_COVERED && coverage > 0.0 {
            // Divides the albedo by coverage, which the result is multiplied by once more.
            albedo *= 1.0 / coverage;
        }
        shown *= albedo;
    }
    shown += params.specular_gain * specular;
    if FEW_TONES && !TOON {
        shown *= tone_factor(luminance(shown));
    }
    red[i] = premultiplied(shown.x, coverage);
    green[i] = premultiplied(shown.y, coverage);
    blue[i] = premultiplied(shown.z, coverage);
}

fn at_pixel(id: vec2<u32>, i: u32) {
    if !is_covered(id.x, id.y) {
        return;
    }
    prepare(i, id.x, id.y);
    add_lights();
    compose(i);
}
