// Where a surface was seen: words of 32 pixels.

// Whether a pixel is covered; those beyond the border are those at the border.
fn is_covered(x: i32, y: i32) -> bool {
    let column = u32(clamp(x, 0, i32(width()) - 1));
    let row = u32(clamp(y, 0, i32(height()) - 1));
    let words_per_row = (width() + 31u) / 32u;
    let word = covered[row * words_per_row + column / 32u];
    return ((word >> (column % 32u)) & 1u) == 1u;
}
