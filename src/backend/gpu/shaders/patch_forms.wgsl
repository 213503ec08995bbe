// The tensor of curvature of each patch, per pixel, from the rays along the normals of the patches around it: half the
// difference of the curvatures toward twice the angle of the larger one, their mean, and 1.

@group(0) @binding(0) var<uniform> params: DirectionParams;
@group(0) @binding(1) var<storage, read> held: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> further: u32;
@group(0) @binding(3) var<storage, read> patches: array<Patch>;
@group(0) @binding(4) var<storage, read> links: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> forms: array<vec4<f32>>;

// Where the ray of a normal meets the tangent plane of another patch, and its slope there.
struct Ray {
    is_there: bool,
    foot: vec2<f32>,
    slope: vec2<f32>,
}

const NO_RAY = Ray(false, vec2<f32>(0.0), vec2<f32>(0.0));

// From a patch to where it goes on, in pixels, x right and y down.
fn step_between(here: Patch, there: Patch) -> vec2<f32> {
    let cells = vec2<i32>(column_and_row(there.cell)) - vec2<i32>(column_and_row(here.cell));
    return vec2<f32>(cells * i32(params.cell_px)) + (there.offset - here.offset);
}

fn ray_of(here: Patch, tangents: Tangents, i: u32) -> Ray {
    if i == NO_PATCH {
        return NO_RAY;
    }
    let there = patches[i];
    // The step is taken square to the sum of both normals. What sight lines differ by is told by itself: their
    // difference would lose it.
    let normals = here.normal + there.normal;
    let line = line_at(middle_of(here.cell, here.offset));
    let line_there = line_at(middle_of(there.cell, there.offset));
    let facing = dot(normals, line_there);
    let apart = vec3<f32>(step_between(here, there) * vec2<f32>(params.apart_x_step, params.apart_y_step), 0.0);
    let offset = apart - dot(normals, apart) / facing * line_there;
    // Of the normals' difference too: what they have in common lies along the own one.
    let turn = there.normal - here.normal;
    let lean = vec2<f32>(dot(tangents.x, turn), dot(tangents.y, turn));
    let up = dot(here.normal, there.normal);
    let slope = lean / up;
    let foot = vec2<f32>(dot(tangents.x, offset), dot(tangents.y, offset)) - dot(here.normal, offset) * slope;
    let is_there = dot(normals, line) < 0.0
        && facing < 0.0
        && up > MIN_COSINE * sqrt(dot(lean, lean) + up * up)
        && is_finite(foot.x)
        && is_finite(foot.y)
        && is_finite(slope.x)
        && is_finite(slope.y);
    if is_there {
        return Ray(true, foot, slope);
    }
    return NO_RAY;
}

// The tensor; its last component is 0 where there is none.
fn form_of(i: u32) -> vec4<f32> {
    let here = patches[i];
    let tangents = upright_tangents(here.normal);
    let around = links[i];
    let left = ray_of(here, tangents, around.x);
    let right = ray_of(here, tangents, around.y);
    let above = ray_of(here, tangents, around.z);
    let below = ray_of(here, tangents, around.w);
    let are_there = tangents.are_there && (left.is_there || right.is_there) && (above.is_there || below.is_there);
    // The own ray, all 0, stands in for one that is missing.
    let u = right.foot - left.foot;
    let v = above.foot - below.foot;
    let slope_x = right.slope - left.slope;
    let slope_y = above.slope - below.slope;
    let area = u.x * v.y - u.y * v.x;
    if !are_there || !(abs(area) > MIN_SINE * (dot(u, u) + dot(v, v))) {
        return vec4<f32>(0.0);
    }
    let column_x = (slope_y * u.y - slope_x * v.y) / area;
    let column_y = (slope_x * v.x - slope_y * u.x) / area;
    let mean = 0.5 * (column_x.x + column_y.y);
    let deviator = 0.5 * vec2<f32>(column_x.x - column_y.y, column_x.y + column_y.x);
    return vec4<f32>(params.per_pixel * deviator, params.per_pixel * mean, 1.0);
}

fn visit(i: u32) {
    let form = form_of(i);
    let is_known = is_finite(form.x) && is_finite(form.y) && is_finite(form.z);
    forms[i] = select(vec4<f32>(0.0, 0.0, 0.0, 1.0), form, is_known && form.w == 1.0);
}
