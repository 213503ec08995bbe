// Strengths of the silhouettes between each pixel and the next ones, to the right and below: positive where it is the
// nearer, else negative; up to 1 a weight, beyond the size of the gap in pixels.

override IS_PERSPECTIVE: bool;
override DEPTH_ALONG_RAY: bool;
override HAS_NOISE: bool;

// A pixel beside the border between it and its neighbour.
struct Side {
    depth: f32,
    // What is linear along a plane, of this pixel and of the next one away from the neighbour.
    linear: f32,
    beyond: f32,
    // The sight line times the normal, and the step to the second pixel at depth 1 times the normal.
    facing: f32,
    along: f32,
    has_beyond: bool,
}

// The strength of the gap between two pixels, `pitch` pixels apart per unit of length.
fn gap_strength(a: Side, b: Side, pitch: f32, noise: f32, is_perspective: bool) -> f32 {
    let step = b.depth - a.depth;
    var per_unit = pitch;
    var per_linear = pitch;
    var past = vec2<f32>(1.0);
    if is_perspective {
        per_unit = pitch * max(a.linear, b.linear);
        per_linear = pitch * max(a.depth, b.depth);
        past = vec2<f32>(b.depth, a.depth);
    }
    let off_a = abs(per_unit * (step * a.facing + past.x * a.along));
    let off_b = abs(per_unit * (step * b.facing + past.y * b.along));
    let jump = (b.linear - a.linear) * per_linear;
    let chord_a = (a.linear - a.beyond) * per_linear;
    let chord_b = (b.beyond - b.linear) * per_linear;
    let first = select(chord_b, chord_a, a.has_beyond);
    let second = select(chord_a, chord_b, b.has_beyond);
    let outside = max(max(min(first, second) - jump, jump - max(first, second)), 0.0);
    let bend = select(abs(jump), outside, a.has_beyond || b.has_beyond);
    let px = max(off_a, off_b);
    let departs = soft_threshold_weight(bend / max(abs(jump), 1.17549435e-38), DEPARTS_LO, DEPARTS_HI);
    let steep = min(abs(jump), STEEPEST);
    let turns = soft_threshold_weight(px / sqrt(1.0 + steep * steep), TURNS_LO, TURNS_HI);
    let size = max(abs(a.depth), abs(b.depth));
    let more = per_unit * (params.rounding.x * size + params.rounding.y) + NOISES * noise;
    let size_weight = soft_threshold_weight(px, params.silhouette_lo + more, params.silhouette_hi + more);
    let weight = max(departs, turns) * size_weight;
    return select(weight, max(px, 1.0), weight > CLOSED);
}

// Whether a pixel is covered, possibly one beyond the picture.
fn is_there(at: vec2<i32>) -> bool {
    let inside = all(at >= vec2<i32>(0)) && at.x < i32(width()) && at.y < i32(height());
    return inside && is_covered(u32(at.x), u32(at.y));
}

// The direction to the eye, and the depth along the view axis, of a pixel.
fn eye_and_depth(at: vec2<i32>) -> vec3<f32> {
    let eye = params.to_eye.xy + params.to_eye.zw * vec2<f32>(at);
    var planar = depth[index_of(u32(at.x), u32(at.y))];
    if DEPTH_ALONG_RAY {
        planar /= sqrt(1.0 + (eye.x * eye.x + eye.y * eye.y));
    }
    return vec3<f32>(eye, clamp(planar, select(-FARTHEST, NEAREST, IS_PERSPECTIVE), FARTHEST));
}

// A pixel that is there, with the next one at `beyond`; `step` is that between the pixels compared, at depth 1.
fn side(at: vec2<i32>, beyond: vec2<i32>, step: vec2<f32>) -> Side {
    let i = index_of(u32(at.x), u32(at.y));
    let n = vec3<f32>(normal_x[i], normal_y[i], normal_z[i]);
    let eye = eye_and_depth(at);
    let depth = eye.z;
    var next = 0.0;
    let has_beyond = is_there(beyond);
    if has_beyond {
        let depth_beyond = eye_and_depth(beyond).z;
        next = select(depth_beyond, 1.0 / depth_beyond, IS_PERSPECTIVE);
    }
    let linear = select(depth, 1.0 / depth, IS_PERSPECTIVE);
    return Side(depth, linear, next, -facing(n, eye.xy), n.x * step.x + n.y * step.y, has_beyond);
}

// The noise of depth between a pixel and the next along an axis.
fn noise_after(at: vec2<i32>, axis: vec2<i32>) -> f32 {
    if !HAS_NOISE {
        return 0.0;
    }
    let count = vec2<i32>(i32(params.tile_columns), i32(params.tile_rows));
    let place = 2 * at + vec2<i32>(params.tile_x, params.tile_y) + axis - vec2<i32>(TILE / 2);
    // The first place is up to half a tile before the middle of the first tile.
    let first = (place + vec2<i32>(TILE)) / TILE - vec2<i32>(1);
    let past = vec2<f32>(place - first * TILE) / f32(TILE);
    let from_tile = clamp(first, vec2<i32>(0), count - vec2<i32>(1));
    let to_tile = clamp(first + vec2<i32>(1), vec2<i32>(0), count - vec2<i32>(1));
    let up = from_tile.y * count.x;
    let down = to_tile.y * count.x;
    let ends = noise[up + from_tile.x] * ((1.0 - past.y) * (1.0 - past.x)) + noise[down + to_tile.x] * (past.y * past.x);
    let others = noise[up + to_tile.x] * ((1.0 - past.y) * past.x) + noise[down + from_tile.x] * (past.y * (1.0 - past.x));
    return ends + others;
}

fn strength_after(at: vec2<i32>, axis: vec2<i32>, pitch: f32, step: vec2<f32>) -> f32 {
    let next = at + axis;
    if !is_there(at) || !is_there(next) {
        return 0.0;
    }
    let a = side(at, at - axis, step);
    let b = side(next, next + axis, step);
    let strength = gap_strength(a, b, pitch, noise_after(at, axis), IS_PERSPECTIVE);
    return select(-strength, strength, a.depth <= b.depth);
}

fn at_pixel(id: vec2<u32>, i: u32) {
    let at = vec2<i32>(id.xy);
    let across = strength_after(at, vec2<i32>(1, 0), params.pitch.x, vec2<f32>(params.step.x, 0.0));
    let down = strength_after(at, vec2<i32>(0, 1), params.pitch.y, vec2<f32>(0.0, params.step.y));
    gaps[i] = vec2<f32>(across, down);
}
