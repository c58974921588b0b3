// README.md beside this file says what is computed. One invocation: one row (x) of one frame (y).
struct Params {
    frames: u32,
    handles: u32,
    cluster_rows: u32,
}

@group(0) @binding(0) var<storage, read> cluster_basis: array<f32>;
@group(0) @binding(1) var<storage, read> displacements: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> cluster_motions: array<f32>;
@group(0) @binding(3) var<uniform> params: Params;

@compute @workgroup_size(64)
fn clusters(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    let frame = id.y;
    if k >= params.cluster_rows {
        return;
    }
    var sum = vec3f(0.0);
    for (var h = 0u; h < params.handles; h++) {
        sum += cluster_basis[h * params.cluster_rows + k] * displacements[frame * params.handles + h].xyz;
    }
    let at = 4 * (frame * params.cluster_rows + k);
    cluster_motions[at] = sum.x;
    cluster_motions[at + 1] = sum.y;
    cluster_motions[at + 2] = sum.z;
    cluster_motions[at + 3] = 0.0;
}
