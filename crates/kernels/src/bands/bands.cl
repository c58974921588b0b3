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
typedef ushort Ushorts;
typedef short Shorts;
#define AS_FLOATS as_float
#define TO_FLOATS convert_float
#define TO_UINTS convert_uint
#else
typedef float16 Floats;
typedef ushort16 Ushorts;
typedef short16 Shorts;
#define AS_FLOATS as_float16
#define TO_FLOATS convert_float16
#define TO_UINTS convert_uint16
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
    uint narrow;
    uint wrinkles;
} Params;

// Number `at` of those of a tile's vertices, and the numbers behind it.
static Floats floats(__global const uint *words, uint at) {
    return ((__global const Floats *)words)[at / VERTICES];
}

// The weight of an influence for vertex i of a tile; floating-point numbers of 16 bits where params.narrow is 1.
static Floats influence_weight(__global const uint *influence_weights, const Params params, uint row, uint i) {
    if (params.narrow != 0) {
        Ushorts bits = ((__global const Ushorts *)influence_weights)[(16 * row + i) / VERTICES];
        Floats weight = AS_FLOATS((TO_UINTS(bits) << 12) + 0x30000000);
        return TO_UINTS(bits) == 0 ? (Floats)(0.0f) : weight;
    }
    return floats(influence_weights, 16 * row + i);
}

// Coordinate `axis` of vector j of vertex i of a tile: first the vectors of the rest pose, then those of each example.
// `record` says where the tile's vectors begin. Those of the examples are integers with a unit where its lowest bit is 1.
static Floats band_weight(__global const uint *band_weights, const Params params, uint record, uint i, uint j, uint axis) {
    uint first = record / 2 * 2;
    uint kinds = params.wrinkles != 0 ? 2 : 1;
    if (record % 2 == 0 || j < kinds) {
        return floats(band_weights, first + 48 * j + 16 * axis + i);
    }
    uint units = first + 48 * kinds;
    uint at = 2 * (units + (kinds * (params.centers - 1) + 15) / 16 * 16) + 48 * (j - kinds) + 16 * axis + i;
    Shorts integers = ((__global const Shorts *)band_weights)[at / VERTICES];
    return as_float(band_weights[units + j - kinds]) * TO_FLOATS(integers);
}

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void bands(
    __global const float *restrict squared_vector_differences,
    __global const uint *restrict influence_offsets,
    __global const uint *restrict influences,
    __global const uint *restrict influence_weights,
    __global const uint *restrict band_weights,
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
    uint kinds = params.wrinkles != 0 ? 2 : 1;
    uint record = band_weights[i / 16];
    Lanes offset[FRAMES][3];
    Lanes detail[FRAMES][3];
    for (uint g = 0; g < FRAMES; g++) {
        for (uint c = 0; c < 3; c++) {
            offset[g][c].all = band_weight(band_weights, params, record, i % 16, 0, c);
            detail[g][c].all = (Floats)(0.0f);
            if (params.wrinkles != 0) {
                detail[g][c].all = band_weight(band_weights, params, record, i % 16, 1, c);
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
            Floats weight = influence_weight(influence_weights, params, row, i % 16);
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
            Floats x = band_weight(band_weights, params, record, i % 16, kinds * center, 0);
            Floats y = band_weight(band_weights, params, record, i % 16, kinds * center, 1);
            Floats z = band_weight(band_weights, params, record, i % 16, kinds * center, 2);
            for (uint g = 0; g < FRAMES; g++) {
                Floats along = squared_rest[g] - squares[g][j];
                offset[g][0].all += x * along;
                offset[g][1].all += y * along;
                offset[g][2].all += z * along;
            }
            if (params.wrinkles != 0) {
                x = band_weight(band_weights, params, record, i % 16, kinds * center + 1, 0);
                y = band_weight(band_weights, params, record, i % 16, kinds * center + 1, 1);
                z = band_weight(band_weights, params, record, i % 16, kinds * center + 1, 2);
                for (uint g = 0; g < FRAMES; g++) {
                    Floats farther = sqrt(squares[g][j]) - rest[g];
                    detail[g][0].all += x * farther;
                    detail[g][1].all += y * farther;
                    detail[g][2].all += z * farther;
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
