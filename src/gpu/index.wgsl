// The pixels of a frame, whose size starts every uniform block: row-major, rows running down.

fn width() -> u32 {
    return params.width;
}

fn height() -> u32 {
    return params.height;
}

fn index_of(x: u32, y: u32) -> u32 {
    return y * width() + x;
}

// The pixels around one. The border of the picture extends beyond it.

fn columns_around(x: u32) -> vec3<u32> {
    return vec3<u32>(max(x, 1u) - 1u, x, min(x + 1u, width() - 1u));
}

fn row_above(y: u32) -> u32 {
    return max(y, 1u) - 1u;
}

fn row_below(y: u32) -> u32 {
    return min(y + 1u, height() - 1u);
}
