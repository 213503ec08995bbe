// The pixels of a frame, whose size is at the head of every uniform block: rows running down, one after the other.

fn width() -> u32 {
    return params.width;
}

fn height() -> u32 {
    return params.height;
}

fn index_of(x: u32, y: u32) -> u32 {
    return y * width() + x;
}
