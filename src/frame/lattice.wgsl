// The lattice of a bounded sample of pixels: the twin of Lattice in sampling.rs.

// Bits that depend on both numbers like random ones.
fn scattered(i: u32, j: u32) -> u32 {
    var bits = i * 0x9e3779b1u + ((j ^ (j >> 16u)) * 0x85ebca6bu);
    bits = (bits ^ (bits >> 16u)) * 0x85ebca6bu;
    bits = (bits ^ (bits >> 16u)) * 0xc2b2ae35u;
    return bits ^ (bits >> 16u);
}

// The place in cell i of cells with this side along `length` pixels, the last of which may be shorter.
fn lattice_place(i: u32, side: u32, length: u32, random: u32) -> u32 {
    let start = i * side;
    return start + ((min(side, length - start) * (random >> 16u)) >> 16u);
}

// The side with which enough of the values should count, of which `counted` do.
fn finer_side(side: u32, counted: u32) -> u32 {
    if counted >= ENOUGH {
        return side;
    }
    var finer = side;
    while finer > 1u && finer * finer * ENOUGH > side * side * counted {
        finer -= 1u;
    }
    return finer;
}
