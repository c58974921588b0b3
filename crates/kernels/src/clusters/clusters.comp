#version 450
// README.md beside this file says what is computed. One invocation: one row (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint handles;
    uint cluster_rows;
} params;
layout(std430, binding = 0) readonly buffer ClusterBasis { float cluster_basis[]; };
layout(std430, binding = 1) readonly buffer Displacements { vec4 displacements[]; };
layout(std430, binding = 2) writeonly buffer ClusterMotions { float cluster_motions[]; };

void main() {
    uint k = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    if (k >= params.cluster_rows) {
        return;
    }
    vec3 sum = vec3(0.0);
    for (uint h = 0; h < params.handles; h++) {
        sum += cluster_basis[h * params.cluster_rows + k] * displacements[frame * params.handles + h].xyz;
    }
    uint at = 4 * (frame * params.cluster_rows + k);
    cluster_motions[at] = sum.x;
    cluster_motions[at + 1] = sum.y;
    cluster_motions[at + 2] = sum.z;
    cluster_motions[at + 3] = 0.0;
}
