// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    strain_edges: u32,
    influences: u32,
    centers: u32,
}

@group(0) @binding(0) var<storage, read> features: array<f32>;
@group(0) @binding(1) var<storage, read> influence_edges: array<u32>;
@group(0) @binding(2) var<storage, read> influence_weights: array<f32>;
@group(0) @binding(3) var<storage, read> pose_features: array<f32>;
@group(0) @binding(4) var<storage, read> rbf_weights: array<f32>;
@group(0) @binding(5) var<storage, read> pivots: array<u32>;
@group(0) @binding(6) var<storage, read_write> local_detail: array<f32>;
@group(0) @binding(7) var<uniform> params: Params;

// How far the features from f on are from centre j, as a vertex sees it.
fn feature_distance(f: u32, j: u32, tile: u32, lane: u32) -> f32 {
    let f_j = j * params.strain_edges;
    var square = 0.0;
    for (var k = 0u; k < params.influences; k++) {
        let at = (tile * params.influences + k) * 64 + lane;
        let edge = influence_edges[at];
        let difference = features[f + edge] - pose_features[f_j + edge];
        square += influence_weights[at] * (difference * difference);
    }
    return sqrt(square);
}

fn weight(j: u32, tile: u32, lane: u32) -> vec3f {
    let at = ((tile * params.centers + j) * 3) * 64 + lane;
    return vec3f(rbf_weights[at], rbf_weights[at + 64], rbf_weights[at + 128]);
}

@compute @workgroup_size(64)
fn detail(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let frame = id.y;
    if i >= params.part_vertices {
        return;
    }
    let v = params.first_vertex + i;
    let tile = i / 64;
    let lane = i % 64;
    let f = frame * params.strain_edges;
    let pivot = pivots[i];
    let r_pivot = feature_distance(f, pivot, tile, lane);
    var sum = weight(pivot, tile, lane) * r_pivot;
    for (var j = 0u; j < params.centers; j++) {
        if j != pivot {
            sum += weight(j, tile, lane) * (feature_distance(f, j, tile, lane) - r_pivot);
        }
    }
    let result = 3 * (frame * params.vertices + v);
    local_detail[result] = sum.x;
    local_detail[result + 1] = sum.y;
    local_detail[result + 2] = sum.z;
}
