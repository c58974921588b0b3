//! A rig as it is uploaded: in host memory, laid out for the processor.
use crate::blocks::block_length;
use crate::detail::Detail;
use crate::large_scale::Basis;
use crate::linear_band::LinearBand;
use crate::mesh::BlockMesh;
use crate::vectors::Vectors;
use rhytid_core::{BasisStorage, FoldAxes, Rig};
use rhytid_kernels::normals::VertexTriangles;

/// What every frame reads.
#[derive(Debug)]
pub(crate) struct UploadedRig {
    pub vectors: Vectors,
    /// V rest positions.
    pub rest: Vec<[f32; 3]>,
    pub basis: Basis,
    pub linear_band: Option<LinearBand>,
    pub detail: Detail,
    /// Vertices of a block.
    pub block: usize,
    pub meshes: Vec<BlockMesh>,
    pub tangent_neighbors: Vec<u32>,
    /// Whether the detail is along the mesh's axes.
    pub mesh_axes: bool,
}

impl UploadedRig {
    pub(crate) fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let vertices = rig.vertices();
        let block = block_length(vertices);
        let vertex_triangles = VertexTriangles::new(vertices, &rig.triangles);
        Self {
            vectors: Vectors::Widest,
            rest: rig.rest.clone(),
            basis: Basis::new(rig, storage),
            linear_band: LinearBand::new(rig, storage),
            detail: Detail::new(rig),
            block,
            meshes: BlockMesh::all(
                block,
                vertices,
                &rig.triangles,
                &vertex_triangles,
                &rig.tangent_neighbors,
            ),
            tangent_neighbors: rig.tangent_neighbors.clone(),
            mesh_axes: rig.fold_axes() == FoldAxes::Mesh,
        }
    }
}
