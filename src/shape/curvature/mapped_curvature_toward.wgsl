// Mapped curvature for light from one side, from the Hessian [xx, xy, yy].
fn mapped_curvature_toward(hessian: vec3<f32>, l: vec2<f32>, gain: f32, anisotropy: f32) -> f32 {
    // The form l^T H l without the trace, which would cancel if both curvatures are equal.
    let along = (hessian.x - hessian.z) * ((l.x - l.y) * (l.x + l.y)) + 4.0 * hessian.y * (l.x * l.y);
    return mapped_curvature((hessian.x + hessian.z) + anisotropy * along, gain);
}
