// Finds the bin that contains the percentile, and clears the bins; after the last bits, stores the choice.
//
// search: the bits found so far, the rank among the numbers with these bits, the number of values, and the side of the
// lattice that a second look takes: that of the first if there is none.

@group(0) @binding(0) var<uniform> params: NarrowParams;
@group(0) @binding(1) var<storage, read_write> bins: array<u32>;
@group(0) @binding(2) var<storage, read_write> search: array<u32>;
@group(0) @binding(3) var<storage, read_write> chosen: array<f32>;

// Whether a gain is chosen, or a white level.
override IS_GAIN: bool;

var<workgroup> sums: array<u32, SEARCH_INVOCATIONS>;

fn choose(is_found: bool, value: f32) {
    if IS_GAIN {
        chosen[GAIN] = params.most_gain;
        if is_found && value > 0.0 {
            chosen[GAIN] = min(params.target_times / value, params.most_gain);
        }
    } else {
        chosen[WHITE] = 1.0;
        if is_found && value > 0.0 {
            chosen[WHITE] = value;
        }
    }
}

fn narrow(per_invocation: u32) {
    if params.is_first == 1u {
        var all = 0u;
        for (var k = 0u; k < SEARCH_INVOCATIONS; k++) {
            all += sums[k];
        }
        search[0] = 0u;
        search[2] = all;
        if params.is_second == 0u {
            search[3] = finer_side(params.side, all);
        }
        // Rounded half up.
        let last = max(all, 1u) - 1u;
        let whole = last / params.share_of;
        let rest = last % params.share_of;
        search[1] = whole * params.share + (2u * rest * params.share + params.share_of) / (2u * params.share_of);
    }
    var rank = search[1];
    var bin = 0u;
    if search[2] > 0u {
        var part = 0u;
        while part + 1u < SEARCH_INVOCATIONS && rank >= sums[part] {
            rank -= sums[part];
            part += 1u;
        }
        bin = part * per_invocation;
        while bin + 1u < SEARCH_BINS && rank >= bins[bin] {
            rank -= bins[bin];
            bin += 1u;
        }
    }
    search[0] |= bin << params.shift;
    search[1] = rank;
}

@compute @workgroup_size(SEARCH_INVOCATIONS)
fn main(@builtin(local_invocation_index) local: u32) {
    let per_invocation = SEARCH_BINS / SEARCH_INVOCATIONS;
    var sum = 0u;
    for (var k = 0u; k < per_invocation; k++) {
        sum += bins[local * per_invocation + k];
    }
    sums[local] = sum;
    workgroupBarrier();
    if local == 0u {
        // A search that takes no second look keeps what it found.
        if params.is_second == 0u || search[3] != params.side {
            narrow(per_invocation);
        }
        if params.shift == 0u {
            choose(search[2] > 0u, value_of(search[0]));
        }
    }
    workgroupBarrier();
    for (var k = 0u; k < per_invocation; k++) {
        bins[local * per_invocation + k] = 0u;
    }
}
