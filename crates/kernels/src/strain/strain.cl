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
    __global const float *restrict handle_rest,
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
    uint a = strain_edges[2 * i];
    uint b = strain_edges[2 * i + 1];
    float3 p_a = vector(handle_positions, first + a);
    float3 p_b = vector(handle_positions, first + b);
    float3 rest_a = vector(handle_rest, a);
    float3 rest_b = vector(handle_rest, b);
    float3 e = p_a - p_b;
    float3 moved = (p_a - rest_a) - (p_b - rest_b);
    float3 sum = e + (rest_a - rest_b);
    float length = sqrt(e.x * e.x + e.y * e.y + e.z * e.z);
    float l = rest_lengths[i];
    features[frame * params.strain_edges + i] =
        (moved.x * sum.x + moved.y * sum.y + moved.z * sum.z) / (length + l) / l;
}
