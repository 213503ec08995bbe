// Means of values around each patch, along the chains of both axes, with weights that fall linearly to 0.

// Whether the radius is inversely proportional to depth.
override IS_BY_DEPTH: bool;
// Whether means reach no farther than a run, so that visiting patches is cheaper than sums.
override IS_NEAR: bool;

fn run_of(i: u32, axis: u32) -> vec4<u32> {
    if axis == 0u {
        return runs_across[i];
    }
    return runs_down[i];
}

fn until(i: u32, axis: u32) -> Sum {
    if axis == 0u {
        return sums_across[i].until;
    }
    return sums_down[i].until;
}

fn since(i: u32, axis: u32) -> Sum {
    if axis == 0u {
        return sums_across[i].since;
    }
    return sums_down[i].since;
}

// Distance of a place from the start of its run.
fn in_cells(place: i32) -> i32 {
    return place % i32(RUN_CELLS);
}

// The patch `steps` steps from the first one of a run.
fn in_run(first: u32, axis: u32, steps: u32) -> u32 {
    var cell = first;
    if first >= cell_count() {
        cell = patches[first].cell;
    }
    cell += steps * select(params.columns, 1u, axis == 0u);
    let own = held[cell];
    if own.x > 0u && run_of(cell, axis).x == first {
        return cell;
    }
    for (var k = 1u; k < own.x; k++) {
        let i = patch_of(cell, own, k);
        if run_of(i, axis).x == first {
            return i;
        }
    }
    return first;
}

// The weighted sum over the patches on one side of a patch, at most `far` of them.
fn sum_beside(start: u32, side: u32, far: i32, slope: f32) -> vec4<f32> {
    var total = vec4<f32>(0.0);
    var i = links[start][side];
    for (var step = 1; step <= far && i != NO_PATCH; step++) {
        total += (1.0 - slope * f32(step)) * values[i];
        i = links[i][side];
    }
    return total;
}

// The same after a patch at `own`, run by run.
fn sum_after(start: u32, axis: u32, own: i32, far: i32, slope: f32) -> vec4<f32> {
    let side = 2u * axis + 1u;
    let goal = own + far;
    let own_run = run_of(start, axis);
    var place = own + i32(own_run.w) + 1;
    if place > goal + 1 {
        return sum_beside(start, side, far, slope);
    }
    var total = vec4<f32>(0.0);
    if own_run.w > 0u {
        let sum = since(links[start][side], axis);
        total = (1.0 + slope * f32(in_cells(own))) * sum.plain - slope * sum.placed;
    }
    var i = links[own_run.y][side];
    while i != NO_PATCH && place <= goal {
        let run = run_of(i, axis);
        let steps = goal - place;
        var end = run.y;
        if i32(run.w) > steps {
            end = in_run(i, axis, u32(steps));
        }
        let sum = until(end, axis);
        total += (1.0 + slope * f32(own - place)) * sum.plain - slope * sum.placed;
        place += i32(run.w) + 1;
        i = links[run.y][side];
    }
    return total;
}

// The same before it.
fn sum_before(start: u32, axis: u32, own: i32, far: i32, slope: f32) -> vec4<f32> {
    let side = 2u * axis;
    let goal = own - far;
    let own_run = run_of(start, axis);
    var place = own - i32(own_run.z) - 1;
    if place < goal - 1 {
        return sum_beside(start, side, far, slope);
    }
    var total = vec4<f32>(0.0);
    if own_run.z > 0u {
        let sum = until(links[start][side], axis);
        total = (1.0 - slope * f32(in_cells(own))) * sum.plain + slope * sum.placed;
    }
    var i = links[own_run.x][side];
    while i != NO_PATCH && place >= goal {
        let run = run_of(i, axis);
        let first = place - i32(run.z);
        var end = run.x;
        if first < goal {
            end = in_run(run.x, axis, u32(goal - first));
        }
        let sum = since(end, axis);
        let begin = place - in_cells(place);
        total += (1.0 - slope * f32(own - begin)) * sum.plain + slope * sum.placed;
        place = first - 1;
        i = links[run.x][side];
    }
    return total;
}

// The weighted sum around a patch, up to the distance `far`.
fn sum_around(i: u32, far: i32, slope: f32) -> vec4<f32> {
    var sum = values[i];
    if IS_NEAR {
        for (var side = 0u; side < 4u; side++) {
            sum += sum_beside(i, side, far, slope);
        }
        return sum;
    }
    let places = column_and_row(patches[i].cell);
    for (var axis = 0u; axis < 2u; axis++) {
        let own = i32(places[axis]);
        sum += sum_before(i, axis, own, far, slope) + sum_after(i, axis, own, far, slope);
    }
    return sum;
}

fn visit(i: u32) {
    var reach = params.reach;
    if IS_BY_DEPTH && depths[i] > 0.0 {
        reach *= clamp(params.median / depths[i], FAR, NEAR);
    }
    // The last place whose weight is above 0.
    let far = i32(ceil(reach)) - 1;
    let sum = sum_around(i, far, 1.0 / reach);
    means[i] = sum / sum.w;
}
