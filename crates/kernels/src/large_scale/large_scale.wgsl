// README.md beside this file says what is computed. One invocation: four vertices (x) of FRAMES frames (y), or of one frame (y) whose four
// vectors of each handle are summed as those of FRAMES = 4 frames are.
override FRAMES: u32 = 1;

struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    motions: u32,
    basis_format: u32,
    banded: u32,
    rotating: u32,
    center: u32,
}

@group(0) @binding(0) var<storage, read> rest: array<f32>;
@group(0) @binding(1) var<storage, read> basis: array<vec2u>;
@group(0) @binding(2) var<storage, read> basis_rows: array<u32>;
@group(0) @binding(3) var<storage, read> displacements: array<vec4f>;
@group(0) @binding(4) var<storage, read> band_offsets: array<f32>;
@group(0) @binding(5) var<storage, read_write> large_scale_positions: array<f32>;
@group(0) @binding(6) var<uniform> params: Params;

// Two integers of 16 bits with a sign.
fn integers(pair: u32) -> vec2f {
    let bits = bitcast<i32>(pair);
    return vec2f(vec2i(extractBits(bits, 0u, 16u), extractBits(bits, 16u, 16u)));
}

// A row of the basis, for the four vertices from i on.
fn basis_at(i: u32, row: u32) -> vec4f {
    let at = row * 16 + i % 16;
    if params.basis_format == 1 {
        let pairs = basis[at / 4];
        return vec4f(unpack2x16float(pairs.x), unpack2x16float(pairs.y));
    }
    if params.basis_format == 2 {
        let pairs = basis[at / 4];
        return vec4f(integers(pairs.x), integers(pairs.y));
    }
    return vec4f(bitcast<vec2f>(basis[at / 2]), bitcast<vec2f>(basis[at / 2 + 1]));
}

@compute @workgroup_size(64)
fn large_scale(@builtin(global_invocation_id) id: vec3u) {
    // Those past the end compute the last four once more, so that all of a workgroup go the same way.
    let i = min(4 * id.x, (params.part_vertices - 1) / 4 * 4);
    let rotating = params.rotating != 0;
    let first = FRAMES * id.y;
    let last = params.frames * select(1u, 4u, rotating) - 1;
    var x: array<vec4f, 4>;
    var y: array<vec4f, 4>;
    var z: array<vec4f, 4>;
    let tile = 2 * (i / 16);
    let rows = basis_rows[tile + 2] - basis_rows[tile];
    for (var k = 0u; k < rows; k++) {
        let b = basis_at(i, basis_rows[tile] + k);
        for (var g = 0u; g < FRAMES; g++) {
            let u = displacements[min(first + g, last) * params.motions + basis_rows[tile + 1] + k];
            x[g] += b * u.x;
            y[g] += b * u.y;
            z[g] += b * u.z;
        }
    }
    for (var g = 0u; g < select(FRAMES, 1u, rotating); g++) {
        let frame = select(first + g, id.y, rotating);
        for (var lane = 0u; lane < 4; lane++) {
            if frame < params.frames && 4 * id.x + lane < params.part_vertices {
                let v = params.first_vertex + i + lane;
                let result = 3 * (frame * params.vertices + v);
                var position = vec3f(rest[3 * v], rest[3 * v + 1], rest[3 * v + 2]);
                var moved = vec3f(x[g][lane], y[g][lane], z[g][lane]);
                if rotating {
                    let c = 3 * params.center;
                    let from_center = position - vec3f(rest[c], rest[c + 1], rest[c + 2]);
                    for (var k = 0u; k < 3; k++) {
                        moved += from_center[k] * vec3f(x[1 + k][lane], y[1 + k][lane], z[1 + k][lane]);
                    }
                }
                position += moved;
                if params.banded != 0 {
                    position += vec3f(band_offsets[result], band_offsets[result + 1], band_offsets[result + 2]);
                }
                large_scale_positions[result] = position.x;
                large_scale_positions[result + 1] = position.y;
                large_scale_positions[result + 2] = position.z;
            }
        }
    }
}
