// Sums over each run, from its first patch to every patch, and from every patch to its last.

@group(0) @binding(0) var<uniform> params: DirectionParams;
@group(0) @binding(1) var<storage, read> held: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> links: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> values: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> sums: array<Sums>;

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x * RUN_CELLS >= cells_along() || id.y >= cells_across() {
        return;
    }
    let begin = id.x * RUN_CELLS;
    let end = min(begin + RUN_CELLS, cells_along());
    for (var along = begin; along < end; along++) {
        let cell = cell_at(along, id.y);
        let own = held[cell];
        for (var k = 0u; k < own.x; k++) {
            let i = patch_of(cell, own, k);
            let before = links[i][2u * params.axis];
            var sum = Sum(values[i], f32(along - begin) * values[i]);
            if before != NO_PATCH && along > begin {
                sum.plain += sums[before].until.plain;
                sum.placed += sums[before].until.placed;
            }
            sums[i].until = sum;
        }
    }
    for (var along = end; along > begin; along--) {
        let cell = cell_at(along - 1u, id.y);
        let own = held[cell];
        for (var k = 0u; k < own.x; k++) {
            let i = patch_of(cell, own, k);
            let after = links[i][2u * params.axis + 1u];
            var sum = Sum(values[i], f32(along - 1u - begin) * values[i]);
            if after != NO_PATCH && along < end {
                sum.plain += sums[after].since.plain;
                sum.placed += sums[after].since.placed;
            }
            sums[i].since = sum;
        }
    }
}
