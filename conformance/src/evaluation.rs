//! The references of all kernels, run one after the other.
use rhytid_core::{HandleId, Rig, Stage, StrainEdgeId, Table, VertexId};
use rhytid_kernels::{
    Real, bands, beyond, detail, differences, fine_scale, large_scale, normals, strain, vec3,
    vector_differences,
};

/// Every stage of a batch, as the reference computes them.
#[derive(Debug, Clone, PartialEq)]
pub struct Results<T> {
    /// frames × F.
    pub strain: Vec<T>,
    /// frames × V.
    pub large_scale: Vec<[T; 3]>,
    /// frames × V.
    pub large_scale_normals: Vec<[T; 3]>,
    /// frames × V.
    pub detail: Vec<[T; 3]>,
    /// frames × V.
    pub positions: Vec<[T; 3]>,
    /// frames × V.
    pub normals: Vec<[T; 3]>,
}

impl<T: Real> Results<T> {
    /// One stage as flat numbers, as [`rhytid_core::Session::read`] gives it.
    pub fn stage(&self, stage: Stage) -> &[T] {
        match stage {
            Stage::Strain => &self.strain,
            Stage::LargeScale => self.large_scale.as_flattened(),
            Stage::LargeScaleNormals => self.large_scale_normals.as_flattened(),
            Stage::Detail => self.detail.as_flattened(),
            Stage::Positions => self.positions.as_flattened(),
            Stage::Normals => self.normals.as_flattened(),
        }
    }
}

/// Runs the references of all kernels, one after the other, on one thread. `handle_positions` is frames × H.
pub fn evaluate<T: Real>(rig: &Rig<T>, handle_positions: &[[T; 3]]) -> Results<T> {
    let (vertices, handles) = (rig.vertices(), rig.handles().len());
    let frames = handle_positions.len() / handles;
    let strain_edges = rig.handles().strain_edges.len();
    let vectors = || vec![[T::ZERO; 3]; frames * vertices];
    let mut results = Results {
        strain: vec![T::ZERO; frames * strain_edges],
        large_scale: vectors(),
        large_scale_normals: vectors(),
        detail: vectors(),
        positions: vectors(),
        normals: vectors(),
    };
    strain::strain(
        strain::Params { frames: frames as u32, handles: handles as u32, strain_edges: strain_edges as u32 },
        handle_positions,
        &rig.handles().rest,
        rig.handles().edge_numbers(),
        &rig.handles().rest_lengths(),
        &mut results.strain,
    );
    let mut band_offsets = Vec::new();
    if rig.bands().is_some() {
        band_offsets = vectors();
        add_bands(rig, handle_positions, &mut band_offsets, &mut results.detail);
    }
    let motions = rig.handles().motions(handle_positions);
    let center = motions.center.map(|v| v.0);
    large_scale::large_scale(
        large_scale::Params::whole(frames, vertices, handles, !band_offsets.is_empty()).turning(center),
        &rig.surface().rest,
        rig.basis().as_slice(),
        &motions.vectors,
        &band_offsets,
        &mut results.large_scale,
    );
    let vertex_triangles = rig.surface().vertex_triangles();
    let normals_of = |positions: &[[T; 3]], vertex_normals: &mut [[T; 3]]| {
        let params = normals::Params::whole(frames, vertices);
        normals::normals(params, positions, &rig.surface().triangles, &vertex_triangles, vertex_normals);
    };
    normals_of(&results.large_scale, &mut results.large_scale_normals);
    if !rig.vector_wrinkles() {
        let (rbf_weights, pivots) = pivoted_weights(rig);
        detail::detail(
            detail_params(rig, frames),
            &squared_differences(rig, &results.strain),
            &detail::Buffers {
                influences: rig.influences().per_vertex(),
                influence_edges: StrainEdgeId::numbers(rig.influences().edges.as_slice()),
                influence_weights: rig.influences().weights.as_slice(),
                rbf_weights: rbf_weights.as_slice(),
                pivots: &pivots,
            },
            &mut results.detail,
        );
    }
    fine_scale::fine_scale(
        fine_scale::Params::whole(frames, vertices, rig.vector_wrinkles()),
        &results.large_scale,
        &results.large_scale_normals,
        &results.detail,
        VertexId::numbers(&rig.surface().tangent_neighbors),
        &mut results.positions,
    );
    normals_of(&results.positions, &mut results.normals);
    results
}

