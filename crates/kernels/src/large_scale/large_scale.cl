// README.md beside this file says what is computed. One work item: one vertex (x) of one frame (y).
typedef struct {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint handles;
    uint half_basis;
} Params;

// Row h of the tile of 64 vertices that vertex i of the part is in; halves where params.half_basis is 1.
static float basis_at(__global const uint *basis, const Params params, uint i, uint h) {
    uint at = (i / 64 * params.handles + h) * 64 + i % 64;
    return params.half_basis != 0 ? vload_half(at, (__global const half *)basis) : as_float(basis[at]);
}

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void large_scale(
    __global const float *restrict rest,
    __global const uint *restrict basis,
    __global const float *restrict handle_rest,
    __global const float *restrict handle_positions,
    __global float *restrict large_scale_positions,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint first = frame * params.handles;
    float3 sum = (float3)(0.0f);
    for (uint h = 0; h < params.handles; h++) {
        uint p = 3 * (first + h);
        float3 u = (float3)(handle_positions[p] - handle_rest[3 * h],
                      handle_positions[p + 1] - handle_rest[3 * h + 1],
                      handle_positions[p + 2] - handle_rest[3 * h + 2]);
        sum += basis_at(basis, params, i, h) * u;
    }
    uint result = 3 * (frame * params.vertices + v);
    large_scale_positions[result] = rest[3 * v] + sum.x;
    large_scale_positions[result + 1] = rest[3 * v + 1] + sum.y;
    large_scale_positions[result + 2] = rest[3 * v + 2] + sum.z;
}
