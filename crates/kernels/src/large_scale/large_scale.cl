// README.md beside this file says what is computed. One work item: VERTICES vertices (x) of FRAMES frames (y), or of one frame (y) whose four
// vectors of each handle are summed as those of FRAMES = 4 frames are.
#ifndef FRAMES
#define FRAMES 1
#endif
// 4 on GPUs; 16, a tile, where there is a processor behind OpenCL.
#ifndef VERTICES
#define VERTICES 4
#endif
#define JOINED(a, b) a##b
#define JOIN(a, b) JOINED(a, b)
typedef JOIN(float, VERTICES) Floats;
typedef JOIN(uint, VERTICES) Uints;
typedef JOIN(short, VERTICES) Shorts;
typedef union {
    Floats all;
    float of[VERTICES];
} Lanes;

typedef struct {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint motions;
    uint basis_format;
    uint banded;
    uint rotating;
    uint center;
} Params;

// A row of the basis, for the vertices from i on.
static Floats basis_at(__global const uint *basis, const Params params, uint i, uint row) {
    uint at = (row * 16 + i % 16) / VERTICES;
    if (params.basis_format == 1) {
        return JOIN(vloada_half, VERTICES)(at, (__global const half *)basis);
    }
    if (params.basis_format == 2) {
        return JOIN(convert_float, VERTICES)(((__global const Shorts *)basis)[at]);
    }
    return JOIN(as_float, VERTICES)(((__global const Uints *)basis)[at]);
}

__kernel __attribute__((reqd_work_group_size(256 / VERTICES, 1, 1))) void large_scale(
    __global const float *restrict rest,
    __global const uint *restrict basis,
    __global const uint *restrict basis_rows,
    __global const float *restrict displacements,
    __global const float *restrict band_offsets,
    __global float *restrict large_scale_positions,
    const Params params)
{
    uint i = VERTICES * get_global_id(0);
    uint first = FRAMES * get_global_id(1);
    uint last = params.frames * (params.rotating != 0 ? 4 : 1) - 1;
    if (i >= params.part_vertices) {
        return;
    }
    Lanes x[FRAMES];
    Lanes y[FRAMES];
    Lanes z[FRAMES];
    for (uint g = 0; g < FRAMES; g++) {
        x[g].all = (Floats)(0.0f);
        y[g].all = (Floats)(0.0f);
        z[g].all = (Floats)(0.0f);
    }
    uint tile = 2 * (i / 16);
    uint rows = basis_rows[tile + 2] - basis_rows[tile];
    for (uint k = 0; k < rows; k++) {
        Floats b = basis_at(basis, params, i, basis_rows[tile] + k);
        for (uint g = 0; g < FRAMES; g++) {
            uint at = min(first + g, last) * params.motions + basis_rows[tile + 1] + k;
            float4 u = ((__global const float4 *)displacements)[at];
            x[g].all += b * u.x;
            y[g].all += b * u.y;
            z[g].all += b * u.z;
        }
    }
    for (uint g = 0; g < (params.rotating != 0 ? 1 : FRAMES); g++) {
        uint frame = params.rotating != 0 ? get_global_id(1) : first + g;
        for (uint lane = 0; lane < VERTICES; lane++) {
            if (frame < params.frames && i + lane < params.part_vertices) {
                uint v = params.first_vertex + i + lane;
                uint result = 3 * (frame * params.vertices + v);
                float3 position = vload3(v, rest);
                float3 moved = (float3)(x[g].of[lane], y[g].of[lane], z[g].of[lane]);
#if FRAMES == 4
                if (params.rotating != 0) {
                    float3 from_center = position - vload3(params.center, rest);
                    moved += from_center.x * (float3)(x[1].of[lane], y[1].of[lane], z[1].of[lane]);
                    moved += from_center.y * (float3)(x[2].of[lane], y[2].of[lane], z[2].of[lane]);
                    moved += from_center.z * (float3)(x[3].of[lane], y[3].of[lane], z[3].of[lane]);
                }
#endif
                position += moved;
                if (params.banded != 0) {
                    position += vload3(result / 3, band_offsets);
                }
                vstore3(position, result / 3, large_scale_positions);
            }
        }
    }
}
