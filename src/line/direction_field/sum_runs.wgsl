// Sums over each run, from its first patch to every patch, and from every patch to its last.

@group(0) @binding(0) var<uniform> params: DirectionParams;
@group(0) @binding(1) var<storage, read> held: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> links: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> values: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> sums: array<Sums>;

fn go_on(i: u32, before: u32, place: u32) {
    var sum = Sum(values[i], f32(place) * values[i]);
    if before != NO_PATCH {
        sum.plain += sums[before].until.plain;
        sum.placed += sums[before].until.placed;
    }
    sums[i].until = sum;
}

fn go_back(i: u32, after: u32, place: u32) {
    var sum = Sum(values[i], f32(place) * values[i]);
    if after != NO_PATCH {
        sum.plain += sums[after].since.plain;
        sum.placed += sums[after].since.placed;
    }
    sums[i].since = sum;
}
