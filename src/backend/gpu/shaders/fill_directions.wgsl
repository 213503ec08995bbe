// Gives pixels that lack a direction the mean of their neighbours', as far as these had one in the wave before; after the
// last wave the fallback.

@group(0) @binding(0) var<uniform> params: DirectionParams;
@group(0) @binding(1) var<storage, read> lacking: array<u32>;
@group(0) @binding(2) var<storage, read> lacking_count: u32;
@group(0) @binding(3) var<storage, read> normal_x: array<f32>;
@group(0) @binding(4) var<storage, read> normal_y: array<f32>;
@group(0) @binding(5) var<storage, read> normal_z: array<f32>;
@group(0) @binding(6) var<storage, read_write> direction_x: array<f32>;
@group(0) @binding(7) var<storage, read_write> direction_y: array<f32>;
// 1 more than the wave that gave a pixel its direction, 0 where it lacks one.
@group(0) @binding(8) var<storage, read_write> filled: array<atomic<u32>>;

override IS_LAST: bool;

// What a neighbour adds: twice its angle, and 1.
fn neighbour(i: u32) -> vec3<f32> {
    let wave = atomicLoad(&filled[i]);
    if wave == 0u || wave > params.wave {
        return vec3<f32>(0.0);
    }
    return vec3<f32>(doubled(vec2<f32>(direction_x[i], direction_y[i])), 1.0);
}

fn mean_around(i: u32) -> vec2<f32> {
    let x = i % width();
    let y = i / width();
    var sum = vec3<f32>(0.0);
    if x > 0u {
        sum += neighbour(i - 1u);
    }
    if x + 1u < width() {
        sum += neighbour(i + 1u);
    }
    if y > 0u {
        sum += neighbour(i - width());
    }
    if y + 1u < height() {
        sum += neighbour(i + width());
    }
    let length = sqrt(dot(sum.xy, sum.xy));
    if !(length > CANCELLED * sum.z) {
        return vec2<f32>(0.0);
    }
    return halved(sum.xy);
}

@compute @workgroup_size(LIST_INVOCATIONS)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    for (var k = id.x; k < lacking_count; k += groups.x * LIST_INVOCATIONS) {
        let i = lacking[k];
        if atomicLoad(&filled[i]) != 0u {
            continue;
        }
        var direction = vec2<f32>(0.0);
        if IS_LAST {
            let place = vec2<f32>(f32(i % width()), f32(i / width())) + 0.5;
            direction = fallback(line_at(place), vec3<f32>(normal_x[i], normal_y[i], normal_z[i]));
        } else {
            direction = mean_around(i);
        }
        if any(direction != vec2<f32>(0.0)) {
            direction_x[i] = direction.x;
            direction_y[i] = direction.y;
            atomicStore(&filled[i], params.wave + 1u);
        }
    }
}
