// The pixels of a frame: rows running down, one after the other.

fn index_of(x: u32, y: u32) -> u32 {
    return y * width() + x;
}
