// Edges as lists, in any order: the cracks between pixels that may have a silhouette, and the pixels with a crease.
//
// A list holds as many as there is room for; counting continues beyond that.

@group(0) @binding(0) var<uniform> params: SizeParams;
// Silhouette and crease weight.
@group(0) @binding(1) var<storage, read> weights: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read_write> counts: array<atomic<u32>>;
// Four times the pixel behind a crack, plus 2 if it is left of that pixel and not above it.
@group(0) @binding(3) var<storage, read_write> candidates: array<u32>;
// A pixel, and its weight.
@group(0) @binding(4) var<storage, read_write> creases: array<vec2<u32>>;

override CREASES_WANTED: bool;

fn add_candidate(key: u32) {
    let place = atomicAdd(&counts[CANDIDATES], 1u);
    if place < arrayLength(&candidates) {
        candidates[place] = key;
    }
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    let weight = weights[i];
    if CREASES_WANTED && weight.y > 0.0 {
        let place = atomicAdd(&counts[CREASES], 1u);
        if place < arrayLength(&creases) {
            creases[place] = vec2<u32>(i, bitcast<u32>(weight.y));
        }
    }
    // Only pixels beside a silhouette have a weight.
    let is_marked = weight.x > 0.0;
    if id.y > 0u && (is_marked || weights[i - width()].x > 0.0) {
        add_candidate(4u * i);
    }
    if id.x > 0u && (is_marked || weights[i - 1u].x > 0.0) {
        add_candidate(4u * i + 2u);
    }
}
