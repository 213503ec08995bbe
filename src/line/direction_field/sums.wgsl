// Sums over part of a run: of values, and of each times how far its cell lies from where runs begin.
struct Sum {
    plain: vec4<f32>,
    placed: vec4<f32>,
}

// What a patch knows of its run: the sum from its first patch to this one, and from this one to its last. No sum is the
// difference of two, in which what is small would be lost.
struct Sums {
    until: Sum,
    since: Sum,
}
