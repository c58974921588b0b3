// Gives each copy of a vertex the numbers of its vertex, three for each. One invocation: one copy after the other.
struct Params {
    vertices: u32,
    copies: u32,
    invocations: u32,
}

@group(0) @binding(0) var<storage, read> copies: array<u32>;
@group(0) @binding(1) var<storage, read_write> numbers: array<f32>;
@group(0) @binding(2) var<uniform> params: Params;

@compute @workgroup_size(64)
fn copies_of_vertices(@builtin(global_invocation_id) id: vec3u) {
    for (var i = id.x; i < params.copies; i += params.invocations) {
        let vertex = 3 * copies[i];
        let result = 3 * (params.vertices + i);
        numbers[result] = numbers[vertex];
        numbers[result + 1] = numbers[vertex + 1];
        numbers[result + 2] = numbers[vertex + 2];
    }
}
