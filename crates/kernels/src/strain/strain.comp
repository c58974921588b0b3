#version 450
// README.md beside this file says what is computed. One invocation: one edge (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint handles;
    uint strain_edges;
} params;
layout(std430, binding = 0) readonly buffer HandlePositions { float handle_positions[]; };
layout(std430, binding = 1) readonly buffer StrainEdges { uint strain_edges[]; };
layout(std430, binding = 2) readonly buffer RestLengths { float rest_lengths[]; };
layout(std430, binding = 3) writeonly buffer Features { float features[]; };

vec3 handle_position(uint i) {
    return vec3(handle_positions[3 * i], handle_positions[3 * i + 1], handle_positions[3 * i + 2]);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    if (i >= params.strain_edges) {
        return;
    }
    uint first = frame * params.handles;
    vec3 a = handle_position(first + strain_edges[2 * i]);
    vec3 b = handle_position(first + strain_edges[2 * i + 1]);
    vec3 d = a - b;
    float length = sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    features[frame * params.strain_edges + i] = (length - rest_lengths[i]) / rest_lengths[i];
}
