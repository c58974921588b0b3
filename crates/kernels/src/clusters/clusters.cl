// README.md beside this file says what is computed. One work item: one row (x) of one frame (y).
typedef struct {
    uint frames;
    uint handles;
    uint cluster_rows;
} Params;

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void clusters(
    __global const float *restrict cluster_basis,
    __global const float *restrict displacements,
    __global float *restrict cluster_motions,
    const Params params)
{
    uint k = get_global_id(0);
    uint frame = get_global_id(1);
    if (k >= params.cluster_rows) {
        return;
    }
    float3 sum = (float3)(0.0f);
    for (uint h = 0; h < params.handles; h++) {
        float4 u = ((__global const float4 *)displacements)[frame * params.handles + h];
        sum += cluster_basis[h * params.cluster_rows + k] * u.xyz;
    }
    vstore4((float4)(sum, 0.0f), frame * params.cluster_rows + k, cluster_motions);
}
