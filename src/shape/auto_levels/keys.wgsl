// Keys of the numbers whose percentile chooses a gain or a white level: bit patterns with the same order, or NOTHING.

fn key_of(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    if (bits & 0x7f800000u) == 0x7f800000u {
        return NOTHING;
    }
    if (bits & 0x80000000u) != 0u {
        return ~bits;
    }
    return bits | 0x80000000u;
}

fn value_of(key: u32) -> f32 {
    if (key & 0x80000000u) == 0u {
        return bitcast<f32>(~key);
    }
    return bitcast<f32>(key & 0x7fffffffu);
}
