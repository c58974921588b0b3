use crate::Numbers;
use rhytid_core::{Faces, Rig, UpAxis};

/// A rig and a batch of frames to evaluate it for.
#[derive(Debug, Clone)]
pub struct Case {
    /// Says what is special: `v65-h89-f240-p6-k16-frames2`.
    pub name: String,
    /// The rig.
    pub rig: Rig,
    /// frames × H × 3.
    pub handle_positions: Vec<f32>,
}

/// Sizes of a made-up rig.
struct Sizes {
    vertices: usize,
    handles: usize,
    edges: usize,
    examples: usize,
    influences: usize,
    frames: usize,
}

/// Rigs whose sizes straddle every tile and batch, with random numbers from fixed seeds.
pub fn cases() -> Vec<Case> {
    const SIZES: [[usize; 6]; 16] = [
        [1, 1, 0, 0, 0, 1],
        [2, 2, 1, 0, 1, 1],
        [3, 1, 0, 1, 0, 2],
        [4, 3, 3, 1, 2, 31],
        [31, 7, 11, 2, 4, 2],
        [63, 8, 20, 6, 16, 1],
        [64, 8, 20, 6, 16, 2],
        [65, 8, 20, 6, 16, 3],
        [127, 31, 80, 6, 16, 1],
        [128, 32, 80, 6, 16, 16],
        [129, 33, 80, 6, 16, 17],
        [1023, 64, 150, 6, 16, 1],
        [1024, 65, 160, 40, 16, 1],
        [1025, 89, 243, 6, 16, 31],
        [2049, 300, 1000, 6, 16, 2],
        [4000, 89, 243, 8, 1, 4],
    ];
    SIZES
        .iter()
        .enumerate()
        .map(|(seed, &[vertices, handles, edges, examples, influences, frames])| {
            random(seed as u64, &Sizes { vertices, handles, edges, examples, influences, frames })
        })
        .collect()
}

/// Three numbers in −size..size.
fn vector(numbers: &mut Numbers, size: f32) -> [f32; 3] {
    std::array::from_fn(|_| size * numbers.signed() as f32)
}

/// A jittered sheet; the vertices that are left over from whole rows are isolated.
fn random(seed: u64, sizes: &Sizes) -> Case {
    let mut numbers = Numbers::new(seed);
    let &Sizes { vertices, handles, edges, examples, influences, frames } = sizes;
    let width = (vertices as f64).sqrt().ceil() as usize;
    let rest: Vec<[f32; 3]> = (0..vertices)
        .map(|v| {
            let [x, y, z] = vector(&mut numbers, 0.3);
            [(v % width) as f32 + x, (v / width) as f32 + y, z]
        })
        .collect();
    let mut triangles = Vec::new();
    for v in 0..vertices {
        if v % width + 1 < width && v + width + 1 < vertices {
            let [a, b, c, d] = [v, v + 1, v + width + 1, v + width].map(|i| i as u32);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    if triangles.is_empty() {
        triangles.push([0, 0, (vertices - 1) as u32]);
    }
    // Distinct vertices, spread by a step that shares no factor with V; more handles than that cannot be.
    let step = (1..).map(|i| vertices * 5 / 8 + i).find(|s| gcd(*s, vertices) == 1).unwrap_or(1);
    let handle_vertices: Vec<u32> =
        (0..handles.min(vertices)).map(|h| (h * step % vertices) as u32).collect();
    let handles = handle_vertices.len();
    let strain_edges: Vec<[u32; 2]> = (0..if handles > 1 { edges } else { 0 })
        .map(|_| {
            let a = numbers.below(handles) as u32;
            [a, (a + 1 + numbers.below(handles - 1) as u32) % handles as u32]
        })
        .collect();
    let edges = strain_edges.len();
    let influences = influences.min(edges);
    let centers = examples + 1;
    let pose_features: Vec<f32> =
        (0..centers * edges).map(|i| if i < edges { 0.0 } else { 0.3 * numbers.signed() as f32 }).collect();
    let rig = Rig {
        name: "random".into(),
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        labels: (0..handles).map(|h| format!("m{h}")).collect(),
        example_names: (0..examples).map(|j| format!("pose {j}")).collect(),
        faces: Faces { counts: vec![3; triangles.len()], indices: triangles.as_flattened().to_vec() },
        uvs: None,
        bending_length: 1.0,
        beta: 1.0,
        triangles,
        basis: (0..vertices * handles).map(|_| numbers.signed() as f32).collect(),
        influence_edges: (0..vertices * influences).map(|_| numbers.below(edges) as u32).collect(),
        influence_weights: (0..vertices * influences).map(|_| numbers.unit() as f32).collect(),
        frame_neighbors: (0..vertices).map(|v| ((v + 1) % vertices) as u32).collect(),
        pose_features,
        rbf_weights: (0..vertices * centers).map(|_| vector(&mut numbers, 2.0)).collect(),
        strain_edges,
        rest,
        handles: handle_vertices,
    };
    let handle_positions = (0..frames)
        .flat_map(|_| rig.handles.iter().map(|&v| rig.rest[v as usize]).collect::<Vec<_>>())
        .flat_map(|p| {
            let u = vector(&mut numbers, 0.5);
            [p[0] + u[0], p[1] + u[1], p[2] + u[2]]
        })
        .collect();
    let name = format!("v{vertices}-h{handles}-f{edges}-p{examples}-k{influences}-frames{frames}");
    Case { name, rig, handle_positions }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
