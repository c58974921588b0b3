// README.md beside this file says what is computed. One invocation: one edge (x) of one frame (y).
struct Params {
    frames: u32,
    handles: u32,
    strain_edges: u32,
}

@group(0) @binding(0) var<storage, read> handle_positions: array<f32>;
@group(0) @binding(1) var<storage, read> handle_rest: array<f32>;
@group(0) @binding(2) var<storage, read> strain_edges: array<u32>;
@group(0) @binding(3) var<storage, read> rest_lengths: array<f32>;
@group(0) @binding(4) var<storage, read_write> features: array<f32>;
@group(0) @binding(5) var<uniform> params: Params;

fn handle_position(i: u32) -> vec3f {
    return vec3f(handle_positions[3 * i], handle_positions[3 * i + 1], handle_positions[3 * i + 2]);
}

fn rest_position(i: u32) -> vec3f {
    return vec3f(handle_rest[3 * i], handle_rest[3 * i + 1], handle_rest[3 * i + 2]);
}

@compute @workgroup_size(64)
fn strain(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let frame = id.y;
    if i >= params.strain_edges {
        return;
    }
    let first = frame * params.handles;
    let a = strain_edges[2 * i];
    let b = strain_edges[2 * i + 1];
    let p_a = handle_position(first + a);
    let p_b = handle_position(first + b);
    let rest_a = rest_position(a);
    let rest_b = rest_position(b);
    let e = p_a - p_b;
    let moved = (p_a - rest_a) - (p_b - rest_b);
    let sum = e + (rest_a - rest_b);
    let length = sqrt(e.x * e.x + e.y * e.y + e.z * e.z);
    let l = rest_lengths[i];
    features[frame * params.strain_edges + i] =
        (moved.x * sum.x + moved.y * sum.y + moved.z * sum.z) / (length + l) / l;
}
