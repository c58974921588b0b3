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
} Params;

// a / |a|, or zero where a is zero; divides by the largest component first, so that no square vanishes or overflows.
static void normalize_all(Lanes a[3]) {
    Floats largest = max(max(fabs(a[0].all), fabs(a[1].all)), fabs(a[2].all));
    Floats scale = select(largest, (Floats)(1.0f), largest == 0.0f);
    Floats x = a[0].all / scale;
    Floats y = a[1].all / scale;
    Floats z = a[2].all / scale;
    Floats length = select(sqrt(x * x + y * y + z * z), (Floats)(1.0f), largest == 0.0f);
    a[0].all = x / length;
    a[1].all = y / length;
    a[2].all = z / length;
}

static void put(float3 a, uint lane, Lanes vectors[3]) {
    vectors[0].of[lane] = a.x;
    vectors[1].of[lane] = a.y;
    vectors[2].of[lane] = a.z;
}

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void fine_scale(
    __global const float *restrict large_scale_positions,
    __global const float *restrict large_scale_normals,
    __global const float *restrict local_detail,
    __global const uint *restrict frame_neighbors,
    __global float *restrict positions,
    const Params params)
{
    uint i = VERTICES * get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint first = frame * params.vertices;
    uint lanes = min((uint)VERTICES, params.part_vertices - i);
    Lanes x[3];
    Lanes e[3];
    Lanes n[3];
    Lanes d[3];
    for (uint lane = 0; lane < VERTICES; lane++) {
        // What is past the part is computed as its last vertex, and not written.
        uint v = params.first_vertex + i + min(lane, lanes - 1);
        float3 here = vload3(first + v, large_scale_positions);
        put(here, lane, x);
        put(vload3(first + frame_neighbors[v], large_scale_positions) - here, lane, e);
        put(vload3(first + v, large_scale_normals), lane, n);
        put(vload3(first + v, local_detail), lane, d);
    }
    Floats along = e[0].all * n[0].all + e[1].all * n[1].all + e[2].all * n[2].all;
    Lanes t[3];
    for (uint c = 0; c < 3; c++) {
        t[c].all = e[c].all - along * n[c].all;
    }
    normalize_all(t);
    for (uint c = 0; c < 3; c++) {
        uint p = (c + 1) % 3;
        uint q = (c + 2) % 3;
        Floats b = n[p].all * t[q].all - n[q].all * t[p].all;
        x[c].all += t[c].all * d[0].all + b * d[1].all + n[c].all * d[2].all;
    }
    for (uint lane = 0; lane < lanes; lane++) {
        uint v = params.first_vertex + i + lane;
        vstore3((float3)(x[0].of[lane], x[1].of[lane], x[2].of[lane]), first + v, positions);
    }
}
