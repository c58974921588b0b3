// README.md beside this file says what is computed. One work item: one vertex (x) of one frame (y).
typedef struct {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
} Params;

static float3 vector(__global const float *numbers, uint i) {
    return (float3)(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
}

// a / |a|, or zero where a is zero; divides by the largest component first, so that no square vanishes or overflows.
static float3 unit(float3 a) {
    float largest = max(max(fabs(a.x), fabs(a.y)), fabs(a.z));
    if (largest == 0.0f) {
        return (float3)(0.0f);
    }
    float3 scaled = a / largest;
    return scaled / sqrt(scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z);
}

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void normals(
    __global const float *restrict positions,
    __global const uint *restrict triangles,
    __global const uint *restrict triangle_offsets,
    __global const uint *restrict vertex_triangles,
    __global float *restrict vertex_normals,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint first = frame * params.vertices;
    float3 sum = (float3)(0.0f);
    for (uint k = triangle_offsets[v]; k < triangle_offsets[v + 1]; k++) {
        uint t = 3 * vertex_triangles[k];
        float3 a = vector(positions, first + triangles[t]);
        float3 e = vector(positions, first + triangles[t + 1]) - a;
        float3 f = vector(positions, first + triangles[t + 2]) - a;
        sum += (float3)(e.y * f.z - e.z * f.y, e.z * f.x - e.x * f.z, e.x * f.y - e.y * f.x);
    }
    float3 n = unit(sum);
    uint result = 3 * (first + v);
    vertex_normals[result] = n.x;
    vertex_normals[result + 1] = n.y;
    vertex_normals[result + 2] = n.z;
}
