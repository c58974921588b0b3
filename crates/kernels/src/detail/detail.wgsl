// README.md beside this file says what is computed. One invocation: one vertex (x) of FRAMES frames (y).
override FRAMES: u32 = 1;

struct Params {
    frames: u32,
    vertices: u32,
    first_vertex: u32,
    part_vertices: u32,
    strain_edges: u32,
    centers: u32,
    zero_at_rest: u32,
}

@group(0) @binding(0) var<storage, read> squared_differences: array<vec4f>;
@group(0) @binding(1) var<storage, read> influence_offsets: array<u32>;
@group(0) @binding(2) var<storage, read> influences: array<u32>;
@group(0) @binding(3) var<storage, read> influence_weights: array<f32>;
@group(0) @binding(4) var<storage, read> rbf_weights: array<f32>;
@group(0) @binding(5) var<storage, read> pivots: array<u32>;
@group(0) @binding(6) var<storage, read_write> local_detail: array<f32>;
@group(0) @binding(7) var<uniform> params: Params;

// The distances of each frame's features from those of eight centres: the first four, and the others.
var<private> low: array<vec4f, 4>;
var<private> high: array<vec4f, 4>;

// Computes the distances from the centres 8 eight to 8 eight + 7, as vertex i of the part sees them.
fn measure(i: u32, frame: u32, eight: u32) {
    let eights = (params.centers + 7) / 8;
    low = array<vec4f, 4>();
    high = array<vec4f, 4>();
    for (var row = influence_offsets[i / 16 * 2]; row < influence_offsets[i / 16 * 2 + 1]; row++) {
        let edge = influences[row];
        let alpha = influence_weights[16 * row + i % 16];
        for (var g = 0u; g < FRAMES; g++) {
            let of_frame = min(frame + g, params.frames - 1);
            let at = 2 * ((of_frame * eights + eight) * params.strain_edges + edge);
            low[g] += alpha * squared_differences[at];
            high[g] += alpha * squared_differences[at + 1];
        }
    }
    for (var g = 0u; g < FRAMES; g++) {
        low[g] = sqrt(low[g]);
        high[g] = sqrt(high[g]);
    }
}

// One of the distances, 0 to 7. Written so that no array is indexed by what differs between invocations.
fn distance_to(g: u32, j: u32) -> f32 {
    let of_four = select(high[g], low[g], j < 4);
    let of_two = select(of_four.zw, of_four.xy, j % 4 < 2);
    return select(of_two.y, of_two.x, j % 2 == 0);
}

fn weight(i: u32, j: u32) -> vec3f {
    let at = (i / 16 * params.centers + j) * 48 + i % 16;
    return vec3f(rbf_weights[at], rbf_weights[at + 16], rbf_weights[at + 32]);
}

@compute @workgroup_size(64)
fn detail(@builtin(global_invocation_id) id: vec3u) {
    // Those past the end compute the last vertex once more, so that all of a workgroup go the same way.
    let i = min(id.x, params.part_vertices - 1);
    let frame = FRAMES * id.y;
    let pivot = pivots[i];
    measure(i, frame, pivot / 8);
    var r_pivot: array<f32, 4>;
    var sum: array<vec3f, 4>;
    for (var g = 0u; g < FRAMES; g++) {
        r_pivot[g] = distance_to(g, pivot % 8);
    }
    for (var first = 0u; first < params.centers; first += 8) {
        // Most rigs have no more than eight centres: then these are the distances that there are already.
        if params.centers > 8 {
            measure(i, frame, first / 8);
        }
        for (var j = 0u; j < min(8, params.centers - first); j++) {
            let w = weight(i, first + j);
            for (var g = 0u; g < FRAMES; g++) {
                let at_pivot = select(r_pivot[g], 1.0, params.zero_at_rest != 0);
                sum[g] += w * select(distance_to(g, j) - r_pivot[g], at_pivot, first + j == pivot);
            }
        }
    }
    for (var g = 0u; g < FRAMES; g++) {
        if frame + g < params.frames && id.x < params.part_vertices {
            let result = 3 * ((frame + g) * params.vertices + params.first_vertex + i);
            local_detail[result] = sum[g].x;
            local_detail[result + 1] = sum[g].y;
            local_detail[result + 2] = sum[g].z;
        }
    }
}
