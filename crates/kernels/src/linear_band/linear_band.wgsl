// README.md beside this file says what is computed. One invocation: one vertex (x) of FRAMES frames (y).
override FRAMES: u32 = 1;

struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    features: u32,
    examples: u32,
    fp16: u32,
}

@group(0) @binding(0) var<storage, read> basis_positions: array<f32>;
@group(0) @binding(1) var<storage, read> strain_products: array<vec4f>;
@group(0) @binding(2) var<storage, read> influence_offsets: array<u32>;
@group(0) @binding(3) var<storage, read> influences: array<u32>;
@group(0) @binding(4) var<storage, read> influence_weights: array<f32>;
@group(0) @binding(5) var<storage, read> example_weights: array<u32>;
@group(0) @binding(6) var<storage, read_write> large_scale_positions: array<f32>;
@group(0) @binding(7) var<uniform> params: Params;

// Number i of c; fp16 where params.fp16 is 1.
fn example_weight(i: u32) -> f32 {
    if params.fp16 != 0 {
        let pair = unpack2x16float(example_weights[i / 2]);
        return select(pair.y, pair.x, i % 2 == 0);
    }
    return bitcast<f32>(example_weights[i]);
}

// One of eight numbers. Written so that no array is indexed by what differs between invocations.
fn one_of(low: vec4f, high: vec4f, j: u32) -> f32 {
    let of_four = select(high, low, j < 4);
    let of_two = select(of_four.zw, of_four.xy, j % 4 < 2);
    return select(of_two.y, of_two.x, j % 2 == 0);
}

@compute @workgroup_size(64)
fn linear_band(@builtin(global_invocation_id) id: vec3u) {
    // Those past the end compute the last vertex once more, so that all of a workgroup go the same way.
    let i = min(id.x, params.part_vertices - 1);
    let frame = FRAMES * id.y;
    let eights = (params.examples + 7) / 8;
    var offset: array<vec3f, 4>;
    for (var eight = 0u; eight < eights; eight++) {
        // How much of each of eight examples there is in each frame: the first four, and the others.
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
                low[g] += weight * strain_products[at];
                high[g] += weight * strain_products[at + 1];
            }
        }
        for (var j = 0u; j < min(8, params.examples - 8 * eight); j++) {
            let at = (i / 16 * params.examples + 8 * eight + j) * 48 + i % 16;
            let c = vec3f(example_weight(at), example_weight(at + 16), example_weight(at + 32));
            for (var g = 0u; g < FRAMES; g++) {
                offset[g] += c * one_of(low[g], high[g], j);
            }
        }
    }
    for (var g = 0u; g < FRAMES; g++) {
        if frame + g < params.frames && id.x < params.part_vertices {
            let result = 3 * ((frame + g) * params.vertices + params.first_vertex + i);
            large_scale_positions[result] = basis_positions[result] + offset[g].x;
            large_scale_positions[result + 1] = basis_positions[result + 1] + offset[g].y;
            large_scale_positions[result + 2] = basis_positions[result + 2] + offset[g].z;
        }
    }
}
