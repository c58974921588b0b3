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

__kernel __attribute__((reqd_work_group_size(64 / VERTICES, 1, 1))) void normals(
    __global const float *restrict positions,
    __global const uint *restrict fan_offsets,
    __global const uint *restrict fans,
    __global float *restrict vertex_normals,
    const Params params)
{
    uint i = VERTICES * get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint first = frame * params.vertices;
    uint v = first + params.first_vertex + i;
    uint lanes = min((uint)VERTICES, params.part_vertices - i);
    Lanes normal[3];
    for (uint lane = 0; lane < VERTICES; lane++) {
        // What is past the part is computed as its last vertex, and not written.
        float3 here = vload3(v + min(lane, lanes - 1), positions);
        float3 e = (float3)(0.0f);
        float3 sum = (float3)(0.0f);
        for (uint row = fan_offsets[i / 16]; row < fan_offsets[i / 16 + 1]; row++) {
            float3 f = vload3(first + fans[16 * row + i % 16 + lane], positions) - here;
            // e × f, but for the order of its components.
            sum += e * f.yzx - e.yzx * f;
            e = f;
        }
        normal[0].of[lane] = sum.y;
        normal[1].of[lane] = sum.z;
        normal[2].of[lane] = sum.x;
    }
    normalize_all(normal);
    for (uint lane = 0; lane < lanes; lane++) {
        vstore3((float3)(normal[0].of[lane], normal[1].of[lane], normal[2].of[lane]), v + lane, vertex_normals);
    }
}
