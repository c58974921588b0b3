// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    features: u32,
}

@group(0) @binding(0) var<storage, read> vector_excess: array<vec4f>;
@group(0) @binding(1) var<storage, read> influence_offsets: array<u32>;
@group(0) @binding(2) var<storage, read> influences: array<u32>;
@group(0) @binding(3) var<storage, read> feature_gains: array<f32>;
@group(0) @binding(4) var<storage, read_write> band_offsets: array<f32>;
@group(0) @binding(5) var<uniform> params: Params;

@compute @workgroup_size(64)
fn beyond(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let frame = id.y;
    if i >= params.part_vertices {
        return;
    }
    let first = frame * params.features;
    if vector_excess[first].w == 0.0 {
        return;
    }
    var sum = vec3f(0.0);
    let end = influence_offsets[i / 16 * 2 + 2];
    for (var row = influence_offsets[i / 16 * 2]; row < end; row++) {
        sum += feature_gains[16 * row + i % 16] * vector_excess[first + influences[row]].xyz;
    }
    let at = 3 * (frame * params.vertices + params.first_vertex + i);
    band_offsets[at] -= sum.x;
    band_offsets[at + 1] -= sum.y;
    band_offsets[at + 2] -= sum.z;
}
