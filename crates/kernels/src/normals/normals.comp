#version 450
// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
} params;
layout(std430, binding = 0) readonly buffer Positions { float positions[]; };
layout(std430, binding = 1) readonly buffer FanOffsets { uint fan_offsets[]; };
layout(std430, binding = 2) readonly buffer Fans { uint fans[]; };
layout(std430, binding = 3) writeonly buffer VertexNormals { float vertex_normals[]; };

vec3 position(uint v) {
    return vec3(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
}

// a / |a|, or zero where a is zero; divides by the largest component first, so that no square vanishes or overflows.
vec3 unit(vec3 a) {
    float largest = max(max(abs(a.x), abs(a.y)), abs(a.z));
    if (largest == 0.0) {
        return vec3(0.0);
    }
    vec3 scaled = a / largest;
    return scaled / sqrt(scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint first = frame * params.vertices;
    vec3 here = position(first + v);
    vec3 e = vec3(0.0);
    vec3 sum = vec3(0.0);
    for (uint row = fan_offsets[i / 16]; row < fan_offsets[i / 16 + 1]; row++) {
        vec3 f = position(first + fans[16 * row + i % 16]) - here;
        sum += cross(e, f);
        e = f;
    }
    vec3 n = unit(sum);
    uint result = 3 * (first + v);
    vertex_normals[result] = n.x;
    vertex_normals[result + 1] = n.y;
    vertex_normals[result + 2] = n.z;
}
