// A pixel, and its light-independent state.

// A vector, and its x and y multiplied by the inverse of Lambda: the inputs of its dot product with an unwarped
// direction.
struct Axis {
    vector: vec3<f32>,
    unwarped: vec2<f32>,
}

struct Pixel {
    // Unit vectors: the normal, to the eye, the view mirrored at the normal, along the grain and across it.
    normal: Axis,
    to_eye: Axis,
    mirrored: Axis,
    along: Axis,
    across: Axis,
    // Inverse of Lambda: xx, xy, yy.
    unwarp: vec3<f32>,
    // Its square: xx, twice xy, yy.
    unwarp_squared: vec3<f32>,
    // One over the determinant of Lambda.
    spread: f32,
    // Hessian of the height: xx, xy, yy.
    hessian: vec3<f32>,
    // Mapped curvature.
    kappa: f32,
    // Scaling curves of ambient, diffuse and specular light.
    ambient_curve: vec2<f32>,
    diffuse_curve: vec2<f32>,
    specular_curve: vec2<f32>,
    // Ambient occlusion, 1 in the open.
    occlusion: f32,
    // View-space position of the surface.
    point: vec3<f32>,
}

var<private> pixel: Pixel;

// Whether to warp, weigh by the Jacobian, and scale.
override WARPS: bool;
override HAS_JACOBIAN: bool;
override SCALES: bool;

fn scalar_product(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
