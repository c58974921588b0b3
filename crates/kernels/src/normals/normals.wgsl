// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
}

@group(0) @binding(0) var<storage, read> positions: array<f32>;
@group(0) @binding(1) var<storage, read> fan_offsets: array<u32>;
@group(0) @binding(2) var<storage, read> fans: array<u32>;
@group(0) @binding(3) var<storage, read_write> vertex_normals: array<f32>;
@group(0) @binding(4) var<uniform> params: Params;

fn position(i: u32) -> vec3f {
    return vec3f(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
}

// a / |a|, or zero where a is zero; divides by the largest component first, so that no square vanishes or overflows.
fn unit(a: vec3f) -> vec3f {
    let largest = max(max(abs(a.x), abs(a.y)), abs(a.z));
    if largest == 0.0 {
        return vec3f();
    }
    let scaled = a / largest;
    return scaled / sqrt(scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z);
}

@compute @workgroup_size(64)
fn normals(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let frame = id.y;
    if i >= params.part_vertices {
        return;
    }
    let v = params.first_vertex + i;
    let first = frame * params.vertices;
    let here = position(first + v);
    var e = vec3f();
    var sum = vec3f();
    for (var row = fan_offsets[i / 16]; row < fan_offsets[i / 16 + 1]; row++) {
        let f = position(first + fans[16 * row + i % 16]) - here;
        sum += cross(e, f);
        e = f;
    }
    let n = unit(sum);
    let result = 3 * (first + v);
    vertex_normals[result] = n.x;
    vertex_normals[result + 1] = n.y;
    vertex_normals[result + 2] = n.z;
}
