// The patches of a frame: surfaces cell by cell. The first patch of each cell has the number of the cell, further ones
// are numbered after those of all cells.

struct Patch {
    // Mean normal in the middle of the patch, unit or 0.
    normal: vec3<f32>,
    cell: u32,
    // Offset of that middle from the middle of the cell, in pixels, y down.
    offset: vec2<f32>,
    // Its pixels: eight bits for each row of the cell.
    pixels: vec2<u32>,
}

const NO_PATCH = 0xffffffffu;

fn cell_count() -> u32 {
    return params.columns * params.rows;
}

// Upper bound of patch numbers, given the number after the first ones.
fn patches_end(further: u32) -> u32 {
    return cell_count() + min(further, params.room);
}

// A cell has x patches; the first has the number of the cell, the others are numbered from y on.
fn patch_of(cell: u32, held: vec2<u32>, number: u32) -> u32 {
    return select(held.y + number - 1u, cell, number == 0u);
}

fn column_and_row(cell: u32) -> vec2<u32> {
    return vec2<u32>(cell % params.columns, cell / params.columns);
}

// The pixel of the picture at the corner of a cell; it may be outside the picture.
fn corner_of(cell: u32) -> vec2<i32> {
    let cut = vec2<i32>(i32(params.cut_x), i32(params.cut_y));
    return vec2<i32>(column_and_row(cell) * params.cell_px) - cut;
}

fn bit_of(x: u32, y: u32) -> vec2<u32> {
    let bit = 1u << (8u * (y & 3u) + x);
    return select(vec2<u32>(0u, bit), vec2<u32>(bit, 0u), y < 4u);
}

fn has_pixel(pixels: vec2<u32>, x: u32, y: u32) -> bool {
    return any((pixels & bit_of(x, y)) != vec2<u32>(0u));
}

fn pixel_count(pixels: vec2<u32>) -> u32 {
    return countOneBits(pixels.x) + countOneBits(pixels.y);
}
