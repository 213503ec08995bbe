// Several sweeps of the diffusion operator over a tile, whose current term is kept in workgroup memory.
//
// A group loads a region, sweeps it, and outputs pixels at least as far inside as there were sweeps: a region loses one
// pixel per sweep at its rim. Earlier terms, sums and faces stay with the invocation that owns the pixel. A region
// without surface has no slopes, and is skipped.

override IS_EXPANSION: bool;
override BY_LEVEL: bool;

var<workgroup> region: array<vec2<f32>, REGION_PIXELS>;

fn is_inside(x: i32, y: i32) -> bool {
    return x >= 0 && y >= 0 && x < i32(width()) && y < i32(height());
}

// Whether an invocation owns a covered pixel.
fn holds_surface(x: i32, top: i32) -> bool {
    for (var k = 0u; k < ROWS_PER_INVOCATION; k++) {
        let y = top + i32(k);
        if is_inside(x, y) && is_covered(u32(x), u32(y)) {
            return true;
        }
    }
    return false;
}

// Whether any invocation of the group owns surface. Uses the memory of the region, which is not loaded yet: no more is
// guaranteed to groups.
fn is_reached(local: vec2<u32>, holds_surface: bool) -> bool {
    let row = local.y * REGION_COLUMNS;
    region[row + local.x].x = f32(holds_surface);
    workgroupBarrier();
    if local.x == 0u {
        for (var k = 1u; k < REGION_COLUMNS; k++) {
            region[row].x = max(region[row].x, region[row + k].x);
        }
    }
    workgroupBarrier();
    if all(local == vec2<u32>(0u)) {
        for (var k = 1u; k < REGION_GROUP_ROWS; k++) {
            region[0].x = max(region[0].x, region[k * REGION_COLUMNS].x);
        }
    }
    return workgroupUniformLoad(&region[0]).x > 0.0;
}

// A coordinate within the tile from `start` on that the frame repeats, so that its borders are joined.
fn within(at: i32, start: u32, length: u32, wraps: u32) -> i32 {
    if wraps == 0u {
        return at;
    }
    let period = i32(length);
    let offset = (at - i32(start)) % period;
    return i32(start) + select(offset, offset + period, offset < 0);
}

// The pixel whose sample is that of a place.
fn source(x: i32, y: i32) -> vec2<i32> {
    return vec2<i32>(
        within(x, params.tile_x, params.tile_width, params.wraps_x),
        within(y, params.tile_y, params.tile_height, params.wraps_y),
    );
}

fn conductance_at(x: i32, y: i32) -> f32 {
    let at = source(x, y);
    if !is_inside(at.x, at.y) {
        return 0.0;
    }
    return conductance[index_of(u32(at.x), u32(at.y))];
}

// Passes a pixel's terms and sum to the next pass, as far as it needs them.
fn give_out(i: u32, g: vec2<f32>, before: vec2<f32>, sum: vec2<f32>) {
    if IS_EXPANSION || BY_LEVEL {
        sums[i] = sum;
    }
    if params.is_final == 0u || !(IS_EXPANSION || BY_LEVEL) {
        next_last[i] = g;
        if IS_EXPANSION {
            next_earlier[i] = before;
        }
    }
}

