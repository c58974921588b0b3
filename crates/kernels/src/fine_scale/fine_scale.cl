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

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void fine_scale(
    __global const float *restrict large_scale_positions,
    __global const float *restrict large_scale_normals,
    __global const float *restrict local_detail,
    __global const uint *restrict frame_neighbors,
    __global float *restrict positions,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint first = frame * params.vertices;
    uint at = 3 * (first + v);
    float3 x = vector(large_scale_positions, first + v);
    float3 n = (float3)(large_scale_normals[at], large_scale_normals[at + 1], large_scale_normals[at + 2]);
    float3 e = vector(large_scale_positions, first + frame_neighbors[v]) - x;
    float3 t = unit(e - (e.x * n.x + e.y * n.y + e.z * n.z) * n);
    float3 b = (float3)(n.y * t.z - n.z * t.y, n.z * t.x - n.x * t.z, n.x * t.y - n.y * t.x);
    float3 moved = x + (t * local_detail[at] + b * local_detail[at + 1] + n * local_detail[at + 2]);
    positions[at] = moved.x;
    positions[at + 1] = moved.y;
    positions[at + 2] = moved.z;
}
