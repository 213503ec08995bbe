// Coverage of every pixel by lines: a workgroup handles a tile of pixels, with the pieces of lines that reach it.

override IN_GRAPHITE: bool;

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    let tile = group.y * groups.x + group.x;
    let middle = vec2<f32>(f32(id.x) + 0.5, f32(id.y) + 0.5);
    // Coverage by all lines, and by the current one.
    var sum = 0.0;
    var own = 0.0;
    var line = 0u;
    for (var k = tile_starts[tile]; k < tile_starts[tile + 1u]; k++) {
        let piece = tile_pieces[k];
        if lines[piece] != line {
            sum = min(sum + own, 1.0);
            own = 0.0;
            line = lines[piece];
        }
        own = max(own, round_stroke_coverage(pieces[piece], middle));
    }
    sum = min(sum + own, 1.0);
    if IN_GRAPHITE && sum > 0.0 {
        // Coordinates wrap as on the CPU.
        sum = graphite(sum, grain(bitcast<u32>(params.x0) + id.x, bitcast<u32>(params.y0) + id.y));
    }
    covered_by_lines[i] = sum;
}
