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
#define AS_FLOATS as_float
#define LOAD_HALVES vload_half
#else
typedef float16 Floats;
typedef uint16 Uints;
#define AS_FLOATS as_float16
#define LOAD_HALVES vloada_half16
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
    uint centers;
    uint fp16;
    uint wrinkles;
} Params;

// Number i of half of c, and those of the vertices after it; fp16 where params.fp16 is 1.
static Floats example_weight(__global const uint *example_weights, const Params params, uint i) {
    return params.fp16 != 0 ? LOAD_HALVES(i / VERTICES, (__global const half *)example_weights)
                            : AS_FLOATS(((__global const Uints *)example_weights)[i / VERTICES]);
}

// Where vector j of vertex i is in a, b and w.
static uint wrinkle_weight(const Params params, uint i, uint j) {
    uint vectors = params.wrinkles != 0 ? params.centers + 1 : 1;
    return ((i / 16 * vectors + j) * 48 + i % 16) / VERTICES;
}

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void bands(
    __global const float *restrict squared_vector_differences,
    __global const uint *restrict influence_offsets,
    __global const uint *restrict influences,
    __global const float *restrict influence_weights,
    __global const uint *restrict example_weights,
    __global const float *restrict wrinkle_weights,
    __global float *restrict band_offsets,
    __global float *restrict local_detail,
    const Params params)
{
    uint i = VERTICES * get_global_id(0);
    uint frame = FRAMES * get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint eights = (params.centers + 7) / 8;
    __global const Floats *weights = (__global const Floats *)wrinkle_weights;
    Lanes offset[FRAMES][3];
    Lanes detail[FRAMES][3];
    for (uint g = 0; g < FRAMES; g++) {
        for (uint c = 0; c < 3; c++) {
            offset[g][c].all = weights[wrinkle_weight(params, i, 0) + c * (16 / VERTICES)];
            detail[g][c].all = (Floats)(0.0f);
            if (params.wrinkles != 0) {
                detail[g][c].all = weights[wrinkle_weight(params, i, 1) + c * (16 / VERTICES)];
            }
        }
    }
    // The distance from the rest pose, squared and not.
    Floats squared_rest[FRAMES];
    Floats rest[FRAMES];
    for (uint eight = 0; eight < eights; eight++) {
        Floats squares[FRAMES][8];
        for (uint g = 0; g < FRAMES; g++) {
            for (uint j = 0; j < 8; j++) {
                squares[g][j] = (Floats)(0.0f);
            }
        }
        uint anchors = influence_offsets[i / 16 * 2 + 1];
        for (uint row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 2]; row++) {
            uint feature = influences[row];
            Floats weight = ((__global const Floats *)influence_weights)[(16 * row + i % 16) / VERTICES];
            for (uint g = 0; g < FRAMES; g++) {
                if (row == anchors) {
                    for (uint j = 0; j < 8; j++) {
                        squares[g][j] *= 0.9f;
                    }
                }
                uint of_frame = min(frame + g, params.frames - 1);
                uint at = (of_frame * eights + eight) * params.features + feature;
                float8 differences = ((__global const float8 *)squared_vector_differences)[at];
                squares[g][0] += weight * differences.s0;
                squares[g][1] += weight * differences.s1;
                squares[g][2] += weight * differences.s2;
                squares[g][3] += weight * differences.s3;
                squares[g][4] += weight * differences.s4;
                squares[g][5] += weight * differences.s5;
                squares[g][6] += weight * differences.s6;
                squares[g][7] += weight * differences.s7;
            }
        }
        if (eight == 0) {
            for (uint g = 0; g < FRAMES; g++) {
                squared_rest[g] = squares[g][0];
                rest[g] = sqrt(squares[g][0]);
            }
        }
        for (uint j = eight == 0 ? 1 : 0; j < 8 && 8 * eight + j < params.centers; j++) {
            uint center = 8 * eight + j;
            uint at = (i / 16 * (params.centers - 1) + center - 1) * 48 + i % 16;
            Floats x = example_weight(example_weights, params, at);
            Floats y = example_weight(example_weights, params, at + 16);
            Floats z = example_weight(example_weights, params, at + 32);
            for (uint g = 0; g < FRAMES; g++) {
                Floats along = squared_rest[g] - squares[g][j];
                offset[g][0].all += x * along;
                offset[g][1].all += y * along;
                offset[g][2].all += z * along;
            }
            if (params.wrinkles != 0) {
                __global const Floats *w = weights + wrinkle_weight(params, i, center + 1);
                for (uint g = 0; g < FRAMES; g++) {
                    Floats farther = sqrt(squares[g][j]) - rest[g];
                    detail[g][0].all += w[0] * farther;
                    detail[g][1].all += w[16 / VERTICES] * farther;
                    detail[g][2].all += w[32 / VERTICES] * farther;
                }
            }
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        for (uint lane = 0; lane < VERTICES; lane++) {
            if (frame + g < params.frames && i + lane < params.part_vertices) {
                uint result = 3 * ((frame + g) * params.vertices + params.first_vertex + i + lane);
                for (uint c = 0; c < 3; c++) {
                    band_offsets[result + c] = offset[g][c].of[lane];
                    if (params.wrinkles != 0) {
                        local_detail[result + c] = detail[g][c].of[lane];
                    }
                }
            }
        }
    }
}
