#version 450
// README.md beside this file says what is computed. One invocation: one feature (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint handles;
    uint strain_edges;
    uint centers;
} params;
layout(std430, binding = 0) readonly buffer Displacements { vec4 displacements[]; };
layout(std430, binding = 1) readonly buffer StrainEdges { uint strain_edges[]; };
layout(std430, binding = 2) readonly buffer FeatureLengths { float feature_lengths[]; };
layout(std430, binding = 3) readonly buffer ExampleVectors { float example_vectors[]; };
layout(std430, binding = 4) readonly buffer FeatureLimits { float feature_limits[]; };
layout(std430, binding = 5) writeonly buffer SquaredVectorDifferences { float squared_vector_differences[]; };

vec3 displacement(uint i) {
    return displacements[i].xyz;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    uint features = params.strain_edges + params.handles;
    if (i >= features) {
        return;
    }
    uint first = frame * params.handles;
    vec3 moved;
    if (i < params.strain_edges) {
        moved = displacement(first + strain_edges[2 * i + 1]) - displacement(first + strain_edges[2 * i]);
    } else {
        moved = displacement(first + i - params.strain_edges);
    }
    vec3 strain = moved / feature_lengths[i];
    float size = sqrt(strain.x * strain.x + strain.y * strain.y + strain.z * strain.z);
    if (size > feature_limits[i]) {
        strain *= feature_limits[i] / size;
    }
    uint eights = (params.centers + 7) / 8;
    for (uint j = 0; j < 8 * eights; j++) {
        vec3 away = vec3(0.0);
        if (j < params.centers) {
            away = strain;
        }
        if (j > 0 && j < params.centers) {
            uint at = 3 * ((j - 1) * features + i);
            away -= vec3(example_vectors[at], example_vectors[at + 1], example_vectors[at + 2]);
        }
        squared_vector_differences[((frame * eights + j / 8) * features + i) * 8 + j % 8] =
            away.x * away.x + away.y * away.y + away.z * away.z;
    }
}
