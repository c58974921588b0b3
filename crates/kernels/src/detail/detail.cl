// README.md beside this file says what is computed. One work item: one vertex (x) of one frame (y).
typedef struct {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint strain_edges;
    uint influences;
    uint centers;
} Params;

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void detail(
    __global const float *restrict features,
    __global const uint *restrict influence_edges,
    __global const float *restrict influence_weights,
    __global const float *restrict pose_features,
    __global const float *restrict rbf_weights,
    __global float *restrict local_detail,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint tile = i / 64;
    uint lane = i % 64;
    uint f = frame * params.strain_edges;
    float3 sum = (float3)(0.0f);
    for (uint j = 0; j < params.centers; j++) {
        uint f_j = j * params.strain_edges;
        float square = 0.0f;
        for (uint k = 0; k < params.influences; k++) {
            uint at = (tile * params.influences + k) * 64 + lane;
            uint edge = influence_edges[at];
            float difference = features[f + edge] - pose_features[f_j + edge];
            square += influence_weights[at] * (difference * difference);
        }
        float r = sqrt(square);
        uint w = ((tile * params.centers + j) * 3) * 64 + lane;
        sum += (float3)(rbf_weights[w], rbf_weights[w + 64], rbf_weights[w + 128]) * r;
    }
    uint result = 3 * (frame * params.vertices + v);
    local_detail[result] = sum.x;
    local_detail[result + 1] = sum.y;
    local_detail[result + 2] = sum.z;
}
