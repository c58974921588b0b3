//! What there is one of each buffer for.
use crate::Stage;
use rhytid_kernels::table::Buffer;

/// What there is one of a buffer for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Extent {
    /// The rig.
    Rig,
    /// Each part.
    Part,
    /// Each slice, to be filled by the host.
    Input,
    /// Each slice, written by one kernel for another.
    Scratch,
    /// Each slice, of this stage.
    Result(Stage),
}

pub(super) fn extent(buffer: Buffer) -> Extent {
    match buffer {
        Buffer::Rest
        | Buffer::HandleRest
        | Buffer::StrainEdges
        | Buffer::RestLengths
        | Buffer::PoseFeatures
        | Buffer::ExampleVectors
        | Buffer::FeatureBounds
        | Buffer::TangentNeighbors => Extent::Rig,
        Buffer::Basis
        | Buffer::InfluenceOffsets
        | Buffer::Influences
        | Buffer::InfluenceWeights
        | Buffer::RbfWeights
        | Buffer::Pivots
        | Buffer::ExampleWeights
        | Buffer::FanOffsets
        | Buffer::Fans => Extent::Part,
        Buffer::HandlePositions | Buffer::Displacements => Extent::Input,
        Buffer::SquaredDifferences | Buffer::StrainProducts | Buffer::BasisPositions => Extent::Scratch,
        Buffer::Features => Extent::Result(Stage::Strain),
        Buffer::LargeScalePositions => Extent::Result(Stage::LargeScale),
        Buffer::LargeScaleNormals => Extent::Result(Stage::LargeScaleNormals),
        Buffer::LocalDetail => Extent::Result(Stage::Detail),
        Buffer::Positions => Extent::Result(Stage::Positions),
        Buffer::VertexNormals => Extent::Result(Stage::Normals),
    }
}

/// Whether the linear band alone needs `buffer`.
pub(super) fn of_linear_band(buffer: Buffer) -> bool {
    matches!(
        buffer,
        Buffer::ExampleVectors
            | Buffer::FeatureBounds
            | Buffer::ExampleWeights
            | Buffer::StrainProducts
            | Buffer::BasisPositions
    )
}
