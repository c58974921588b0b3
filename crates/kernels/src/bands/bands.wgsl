// README.md beside this file says what is computed. One invocation: one vertex (x) of FRAMES frames (y).
override FRAMES: u32 = 1;

struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    features: u32,
    centers: u32,
    narrow: u32,
    wrinkles: u32,
}

@group(0) @binding(0) var<storage, read> squared_vector_differences: array<vec4f>;
@group(0) @binding(1) var<storage, read> influence_offsets: array<u32>;
@group(0) @binding(2) var<storage, read> influences: array<u32>;
@group(0) @binding(3) var<storage, read> influence_weights: array<u32>;
@group(0) @binding(4) var<storage, read> band_weights: array<u32>;
@group(0) @binding(5) var<storage, read_write> band_offsets: array<f32>;
@group(0) @binding(6) var<storage, read_write> local_detail: array<f32>;
@group(0) @binding(7) var<uniform> params: Params;

// The weight of an influence for vertex i of a tile; floating-point numbers of 16 bits where params.narrow is 1.
fn influence_weight(row: u32, i: u32) -> f32 {
    if params.narrow != 0 {
        let bits = (influence_weights[8 * row + i / 2] >> (i % 2 * 16)) & 0xffff;
        return select(bitcast<f32>((bits << 12) + 0x30000000), 0.0, bits == 0);
    }
    return bitcast<f32>(influence_weights[16 * row + i]);
}

// Vector j of vertex i of a tile: first those of the rest pose, then those of each example. `record` says where the tile's
// vectors begin. Those of the examples are integers with a unit where its lowest bit is 1.
fn band_weight(record: u32, i: u32, j: u32) -> vec3f {
    let first = record / 2 * 2;
    let kinds = select(1u, 2u, params.wrinkles != 0);
    if record % 2 == 0 || j < kinds {
        let at = first + 48 * j + i;
        return bitcast<vec3f>(vec3u(band_weights[at], band_weights[at + 16], band_weights[at + 32]));
    }
    let units = first + 48 * kinds;
    let at = units + (kinds * (params.centers - 1) + 15) / 16 * 16 + 24 * (j - kinds) + i / 2;
    let pairs = bitcast<vec3i>(vec3u(band_weights[at], band_weights[at + 8], band_weights[at + 16]));
    return bitcast<f32>(band_weights[units + j - kinds]) * vec3f(extractBits(pairs, i % 2 * 16, 16));
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
    let kinds = select(1u, 2u, params.wrinkles != 0);
    let record = band_weights[i / 16];
    let constant = band_weight(record, i % 16, 0);
    var at_rest = vec3f(0.0);
    if params.wrinkles != 0 {
        at_rest = band_weight(record, i % 16, 1);
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
            let weight = influence_weight(row, i % 16);
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
            let c = band_weight(record, i % 16, kinds * center);
            for (var g = 0u; g < FRAMES; g++) {
                offset[g] += c * (squared_rest[g] - one_of(low[g], high[g], j));
            }
            if params.wrinkles != 0 {
                let w = band_weight(record, i % 16, kinds * center + 1);
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
