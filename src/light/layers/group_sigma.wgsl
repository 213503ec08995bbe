// The scaling of a light group: the mean over its directions, 1 where all are below the horizon.

override TOWARD_LIGHT: bool;

fn kappa_toward(i: u32, light: vec3<f32>) -> f32 {
    if TOWARD_LIGHT {
        let entries = vec3<f32>(curvature_xx[i], curvature_xy[i], curvature_yy[i]);
        return mapped_curvature_toward(entries, light.xy, params.gain, params.anisotropy);
    }
    return mapped_curvature(curvature_xx[i], params.gain);
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    var plain = 0.0;
    var scaled = 0.0;
    if is_covered(id.x, id.y) {
        for (var k = 0u; k < params.light_count; k++) {
            let light = vec3<f32>(to_light[3u * k], to_light[3u * k + 1u], to_light[3u * k + 2u]);
            let facing = max(normal_x[i] * light.x + normal_y[i] * light.y + normal_z[i] * light.z, 0.0);
            plain += facing;
            // Intensity is the share of 1 that arrives.
            scaled += facing * term_scaling_sigma(facing, 1.0, kappa_toward(i, light));
        }
    }
    sigma[i] = select(1.0, scaled / max(plain, MIN_POSITIVE), plain > 0.0);
}
