// Behind shader.wgsl. A rig in textures, for devices without compute shaders and storage buffers. Each array of the kernels is a
// texture of words, and each array of a frame a texture of four floats. The kernels' READMEs say what is computed.
struct Sizes {
    // Texels of a row, in every texture.
    width: u32,
    vertices: u32,
    features: u32,
    centers: u32,
    // Vectors that the basis is multiplied by.
    motions: u32,
    // 4 where the handles turn, else 1.
    vectors: u32,
    // Where the handles turn, the vertex that they turn about.
    center: u32,
    unused: u32,
}

@group(2) @binding(0) var<uniform> sizes: Sizes;
@group(2) @binding(1) var rest: texture_2d<u32>;
@group(2) @binding(2) var basis: texture_2d<u32>;
@group(2) @binding(3) var basis_rows: texture_2d<u32>;
@group(2) @binding(4) var influence_offsets: texture_2d<u32>;
@group(2) @binding(5) var influences: texture_2d<u32>;
@group(2) @binding(6) var influence_weights: texture_2d<u32>;
@group(2) @binding(7) var band_weights: texture_2d<u32>;
@group(2) @binding(8) var feature_gains: texture_2d<u32>;
@group(2) @binding(9) var cluster_motions: texture_2d<f32>;
@group(2) @binding(10) var squared_vector_differences: texture_2d<f32>;
@group(2) @binding(11) var vector_excess: texture_2d<f32>;
@group(3) @binding(0) var fan_offsets: texture_2d<u32>;
@group(3) @binding(1) var fans: texture_2d<u32>;
@group(3) @binding(2) var positions: texture_2d<u32>;

// Where number i of an array is.
fn at(i: u32) -> vec2u {
    return vec2u(i % sizes.width, i / sizes.width);
}

fn rest_position(v: u32) -> vec3f {
    let i = 3 * v;
    let words = vec3u(textureLoad(rest, at(i), 0).x, textureLoad(rest, at(i + 1), 0).x, textureLoad(rest, at(i + 2), 0).x);
    return bitcast<vec3f>(words);
}

fn motion(i: u32) -> vec3f {
    return textureLoad(cluster_motions, at(i), 0).xyz;
}

// The kernels `clusters` and `large_scale`, without the bands. The basis is in clusters.
fn large_scale(i: u32) -> vec3f {
    let tile = 2 * (i / 16);
    let row = textureLoad(basis_rows, at(tile), 0).x;
    let first = textureLoad(basis_rows, at(tile + 1), 0).x;
    let rows = textureLoad(basis_rows, at(tile + 2), 0).x - row;
    let position = rest_position(i);
    let from_center = position - rest_position(sizes.center);
    var moved = vec3f();
    for (var k = 0u; k < rows; k++) {
        let pair = bitcast<i32>(textureLoad(basis, at(8 * (row + k) + i % 16 / 2), 0).x);
        let b = f32(extractBits(pair, i % 2 * 16, 16u));
        var u = motion(first + k);
        if sizes.vectors == 4 {
            u += from_center.x * motion(sizes.motions + first + k);
            u += from_center.y * motion(2 * sizes.motions + first + k);
            u += from_center.z * motion(3 * sizes.motions + first + k);
        }
        moved += b * u;
    }
    return position + moved;
}

// α or ν of vertex i of a tile, a number of 16 bits.
fn influence_weight(row: u32, i: u32) -> f32 {
    let bits = (textureLoad(influence_weights, at(8 * row + i / 2), 0).x >> (i % 2 * 16)) & 0xffff;
    return select(bitcast<f32>((bits << 12) + 0x30000000), 0.0, bits == 0);
}

fn band_word(i: u32) -> u32 {
    return textureLoad(band_weights, at(i), 0).x;
}

// Vector j of vertex i of a tile, as in the kernel `bands`: a and b, then c / 2 and w of each example.
fn band_weight(record: u32, i: u32, j: u32) -> vec3f {
    let first = record / 2 * 2;
    if record % 2 == 0 || j < 2 {
        let place = first + 48 * j + i;
        return bitcast<vec3f>(vec3u(band_word(place), band_word(place + 16), band_word(place + 32)));
    }
    let units = first + 96;
    let place = units + (2 * (sizes.centers - 1) + 15) / 16 * 16 + 24 * (j - 2) + i / 2;
    let pairs = bitcast<vec3i>(vec3u(band_word(place), band_word(place + 8), band_word(place + 16)));
    return bitcast<f32>(band_word(units + j - 2)) * vec3f(extractBits(pairs, i % 2 * 16, 16u));
}

