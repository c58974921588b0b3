// README.md beside this file says what is computed. One work item: one edge (x) of one frame (y).
typedef struct {
    uint frames;
    uint strain_edges;
    uint centers;
} Params;

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void differences(
    __global const float *restrict features,
    __global const float *restrict pose_features,
    __global float *restrict squared_differences,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.strain_edges) {
        return;
    }
    float f = features[frame * params.strain_edges + i];
    uint eights = (params.centers + 7) / 8;
    for (uint j = 0; j < 8 * eights; j++) {
        float difference = 0.0f;
        if (j < params.centers) {
            difference = f - pose_features[j * params.strain_edges + i];
        }
        uint result = ((frame * eights + j / 8) * params.strain_edges + i) * 8 + j % 8;
        squared_differences[result] = difference * difference;
    }
}
