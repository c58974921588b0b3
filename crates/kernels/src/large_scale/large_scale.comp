#version 450
// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint handles;
    uint half_basis;
} params;
layout(std430, binding = 0) readonly buffer Rest { float rest[]; };
layout(std430, binding = 1) readonly buffer Basis { uint basis[]; };
layout(std430, binding = 2) readonly buffer HandleRest { float handle_rest[]; };
layout(std430, binding = 3) readonly buffer HandlePositions { float handle_positions[]; };
layout(std430, binding = 4) writeonly buffer LargeScalePositions { float large_scale_positions[]; };

// Row h of the tile of 64 vertices that vertex i of the part is in; two halves to a word where params.half_basis is 1.
float basis_at(uint i, uint h) {
    uint at = (i / 64 * params.handles + h) * 64 + i % 64;
    if (params.half_basis != 0) {
        vec2 pair = unpackHalf2x16(basis[at / 2]);
        return at % 2 == 0 ? pair.x : pair.y;
    }
    return uintBitsToFloat(basis[at]);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint first = frame * params.handles;
    vec3 sum = vec3(0.0);
    for (uint h = 0; h < params.handles; h++) {
        uint p = 3 * (first + h);
        vec3 u = vec3(handle_positions[p] - handle_rest[3 * h],
                      handle_positions[p + 1] - handle_rest[3 * h + 1],
                      handle_positions[p + 2] - handle_rest[3 * h + 2]);
        sum += basis_at(i, h) * u;
    }
    uint result = 3 * (frame * params.vertices + v);
    large_scale_positions[result] = rest[3 * v] + sum.x;
    large_scale_positions[result + 1] = rest[3 * v + 1] + sum.y;
    large_scale_positions[result + 2] = rest[3 * v + 2] + sum.z;
}
