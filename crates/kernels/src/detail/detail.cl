// README.md beside this file says what is computed. One work item: one vertex (x) of one frame (y).
typedef struct {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint strain_edges;
    uint influences;
    uint centers;
} Params;

// How far the features f are from those of a centre, f_j, as a vertex sees it.
static float feature_distance(
    __global const float *f,
    __global const float *f_j,
    __global const uint *influence_edges,
    __global const float *influence_weights,
    const Params params,
    uint tile,
    uint lane)
{
    float square = 0.0f;
    for (uint k = 0; k < params.influences; k++) {
        uint at = (tile * params.influences + k) * 64 + lane;
        uint edge = influence_edges[at];
        float difference = f[edge] - f_j[edge];
        square += influence_weights[at] * (difference * difference);
    }
    return sqrt(square);
}

static float3 weight(__global const float *rbf_weights, const Params params, uint j, uint tile, uint lane) {
    uint at = ((tile * params.centers + j) * 3) * 64 + lane;
    return (float3)(rbf_weights[at], rbf_weights[at + 64], rbf_weights[at + 128]);
}

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void detail(
    __global const float *restrict features,
    __global const uint *restrict influence_edges,
    __global const float *restrict influence_weights,
    __global const float *restrict pose_features,
    __global const float *restrict rbf_weights,
    __global const uint *restrict pivots,
    __global float *restrict local_detail,
    const Params params)
{
    uint i = get_global_id(0);
    uint frame = get_global_id(1);
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint tile = i / 64;
    uint lane = i % 64;
    __global const float *f = features + frame * params.strain_edges;
    uint pivot = pivots[i];
    float r_pivot = feature_distance(
        f, pose_features + pivot * params.strain_edges, influence_edges, influence_weights, params, tile, lane);
    float3 sum = weight(rbf_weights, params, pivot, tile, lane) * r_pivot;
    for (uint j = 0; j < params.centers; j++) {
        if (j != pivot) {
            float r = feature_distance(
                f, pose_features + j * params.strain_edges, influence_edges, influence_weights, params, tile, lane);
            sum += weight(rbf_weights, params, j, tile, lane) * (r - r_pivot);
        }
    }
    uint result = 3 * (frame * params.vertices + v);
    local_detail[result] = sum.x;
    local_detail[result + 1] = sum.y;
    local_detail[result + 2] = sum.z;
}
