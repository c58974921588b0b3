// README.md beside this file says what is computed. One work item: one feature (x) of one frame (y).
typedef struct {
    uint frames;
    uint handles;
    uint strain_edges;
    uint examples;
} Params;

static float3 displacement(__global const float *displacements, uint i) {
    return ((__global const float4 *)displacements)[i].xyz;
}

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void products(
    __global const float *restrict displacements,
    __global const uint *restrict strain_edges,
    __global const float *restrict example_vectors,
    __global const float *restrict feature_bounds,
    __global float *restrict strain_products,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    uint features = params.strain_edges + params.handles;
    if (i >= features) {
        return;
    }
    uint first = frame * params.handles;
    float3 moved;
    if (i < params.strain_edges) {
        moved = displacement(displacements, first + strain_edges[2 * i + 1]) -
                displacement(displacements, first + strain_edges[2 * i]);
    } else {
        moved = displacement(displacements, first + i - params.strain_edges);
    }
    moved = clamp(moved, vload3(i, feature_bounds), vload3(features + i, feature_bounds));
    uint eights = (params.examples + 7) / 8;
    for (uint j = 0; j < 8 * eights; j++) {
        float product = 0.0f;
        if (j < params.examples) {
            float3 vector = vload3(j * features + i, example_vectors);
            product = moved.x * vector.x + moved.y * vector.y + moved.z * vector.z;
        }
        strain_products[((frame * eights + j / 8) * features + i) * 8 + j % 8] = product;
    }
}
