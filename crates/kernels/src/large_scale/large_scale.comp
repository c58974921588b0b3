#version 450
// README.md beside this file says what is computed. One invocation: four vertices (x) of FRAMES frames (y), or of one frame (y) whose four
// vectors of each handle are summed as those of FRAMES = 4 frames are.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint FRAMES = 1;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint motions;
    uint basis_format;
    uint banded;
    uint rotating;
    uint center;
} params;
layout(std430, binding = 0) readonly buffer Rest { float rest[]; };
layout(std430, binding = 1) readonly buffer Basis { uvec2 basis[]; };
layout(std430, binding = 2) readonly buffer BasisRows { uint basis_rows[]; };
layout(std430, binding = 3) readonly buffer Displacements { vec4 displacements[]; };
layout(std430, binding = 4) readonly buffer BandOffsets { float band_offsets[]; };
layout(std430, binding = 5) writeonly buffer LargeScalePositions { float large_scale_positions[]; };

// Two integers of 16 bits with a sign.
vec2 integers(uint pair) {
    return vec2(bitfieldExtract(int(pair), 0, 16), bitfieldExtract(int(pair), 16, 16));
}

// A row of the basis, for the four vertices from i on.
vec4 basis_at(uint i, uint row) {
    uint at = row * 16 + i % 16;
    if (params.basis_format == 1) {
        uvec2 pairs = basis[at / 4];
        return vec4(unpackHalf2x16(pairs.x), unpackHalf2x16(pairs.y));
    }
    if (params.basis_format == 2) {
        uvec2 pairs = basis[at / 4];
        return vec4(integers(pairs.x), integers(pairs.y));
    }
    return vec4(uintBitsToFloat(basis[at / 2]), uintBitsToFloat(basis[at / 2 + 1]));
}

void main() {
    // Those past the end compute the last four once more, so that all of a workgroup go the same way.
    uint i = min(4 * gl_GlobalInvocationID.x, (params.part_vertices - 1) / 4 * 4);
    bool rotating = params.rotating != 0;
    uint first = FRAMES * gl_GlobalInvocationID.y;
    uint last = params.frames * (rotating ? 4 : 1) - 1;
    vec4 x[4];
    vec4 y[4];
    vec4 z[4];
    for (uint g = 0; g < FRAMES; g++) {
        x[g] = vec4(0.0);
        y[g] = vec4(0.0);
        z[g] = vec4(0.0);
    }
    uint tile = 2 * (i / 16);
    uint rows = basis_rows[tile + 2] - basis_rows[tile];
    for (uint k = 0; k < rows; k++) {
        vec4 b = basis_at(i, basis_rows[tile] + k);
        for (uint g = 0; g < FRAMES; g++) {
            vec4 u = displacements[min(first + g, last) * params.motions + basis_rows[tile + 1] + k];
            x[g] += b * u.x;
            y[g] += b * u.y;
            z[g] += b * u.z;
        }
    }
    for (uint g = 0; g < (rotating ? 1 : FRAMES); g++) {
        uint frame = rotating ? gl_GlobalInvocationID.y : first + g;
        for (uint lane = 0; lane < 4; lane++) {
            if (frame < params.frames && 4 * gl_GlobalInvocationID.x + lane < params.part_vertices) {
                uint v = params.first_vertex + i + lane;
                uint result = 3 * (frame * params.vertices + v);
                vec3 position = vec3(rest[3 * v], rest[3 * v + 1], rest[3 * v + 2]);
                vec3 moved = vec3(x[g][lane], y[g][lane], z[g][lane]);
                if (rotating) {
                    uint c = 3 * params.center;
                    vec3 from_center = position - vec3(rest[c], rest[c + 1], rest[c + 2]);
                    for (uint k = 0; k < 3; k++) {
                        moved += from_center[k] * vec3(x[1 + k][lane], y[1 + k][lane], z[1 + k][lane]);
                    }
                }
                position += moved;
                if (params.banded != 0) {
                    position += vec3(band_offsets[result], band_offsets[result + 1], band_offsets[result + 2]);
                }
                large_scale_positions[result] = position.x;
                large_scale_positions[result + 1] = position.y;
                large_scale_positions[result + 2] = position.z;
            }
        }
    }
}
