// Conductances of the faces left of and above every pixel; no flow through the borders of the picture.

@group(0) @binding(0) var<uniform> params: SizeParams;
@group(0) @binding(1) var<storage, read> conductance: array<f32>;
@group(0) @binding(2) var<storage, read_write> faces: array<vec2<f32>>;

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    let own = conductance[i];
    let left = select(0.0, face_conductance(conductance[max(i, 1u) - 1u], own), id.x > 0u);
    let above = select(0.0, face_conductance(conductance[max(i, width()) - width()], own), id.y > 0u);
    faces[i] = vec2<f32>(left, above);
}
