#version 450
// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Params {
    uint frames;
    uint vertices;
    uint first_vertex;
    uint part_vertices;
    uint mesh_axes;
} params;
layout(std430, binding = 0) readonly buffer LargeScalePositions { float large_scale_positions[]; };
layout(std430, binding = 1) readonly buffer LargeScaleNormals { float large_scale_normals[]; };
layout(std430, binding = 2) readonly buffer LocalDetail { float local_detail[]; };
layout(std430, binding = 3) readonly buffer TangentNeighbors { uint tangent_neighbors[]; };
layout(std430, binding = 4) writeonly buffer Positions { float positions[]; };

vec3 smooth_position(uint i) {
    return vec3(large_scale_positions[3 * i], large_scale_positions[3 * i + 1], large_scale_positions[3 * i + 2]);
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

void store(uint at, vec3 moved) {
    positions[at] = moved.x;
    positions[at + 1] = moved.y;
    positions[at + 2] = moved.z;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    uint frame = gl_GlobalInvocationID.y;
    if (i >= params.part_vertices) {
        return;
    }
    uint v = params.first_vertex + i;
    uint first = frame * params.vertices;
    uint at = 3 * (first + v);
    vec3 x = smooth_position(first + v);
    vec3 d = vec3(local_detail[at], local_detail[at + 1], local_detail[at + 2]);
    if (params.mesh_axes != 0) {
        store(at, x + d);
        return;
    }
    vec3 n = vec3(large_scale_normals[at], large_scale_normals[at + 1], large_scale_normals[at + 2]);
    vec3 e = smooth_position(first + tangent_neighbors[v]) - x;
    vec3 t = unit(e - (e.x * n.x + e.y * n.y + e.z * n.z) * n);
    vec3 b = vec3(n.y * t.z - n.z * t.y, n.z * t.x - n.x * t.z, n.x * t.y - n.y * t.x);
    store(at, x + (t * d.x + b * d.y + n * d.z));
}