fn one_of(low: vec4f, high: vec4f, j: u32) -> f32 {
    let of_four = select(high, low, j < 4);
    let of_two = select(of_four.zw, of_four.xy, j % 4 < 2);
    return select(of_two.y, of_two.x, j % 2 == 0);
}

// The kernels `bands` and `beyond`: the sum of the linear band and the wrinkles.
fn detail(i: u32) -> vec3f {
    let record = band_word(i / 16);
    let begin = textureLoad(influence_offsets, at(2 * (i / 16)), 0).x;
    let anchors = textureLoad(influence_offsets, at(2 * (i / 16) + 1), 0).x;
    let end = textureLoad(influence_offsets, at(2 * (i / 16) + 2), 0).x;
    var sum = band_weight(record, i % 16, 0) + band_weight(record, i % 16, 1);
    var at_rest = 0.0;
    let eights = (sizes.centers + 7) / 8;
    for (var eight = 0u; eight < eights; eight++) {
        var low = vec4f();
        var high = vec4f();
        for (var row = begin; row < end; row++) {
            if row == anchors {
                low *= 0.9;
                high *= 0.9;
            }
            let weight = influence_weight(row, i % 16);
            let place = 2 * (eight * sizes.features + textureLoad(influences, at(row), 0).x);
            low += weight * textureLoad(squared_vector_differences, at(place), 0);
            high += weight * textureLoad(squared_vector_differences, at(place + 1), 0);
        }
        if eight == 0 {
            at_rest = low.x;
        }
        for (var j = select(0u, 1u, eight == 0); j < min(8, sizes.centers - 8 * eight); j++) {
            let squared = one_of(low, high, j);
            let center = 8 * eight + j;
            sum += band_weight(record, i % 16, 2 * center) * (at_rest - squared);
            sum += band_weight(record, i % 16, 2 * center + 1) * (sqrt(squared) - sqrt(at_rest));
        }
    }
    if textureLoad(vector_excess, vec2u(), 0).w != 0 {
        for (var row = begin; row < end; row++) {
            let gain = bitcast<f32>(textureLoad(feature_gains, at(16 * row + i % 16), 0).x);
            sum -= gain * textureLoad(vector_excess, at(textureLoad(influences, at(row), 0).x), 0).xyz;
        }
    }
    return sum;
}

fn evaluated(i: u32) -> vec3f {
    return large_scale(i) + detail(i);
}

// While the triangles are drawn, with no pass before.
@vertex fn evaluated_corner(@builtin(vertex_index) i: u32) -> Corner {
    return seen(evaluated(i), vec3f(0, 0, 1), 0);
}

// A triangle over the whole texture of positions.
@vertex fn everywhere(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(i % 2), f32(i / 2)) * 4 - 1, 0, 1);
}

// A texel of positions: a vertex. Those past the end are the last vertex once more.
@fragment fn placed(@builtin(position) texel: vec4f) -> @location(0) vec4u {
    let i = u32(texel.y) * sizes.width + u32(texel.x);
    return vec4u(bitcast<vec3u>(evaluated(min(i, sizes.vertices - 1))), 0);
}

fn position(i: u32) -> vec3f {
    return bitcast<vec3f>(textureLoad(positions, at(i), 0).xyz);
}

// The kernel `normals`, around a vertex whose position was placed before.
@vertex fn placed_corner(@builtin(vertex_index) i: u32) -> Corner {
    let here = position(i);
    var e = vec3f();
    var sum = vec3f();
    let end = textureLoad(fan_offsets, at(i / 16 + 1), 0).x;
    for (var row = textureLoad(fan_offsets, at(i / 16), 0).x; row < end; row++) {
        let f = position(textureLoad(fans, at(16 * row + i % 16), 0).x) - here;
        sum += cross(e, f);
        e = f;
    }
    let largest = max(max(abs(sum.x), abs(sum.y)), abs(sum.z));
    return seen(here, select(vec3f(), normalize(sum / largest), largest > 0), 0);
}
