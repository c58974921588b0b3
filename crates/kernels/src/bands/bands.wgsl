// README.md beside this file says what is computed. One invocation: one vertex (x) of FRAMES frames (y).
override FRAMES: u32 = 1;

struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    features: u32,
    centers: u32,
    fp16: u32,
    wrinkles: u32,
}

@group(0) @binding(0) var<storage, read> squared_vector_differences: array<vec4f>;
@group(0) @binding(1) var<storage, read> influence_offsets: array<u32>;
@group(0) @binding(2) var<storage, read> influences: array<u32>;
@group(0) @binding(3) var<storage, read> influence_weights: array<f32>;
@group(0) @binding(4) var<storage, read> example_weights: array<u32>;
@group(0) @binding(5) var<storage, read> wrinkle_weights: array<f32>;
@group(0) @binding(6) var<storage, read_write> band_offsets: array<f32>;
@group(0) @binding(7) var<storage, read_write> local_detail: array<f32>;
@group(0) @binding(8) var<uniform> params: Params;

// Number i of half of c; fp16 where params.fp16 is 1.
fn example_weight(i: u32) -> f32 {
    if params.fp16 != 0 {
        let pair = unpack2x16float(example_weights[i / 2]);
        return select(pair.y, pair.x, i % 2 == 0);
    }
    return bitcast<f32>(example_weights[i]);
}

// Vector j of vertex i of a, b and w.
fn wrinkle_weight(i: u32, j: u32) -> vec3f {
    let vectors = select(1, params.centers + 1, params.wrinkles != 0);
    let at = (i / 16 * vectors + j) * 48 + i % 16;
    return vec3f(wrinkle_weights[at], wrinkle_weights[at + 16], wrinkle_weights[at + 32]);
}

// One of eight numbers. Written so that no array is indexed by what differs between invocations.
fn one_of(low: vec4f, high: vec4f, j: u32) -> f32 {
    let of_four = select(high, low, j < 4);
    let of_two = select(of_four.zw, of_four.xy, j % 4 < 2);
    return select(of_two.y, of_two.x, j % 2 == 0);
}

@compute @workgroup_size(64)
fn bands(@builtin(global_invocation_id) id: vec3u) {
    // Those past the end compute the last vertex once more, so that all of a workgroup go the same way.
    let i = min(id.x, params.part_vertices - 1);
    let frame = FRAMES * id.y;
    let eights = (params.centers + 7) / 8;
    let constant = wrinkle_weight(i, 0);
    var at_rest = vec3f(0.0);
    if params.wrinkles != 0 {
        at_rest = wrinkle_weight(i, 1);
    }
    var offset: array<vec3f, 4>;
    var detail: array<vec3f, 4>;
    // The distance from the rest pose, squared and not.
    var squared_rest: array<f32, 4>;
    var rest: array<f32, 4>;
    for (var g = 0u; g < FRAMES; g++) {
        offset[g] = constant;
        detail[g] = at_rest;
    }
    for (var eight = 0u; eight < eights; eight++) {
        // The squared distances from eight centres: the first four, and the others.
        var low = array<vec4f, 4>();
        var high = array<vec4f, 4>();
        let anchors = influence_offsets[i / 16 * 2 + 1];
        for (var row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 2]; row++) {
            let feature = influences[row];
            let weight = influence_weights[16 * row + i % 16];
            for (var g = 0u; g < FRAMES; g++) {
                if row == anchors {
                    low[g] *= 0.9;
                    high[g] *= 0.9;
                }
                let of_frame = min(frame + g, params.frames - 1);
                let at = 2 * ((of_frame * eights + eight) * params.features + feature);
                low[g] += weight * squared_vector_differences[at];
                high[g] += weight * squared_vector_differences[at + 1];
            }
        }
        if eight == 0 {
            for (var g = 0u; g < FRAMES; g++) {
                squared_rest[g] = low[g].x;
                rest[g] = sqrt(low[g].x);
            }
        }
        for (var j = select(0u, 1u, eight == 0); j < min(8, params.centers - 8 * eight); j++) {
            let center = 8 * eight + j;
            let at = (i / 16 * (params.centers - 1) + center - 1) * 48 + i % 16;
            let c = vec3f(example_weight(at), example_weight(at + 16), example_weight(at + 32));
            for (var g = 0u; g < FRAMES; g++) {
                offset[g] += c * (squared_rest[g] - one_of(low[g], high[g], j));
            }
            if params.wrinkles != 0 {
                let w = wrinkle_weight(i, center + 1);
                for (var g = 0u; g < FRAMES; g++) {
                    detail[g] += w * (sqrt(one_of(low[g], high[g], j)) - rest[g]);
                }
            }
        }
    }
    for (var g = 0u; g < FRAMES; g++) {
        if frame + g < params.frames && id.x < params.part_vertices {
            let result = 3 * ((frame + g) * params.vertices + params.first_vertex + i);
            band_offsets[result] = offset[g].x;
            band_offsets[result + 1] = offset[g].y;
            band_offsets[result + 2] = offset[g].z;
            if params.wrinkles != 0 {
                local_detail[result] = detail[g].x;
                local_detail[result + 1] = detail[g].y;
                local_detail[result + 2] = detail[g].z;
            }
        }
    }
}
