// README.md beside this file says what is computed. One work item: VERTICES vertices (x) of one frame (y).
// 1 on GPUs; 16, a tile, where there is a processor behind OpenCL.
#ifndef VERTICES
#define VERTICES 1
#endif
#if VERTICES == 1
typedef float Floats;
#else
typedef float16 Floats;
#endif
typedef union {
    Floats all;
    float of[VERTICES];
} Lanes;

typedef struct {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint features;
} Params;

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void beyond(
    __global const float *restrict vector_excess,
    __global const uint *restrict influence_offsets,
    __global const uint *restrict influences,
    __global const float *restrict feature_gains,
    __global float *restrict band_offsets,
    const Params params)
{
    uint i = VERTICES * get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    __global const float4 *excess = (__global const float4 *)vector_excess + frame * params.features;
    if (excess[0].w == 0.0f) {
        return;
    }
    Lanes sum[3];
    for (uint c = 0; c < 3; c++) {
        sum[c].all = (Floats)(0.0f);
    }
    __global const Floats *gains = (__global const Floats *)feature_gains;
    for (uint row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 2]; row++) {
        Floats gain = gains[(16 * row + i % 16) / VERTICES];
        float4 d = excess[influences[row]];
        sum[0].all += gain * d.x;
        sum[1].all += gain * d.y;
        sum[2].all += gain * d.z;
    }
    uint v = frame * params.vertices + params.first_vertex + i;
    uint lanes = min((uint)VERTICES, params.part_vertices - i);
    for (uint lane = 0; lane < lanes; lane++) {
        float3 offset = vload3(v + lane, band_offsets);
        vstore3(offset - (float3)(sum[0].of[lane], sum[1].of[lane], sum[2].of[lane]), v + lane, band_offsets);
    }
}
