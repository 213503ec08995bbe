// Twice the angle of a direction: opposites are equal, and perpendicular directions cancel.
fn doubled(direction: vec2<f32>) -> vec2<f32> {
    let t = direction;
    return vec2<f32>(t.x * t.x - t.y * t.y, 2.0 * t.x * t.y);
}

// The unit direction, of the two, at half the angle; 0 for 0.
fn halved(z: vec2<f32>) -> vec2<f32> {
    let length = sqrt(z.x * z.x + z.y * z.y);
    if !(length > LEAST_LENGTH) {
        return vec2<f32>(0.0);
    }
    // cos^2 = (1 + cos 2a) / 2, whichever of sine and cosine is the larger; the other by sin 2a.
    let twice = 2.0 * length;
    let larger = sqrt((length + abs(z.x)) / twice);
    let lesser = z.y / (twice * larger);
    if z.x >= 0.0 {
        return vec2<f32>(larger, lesser);
    }
    return vec2<f32>(abs(lesser), copysign(larger, z.y));
}
