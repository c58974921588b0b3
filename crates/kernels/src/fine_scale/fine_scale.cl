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
    uint mesh_axes;
} Params;

// a / |a|, or zero where a is zero; scales by the largest component first, so that no square vanishes or overflows.
static void normalize_all(Lanes a[3]) {
    Floats largest = max(max(fabs(a[0].all), fabs(a[1].all)), fabs(a[2].all));
    Floats scale = 1.0f / max(largest, (Floats)(FLT_MIN));
    Floats x = a[0].all * scale;
    Floats y = a[1].all * scale;
    Floats z = a[2].all * scale;
    Floats length = sqrt(x * x + y * y + z * z);
    scale = 1.0f / select(length, (Floats)(1.0f), length == 0.0f);
    a[0].all = x * scale;
    a[1].all = y * scale;
    a[2].all = z * scale;
}

static void put(float3 a, uint lane, Lanes vectors[3]) {
    vectors[0].of[lane] = a.x;
    vectors[1].of[lane] = a.y;
    vectors[2].of[lane] = a.z;
}

// The vectors from v on, coordinate by coordinate; what is past them is the last of them.
static void load_all(__global const float *from, uint v, uint lanes, Lanes to[3]) {
#if VERTICES == 16
    if (lanes == VERTICES) {
        float16 a = vload16(0, from + 3 * (size_t)v);
        float16 b = vload16(1, from + 3 * (size_t)v);
        float16 c = vload16(2, from + 3 * (size_t)v);
        to[0].all = (float16)(
            a.s0, a.s3, a.s6, a.s9, a.sc, a.sf, b.s2, b.s5,
            b.s8, b.sb, b.se, c.s1, c.s4, c.s7, c.sa, c.sd);
        to[1].all = (float16)(
            a.s1, a.s4, a.s7, a.sa, a.sd, b.s0, b.s3, b.s6,
            b.s9, b.sc, b.sf, c.s2, c.s5, c.s8, c.sb, c.se);
        to[2].all = (float16)(
            a.s2, a.s5, a.s8, a.sb, a.se, b.s1, b.s4, b.s7,
            b.sa, b.sd, c.s0, c.s3, c.s6, c.s9, c.sc, c.sf);
        return;
    }
#endif
    for (uint lane = 0; lane < VERTICES; lane++) {
        put(vload3(v + min(lane, lanes - 1), from), lane, to);
    }
}

// Writes the vectors from v on.
static void store_all(Lanes from[3], uint v, uint lanes, __global float *to) {
#if VERTICES == 16
    if (lanes == VERTICES) {
        float16 x = from[0].all;
        float16 y = from[1].all;
        float16 z = from[2].all;
        vstore16((float16)(
            x.s0, y.s0, z.s0, x.s1, y.s1, z.s1, x.s2, y.s2,
            z.s2, x.s3, y.s3, z.s3, x.s4, y.s4, z.s4, x.s5), 0, to + 3 * (size_t)v);
        vstore16((float16)(
            y.s5, z.s5, x.s6, y.s6, z.s6, x.s7, y.s7, z.s7,
            x.s8, y.s8, z.s8, x.s9, y.s9, z.s9, x.sa, y.sa), 1, to + 3 * (size_t)v);
        vstore16((float16)(
            z.sa, x.sb, y.sb, z.sb, x.sc, y.sc, z.sc, x.sd,
            y.sd, z.sd, x.se, y.se, z.se, x.sf, y.sf, z.sf), 2, to + 3 * (size_t)v);
        return;
    }
#endif
    for (uint lane = 0; lane < lanes; lane++) {
        vstore3((float3)(from[0].of[lane], from[1].of[lane], from[2].of[lane]), v + lane, to);
    }
}

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void fine_scale(
    __global const float *restrict large_scale_positions,
    __global const float *restrict large_scale_normals,
    __global const float *restrict local_detail,
    __global const uint *restrict tangent_neighbors,
    __global float *restrict positions,
    const Params params)
{
    uint i = VERTICES * get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint first = frame * params.vertices;
    uint v = params.first_vertex + i;
    uint lanes = min((uint)VERTICES, params.part_vertices - i);
    Lanes x[3];
    Lanes e[3];
    Lanes n[3];
    Lanes d[3];
    load_all(large_scale_positions, first + v, lanes, x);
    load_all(local_detail, first + v, lanes, d);
    if (params.mesh_axes != 0) {
        for (uint c = 0; c < 3; c++) {
            x[c].all += d[c].all;
        }
        store_all(x, first + v, lanes, positions);
        return;
    }
    load_all(large_scale_normals, first + v, lanes, n);
    for (uint lane = 0; lane < VERTICES; lane++) {
        put(vload3(first + tangent_neighbors[v + min(lane, lanes - 1)], large_scale_positions), lane, e);
    }
    for (uint c = 0; c < 3; c++) {
        e[c].all -= x[c].all;
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
    store_all(x, first + v, lanes, positions);
}
