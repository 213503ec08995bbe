// From patches to pixels: interpolates the directions of the patches around a pixel, never across an edge. Lists
// covered pixels that get none.

// The directions of a patch and the eight around it, row by row.
var<private> around: array<vec2<f32>, 9>;

fn neighbour(i: u32, side: u32) -> u32 {
    if i == NO_PATCH {
        return NO_PATCH;
    }
    return links[i][side];
}

fn direction_of(i: u32, own: u32) -> vec2<f32> {
    return settled[select(i, own, i == NO_PATCH)];
}

// The mean of two patches, or the one that exists.
fn either(a: u32, b: u32) -> vec2<f32> {
    return 0.5 * (settled[select(a, b, a == NO_PATCH)] + settled[select(b, a, b == NO_PATCH)]);
}

// A corner may be a different patch when reached via the side than via the end. Where the surface ends, the nearest
// patch replaces the missing one.
fn corner(own: u32, side: u32, end: u32, sideways: u32, endways: u32) -> vec2<f32> {
    let by_side = neighbour(side, endways);
    let by_end = neighbour(end, sideways);
    if by_side != NO_PATCH || by_end != NO_PATCH {
        return either(by_side, by_end);
    }
    if side != NO_PATCH || end != NO_PATCH {
        return either(side, end);
    }
    return settled[own];
}

fn look_around(own: u32) {
    let there = links[own];
    around[0] = corner(own, there.x, there.z, 0u, 2u);
    around[1] = direction_of(there.z, own);
    around[2] = corner(own, there.y, there.z, 1u, 2u);
    around[3] = direction_of(there.x, own);
    around[4] = settled[own];
    around[5] = direction_of(there.y, own);
    around[6] = corner(own, there.x, there.w, 0u, 3u);
    around[7] = direction_of(there.w, own);
    around[8] = corner(own, there.y, there.w, 1u, 3u);
}

// Twice the angle between the middles of the patches looked at, at a place from -1/2 to 1/2 on both axes.
fn between(place: vec2<f32>) -> vec2<f32> {
    let row = select(6u, 0u, place.y < 0.0);
    let column = select(0u, 2u, place.x >= 0.0);
    let here = around[4] + abs(place.y) * (around[row + 1u] - around[4]);
    let beside = around[column + 3u] + abs(place.y) * (around[row + column] - around[column + 3u]);
    return here + abs(place.x) * (beside - here);
}

fn put(at: vec2<i32>, direction: vec2<f32>) {
    let i = index_of(u32(at.x), u32(at.y));
    direction_x[i] = direction.x;
    direction_y[i] = direction.y;
    marks[i] = 0u;
    if !is_covered(u32(at.x), u32(at.y)) {
        filled[i] = NOTHING;
        return;
    }
    let is_there = any(direction != vec2<f32>(0.0));
    filled[i] = u32(is_there);
    if !is_there {
        lacking[atomicAdd(&counts[OPEN_COUNT], 1u)] = i;
    }
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.columns || id.y >= params.rows {
        return;
    }
    let cell = id.y * params.columns + id.x;
    let first = corner_of(cell);
    let begin = max(first, vec2<i32>(0));
    let end = min(first + i32(params.cell_px), vec2<i32>(i32(width()), i32(height())));
    let own = held[cell];
    var left = vec2<u32>(NOTHING);
    for (var k = 0u; k < own.x; k++) {
        let i = patch_of(cell, own, k);
        let pixels = patches[i].pixels;
        left &= ~pixels;
        look_around(i);
        for (var y = begin.y; y < end.y; y++) {
            for (var x = begin.x; x < end.x; x++) {
                let inside = vec2<i32>(x, y) - first;
                if has_pixel(pixels, u32(inside.x), u32(inside.y)) {
                    let place = (vec2<f32>(inside) + 0.5) / f32(params.cell_px) - 0.5;
                    put(vec2<i32>(x, y), halved(between(place)));
                }
            }
        }
    }
    for (var y = begin.y; y < end.y; y++) {
        for (var x = begin.x; x < end.x; x++) {
            if has_pixel(left, u32(x - first.x), u32(y - first.y)) {
                put(vec2<i32>(x, y), vec2<f32>(0.0));
            }
        }
    }
}
