// Links patches to their continuations.

// The pixels of a patch along a side of its cell: left, right, above or below.
fn along_side(pixels: vec2<u32>, side: u32) -> u32 {
    let last = params.cell_px - 1u;
    if side >= 2u {
        let y = select(0u, last, side == 3u);
        return (select(pixels.y, pixels.x, y < 4u) >> (8u * (y & 3u))) & 0xffu;
    }
    let x = select(0u, last, side == 1u);
    var along = 0u;
    for (var y = 0u; y < params.cell_px; y++) {
        along |= u32(has_pixel(pixels, x, y)) << y;
    }
    return along;
}

// Links the patches of a cell to those of the cell at one of its sides. Pairs that share most of the side come first,
// in a tie the first along the side, and no patch is in two.
fn link(cell: u32, there: u32, side: u32) {
    let own = held[cell];
    let others = held[there];
    var linked = 0u;
    var taken = 0u;
    loop {
        var most = 0u;
        var first = 0u;
        var pair = vec2<u32>(0u);
        for (var a = 0u; a < own.x; a++) {
            let ends = along_side(patches[patch_of(cell, own, a)].pixels, side);
            if ends == 0u || ((linked >> a) & 1u) == 1u {
                continue;
            }
            for (var b = 0u; b < others.x; b++) {
                if ((taken >> b) & 1u) == 1u {
                    continue;
                }
                // Sides come in pairs: left of one cell is right of the other.
                let touching = ends & along_side(patches[patch_of(there, others, b)].pixels, side ^ 1u);
                let count = countOneBits(touching);
                let place = firstTrailingBit(touching);
                if count > most || (count == most && count > 0u && place < first) {
                    most = count;
                    first = place;
                    pair = vec2<u32>(a, b);
                }
            }
        }
        if most == 0u {
            break;
        }
        linked |= 1u << pair.x;
        taken |= 1u << pair.y;
        links[patch_of(cell, own, pair.x)][side] = patch_of(there, others, pair.y);
    }
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.columns || id.y >= params.rows {
        return;
    }
    let cell = id.y * params.columns + id.x;
    let own = held[cell];
    for (var k = 0u; k < own.x; k++) {
        links[patch_of(cell, own, k)] = vec4<u32>(NO_PATCH);
    }
    if id.x > 0u {
        link(cell, cell - 1u, 0u);
    }
    if id.x + 1u < params.columns {
        link(cell, cell + 1u, 1u);
    }
    if id.y > 0u {
        link(cell, cell - params.columns, 2u);
    }
    if id.y + 1u < params.rows {
        link(cell, cell + params.columns, 3u);
    }
}
