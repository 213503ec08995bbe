// Sums over part of a run: of values, and of each times the distance of its cell from the run's start.
struct Sum {
    plain: vec4<f32>,
    placed: vec4<f32>,
}

// Partial sums of a patch's run: from its first patch to this one, and from this one to its last. Neither is the
// difference of two sums, in which small values would be lost.
struct Sums {
    until: Sum,
    since: Sum,
}
