// The mask, in words of 32 pixels.

// Whether a pixel is covered.
fn is_covered(x: u32, y: u32) -> bool {
    let words_per_row = (width() + 31u) / 32u;
    let word = covered[y * words_per_row + x / 32u];
    return ((word >> (x % 32u)) & 1u) == 1u;
}

// Whether the pixels in three columns of a row are covered.
fn covered_around(columns: vec3<u32>, y: u32) -> vec3<bool> {
    return vec3<bool>(is_covered(columns.x, y), is_covered(columns.y, y), is_covered(columns.z, y));
}

// Whether any pixel of a column is covered, in the rows from `first` up to but not including `end`.
fn is_any_covered(x: u32, first: u32, end: u32) -> bool {
    for (var y = first; y < end; y++) {
        if is_covered(x, y) {
            return true;
        }
    }
    return false;
}
