// For each patch: twice the angle of one curvature direction, with its confidence as length, plus the fallback with the
// surface's flatness as length; the sum of both lengths; and 1.

// The unit direction of the curvature larger in magnitude, in the frame of the tensor; 0 without any.
fn curvature_tensor_larger(form: vec4<f32>) -> vec2<f32> {
    let d = select(-form.xy, form.xy, form.z >= 0.0);
    let length = sqrt(dot(d, d));
    let axis = select(vec2<f32>(d.y, length - d.x), vec2<f32>(d.x + length, d.y), d.x >= 0.0);
    let size = sqrt(dot(axis, axis));
    return select(vec2<f32>(0.0), axis / size, size > 0.0);
}

// Confidence of directions, 0..1.
fn curvature_tensor_confidence(form: vec4<f32>) -> f32 {
    let difference = sqrt(dot(form.xy, form.xy));
    let mean = abs(form.z);
    let lesser = min(difference, mean);
    let apart = 4.0 * lesser * lesser;
    if !(apart > 0.0) {
        return 0.0;
    }
    let share = max((lesser / max(difference, mean) - ROUND) / (1.0 - ROUND), 0.0);
    return share * share * apart / (apart + params.doubt * params.doubt);
}

// Flatness of the surface, 0..1.
fn curvature_tensor_flatness(form: vec4<f32>) -> f32 {
    let curvature = sqrt(dot(form.xy, form.xy)) + abs(form.z);
    let square = params.doubt * params.doubt;
    let share = square / (square + curvature * curvature);
    return select(0.0, share * share, square > 0.0);
}

// Twice the angle of the patch's own direction, with its confidence as length.
fn own_direction(i: u32, line: vec3<f32>) -> vec2<f32> {
    let form = forms[i];
    let normal = patches[i].normal;
    let most = curvature_tensor_larger(form);
    let axis = select(vec2<f32>(-most.y, most.x), most, params.family == 0u);
    let tangents = upright_tangents(normal);
    if all(axis == vec2<f32>(0.0)) || !tangents.are_there {
        return vec2<f32>(0.0);
    }
    let seen = picture_direction(line, axis.x * tangents.x + axis.y * tangents.y);
    let facing = clamp(sight_lines_facing(line, normal) / FACING, 0.0, 1.0);
    return curvature_tensor_confidence(form) * facing * facing * doubled(seen);
}

fn visit(i: u32) {
    let line = line(middle_of(i));
    let own = own_direction(i, line);
    let sure = sqrt(dot(own, own));
    let flat_share = curvature_tensor_flatness(forms[i]);
    let sum = own + flat_share * doubled(fallback(line, patches[i].normal));
    directions[i] = vec4<f32>(sum, sure + flat_share, 1.0);
}
