#version 450
// README.md beside this file says what is computed. One invocation: one edge (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint strain_edges;
    uint centers;
} params;
layout(std430, binding = 0) readonly buffer Features { float features[]; };
layout(std430, binding = 1) readonly buffer PoseFeatures { float pose_features[]; };
layout(std430, binding = 2) writeonly buffer SquaredDifferences { float squared_differences[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    if (i >= params.strain_edges) {
        return;
    }
    float f = features[frame * params.strain_edges + i];
    uint eights = (params.centers + 7) / 8;
    for (uint j = 0; j < 8 * eights; j++) {
        float difference = 0.0;
        if (j < params.centers) {
            difference = f - pose_features[j * params.strain_edges + i];
        }
        uint result = ((frame * eights + j / 8) * params.strain_edges + i) * 8 + j % 8;
        squared_differences[result] = difference * difference;
    }
}
