// README.md beside this file says what is computed. One work item: one feature (x) of one frame (y).
typedef struct {
    uint frames;
    uint handles;
    uint strain_edges;
    uint centers;
} Params;

static float3 displacement(__global const float *displacements, uint i) {
    return ((__global const float4 *)displacements)[i].xyz;
}

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void vector_differences(
    __global const float *restrict displacements,
    __global const uint *restrict strain_edges,
    __global const float *restrict feature_lengths,
    __global const float *restrict example_vectors,
    __global const float *restrict feature_limits,
    __global float *restrict squared_vector_differences,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    uint features = params.strain_edges + params.handles;
    if (i >= features) {
        return;
    }
    uint first = frame * params.handles;
    float3 moved;
    if (i < params.strain_edges) {
        moved = displacement(displacements, first + strain_edges[2 * i + 1]) -
                displacement(displacements, first + strain_edges[2 * i]);
    } else {
        moved = displacement(displacements, first + i - params.strain_edges);
    }
    float3 strain = moved / feature_lengths[i];
    float size = sqrt(strain.x * strain.x + strain.y * strain.y + strain.z * strain.z);
    if (size > feature_limits[i]) {
        strain *= feature_limits[i] / size;
    }
    uint eights = (params.centers + 7) / 8;
    for (uint j = 0; j < 8 * eights; j++) {
        float3 away = (float3)(0.0f);
        if (j < params.centers) {
            away = strain;
        }
        if (j > 0 && j < params.centers) {
            away -= vload3((j - 1) * features + i, example_vectors);
        }
        squared_vector_differences[((frame * eights + j / 8) * features + i) * 8 + j % 8] =
            away.x * away.x + away.y * away.y + away.z * away.z;
    }
}
