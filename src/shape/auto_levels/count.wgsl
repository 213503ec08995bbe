// Histogram of the numbers of a plane at the places of a lattice, over some of their bits, restricted to numbers whose
// higher bits equal those found before.

@group(0) @binding(0) var<uniform> params: CountParams;
@group(0) @binding(1) var<storage, read> covered: array<u32>;
@group(0) @binding(2) var<storage, read> a: array<f32>;
@group(0) @binding(3) var<storage, read> b: array<f32>;
@group(0) @binding(4) var<storage, read> c: array<f32>;
@group(0) @binding(5) var<storage, read> search: array<u32>;
@group(0) @binding(6) var<storage, read_write> bins: array<atomic<u32>>;

// If OF_TRACE, a is a trace and b the conductance; if OF_LIGHT, a is luminance, of which only positive values count;
// else a, b and c are red, green and blue.
override OF_TRACE: bool;
override OF_LIGHT: bool;

var<workgroup> counts: array<atomic<u32>, SEARCH_BINS>;

fn key_at(x: u32, y: u32) -> u32 {
    let i = index_of(x, y);
    if OF_TRACE {
        // Flat pixels and edges are ignored.
        let size = abs(a[i]);
        if b[i] > 0.5 && size > params.least {
            return key_of(size);
        }
        return NOTHING;
    }
    if OF_LIGHT {
        return select(NOTHING, key_of(a[i]), a[i] > 0.0);
    }
    if !is_covered(x, y) {
        return NOTHING;
    }
    return key_of(a[i] * params.weight_r + b[i] * params.weight_g + c[i] * params.weight_b);
}

// The side of the lattice: at the second look that found by the first, or 0 if there is nothing to look at again.
fn side_of_look() -> u32 {
    if params.is_second == 0u {
        return params.side;
    }
    return select(search[3], 0u, search[3] == params.side);
}

@compute @workgroup_size(SEARCH_INVOCATIONS)
fn main(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    for (var bin = local; bin < SEARCH_BINS; bin += SEARCH_INVOCATIONS) {
        atomicStore(&counts[bin], 0u);
    }
    workgroupBarrier();
    let found = search[0] & params.known_bits;
    let side = side_of_look();
    var across = 0u;
    var cells = 0u;
    if side > 0u {
        across = (params.columns + side - 1u) / side;
        cells = across * ((params.rows + side - 1u) / side);
    }
    for (var cell = group.x * SEARCH_INVOCATIONS + local; cell < cells; cell += groups.x * SEARCH_INVOCATIONS) {
        let i = cell % across;
        let j = cell / across;
        let y = params.first_row + lattice_place(j, side, params.rows, scattered(0u, j));
        if y < params.rows_start || y >= params.rows_end {
            continue;
        }
        let x = params.first_column + lattice_place(i, side, params.columns, scattered(1u + i, j));
        let key = key_at(x, y - params.top);
        if key != NOTHING && (key & params.known_bits) == found {
            atomicAdd(&counts[(key >> params.shift) & (SEARCH_BINS - 1u)], 1u);
        }
    }
    workgroupBarrier();
    for (var bin = local; bin < SEARCH_BINS; bin += SEARCH_INVOCATIONS) {
        let count = atomicLoad(&counts[bin]);
        if count > 0u {
            atomicAdd(&bins[bin], count);
        }
    }
}
