// README.md beside this file says what is computed. One invocation: one vertex (x) of one frame (y).
struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    handles: u32,
    half_basis: u32,
}

@group(0) @binding(0) var<storage, read> rest: array<f32>;
@group(0) @binding(1) var<storage, read> basis: array<u32>;
@group(0) @binding(2) var<storage, read> handle_rest: array<f32>;
@group(0) @binding(3) var<storage, read> handle_positions: array<f32>;
@group(0) @binding(4) var<storage, read_write> large_scale_positions: array<f32>;
@group(0) @binding(5) var<uniform> params: Params;

// Row h of the tile of 64 vertices that vertex i of the part is in; two halves to a word where params.half_basis is 1.
fn basis_at(i: u32, h: u32) -> f32 {
    let at = (i / 64 * params.handles + h) * 64 + i % 64;
    if params.half_basis != 0 {
        let pair = unpack2x16float(basis[at / 2]);
        return select(pair.y, pair.x, at % 2 == 0);
    }
    return bitcast<f32>(basis[at]);
}

@compute @workgroup_size(64)
fn large_scale(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let frame = id.y;
    if i >= params.part_vertices {
        return;
    }
    let v = params.first_vertex + i;
    let first = frame * params.handles;
    var sum = vec3f();
    for (var h = 0u; h < params.handles; h++) {
        let p = 3 * (first + h);
        let u = vec3f(handle_positions[p] - handle_rest[3 * h],
                      handle_positions[p + 1] - handle_rest[3 * h + 1],
                      handle_positions[p + 2] - handle_rest[3 * h + 2]);
        sum += basis_at(i, h) * u;
    }
    let result = 3 * (frame * params.vertices + v);
    large_scale_positions[result] = rest[3 * v] + sum.x;
    large_scale_positions[result + 1] = rest[3 * v + 1] + sum.y;
    large_scale_positions[result + 2] = rest[3 * v + 2] + sum.z;
}
