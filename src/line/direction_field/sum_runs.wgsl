// Sums over each run, from its first patch to every patch, and from every patch to its last.

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
