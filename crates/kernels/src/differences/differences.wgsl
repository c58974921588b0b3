// README.md beside this file says what is computed. One invocation: one edge (x) of one frame (y).
struct Params {
    frames: u32,
    strain_edges: u32,
    centers: u32,
}

@group(0) @binding(0) var<storage, read> features: array<f32>;
@group(0) @binding(1) var<storage, read> pose_features: array<f32>;
@group(0) @binding(2) var<storage, read_write> squared_differences: array<f32>;
@group(0) @binding(3) var<uniform> params: Params;

@compute @workgroup_size(64)
fn differences(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let frame = id.y;
    if i >= params.strain_edges {
        return;
    }
    let f = features[frame * params.strain_edges + i];
    let eights = (params.centers + 7) / 8;
    for (var j = 0u; j < 8 * eights; j++) {
        var difference = 0.0;
        if j < params.centers {
            difference = f - pose_features[j * params.strain_edges + i];
        }
        let result = ((frame * eights + j / 8) * params.strain_edges + i) * 8 + j % 8;
        squared_differences[result] = difference * difference;
    }
}
