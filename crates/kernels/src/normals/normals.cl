// README.md beside this file says what is computed. One work item: one vertex (x) of one frame (y).
typedef struct {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
} Params;

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
    __global const uint *restrict corner_offsets,
    __global const uint *restrict corners,
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
    float3 here = vload3(first + v, positions);
    for (uint k = corner_offsets[i]; k < corner_offsets[i + 1]; k++) {
        uint corner = corners[2 * k] >> 30;
        float3 next = vload3(first + (corners[2 * k] & 0x3fffffff), positions);
        float3 last = vload3(first + corners[2 * k + 1], positions);
        float3 a = corner == 0 ? here : corner == 1 ? last : next;
        float3 e = (corner == 0 ? next : corner == 1 ? here : last) - a;
        float3 f = (corner == 0 ? last : corner == 1 ? next : here) - a;
        sum += (float3)(e.y * f.z - e.z * f.y, e.z * f.x - e.x * f.z, e.x * f.y - e.y * f.x);
    }
    float3 n = unit(sum);
    uint result = 3 * (first + v);
    vertex_normals[result] = n.x;
    vertex_normals[result + 1] = n.y;
    vertex_normals[result + 2] = n.z;
}
