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
#else
typedef float16 Floats;
typedef uint16 Uints;
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
    uint influences;
    uint centers;
    uint edges_per_word;
} Params;

// Computes the distances of each frame's features from those of the centres 8 eight to 8 eight + 7, as vertex i of the
// part sees them, for one lane of `distances`.
static void measure(
    __global const float *squared_differences,
    __global const uint *influence_edges,
    __global const float *influence_weights,
    const Params params,
    uint i,
    uint frame,
    uint eight,
    uint lane,
    Lanes distances[FRAMES][8])
{
    uint eights = (params.centers + 7) / 8;
    uint words = (params.influences + params.edges_per_word - 1) / params.edges_per_word;
    uint bits = 32 / params.edges_per_word;
    uint mask = 0xffffffff >> (32 - bits);
    float8 squares[FRAMES];
    for (uint g = 0; g < FRAMES; g++) {
        squares[g] = (float8)(0.0f);
    }
    for (uint word = 0; word < words; word++) {
        uint edges = influence_edges[(i / 16 * words + word) * 16 + i % 16];
        uint first = word * params.edges_per_word;
        for (uint k = first; k < min(first + params.edges_per_word, params.influences); k++) {
            uint edge = edges >> ((k - first) * bits) & mask;
            float alpha = influence_weights[(i / 16 * params.influences + k) * 16 + i % 16];
            // Those that are zero come last.
            if (alpha == 0.0f) {
                word = words;
                break;
            }
            for (uint g = 0; g < FRAMES; g++) {
                uint of_frame = min(frame + g, params.frames - 1);
                uint at = (of_frame * eights + eight) * params.strain_edges + edge;
                squares[g] += alpha * ((__global const float8 *)squared_differences)[at];
            }
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        float of_eight[8];
        vstore8(sqrt(squares[g]), 0, of_eight);
        for (uint j = 0; j < 8; j++) {
            distances[g][j].of[lane] = of_eight[j];
        }
    }
}

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void detail(
    __global const float *restrict squared_differences,
    __global const uint *restrict influence_edges,
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
    Lanes distances[FRAMES][8];
    for (uint lane = 0; lane < VERTICES; lane++) {
        measure(squared_differences, influence_edges, influence_weights, params, i + lane, frame,
                pivots[i + lane] / 8, lane, distances);
    }
    Floats r_pivot[FRAMES];
    Lanes sum[FRAMES][3];
    for (uint g = 0; g < FRAMES; g++) {
        r_pivot[g] = distances[g][0].all;
        for (uint j = 1; j < 8; j++) {
            r_pivot[g] = pivot % 8 == j ? distances[g][j].all : r_pivot[g];
        }
        for (uint c = 0; c < 3; c++) {
            sum[g][c].all = (Floats)(0.0f);
        }
    }
    for (uint first = 0; first < params.centers; first += 8) {
        // Most rigs have no more than eight centres: then these are the distances that there are already.
        if (params.centers > 8) {
            for (uint lane = 0; lane < VERTICES; lane++) {
                measure(squared_differences, influence_edges, influence_weights, params, i + lane, frame,
                        first / 8, lane, distances);
            }
        }
        for (uint j = 0; j < min(8u, params.centers - first); j++) {
            uint at = ((i / 16 * params.centers + first + j) * 48 + i % 16) / VERTICES;
            __global const Floats *w = (__global const Floats *)rbf_weights + at;
            for (uint g = 0; g < FRAMES; g++) {
                Floats r = pivot == first + j ? r_pivot[g] : distances[g][j].all - r_pivot[g];
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
