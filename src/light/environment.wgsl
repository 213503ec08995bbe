// Environments and lit spheres: maps for colour look-ups, one after another in one buffer.

// A map: its first texel, its size, the numbers of the intensity of its light; for an environment its rotation, in
// turns.
struct Map {
    first: u32,
    width: u32,
    height: u32,
    turn: f32,
    bend: f32,
    level: f32,
}

fn first_map() -> Map {
    let light = params.map_light;
    return Map(0u, params.map_size.x, params.map_size.y, light.x, light.y, light.z);
}

fn second_map() -> Map {
    let first = params.map_size.x * params.map_size.y;
    let light = params.second_light;
    return Map(first, params.second_size.x, params.second_size.y, light.x, light.y, light.z);
}

fn texel(map: Map, x: i32, y: i32) -> vec3<f32> {
    return texels[map.first + u32(y) * map.width + u32(x)].rgb;
}

// From a at 0 to b at 1, exact at both.
fn mixed(a: vec3<f32>, b: vec3<f32>, t: f32) -> vec3<f32> {
    return a * (1.0 - t) + b * t;
}

// Column and row of an environment for a direction, integers being pixel centres.
fn equirectangular_position(map: Map, d: vec3<f32>) -> vec2<f32> {
    let turned = atan2_of(d.x, -d.z) / (2.0 * PI) + 0.5 - map.turn;
    let across = select(turned, turned + 1.0, turned < 0.0);
    let down = 0.5 - atan2_of(d.y, sqrt(d.x * d.x + d.z * d.z)) / PI;
    return vec2<f32>(across * f32(map.width) - 0.5, down * f32(map.height) - 0.5);
}

fn wrapped(width: i32, x: i32) -> i32 {
    let from_left = select(x, x + width, x < 0);
    // A single column is its own neighbour on both sides.
    return clamp(select(from_left, from_left - width, from_left >= width), 0, width - 1);
}

// Linear along row y. Beyond a pole the same row continues, half a turn away.
fn on_row(map: Map, column: f32, y: i32) -> vec3<f32> {
    let last = i32(map.height) - 1;
    let beyond_pole = y < 0 || y > last;
    let place = column + select(0.0, f32(map.width) / 2.0, beyond_pole);
    let left = floor(place);
    let row = clamp(y, 0, last);
    let a = texel(map, wrapped(i32(map.width), i32(left)), row);
    let b = texel(map, wrapped(i32(map.width), i32(left) + 1), row);
    return mixed(a, b, place - left);
}

// The radiance from a direction.
fn radiance(map: Map, direction: vec3<f32>) -> vec3<f32> {
    let position = equirectangular_position(map, direction);
    let top = floor(position.y);
    let upper = on_row(map, position.x, i32(top));
    let lower = on_row(map, position.x, i32(top) + 1);
    return mixed(upper, lower, position.y - top);
}

// The colour of a lit sphere at a point of the disc inscribed in the picture, x right and y up.
fn on_disc(map: Map, at: vec2<f32>) -> vec3<f32> {
    let width = f32(map.width);
    let height = f32(map.height);
    let largest = max(1.0 - 2.0 * RIM_PX / min(width, height), 0.0);
    let inward = largest / max(max(sqrt(at.x * at.x + at.y * at.y), largest), LEAST_RADIUS);
    let column = clamp((1.0 + at.x * inward) / 2.0 * width - 0.5, 0.0, width - 1.0);
    let row = clamp((1.0 - at.y * inward) / 2.0 * height - 0.5, 0.0, height - 1.0);
    let left = floor(column);
    let top = floor(row);
    let x = i32(left);
    let y = i32(top);
    let x1 = min(x + 1, i32(map.width) - 1);
    let y1 = min(y + 1, i32(map.height) - 1);
    let upper = mixed(texel(map, x, y), texel(map, x1, y), column - left);
    let lower = mixed(texel(map, x, y1), texel(map, x1, y1), column - left);
    return mixed(upper, lower, row - top);
}
