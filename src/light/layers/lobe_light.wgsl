// The light of a lobe before multiplication by the surface's colour. Colours are consecutive red, green and blue
// planes; absent light is 0, an absent colour 1.

override HAS_DIRECT: bool;
override HAS_INDIRECT: bool;
override HAS_ALBEDO: bool;

// A dark surface in bright light counts as bright.
fn lobe_luminance(i: u32) -> f32 {
    let plane = width() * height();
    var weights = array<f32, 3>(params.weight_r, params.weight_g, params.weight_b);
    var light = 0.0;
    var own = 0.0;
    for (var k = 0u; k < 3u; k++) {
        let at = k * plane + i;
        var from_lights = 0.0;
        var from_surfaces = 0.0;
        var color = 1.0;
        if HAS_DIRECT {
            from_lights = direct[at];
        }
        if HAS_INDIRECT {
            from_surfaces = indirect[at];
        }
        if HAS_ALBEDO {
            color = albedo[at];
        }
        light += weights[k] * (from_lights + from_surfaces);
        own += weights[k] * color;
    }
    return light / select(MIN_ALBEDO, own, own > MIN_ALBEDO && !is_nan(own));
}
