// The tensor of curvature of each patch, per pixel, from the rays along the normals of the patches around it: half the
// difference of the curvatures toward twice the angle of the larger one, their mean, and 1.

// The step from a patch to its continuation, in pixels, x right and y down.
fn step_between(from_patch: u32, to_patch: u32) -> vec2<f32> {
    let here = patches[from_patch];
    let there = patches[to_patch];
    let cells = vec2<i32>(column_and_row(there.cell)) - vec2<i32>(column_and_row(here.cell));
    return vec2<f32>(cells * i32(params.cell_px)) + (there.offset - here.offset);
}

// The ray of the patch `i`, beside the patch `own`.
fn ray_of(own: u32, tangents: Tangents, i: u32) -> Ray {
    if i == NO_PATCH {
        return no_ray();
    }
    let here = patches[own].normal;
    let there = patches[i].normal;
    let apart = vec3<f32>(step_between(own, i) * vec2<f32>(params.apart_x_step, params.apart_y_step), 0.0);
    let step = sight_lines_step(here + there, line(middle_of(own)), line(middle_of(i)), apart);
    return local_ray(step, there, there - here, here, array(tangents.x, tangents.y));
}

// The tensor; its last component is 0 if there is none.
fn form_of(i: u32) -> vec4<f32> {
    let tangents = upright_tangents(patches[i].normal);
    let around = links[i];
    let form = slopes_of(
        ray_of(i, tangents, around.x),
        ray_of(i, tangents, around.y),
        ray_of(i, tangents, around.w),
        ray_of(i, tangents, around.z),
    );
    if !tangents.are_there || !form.is_there {
        return vec4<f32>(0.0);
    }
    return vec4<f32>(params.per_pixel * form.deviator, params.per_pixel * form.mean, 1.0);
}

fn visit(i: u32) {
    let form = form_of(i);
    let is_known = is_finite(form.x) && is_finite(form.y) && is_finite(form.z);
    forms[i] = select(vec4<f32>(0.0, 0.0, 0.0, 1.0), form, is_known && form.w == 1.0);
}