/// The weights of the detail as its kernel has them, and the pivots.
pub fn pivoted_weights<T: Real>(rig: &Rig<T>) -> (Table<[T; 3]>, Vec<u32>) {
    let weights = &rig.fine_scale().rbf_weights;
    if rig.learned().is_some() {
        return (weights.clone(), vec![0; rig.vertices()]);
    }
    let (pivoted, pivots) = detail::pivoted(weights.as_slice(), rig.centers());
    (Table::new(weights.height(), weights.columns(), pivoted), pivots)
}

/// The detail's parameters for a rig that is not split.
pub fn detail_params<T: Real>(rig: &Rig<T>, frames: usize) -> detail::Params {
    let whole =
        detail::Params::whole(frames, rig.vertices(), rig.handles().strain_edges.len(), rig.centers());
    detail::Params { zero_at_rest: u32::from(rig.learned().is_some()), ..whole }
}

/// Adds both bands of a rig that has them: the linear band, and the wrinkles of vector strains.
fn add_bands<T: Real>(
    rig: &Rig<T>,
    handle_positions: &[[T; 3]],
    offsets: &mut [[T; 3]],
    details: &mut [[T; 3]],
) {
    let Some(learned) = rig.bands() else { return };
    let handle_rest = &rig.handles().rest;
    let (handles, features, centers) = (handle_rest.len(), rig.handles().features(), rig.centers());
    let frames = handle_positions.len() / handles;
    let rest = handle_rest.iter().cycle();
    let displacements: Vec<[T; 3]> =
        handle_positions.iter().zip(rest).map(|(p, rest)| vec3::sub(*p, *rest)).collect();
    let mut table = vec![T::ZERO; frames * differences::table_len(features, centers)];
    let feature_lengths: Vec<T> = rig.handles().feature_lengths().iter().map(|&l| T::round_from(l)).collect();
    let (example_vectors, feature_limits) = (rig.example_vectors(), rig.feature_limits());
    let of_frame = vector_differences::Buffers {
        strain_edges: rig.handles().edge_numbers(),
        feature_lengths: &feature_lengths,
        example_vectors: example_vectors.as_slice(),
        feature_limits: &feature_limits,
    };
    vector_differences::vector_differences(
        vector_differences::Params {
            frames: frames as u32,
            handles: handles as u32,
            strain_edges: rig.handles().strain_edges.len() as u32,
            centers: centers as u32,
        },
        &displacements,
        &of_frame,
        &mut table,
    );
    bands::bands(
        bands::Params::whole(frames, rig.vertices(), features, centers, rig.vector_wrinkles()),
        (&table, rig.handles().strain_edges.len() as u32),
        &bands::Buffers {
            influences: rig.influences().per_vertex(),
            influence_edges: StrainEdgeId::numbers(rig.influences().edges.as_slice()),
            influence_weights: rig.influences().weights.as_slice(),
            anchors_per_vertex: learned.anchors_per_vertex(),
            anchors: HandleId::numbers(learned.anchors.as_slice()),
            anchor_weights: learned.anchor_weights.as_slice(),
            band_weights: rig.band_weights().as_slice(),
        },
        offsets,
        details,
    );
    if rig.limits_basis() {
        let of_vertices = (0..rig.vertices()).flat_map(|v| rig.influences_of(v));
        let frames_of = |u: &[[T; 3]]| {
            (0..features).map(|e| vector_differences::vector_excess(&of_frame, u, e)).collect::<Vec<_>>()
        };
        beyond::beyond(
            beyond::Params {
                frames: frames as u32,
                vertices: rig.vertices() as u32,
                first_vertex: 0,
                part_vertices: rig.vertices() as u32,
                features: features as u32,
            },
            &displacements.chunks_exact(handles).flat_map(frames_of).collect::<Vec<_>>(),
            &beyond::Buffers {
                influences: learned.feature_gains.columns(),
                features: &of_vertices.map(|(e, _)| e as u32).collect::<Vec<_>>(),
                gains: learned.feature_gains.as_slice(),
            },
            offsets,
        );
    }
}

/// The result of the kernel `differences` for a batch's features.
pub fn squared_differences<T: Real>(rig: &Rig<T>, features: &[T]) -> Vec<T> {
    let (edges, centers) = (rig.handles().strain_edges.len(), rig.centers());
    let frames = features.len().checked_div(edges).unwrap_or(0);
    let params =
        differences::Params { frames: frames as u32, strain_edges: edges as u32, centers: centers as u32 };
    let mut table = vec![T::ZERO; frames * differences::table_len(edges, centers)];
    differences::differences(params, features, rig.fine_scale().pose_features.as_slice(), &mut table);
    table
}
