#version 450
// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint features;
} params;
layout(std430, binding = 0) readonly buffer VectorExcess { vec4 vector_excess[]; };
layout(std430, binding = 1) readonly buffer InfluenceOffsets { uint influence_offsets[]; };
layout(std430, binding = 2) readonly buffer Influences { uint influences[]; };
layout(std430, binding = 3) readonly buffer FeatureGains { float feature_gains[]; };
layout(std430, binding = 4) buffer BandOffsets { float band_offsets[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    uint first = frame * params.features;
    if (i >= params.part_vertices || vector_excess[first].w == 0.0) {
        return;
    }
    vec3 sum = vec3(0.0);
    for (uint row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 2]; row++) {
        sum += feature_gains[16 * row + i % 16] * vector_excess[first + influences[row]].xyz;
    }
    uint at = 3 * (frame * params.vertices + params.first_vertex + i);
    band_offsets[at] -= sum.x;
    band_offsets[at + 1] -= sum.y;
    band_offsets[at + 2] -= sum.z;
}
