// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    mesh_axes: u32,
}

@group(0) @binding(0) var<storage, read> large_scale_positions: array<f32>;
@group(0) @binding(1) var<storage, read> large_scale_normals: array<f32>;
@group(0) @binding(2) var<storage, read> local_detail: array<f32>;
@group(0) @binding(3) var<storage, read> tangent_neighbors: array<u32>;
@group(0) @binding(4) var<storage, read_write> positions: array<f32>;
@group(0) @binding(5) var<uniform> params: Params;

fn smooth_position(i: u32) -> vec3f {
    return vec3f(large_scale_positions[3 * i], large_scale_positions[3 * i + 1], large_scale_positions[3 * i + 2]);
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

fn store(at: u32, moved: vec3f) {
    positions[at] = moved.x;
    positions[at + 1] = moved.y;
    positions[at + 2] = moved.z;
}

@compute @workgroup_size(64)
fn fine_scale(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let frame = id.y;
    if i >= params.part_vertices {
        return;
    }
    let v = params.first_vertex + i;
    let first = frame * params.vertices;
    let at = 3 * (first + v);
    let x = smooth_position(first + v);
    let d = vec3f(local_detail[at], local_detail[at + 1], local_detail[at + 2]);
    if params.mesh_axes != 0 {
        store(at, x + d);
        return;
    }
    let n = vec3f(large_scale_normals[at], large_scale_normals[at + 1], large_scale_normals[at + 2]);
    let e = smooth_position(first + tangent_neighbors[v]) - x;
    let t = unit(e - (e.x * n.x + e.y * n.y + e.z * n.z) * n);
    let b = vec3f(n.y * t.z - n.z * t.y, n.z * t.x - n.x * t.z, n.x * t.y - n.y * t.x);
    store(at, x + (t * d.x + b * d.y + n * d.z));
}
