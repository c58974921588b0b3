// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
}

@group(0) @binding(0) var<storage, read> positions: array<f32>;
@group(0) @binding(1) var<storage, read> corner_offsets: array<u32>;
@group(0) @binding(2) var<storage, read> corners: array<u32>;
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
    var sum = vec3f();
    let here = position(first + v);
    for (var k = corner_offsets[i]; k < corner_offsets[i + 1]; k++) {
        let corner = corners[2 * k] >> 30;
        let next = position(first + (corners[2 * k] & 0x3fffffff));
        let last = position(first + corners[2 * k + 1]);
        let a = select(select(next, last, corner == 1), here, corner == 0);
        let e = select(select(last, here, corner == 1), next, corner == 0) - a;
        let f = select(select(here, next, corner == 1), last, corner == 0) - a;
        sum += vec3f(e.y * f.z - e.z * f.y, e.z * f.x - e.x * f.z, e.x * f.y - e.y * f.x);
    }
    let n = unit(sum);
    let result = 3 * (first + v);
    vertex_normals[result] = n.x;
    vertex_normals[result + 1] = n.y;
    vertex_normals[result + 2] = n.z;
}
