// Finds the run that each patch is in, along one axis.

@group(0) @binding(0) var<uniform> params: DirectionParams;
@group(0) @binding(1) var<storage, read> held: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> links: array<vec4<u32>>;
// The first and the last patch of the run, and how many cells away they are.
@group(0) @binding(3) var<storage, read_write> runs: array<vec4<u32>>;

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
            var first = vec2<u32>(i, 0u);
            if before != NO_PATCH && along > begin {
                first = runs[before].xz + vec2<u32>(0u, 1u);
            }
            runs[i].x = first.x;
            runs[i].z = first.y;
        }
    }
    for (var along = end; along > begin; along--) {
        let cell = cell_at(along - 1u, id.y);
        let own = held[cell];
        for (var k = 0u; k < own.x; k++) {
            let i = patch_of(cell, own, k);
            let after = links[i][2u * params.axis + 1u];
            var last = vec2<u32>(i, 0u);
            if after != NO_PATCH && along < end {
                last = runs[after].yw + vec2<u32>(0u, 1u);
            }
            runs[i].y = last.x;
            runs[i].w = last.y;
        }
    }
}
