#version 450
// README.md beside this file says what is computed. One invocation: one edge (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint handles;
    uint strain_edges;
} params;
layout(std430, binding = 0) readonly buffer HandlePositions { float handle_positions[]; };
layout(std430, binding = 1) readonly buffer HandleRest { float handle_rest[]; };
layout(std430, binding = 2) readonly buffer StrainEdges { uint strain_edges[]; };
layout(std430, binding = 3) readonly buffer RestLengths { float rest_lengths[]; };
layout(std430, binding = 4) writeonly buffer Features { float features[]; };

vec3 handle_position(uint i) {
    return vec3(handle_positions[3 * i], handle_positions[3 * i + 1], handle_positions[3 * i + 2]);
}

vec3 rest_position(uint i) {
    return vec3(handle_rest[3 * i], handle_rest[3 * i + 1], handle_rest[3 * i + 2]);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    if (i >= params.strain_edges) {
        return;
    }
    uint first = frame * params.handles;
    uint a = strain_edges[2 * i];
    uint b = strain_edges[2 * i + 1];
    vec3 p_a = handle_position(first + a);
    vec3 p_b = handle_position(first + b);
    vec3 rest_a = rest_position(a);
    vec3 rest_b = rest_position(b);
    vec3 e = p_a - p_b;
    vec3 moved = (p_a - rest_a) - (p_b - rest_b);
    vec3 sum = e + (rest_a - rest_b);
    float length = sqrt(e.x * e.x + e.y * e.y + e.z * e.z);
    float l = rest_lengths[i];
    features[frame * params.strain_edges + i] =
        (moved.x * sum.x + moved.y * sum.y + moved.z * sum.z) / (length + l) / l;
}