@compute @workgroup_size(REGION_COLUMNS, REGION_GROUP_ROWS)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
) {
    let rim = i32(params.sweeps);
    let inner_columns = i32(REGION_COLUMNS) - 2 * rim;
    let inner_rows = i32(REGION_ROWS) - 2 * rim;
    let column = i32(local.x);
    let first_row = i32(local.y * ROWS_PER_INVOCATION);
    let x = i32(group.x) * inner_columns - rim + column;
    let top = i32(group.y) * inner_rows - rim + first_row;

    // Output: the part inside the rim and inside the picture; each invocation outputs these of its rows.
    let is_given = column >= rim && column < rim + inner_columns && x < i32(width());
    let first_given = select(i32(ROWS_PER_INVOCATION), rim - first_row, is_given);
    let end_given = min(rim + inner_rows - first_row, i32(height()) - top);

    if !is_reached(local.xy, holds_surface(x, top)) {
        for (var k = 0; k < i32(ROWS_PER_INVOCATION); k++) {
            if k >= first_given && k < end_given {
                give_out(index_of(u32(x), u32(top + k)), vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(0.0));
            }
        }
        return;
    }

    var before: array<vec2<f32>, ROWS_PER_INVOCATION>;
    var sum: array<vec2<f32>, ROWS_PER_INVOCATION>;
    var level: array<u32, ROWS_PER_INVOCATION>;
    // West, east and north of each pixel; south is north of the next pixel.
    var west: array<f32, ROWS_PER_INVOCATION>;
    var east: array<f32, ROWS_PER_INVOCATION>;
    var north: array<f32, ROWS_PER_INVOCATION + 1u>;

    var above = conductance_at(x, top - 1);
    for (var k = 0u; k < ROWS_PER_INVOCATION; k++) {
        let y = top + i32(k);
        let own = conductance_at(x, y);
        west[k] = face_conductance(conductance_at(x - 1, y), own);
        east[k] = face_conductance(own, conductance_at(x + 1, y));
        north[k] = face_conductance(above, own);
        above = own;
        var g = vec2<f32>(0.0);
        before[k] = vec2<f32>(0.0);
        sum[k] = vec2<f32>(0.0);
        level[k] = 0u;
        let place = source(x, y);
        if is_inside(place.x, place.y) {
            let i = index_of(u32(place.x), u32(place.y));
            g = last[i];
            if IS_EXPANSION && params.first_term > 0u {
                before[k] = earlier[i];
            }
        }
        if is_inside(x, y) {
            // Other groups change the sums of other pixels at the same time.
            let i = index_of(u32(x), u32(y));
            if (IS_EXPANSION || BY_LEVEL) && params.first_term > 0u {
                sum[k] = sums[i];
            }
            if BY_LEVEL {
                level[k] = levels[i];
            }
        }
        region[(first_row + i32(k)) * i32(REGION_COLUMNS) + column] = g;
    }
    north[ROWS_PER_INVOCATION] = face_conductance(above, conductance_at(x, top + i32(ROWS_PER_INVOCATION)));
    workgroupBarrier();

    for (var sweep = 1u; sweep <= params.sweeps; sweep++) {
        let term = params.first_term + sweep;
        var made: array<vec2<f32>, ROWS_PER_INVOCATION>;
        for (var k = 0u; k < ROWS_PER_INVOCATION; k++) {
            let row = first_row + i32(k);
            let at = row * i32(REGION_COLUMNS) + column;
            let g = region[at];
            // At the rim any neighbour will do: that output is discarded.
            let left = region[at - select(0, 1, column > 0)];
            let right = region[at + select(0, 1, column + 1 < i32(REGION_COLUMNS))];
            let up = region[at - select(0, i32(REGION_COLUMNS), row > 0)];
            let down = region[at + select(0, i32(REGION_COLUMNS), row + 1 < i32(REGION_ROWS))];
            let joined = vec4<f32>(west[k], east[k], north[k], north[k + 1u]);
            made[k] = updated(g, flux(g, left, right, up, down, joined), before[k], term);
        }
        workgroupBarrier();
        let is_odd = term % 2u == 1u;
        let is_last = params.is_final == 1u && sweep == params.sweeps;
        for (var k = 0u; k < ROWS_PER_INVOCATION; k++) {
            let at = (first_row + i32(k)) * i32(REGION_COLUMNS) + column;
            let g = region[at];
            if IS_EXPANSION || BY_LEVEL {
                let of_own = term_weights[term * params.level_count + level[k]];
                let of_before = term_weights[(term - 1u) * params.level_count + level[k]];
                // Odd terms are added together with the one before.
                if is_odd {
                    sum[k] += of_before * g + of_own * made[k];
                } else if is_last {
                    sum[k] += of_own * made[k];
                }
            }
            before[k] = g;
            region[at] = made[k];
        }
        workgroupBarrier();
    }

    for (var k = 0; k < i32(ROWS_PER_INVOCATION); k++) {
        if k >= first_given && k < end_given {
            let at = (first_row + k) * i32(REGION_COLUMNS) + column;
            give_out(index_of(u32(x), u32(top + k)), region[at], before[k], sum[k]);
        }
    }
}
