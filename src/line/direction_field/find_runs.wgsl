// Finds the run that each patch is in, along one axis.

// The run up to a patch, which starts it or continues it from the patch `before`.
fn go_on(i: u32, before: u32, place: u32) {
    var first = vec2<u32>(i, 0u);
    if before != NO_PATCH {
        first = runs[before].xz + vec2<u32>(0u, 1u);
    }
    runs[i].x = first.x;
    runs[i].z = first.y;
}

// The run from a patch on, which ends it or continues in the patch `after`.
fn go_back(i: u32, after: u32, place: u32) {
    var last = vec2<u32>(i, 0u);
    if after != NO_PATCH {
        last = runs[after].yw + vec2<u32>(0u, 1u);
    }
    runs[i].y = last.x;
    runs[i].w = last.y;
}
