// Edges as lists, in any order: the cracks between pixels that may have a silhouette, and the pixels with a crease.
//
// A list holds as many as there is room for; counting continues beyond that.

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
