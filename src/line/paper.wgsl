// The grain of paper under a pencil. Numbers of 64 bits are pairs, the low half first.

fn product_of_halves(a: u32, b: u32) -> vec2<u32> {
    let a_low = a & 0xffffu;
    let a_high = a >> 16u;
    let b_low = b & 0xffffu;
    let b_high = b >> 16u;
    let low = a_low * b_low;
    let middle = a_high * b_low + (low >> 16u);
    let other = a_low * b_high + (middle & 0xffffu);
    return vec2<u32>(a * b, a_high * b_high + (middle >> 16u) + (other >> 16u));
}

// The low 64 bits of a product.
fn product(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = product_of_halves(a.x, b.x);
    return vec2<u32>(low.x, low.y + a.x * b.y + a.y * b.x);
}

// Mixes the bits of a position and the seed; returns the high half of the result.
fn hash(x: u32, y: u32) -> u32 {
    var mixed = vec2<u32>(y ^ params.seed_low, x ^ params.seed_high);
    for (var k = 0u; k < HASH_ROUNDS; k++) {
        mixed.x ^= mixed.y;
        mixed = product(mixed, vec2<u32>(HASH_FACTOR_LOW, HASH_FACTOR_HIGH));
    }
    return mixed.y;
}

// 0..1 by the highest 24 bits.
fn unit(bits: u32) -> f32 {
    return f32(bits >> 8u) / f32(1u << 24u);
}

// Height of the paper at a pixel, 0..1.
fn grain(x: u32, y: u32) -> f32 {
    let beside = unit(hash(x + 1u, y)) + unit(hash(x - 1u, y)) + unit(hash(x, y + 1u)) + unit(hash(x, y - 1u));
    let mean = GRAIN_HERE * unit(hash(x, y)) + GRAIN_BESIDE * beside;
    return clamp(0.5 + GRAIN_SPREAD * (mean - 0.5), 0.0, 1.0);
}

// Ink of a pencil line of this coverage on paper of this height: graphite sticks to the raised parts.
fn graphite(coverage: f32, grain: f32) -> f32 {
    let reach = coverage * (1.0 + GRIP) - GRIP * (1.0 - grain);
    return LIGHTEST_BLACK * clamp(reach, 0.0, 1.0);
}
