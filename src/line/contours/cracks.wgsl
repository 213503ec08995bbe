// The cracks with a silhouette among the candidates: a list in any order, as long as there is room.

override HAS_MAP: bool;
override IS_DEPTH: bool;
// Whether the sight lines of the depth are known, and whether they are parallel.
override HAS_SIGHT: bool;
override IS_EYE_FAR: bool;

fn is_inside(pixel: vec2<i32>) -> bool {
    return all(pixel >= vec2<i32>(0)) && all(pixel < vec2<i32>(i32(width()), i32(height())));
}

fn covers(pixel: vec2<i32>) -> bool {
    return is_inside(pixel) && is_covered(u32(pixel.x), u32(pixel.y));
}

fn index_at(pixel: vec2<i32>) -> u32 {
    return index_of(u32(pixel.x), u32(pixel.y));
}

// The map at a pixel, if it is covered and there is a map.
fn sample_at(pixel: vec2<i32>) -> Sample {
    if !covers(pixel) {
        return Sample(0.0, false);
    }
    let value = silhouette_map[index_at(pixel)];
    if !IS_DEPTH {
        return Sample(value, is_finite(value));
    }
    // A negative number has the highest bit set.
    let is_distance = bitcast<u32>(value) - 1u < 0x7f7fffffu;
    return Sample(ln(value), is_distance);
}

fn sharpened_at(pixel: vec2<i32>, value: f32) -> f32 {
    var least = value;
    var greatest = value;
    for (var j = 0; j < 9; j++) {
        let beside = sample_at(pixel + vec2<i32>(j % 3 - 1, j / 3 - 1));
        least = select(least, min(least, beside.value), beside.is_known);
        greatest = select(greatest, max(greatest, beside.value), beside.is_known);
    }
    return nearer_extreme(value, least, greatest);
}

fn normal_at(pixel: vec2<i32>) -> vec3<f32> {
    let i = index_at(pixel);
    return vec3<f32>(normal_x[i], normal_y[i], normal_z[i]);
}

// Step of the logarithm of depth between pixels, beyond that of a smooth surface with the normals on either side.
fn unexplained_by_normals(before: vec2<i32>, behind: vec2<i32>, step_of_log: f32) -> f32 {
    let normal = normal_at(before) + normal_at(behind);
    let eye = vec2<f32>(params.to_eye_x, params.to_eye_y);
    let eye_step = vec2<f32>(params.to_eye_x_step, params.to_eye_y_step);
    let here = facing(normal, eye + eye_step * vec2<f32>(before));
    let there = facing(normal, eye + eye_step * vec2<f32>(behind));
    if !(HAS_SIGHT && here > 0.0 && there > 0.0) {
        return abs(step_of_log);
    }
    var ratio = here / there;
    if IS_EYE_FAR {
        let across = vec2<f32>(behind - before) * vec2<f32>(params.start_x_step, params.start_y_step);
        ratio = 1.0 + dot(normal.xy, across) / here / silhouette_map[index_at(before)];
    }
    if !(ratio > 0.0 && is_finite(ratio)) {
        return abs(step_of_log);
    }
    return abs(step_of_log - ln(ratio));
}

fn is_bare(pixel: vec2<i32>) -> bool {
    return is_inside(pixel) && !covers(pixel);
}

fn add_crack(key: u32, offset: f32, strength: f32, log_depth: f32) {
    let place = atomicAdd(&counts[CRACKS], 1u);
    if place < arrayLength(&cracks) {
        cracks[place] = vec4<u32>(
            key,
            bitcast<u32>(offset),
            bitcast<u32>(strength),
            bitcast<u32>(log_depth),
        );
    }
}

// Adds the crack of a key, if a silhouette passes it.
fn look_at_crack(key: u32) {
    let axis = select(vec2<i32>(0, 1), vec2<i32>(1, 0), (key & 2u) != 0u);
    let behind = vec2<i32>(i32((key >> 2u) % width()), i32((key >> 2u) / width()));
    let before = behind - axis;
    let is_here = vec2<bool>(covers(before), covers(behind));
    if !any(is_here) {
        return;
    }
    if !all(is_here) {
        add_crack(key, 0.0, 1.0, 0.0);
        return;
    }
    if !HAS_MAP {
        return;
    }
    let samples = array<Sample, 6>(
        sample_at(before - 2 * axis),
        sample_at(before - axis),
        sample_at(before),
        sample_at(behind),
        sample_at(behind + axis),
        sample_at(behind + 2 * axis),
    );
    var jump = unexplained_jump(samples);
    if !(jump > params.least_jump) {
        return;
    }
    let raw = vec2<f32>(samples[2].value, samples[3].value);
    let sharp = vec2<f32>(sharpened_at(before, raw.x), sharpened_at(behind, raw.y));
    let step_of_map = sharp.y - sharp.x;
    if abs(step_of_map) < LEAST_STEP * jump {
        return;
    }
    if IS_DEPTH {
        jump = min(jump, unexplained_by_normals(before, behind, step_of_map));
        if !(jump > params.least_jump) {
            return;
        }
    }
    let is_beside = is_bare(before - 2 * axis) || is_bare(before - axis) || is_bare(behind + axis)
        || is_bare(behind + 2 * axis);
    let strength = select(min(jump, 1.0), jump / (jump + HALF_PLAIN_JUMP), IS_DEPTH);
    let log_depth = select(0.0, min(raw.x, raw.y), IS_DEPTH);
    add_crack(key + u32(is_beside), spread_offset(raw, sharp), strength, log_depth);
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let invocations = GROUP_COLUMNS * GROUP_ROWS;
    let end = min(atomicLoad(&counts[CANDIDATES]), arrayLength(&candidates));
    for (var k = group.x * invocations + local; k < end; k += groups.x * invocations) {
        look_at_crack(candidates[k]);
    }
}
