// README.md beside this file says what is computed. One work item: one edge (x) of one frame (y).
typedef struct {
    uint frames;
    uint handles;
    uint strain_edges;
} Params;

static float3 vector(__global const float *numbers, uint i) {
    return (float3)(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
}

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void strain(
    __global const float *restrict handle_positions,
    __global const uint *restrict strain_edges,
    __global const float *restrict rest_lengths,
    __global float *restrict features,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.strain_edges) {
        return;
    }
    uint first = frame * params.handles;
    float3 a = vector(handle_positions, first + strain_edges[2 * i]);
    float3 b = vector(handle_positions, first + strain_edges[2 * i + 1]);
    float3 d = a - b;
    float length = sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    features[frame * params.strain_edges + i] = (length - rest_lengths[i]) / rest_lengths[i];
}
