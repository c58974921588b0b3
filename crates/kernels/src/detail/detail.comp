#version 450
// README.md beside this file says what is computed. One invocation: one vertex (x) of FRAMES frames (y).
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint FRAMES = 1;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint strain_edges;
    uint centers;
    uint zero_at_rest;
} params;
layout(std430, binding = 0) readonly buffer SquaredDifferences { vec4 squared_differences[]; };
layout(std430, binding = 1) readonly buffer InfluenceOffsets { uint influence_offsets[]; };
layout(std430, binding = 2) readonly buffer Influences { uint influences[]; };
layout(std430, binding = 3) readonly buffer InfluenceWeights { float influence_weights[]; };
layout(std430, binding = 4) readonly buffer RbfWeights { float rbf_weights[]; };
layout(std430, binding = 5) readonly buffer Pivots { uint pivots[]; };
layout(std430, binding = 6) writeonly buffer LocalDetail { float local_detail[]; };

// The distances of each frame's features from those of eight centres: the first four, and the others.
vec4 low[4];
vec4 high[4];

// Computes the distances from the centres 8 eight to 8 eight + 7, as vertex i of the part sees them.
void measure(uint i, uint frame, uint eight) {
    uint eights = (params.centers + 7) / 8;
    for (uint g = 0; g < FRAMES; g++) {
        low[g] = vec4(0.0);
        high[g] = vec4(0.0);
    }
    for (uint row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 1]; row++) {
        uint edge = influences[row];
        float alpha = influence_weights[16 * row + i % 16];
        for (uint g = 0; g < FRAMES; g++) {
            uint of_frame = min(frame + g, params.frames - 1);
            uint at = 2 * ((of_frame * eights + eight) * params.strain_edges + edge);
            low[g] += alpha * squared_differences[at];
            high[g] += alpha * squared_differences[at + 1];
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        low[g] = sqrt(low[g]);
        high[g] = sqrt(high[g]);
    }
}

// One of the distances, 0 to 7. Written so that no array is indexed by what differs between invocations.
float distance_to(uint g, uint j) {
    vec4 of_four = j < 4 ? low[g] : high[g];
    vec2 of_two = j % 4 < 2 ? of_four.xy : of_four.zw;
    return j % 2 == 0 ? of_two.x : of_two.y;
}

vec3 weight(uint i, uint j) {
    uint at = (i / 16 * params.centers + j) * 48 + i % 16;
    return vec3(rbf_weights[at], rbf_weights[at + 16], rbf_weights[at + 32]);
}

void main() {
    // Those past the end compute the last vertex once more, so that all of a workgroup go the same way.
    uint i = min(gl_GlobalInvocationID.x, params.part_vertices - 1);
    uint frame = FRAMES * gl_GlobalInvocationID.y;
    uint pivot = pivots[i];
    measure(i, frame, pivot / 8);
    float r_pivot[4];
    vec3 sum[4];
    for (uint g = 0; g < FRAMES; g++) {
        r_pivot[g] = distance_to(g, pivot % 8);
        sum[g] = vec3(0);
    }
    for (uint first = 0; first < params.centers; first += 8) {
        // Most rigs have no more than eight centres: then these are the distances that there are already.
        if (params.centers > 8) {
            measure(i, frame, first / 8);
        }
        for (uint j = 0; j < min(8, params.centers - first); j++) {
            vec3 w = weight(i, first + j);
            for (uint g = 0; g < FRAMES; g++) {
                float at_pivot = params.zero_at_rest != 0 ? 1.0 : r_pivot[g];
                sum[g] += w * (first + j == pivot ? at_pivot : distance_to(g, j) - r_pivot[g]);
            }
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        if (frame + g < params.frames && gl_GlobalInvocationID.x < params.part_vertices) {
            uint result = 3 * ((frame + g) * params.vertices + params.first_vertex + i);
            local_detail[result] = sum[g].x;
            local_detail[result + 1] = sum[g].y;
            local_detail[result + 2] = sum[g].z;
        }
    }
}
