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
    uint centers;
    uint narrow;
    uint wrinkles;
} params;
layout(std430, binding = 0) readonly buffer SquaredVectorDifferences { vec4 squared_vector_differences[]; };
layout(std430, binding = 1) readonly buffer InfluenceOffsets { uint influence_offsets[]; };
layout(std430, binding = 2) readonly buffer Influences { uint influences[]; };
layout(std430, binding = 3) readonly buffer InfluenceWeights { uint influence_weights[]; };
layout(std430, binding = 4) readonly buffer BandWeights { uint band_weights[]; };
layout(std430, binding = 5) writeonly buffer BandOffsets { float band_offsets[]; };
layout(std430, binding = 6) writeonly buffer LocalDetail { float local_detail[]; };

// The weight of an influence for vertex i of a tile; floating-point numbers of 16 bits where params.narrow is 1.
float influence_weight(uint row, uint i) {
    if (params.narrow != 0) {
        uint bits = influence_weights[8 * row + i / 2] >> (i % 2 * 16) & 0xffff;
        return bits == 0 ? 0.0 : uintBitsToFloat((bits << 12) + 0x30000000);
    }
    return uintBitsToFloat(influence_weights[16 * row + i]);
}

// Vector j of vertex i of a tile: first those of the rest pose, then those of each example. `record` says where the tile's
// vectors begin. Those of the examples are integers with a unit where its lowest bit is 1.
vec3 band_weight(uint record, uint i, uint j) {
    uint first = record / 2 * 2;
    uint kinds = params.wrinkles != 0 ? 2 : 1;
    if (record % 2 == 0 || j < kinds) {
        uint at = first + 48 * j + i;
        return uintBitsToFloat(uvec3(band_weights[at], band_weights[at + 16], band_weights[at + 32]));
    }
    uint units = first + 48 * kinds;
    uint at = units + (kinds * (params.centers - 1) + 15) / 16 * 16 + 24 * (j - kinds) + i / 2;
    ivec3 pairs = ivec3(band_weights[at], band_weights[at + 8], band_weights[at + 16]);
    return uintBitsToFloat(band_weights[units + j - kinds]) * vec3(bitfieldExtract(pairs, int(i % 2 * 16), 16));
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
    uint eights = (params.centers + 7) / 8;
    uint kinds = params.wrinkles != 0 ? 2 : 1;
    uint record = band_weights[i / 16];
    vec3 constant = band_weight(record, i % 16, 0);
    vec3 at_rest = params.wrinkles != 0 ? band_weight(record, i % 16, 1) : vec3(0.0);
    vec3 offset[4];
    vec3 detail[4];
    // The distance from the rest pose, squared and not.
    float squared_rest[4];
    float rest[4];
    for (uint g = 0; g < FRAMES; g++) {
        offset[g] = constant;
        detail[g] = at_rest;
    }
    for (uint eight = 0; eight < eights; eight++) {
        // The squared distances from eight centres: the first four, and the others.
        vec4 low[4];
        vec4 high[4];
        for (uint g = 0; g < FRAMES; g++) {
            low[g] = vec4(0.0);
            high[g] = vec4(0.0);
        }
        uint anchors = influence_offsets[i / 16 * 2 + 1];
        for (uint row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 2]; row++) {
            uint feature = influences[row];
            float weight = influence_weight(row, i % 16);
            for (uint g = 0; g < FRAMES; g++) {
                if (row == anchors) {
                    low[g] *= 0.9;
                    high[g] *= 0.9;
                }
                uint of_frame = min(frame + g, params.frames - 1);
                uint at = 2 * ((of_frame * eights + eight) * params.features + feature);
                low[g] += weight * squared_vector_differences[at];
                high[g] += weight * squared_vector_differences[at + 1];
            }
        }
        if (eight == 0) {
            for (uint g = 0; g < FRAMES; g++) {
                squared_rest[g] = low[g].x;
                rest[g] = sqrt(low[g].x);
            }
        }
        for (uint j = eight == 0 ? 1 : 0; j < min(8, params.centers - 8 * eight); j++) {
            uint center = 8 * eight + j;
            vec3 c = band_weight(record, i % 16, kinds * center);
            for (uint g = 0; g < FRAMES; g++) {
                offset[g] += c * (squared_rest[g] - one_of(low[g], high[g], j));
            }
            if (params.wrinkles != 0) {
                vec3 w = band_weight(record, i % 16, kinds * center + 1);
                for (uint g = 0; g < FRAMES; g++) {
                    detail[g] += w * (sqrt(one_of(low[g], high[g], j)) - rest[g]);
                }
            }
        }
    }
    for (uint g = 0; g < FRAMES; g++) {
        if (frame + g < params.frames && gl_GlobalInvocationID.x < params.part_vertices) {
            uint result = 3 * ((frame + g) * params.vertices + params.first_vertex + i);
            band_offsets[result] = offset[g].x;
            band_offsets[result + 1] = offset[g].y;
            band_offsets[result + 2] = offset[g].z;
            if (params.wrinkles != 0) {
                local_detail[result] = detail[g].x;
                local_detail[result + 1] = detail[g].y;
                local_detail[result + 2] = detail[g].z;
            }
        }
    }
}
