// README.md beside this file says what is computed. One invocation: one feature (x) of one frame (y).
struct Params {
    frames: u32,
    handles: u32,
    strain_edges: u32,
    centers: u32,
}

@group(0) @binding(0) var<storage, read> displacements: array<vec4f>;
@group(0) @binding(1) var<storage, read> strain_edges: array<u32>;
@group(0) @binding(2) var<storage, read> feature_lengths: array<f32>;
@group(0) @binding(3) var<storage, read> example_vectors: array<f32>;
@group(0) @binding(4) var<storage, read> feature_limits: array<f32>;
@group(0) @binding(5) var<storage, read_write> squared_vector_differences: array<f32>;
@group(0) @binding(6) var<uniform> params: Params;

fn displacement(i: u32) -> vec3f {
    return displacements[i].xyz;
}

@compute @workgroup_size(64)
fn vector_differences(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let frame = id.y;
    let features = params.strain_edges + params.handles;
    if i >= features {
        return;
    }
    let first = frame * params.handles;
    var moved: vec3f;
    if i < params.strain_edges {
        moved = displacement(first + strain_edges[2 * i + 1]) - displacement(first + strain_edges[2 * i]);
    } else {
        moved = displacement(first + i - params.strain_edges);
    }
    var strain = moved / feature_lengths[i];
    let size = sqrt(strain.x * strain.x + strain.y * strain.y + strain.z * strain.z);
    if size > feature_limits[i] {
        strain *= feature_limits[i] / size;
    }
    let eights = (params.centers + 7) / 8;
    for (var j = 0u; j < 8 * eights; j++) {
        var away = vec3f(0.0);
        if j < params.centers {
            away = strain;
        }
        if j > 0 && j < params.centers {
            let at = 3 * ((j - 1) * features + i);
            away -= vec3f(example_vectors[at], example_vectors[at + 1], example_vectors[at + 2]);
        }
        squared_vector_differences[((frame * eights + j / 8) * features + i) * 8 + j % 8] =
            away.x * away.x + away.y * away.y + away.z * away.z;
    }
}
