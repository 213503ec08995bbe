// A wave of directions: listed pixels without one take the mean of the neighbours that had one before the wave, turned
// to the fallback. Their neighbours are listed for the next wave.

// Whether directions spread only through open faces.
override THROUGH_FACES: bool;
// Whether pixels that turn fully take the fallback, and others nothing.
override IS_FIXED: bool;

// Contribution of a neighbour: twice its angle, and 1, weighted by the path from it.
fn neighbour(i: u32, next_to: u32) -> vec3<f32> {
    let state = atomicLoad(&filled[i]);
    if state == 0u || state > params.wave {
        return vec3<f32>(0.0);
    }
    var weight = 1.0;
    if THROUGH_FACES {
        weight = face_conductance(conductance[i], conductance[next_to]);
    }
    return weight * vec3<f32>(doubled(vec2<f32>(direction_x[i], direction_y[i])), 1.0);
}

// The direction at half the angle of a sum of this weight; 0 if it cancels.
fn clear_direction(sum: vec2<f32>, weight: f32) -> vec2<f32> {
    let length = sqrt(dot(sum, sum));
    let axis = select(vec2<f32>(sum.y, length - sum.x), vec2<f32>(sum.x + length, sum.y), sum.x >= 0.0);
    let unit = 1.0 / sqrt(dot(axis, axis));
    let is_clear = length > CANCELLED * weight && is_finite(unit) && unit > 0.0;
    return select(vec2<f32>(0.0), axis * unit, is_clear);
}

fn mean_around(i: u32) -> vec2<f32> {
    let x = i % width();
    let y = i / width();
    var sum = vec3<f32>(0.0);
    if x > 0u {
        sum += neighbour(i - 1u, i);
    }
    if x + 1u < width() {
        sum += neighbour(i + 1u, i);
    }
    if y > 0u {
        sum += neighbour(i - width(), i);
    }
    if y + 1u < height() {
        sum += neighbour(i + width(), i);
    }
    return clear_direction(sum.xy, sum.z);
}

fn fallback_at(i: u32) -> vec2<f32> {
    let place = vec2<f32>(f32(i % width()), f32(i / width())) + 0.5;
    return fallback(line(place), vec3<f32>(normal_x[i], normal_y[i], normal_z[i]));
}

// The mean turned by a share toward the fallback.
fn turned(i: u32, mean: vec2<f32>, share: f32) -> vec2<f32> {
    if share == 0.0 || all(mean == vec2<f32>(0.0)) {
        return mean;
    }
    let last = fallback_at(i);
    let direction = clear_direction((1.0 - share) * doubled(mean) + share * doubled(last), 1.0);
    return select(direction, last, all(direction == vec2<f32>(0.0)));
}

// Lists a pixel that waits for a direction, once.
fn list_next(i: u32) {
    let is_shut = THROUGH_FACES && !(conductance[i] > 0.0);
    if is_shut || atomicLoad(&filled[i]) != 0u {
        return;
    }
    let mark = 2u * (params.wave + 1u) + (atomicLoad(&marks[i]) & 1u);
    if atomicExchange(&marks[i], mark) != mark {
        next[atomicAdd(&counts[params.next_count], 1u)] = i;
    }
}

fn list_around(i: u32) {
    let x = i % width();
    let y = i / width();
    if x > 0u {
        list_next(i - 1u);
    }
    if x + 1u < width() {
        list_next(i + 1u);
    }
    if y > 0u {
        list_next(i - width());
    }
    if y + 1u < height() {
        list_next(i + width());
    }
}

@compute @workgroup_size(LIST_INVOCATIONS)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let count = atomicLoad(&counts[params.list_count]);
    for (var k = id.x; k < count; k += groups.x * LIST_INVOCATIONS) {
        let i = list[k];
        if atomicLoad(&filled[i]) != 0u {
            continue;
        }
        let is_flat = (atomicLoad(&marks[i]) & 1u) == 1u;
        let share = select(params.share, params.flat_share, is_flat);
        var direction = vec2<f32>(0.0);
        if !IS_FIXED {
            direction = turned(i, mean_around(i), share);
        } else if share == 1.0 {
            direction = fallback_at(i);
        }
        if any(direction != vec2<f32>(0.0)) {
            direction_x[i] = direction.x;
            direction_y[i] = direction.y;
            atomicStore(&filled[i], params.wave + 1u);
            if !IS_FIXED {
                list_around(i);
            }
        }
    }
}
