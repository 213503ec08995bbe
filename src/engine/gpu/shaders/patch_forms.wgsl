// The tensor of curvature of each patch, per pixel, from the rays along the normals of the patches around it: half the
// difference of the curvatures toward twice the angle of the larger one, their mean, and 1.

@group(0) @binding(0) var<uniform> params: DirectionParams;
@group(0) @binding(1) var<storage, read> held: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> further: u32;
@group(0) @binding(3) var<storage, read> patches: array<Patch>;
@group(0) @binding(4) var<storage, read> links: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> forms: array<vec4<f32>>;

// From a patch to where it goes on, in pixels, x right and y down.
fn step_between(here: Patch, there: Patch) -> vec2<f32> {
    let cells = vec2<i32>(column_and_row(there.cell)) - vec2<i32>(column_and_row(here.cell));
    return vec2<f32>(cells * i32(params.cell_px)) + (there.offset - here.offset);
}

fn ray_of(here: Patch, tangents: Tangents, i: u32) -> Ray {
    if i == NO_PATCH {
        return no_ray();
    }
    let there = patches[i];
    let line = line_at(middle_of(here.cell, here.offset));
    let line_there = line_at(middle_of(there.cell, there.offset));
    let apart = vec3<f32>(step_between(here, there) * vec2<f32>(params.apart_x_step, params.apart_y_step), 0.0);
    let step = square_step(here.normal + there.normal, line, line_there, apart);
    let turn = there.normal - here.normal;
    return ray_after(step, there.normal, turn, here.normal, array(tangents.x, tangents.y));
}

// The tensor; its last component is 0 where there is none.
fn form_of(i: u32) -> vec4<f32> {
    let here = patches[i];
    let tangents = upright_tangents(here.normal);
    let around = links[i];
    let form = form_between(
        ray_of(here, tangents, around.x),
        ray_of(here, tangents, around.y),
        ray_of(here, tangents, around.w),
        ray_of(here, tangents, around.z),
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
