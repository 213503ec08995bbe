// One sweep of the diffusion operator, directly from memory: for software devices, where workgroup memory is not faster
// and barriers are expensive.

@group(0) @binding(0) var<uniform> params: DiffusionParams;
@group(0) @binding(1) var<storage, read> last: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read> faces: array<vec2<f32>>;
// Weights of the terms, for all levels of importance together.
@group(0) @binding(3) var<storage, read> term_weights: array<f32>;
@group(0) @binding(4) var<storage, read> levels: array<u32>;
// The term before the last, overwritten by the next one.
@group(0) @binding(5) var<storage, read_write> next: array<vec2<f32>>;
@group(0) @binding(6) var<storage, read_write> sums: array<vec2<f32>>;

override IS_EXPANSION: bool;
override BY_LEVEL: bool;
// Whether the term is odd or the last one, and so added to the sums.
override ADDS_TWO: bool;
override ADDS_OWN: bool;

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    let is_right = id.x + 1u == params.width;
    let is_bottom = id.y + 1u == params.height;
    // At the borders of the picture any neighbour will do: the face is closed.
    let right = select(i + 1u, i, is_right);
    let down = select(i + width(), i, is_bottom);
    let g = last[i];
    let own = faces[i];
    let east = select(faces[right].x, 0.0, is_right);
    let south = select(faces[down].y, 0.0, is_bottom);
    let left = select(i - 1u, i, id.x == 0u);
    let up = select(i - width(), i, id.y == 0u);
    let lg = flux(g, last[left], last[right], last[up], last[down], vec4<f32>(own.x, east, own.y, south));
    let term = params.first_term + 1u;
    var earlier = vec2<f32>(0.0);
    if IS_EXPANSION && term > 1u {
        earlier = next[i];
    }
    let made = updated(g, lg, earlier, term);
    next[i] = made;
    if ADDS_TWO || ADDS_OWN {
        var level = 0u;
        if BY_LEVEL {
            level = levels[i];
        }
        var sum = vec2<f32>(0.0);
        if term > 1u {
            sum = sums[i];
        }
        let of_own = term_weights[term * params.level_count + level];
        if ADDS_TWO {
            let of_before = term_weights[(term - 1u) * params.level_count + level];
            sum += of_before * g + of_own * made;
        } else {
            sum += of_own * made;
        }
        sums[i] = sum;
    }
}
