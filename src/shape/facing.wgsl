// n . v of a normal and the direction v to the eye, scaled to v.z = 1.
fn facing(n: vec3<f32>, to_eye: vec2<f32>) -> f32 {
    return n.z + dot(n.xy, to_eye);
}
