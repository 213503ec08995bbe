// Conductance of the face between two pixels: their harmonic mean, 0 where either is 0.
fn face_conductance(a: f32, b: f32) -> f32 {
    let sum = a + b;
    if sum > 0.0 {
        return 2.0 * a * b / sum;
    }
    return 0.0;
}
