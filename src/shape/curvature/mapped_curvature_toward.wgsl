// Mapped curvature as light from one side shows it, of the Hessian [xx, xy, yy].
fn mapped_curvature_toward(hessian: vec3<f32>, l: vec2<f32>, gain: f32, anisotropy: f32) -> f32 {
    // The form l^T H l without the trace, which would cancel where both curvatures are alike.
    let along = (hessian.x - hessian.z) * ((l.x - l.y) * (l.x + l.y)) + 4.0 * hessian.y * (l.x * l.y);
    return mapped_curvature((hessian.x + hessian.z) + anisotropy * along, gain);
}
