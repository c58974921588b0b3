//! An uploaded rig: in host memory, laid out for the processor.
use crate::bands::Bands;
use crate::beyond::Beyond;
use crate::blocks::block_length;
use crate::detail::Detail;
use crate::large_scale::Basis;
use crate::mesh::BlockMesh;
use crate::tile_weights::TileWeights;
use crate::vectors::Vectors;
use rhytid_core::{BasisStorage, Rig, Rotations, StrainEdgeId, VertexId};

/// The data that are computed from some frames' handle positions before any vertex.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Inputs<'a> {
    /// frames × H.
    pub displacements: &'a [[f32; 3]],
    /// frames × 4 × H where the handles turn, otherwise empty.
    pub motions: &'a [[f32; 3]],
    /// frames × F.
    pub features: &'a [f32],
}

/// The data that every frame reads.
#[derive(Debug)]
pub(crate) struct UploadedRig {
    pub vectors: Vectors,
    /// V rest positions.
    pub rest: Vec<[f32; 3]>,
    pub basis: Basis,
    /// `None` where the handles do not turn.
    pub rotations: Option<Rotations>,
    /// The vertex that they turn about. 0 where they do not turn.
    pub center: usize,
    /// α.
    pub influences: TileWeights,
    /// `None` where nothing was learned beyond the basis.
    pub bands: Option<Bands>,
    /// `None` where nothing in the basis is limited.
    pub beyond: Option<Beyond>,
    /// `None` where the bands have the wrinkles.
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
        let vertex_triangles = rig.surface().vertex_triangles();
        let tangent_neighbors = VertexId::numbers(&rig.surface().tangent_neighbors);
        let rotations = Rotations::new(rig.handles());
        let influences = TileWeights::new(
            vertices,
            StrainEdgeId::numbers(rig.influences().edges.as_slice()),
            rig.influences().weights.as_slice(),
        );
        let narrow = storage.has_narrow_weights(rig.vector_wrinkles());
        let center = rotations
            .as_ref()
            .map_or(0, |rotations| rig.handles().points[rotations.center()].nearest_vertex().index());
        Self {
            vectors: Vectors::Widest,
            rest: rig.surface().rest.clone(),
            basis: Basis::new(rig, storage),
            rotations,
            center,
            influences: if narrow { influences.narrow() } else { influences },
            bands: Bands::new(rig, storage),
            beyond: Beyond::new(rig),
            detail: Detail::new(rig),
            block,
            meshes: BlockMesh::all(
                block,
                vertices,
                &rig.surface().joined_triangles(),
                &vertex_triangles,
                tangent_neighbors,
                |v| rig.surface().first(v),
            ),
            tangent_neighbors: tangent_neighbors.to_vec(),
        }
    }
}
