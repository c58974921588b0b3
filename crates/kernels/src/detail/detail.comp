#version 450
// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint strain_edges;
    uint influences;
    uint centers;
} params;
layout(std430, binding = 0) readonly buffer Features { float features[]; };
layout(std430, binding = 1) readonly buffer InfluenceEdges { uint influence_edges[]; };
layout(std430, binding = 2) readonly buffer InfluenceWeights { float influence_weights[]; };
layout(std430, binding = 3) readonly buffer PoseFeatures { float pose_features[]; };
layout(std430, binding = 4) readonly buffer RbfWeights { float rbf_weights[]; };
layout(std430, binding = 5) readonly buffer Pivots { uint pivots[]; };
layout(std430, binding = 6) writeonly buffer LocalDetail { float local_detail[]; };

// How far the features from f on are from centre j, as a vertex sees it.
float feature_distance(uint f, uint j, uint tile, uint lane) {
    uint f_j = j * params.strain_edges;
    float square = 0.0;
    for (uint k = 0; k < params.influences; k++) {
        uint at = (tile * params.influences + k) * 64 + lane;
        uint edge = influence_edges[at];
        float difference = features[f + edge] - pose_features[f_j + edge];
        square += influence_weights[at] * (difference * difference);
    }
    return sqrt(square);
}

vec3 weight(uint j, uint tile, uint lane) {
    uint at = ((tile * params.centers + j) * 3) * 64 + lane;
    return vec3(rbf_weights[at], rbf_weights[at + 64], rbf_weights[at + 128]);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint tile = i / 64;
    uint lane = i % 64;
    uint f = frame * params.strain_edges;
    uint pivot = pivots[i];
    float r_pivot = feature_distance(f, pivot, tile, lane);
    vec3 sum = weight(pivot, tile, lane) * r_pivot;
    for (uint j = 0; j < params.centers; j++) {
        if (j != pivot) {
            sum += weight(j, tile, lane) * (feature_distance(f, j, tile, lane) - r_pivot);
        }
    }
    uint result = 3 * (frame * params.vertices + v);
    local_detail[result] = sum.x;
    local_detail[result + 1] = sum.y;
    local_detail[result + 2] = sum.z;
}
