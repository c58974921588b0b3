#version 450
// README.md beside this file says what is computed. One invocation: one vertex (x) of FRAMES frames (y).
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint FRAMES = 1;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint features;
    uint examples;
    uint fp16;
} params;
layout(std430, binding = 0) readonly buffer BasisPositions { float basis_positions[]; };
layout(std430, binding = 1) readonly buffer StrainProducts { vec4 strain_products[]; };
layout(std430, binding = 2) readonly buffer InfluenceOffsets { uint influence_offsets[]; };
layout(std430, binding = 3) readonly buffer Influences { uint influences[]; };
layout(std430, binding = 4) readonly buffer InfluenceWeights { float influence_weights[]; };
layout(std430, binding = 5) readonly buffer ExampleWeights { uint example_weights[]; };
layout(std430, binding = 6) writeonly buffer LargeScalePositions { float large_scale_positions[]; };

// Number i of c; fp16 where params.fp16 is 1.
float example_weight(uint i) {
    if (params.fp16 != 0) {
        vec2 pair = unpackHalf2x16(example_weights[i / 2]);
        return i % 2 == 0 ? pair.x : pair.y;
    }
    return uintBitsToFloat(example_weights[i]);
}

// One of eight numbers. Written so that no array is indexed by what differs between invocations.
float one_of(vec4 low, vec4 high, uint j) {
    vec4 of_four = j < 4 ? low : high;
    vec2 of_two = j % 4 < 2 ? of_four.xy : of_four.zw;
    return j % 2 == 0 ? of_two.x : of_two.y;
}

void main() {
    // Those past the end compute the last vertex once more, so that all of a workgroup go the same way.
    uint i = min(gl_GlobalInvocationID.x, params.part_vertices - 1);
    uint frame = FRAMES * gl_GlobalInvocationID.y;
    uint eights = (params.examples + 7) / 8;
    vec3 offset[4];
    for (uint g = 0; g < FRAMES; g++) {
        offset[g] = vec3(0.0);
    }
    for (uint eight = 0; eight < eights; eight++) {
        // How much of each of eight examples there is in each frame: the first four, and the others.
        vec4 low[4];
        vec4 high[4];
        for (uint g = 0; g < FRAMES; g++) {
            low[g] = vec4(0.0);
            high[g] = vec4(0.0);
        }
        uint anchors = influence_offsets[i / 16 * 2 + 1];
        for (uint row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 2]; row++) {
            uint feature = influences[row];
            float weight = influence_weights[16 * row + i % 16];
            for (uint g = 0; g < FRAMES; g++) {
                if (row == anchors) {
                    low[g] *= 0.9;
                    high[g] *= 0.9;
                }
                uint of_frame = min(frame + g, params.frames - 1);
                uint at = 2 * ((of_frame * eights + eight) * params.features + feature);
                low[g] += weight * strain_products[at];
                high[g] += weight * strain_products[at + 1];
            }
        }
        for (uint j = 0; j < min(8, params.examples - 8 * eight); j++) {
            uint at = (i / 16 * params.examples + 8 * eight + j) * 48 + i % 16;
            vec3 c = vec3(example_weight(at), example_weight(at + 16), example_weight(at + 32));
            for (uint g = 0; g < FRAMES; g++) {
                offset[g] += c * one_of(low[g], high[g], j);
            }
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        if (frame + g < params.frames && gl_GlobalInvocationID.x < params.part_vertices) {
            uint result = 3 * ((frame + g) * params.vertices + params.first_vertex + i);
            large_scale_positions[result] = basis_positions[result] + offset[g].x;
            large_scale_positions[result + 1] = basis_positions[result + 1] + offset[g].y;
            large_scale_positions[result + 2] = basis_positions[result + 2] + offset[g].z;
        }
    }
}
