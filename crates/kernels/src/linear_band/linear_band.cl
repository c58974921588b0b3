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
    uint examples;
    uint fp16;
} Params;

// Number i of c, and those of the vertices after it; fp16 where params.fp16 is 1.
static Floats example_weight(__global const uint *example_weights, const Params params, uint i) {
    return params.fp16 != 0 ? LOAD_HALVES(i / VERTICES, (__global const half *)example_weights)
                            : AS_FLOATS(((__global const Uints *)example_weights)[i / VERTICES]);
}

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void linear_band(
    __global const float *restrict basis_positions,
    __global const float *restrict strain_products,
    __global const uint *restrict influence_offsets,
    __global const uint *restrict influences,
    __global const float *restrict influence_weights,
    __global const uint *restrict example_weights,
    __global float *restrict large_scale_positions,
    const Params params)
{
    uint i = VERTICES * get_global_id(0);
    uint frame = FRAMES * get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint eights = (params.examples + 7) / 8;
    Lanes offset[FRAMES][3];
    for (uint g = 0; g < FRAMES; g++) {
        for (uint c = 0; c < 3; c++) {
            offset[g][c].all = (Floats)(0.0f);
        }
    }
    for (uint eight = 0; eight < eights; eight++) {
        Floats kappa[FRAMES][8];
        for (uint g = 0; g < FRAMES; g++) {
            for (uint j = 0; j < 8; j++) {
                kappa[g][j] = (Floats)(0.0f);
            }
        }
        uint anchors = influence_offsets[i / 16 * 2 + 1];
        for (uint row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 2]; row++) {
            uint feature = influences[row];
            Floats weight = ((__global const Floats *)influence_weights)[(16 * row + i % 16) / VERTICES];
            for (uint g = 0; g < FRAMES; g++) {
                if (row == anchors) {
                    for (uint j = 0; j < 8; j++) {
                        kappa[g][j] *= 0.9f;
                    }
                }
                uint of_frame = min(frame + g, params.frames - 1);
                uint at = (of_frame * eights + eight) * params.features + feature;
                float8 products = ((__global const float8 *)strain_products)[at];
                kappa[g][0] += weight * products.s0;
                kappa[g][1] += weight * products.s1;
                kappa[g][2] += weight * products.s2;
                kappa[g][3] += weight * products.s3;
                kappa[g][4] += weight * products.s4;
                kappa[g][5] += weight * products.s5;
                kappa[g][6] += weight * products.s6;
                kappa[g][7] += weight * products.s7;
            }
        }
        for (uint j = 0; j < 8 && 8 * eight + j < params.examples; j++) {
            uint at = (i / 16 * params.examples + 8 * eight + j) * 48 + i % 16;
            Floats x = example_weight(example_weights, params, at);
            Floats y = example_weight(example_weights, params, at + 16);
            Floats z = example_weight(example_weights, params, at + 32);
            for (uint g = 0; g < FRAMES; g++) {
                offset[g][0].all += x * kappa[g][j];
                offset[g][1].all += y * kappa[g][j];
                offset[g][2].all += z * kappa[g][j];
            }
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        for (uint lane = 0; lane < VERTICES; lane++) {
            if (frame + g < params.frames && i + lane < params.part_vertices) {
                uint result = 3 * ((frame + g) * params.vertices + params.first_vertex + i + lane);
                for (uint c = 0; c < 3; c++) {
                    large_scale_positions[result + c] = basis_positions[result + c] + offset[g][c].of[lane];
                }
            }
        }
    }
}
