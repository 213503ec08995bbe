// Finds the part of each surface in each cell.

override HAS_DEPTH: bool;

// The open pixels of a cell.
fn open_pixels(cell: u32) -> vec2<u32> {
    let corner = corner_of(cell);
    var open = vec2<u32>(0u);
    for (var y = 0u; y < params.cell_px; y++) {
        let row = corner.y + i32(y);
        if row < 0 || row >= i32(height()) {
            continue;
        }
        for (var x = 0u; x < params.cell_px; x++) {
            let column = corner.x + i32(x);
            if column < 0 || column >= i32(width()) {
                continue;
            }
            if conductance[index_of(u32(column), u32(row))] > OPEN {
                open |= bit_of(x, y);
            }
        }
    }
    return open;
}

// The first pixel of some.
fn first_of(pixels: vec2<u32>) -> vec2<u32> {
    let upper = vec2<u32>(pixels.x & (~pixels.x + 1u), 0u);
    let lower = vec2<u32>(0u, pixels.y & (~pixels.y + 1u));
    return select(lower, upper, pixels.x != 0u);
}

// Pixels, and those adjacent to them by their sides.
fn grown(pixels: vec2<u32>) -> vec2<u32> {
    let beside = ((pixels << vec2<u32>(1u)) & vec2<u32>(0xfefefefeu))
        | ((pixels >> vec2<u32>(1u)) & vec2<u32>(0x7f7f7f7fu));
    let below = vec2<u32>(pixels.x << 8u, (pixels.y << 8u) | (pixels.x >> 24u));
    let above = vec2<u32>((pixels.x >> 8u) | (pixels.y << 24u), pixels.y >> 8u);
    return pixels | beside | below | above;
}

// The open pixels that hang together with `first`.
fn patch_from(first: vec2<u32>, open: vec2<u32>) -> vec2<u32> {
    var pixels = first;
    loop {
        let next = grown(pixels) & open;
        if all(next == pixels) {
            break;
        }
        pixels = next;
    }
    return pixels;
}

// The place of the first of some pixels.
fn place_in_cell(pixels: vec2<u32>) -> vec2<u32> {
    let bit = select(32u + firstTrailingBit(pixels.y), firstTrailingBit(pixels.x), pixels.x != 0u);
    return vec2<u32>(bit & 7u, bit >> 3u);
}

// The pixels around the middle of a whole cell: a mean over all of it would be below the surface.
fn inner_pixels() -> vec2<u32> {
    let margin = params.cell_px / 4u;
    var inner = vec2<u32>(0u);
    for (var y = margin; y < params.cell_px - margin; y++) {
        for (var x = margin; x < params.cell_px - margin; x++) {
            inner |= bit_of(x, y);
        }
    }
    return inner;
}

// The pixels nearest to the middle of a part of a cell, all that are as near: one of two would prefer a side.
fn middle_pixels(pixels: vec2<u32>) -> vec2<u32> {
    let count = pixel_count(pixels);
    var sum = vec2<u32>(0u);
    var left = pixels;
    while any(left != vec2<u32>(0u)) {
        sum += place_in_cell(left);
        left ^= first_of(left);
    }
    var least = NOTHING;
    var nearest = vec2<u32>(0u);
    left = pixels;
    while any(left != vec2<u32>(0u)) {
        let first = first_of(left);
        let off = vec2<i32>(sum) - vec2<i32>(place_in_cell(left) * count);
        let square = u32(off.x * off.x + off.y * off.y);
        nearest = select(nearest, vec2<u32>(0u), square < least) | select(vec2<u32>(0u), first, square <= least);
        least = min(least, square);
        left ^= first;
    }
    return nearest;
}

// Writes a patch, as the mean of the pixels in its middle.
fn describe(slot: u32, cell: u32, pixels: vec2<u32>) {
    var middle = inner_pixels();
    if pixel_count(pixels) != params.cell_px * params.cell_px {
        middle = middle_pixels(pixels);
    }
    let corner = corner_of(cell);
    var normal = vec3<f32>(0.0);
    var place = vec2<f32>(0.0);
    var away = 0.0;
    var left = middle;
    while any(left != vec2<u32>(0u)) {
        let inside = place_in_cell(left);
        let at = vec2<u32>(corner + vec2<i32>(inside));
        let i = index_of(at.x, at.y);
        normal += vec3<f32>(normal_x[i], normal_y[i], normal_z[i]);
        place += vec2<f32>(inside) + 0.5;
        if HAS_DEPTH {
            away += depth[i];
        }
        left ^= first_of(left);
    }
    let count = f32(pixel_count(middle));
    let length = sqrt(dot(normal, normal));
    let is_clear = is_finite(length) && length > 0.0;
    patches[slot] = Patch(
        select(vec3<f32>(0.0), normal / length, is_clear),
        cell,
        place / count - 0.5 * f32(params.cell_px),
        pixels,
    );
    depths[slot] = select(0.0, away / count, is_finite(away));
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.columns || id.y >= params.rows {
        return;
    }
    let cell = id.y * params.columns + id.x;
    let open = open_pixels(cell);
    var left = open;
    var count = 0u;
    while any(left != vec2<u32>(0u)) {
        left &= ~patch_from(first_of(left), open);
        count += 1u;
    }
    var next = 0u;
    if count > 1u {
        next = atomicAdd(&further[0], count - 1u);
        // Patches without room are dropped; the total count reveals it.
        count = 1u + min(count - 1u, params.room - min(next, params.room));
    }
    let cell_holds = vec2<u32>(count, cell_count() + next);
    held[cell] = cell_holds;
    left = open;
    for (var k = 0u; k < count; k++) {
        let pixels = patch_from(first_of(left), open);
        describe(patch_of(cell, cell_holds, k), cell, pixels);
        left &= ~pixels;
    }
}
