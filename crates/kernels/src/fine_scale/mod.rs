#![doc = include_str!("README.md")]
use crate::params::parameter_block;
use crate::{Number, Real, vec3};

parameter_block!(
    /// Frames in the batch.
    frames,
    /// V.
    vertices,
    /// The first vertex of this part; 0 where the rig is in one piece.
    first_vertex,
    /// Vertices of this part.
    part_vertices,
    /// 1 where the detail is along the mesh's axes, 0 where it is along those of tangent frames.
    mesh_axes,
);

impl Params {
    /// For a rig in one piece.
    pub fn whole(frames: usize, vertices: usize, mesh_axes: bool) -> Self {
        let (frames, vertices, mesh_axes) = (frames as u32, vertices as u32, u32::from(mesh_axes));
        Self { frames, vertices, first_vertex: 0, part_vertices: vertices, mesh_axes }
    }
}

/// The columns t, b, n of a tangent frame (method, section 5), from the vector to the neighbour that orients
/// it.
#[inline(always)]
pub fn tangent_frame<T: Number>(to_neighbor: [T; 3], n: [T; 3]) -> [[T; 3]; 3] {
    let along = vec3::dot(to_neighbor, n);
    let t = vec3::normalize(vec3::sub(to_neighbor, vec3::scaled(n, along)));
    [t, vec3::cross(n, t), n]
}

/// x̃ + R d.
#[inline(always)]
pub fn add_detail<T: Number>(large_scale: [T; 3], [t, b, n]: [[T; 3]; 3], d: [T; 3]) -> [T; 3] {
    let [t, b, n] = [vec3::scaled(t, d[0]), vec3::scaled(b, d[1]), vec3::scaled(n, d[2])];
    vec3::add(large_scale, vec3::add(vec3::add(t, b), n))
}

/// The reference.
pub fn fine_scale<T: Real>(
    params: Params,
    large_scale_positions: &[[T; 3]],
    large_scale_normals: &[[T; 3]],
    local_detail: &[[T; 3]],
    tangent_neighbors: &[u32],
    positions: &mut [[T; 3]],
) {
    let vertices = params.vertices as usize;
    for frame in 0..params.frames as usize {
        let first = frame * vertices;
        for i in 0..params.part_vertices as usize {
            let v = params.first_vertex as usize + i;
            let (smooth, d) = (large_scale_positions[first + v], local_detail[first + v]);
            if params.mesh_axes != 0 {
                positions[first + v] = vec3::add(smooth, d);
                continue;
            }
            let neighbor = large_scale_positions[first + tangent_neighbors[v] as usize];
            let axes = tangent_frame(vec3::sub(neighbor, smooth), large_scale_normals[first + v]);
            positions[first + v] = add_detail(smooth, axes, d);
        }
    }
}
