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
