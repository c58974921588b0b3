//! A rig as it is uploaded: in host memory, laid out for the processor.
use crate::bands::Bands;
use crate::blocks::block_length;
use crate::detail::Detail;
use crate::large_scale::Basis;
use crate::mesh::BlockMesh;
use crate::tile_weights::TileWeights;
use crate::vectors::Vectors;
use rhytid_core::{BasisStorage, Rig, Rotations};
use rhytid_kernels::normals::VertexTriangles;

/// What is made of some frames' handle positions before any vertex is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Inputs<'a> {
    /// frames × H.
    pub displacements: &'a [[f32; 3]],
    /// frames × 4 × H where the handles turn; else empty.
    pub motions: &'a [[f32; 3]],
    /// frames × F.
    pub features: &'a [f32],
}

/// What every frame reads.
#[derive(Debug)]
pub(crate) struct UploadedRig {
    pub vectors: Vectors,
    /// V rest positions.
    pub rest: Vec<[f32; 3]>,
    pub basis: Basis,
    /// Where the handles turn.
    pub rotations: Option<Rotations>,
    /// The vertex that they turn about; 0 where they do not.
    pub center: usize,
    /// α.
    pub influences: TileWeights,
    /// Where something was learned that is no row of the basis.
    pub bands: Option<Bands>,
    /// Where the folds are not those of the bands.
    pub detail: Option<Detail>,
    /// Vertices of a block.
    pub block: usize,
    pub meshes: Vec<BlockMesh>,
    pub tangent_neighbors: Vec<u32>,
}

impl UploadedRig {
    pub(crate) fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let vertices = rig.vertices();
        let block = block_length(vertices);
        let vertex_triangles = VertexTriangles::new(vertices, &rig.triangles);
        let rotations = Rotations::new(rig);
        let center = rotations.as_ref().map_or(0, |rotations| rig.handles[rotations.center()] as usize);
        Self {
            vectors: Vectors::Widest,
            rest: rig.rest.clone(),
            basis: Basis::new(rig, storage),
            rotations,
            center,
            influences: TileWeights::new(vertices, &rig.influence_edges, &rig.influence_weights),
            bands: Bands::new(rig, storage),
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
        }
    }
}
