// Mapped curvature, +1 convex and -1 concave. This is the only place where the sign flips.
fn mapped_curvature(trace: f32, gain: f32) -> f32 {
    return tanh_of(-gain * trace);
}
