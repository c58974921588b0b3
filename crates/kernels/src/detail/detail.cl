// README.md beside this file says what is computed. One work item: VERTICES vertices (x) of FRAMES frames (y).
#ifndef FRAMES
#define FRAMES 1
#endif
// 1 on GPUs; 16, a tile, where there is a processor behind OpenCL.
#ifndef VERTICES
#define VERTICES 1
#endif
#if VERTICES == 1
typedef float Floats;
typedef uint Uints;
#define ANY(flags) (flags)
#else
typedef float16 Floats;
typedef uint16 Uints;
#define ANY(flags) any(flags)
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
    uint strain_edges;
    uint centers;
    uint zero_at_rest;
} Params;

// Computes the distances of each frame's features from those of the centres 8 eight to 8 eight + 7, as the vertices of the
// part from i on see them.
static void measure(
    __global const float *squared_differences,
    __global const uint *influence_offsets,
    __global const uint *influences,
    __global const float *influence_weights,
    const Params params,
    uint i,
    uint frame,
    uint eight,
    Floats distances[FRAMES][8])
{
    uint eights = (params.centers + 7) / 8;
    for (uint g = 0; g < FRAMES; g++) {
        for (uint j = 0; j < 8; j++) {
            distances[g][j] = (Floats)(0.0f);
        }
    }
    for (uint row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 1]; row++) {
        uint edge = influences[row];
        Floats alpha = ((__global const Floats *)influence_weights)[(16 * row + i % 16) / VERTICES];
        for (uint g = 0; g < FRAMES; g++) {
            uint of_frame = min(frame + g, params.frames - 1);
            uint at = (of_frame * eights + eight) * params.strain_edges + edge;
            float8 squares = ((__global const float8 *)squared_differences)[at];
            distances[g][0] += alpha * squares.s0;
            distances[g][1] += alpha * squares.s1;
            distances[g][2] += alpha * squares.s2;
            distances[g][3] += alpha * squares.s3;
            distances[g][4] += alpha * squares.s4;
            distances[g][5] += alpha * squares.s5;
            distances[g][6] += alpha * squares.s6;
            distances[g][7] += alpha * squares.s7;
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        for (uint j = 0; j < 8; j++) {
            distances[g][j] = sqrt(distances[g][j]);
        }
    }
}

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void detail(
    __global const float *restrict squared_differences,
    __global const uint *restrict influence_offsets,
    __global const uint *restrict influences,
    __global const float *restrict influence_weights,
    __global const float *restrict rbf_weights,
    __global const uint *restrict pivots,
    __global float *restrict local_detail,
    const Params params)
{
    uint i = VERTICES * get_global_id(0);
    uint frame = FRAMES * get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    // A part ends with a whole tile, so that there is something to read for every lane.
    Uints pivot = ((__global const Uints *)pivots)[i / VERTICES];
    Floats distances[FRAMES][8];
    Floats r_pivot[FRAMES];
    Lanes sum[FRAMES][3];
    for (uint g = 0; g < FRAMES; g++) {
        r_pivot[g] = (Floats)(0.0f);
        for (uint c = 0; c < 3; c++) {
            sum[g][c].all = (Floats)(0.0f);
        }
    }
    for (uint first = 0; first < params.centers; first += 8) {
        if (!ANY(pivot / 8 == first / 8)) {
            continue;
        }
        measure(squared_differences, influence_offsets, influences, influence_weights, params, i, frame,
                first / 8, distances);
        for (uint g = 0; g < FRAMES; g++) {
            for (uint j = 0; j < 8; j++) {
                r_pivot[g] = pivot == first + j ? distances[g][j] : r_pivot[g];
            }
        }
    }
    for (uint first = 0; first < params.centers; first += 8) {
        // Most rigs have no more than eight centres: then these are the distances that there are already.
        if (params.centers > 8) {
            measure(squared_differences, influence_offsets, influences, influence_weights, params, i, frame,
                    first / 8, distances);
        }
        for (uint j = 0; j < 8 && first + j < params.centers; j++) {
            uint at = ((i / 16 * params.centers + first + j) * 48 + i % 16) / VERTICES;
            __global const Floats *w = (__global const Floats *)rbf_weights + at;
            for (uint g = 0; g < FRAMES; g++) {
                Floats at_pivot = params.zero_at_rest != 0 ? (Floats)(1.0f) : r_pivot[g];
                Floats r = pivot == first + j ? at_pivot : distances[g][j] - r_pivot[g];
                sum[g][0].all += w[0] * r;
                sum[g][1].all += w[16 / VERTICES] * r;
                sum[g][2].all += w[32 / VERTICES] * r;
            }
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        for (uint lane = 0; lane < VERTICES; lane++) {
            if (frame + g < params.frames && i + lane < params.part_vertices) {
                uint result = 3 * ((frame + g) * params.vertices + params.first_vertex + i + lane);
                local_detail[result] = sum[g][0].of[lane];
                local_detail[result + 1] = sum[g][1].of[lane];
                local_detail[result + 2] = sum[g][2].of[lane];
            }
        }
    }
}
