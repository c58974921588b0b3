//! How many copies of each buffer there are.
use crate::Stage;
use rhytid_kernels::table::Buffer;

/// What each copy of a buffer belongs to.
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
        | Buffer::FeatureLengths
        | Buffer::ExampleVectors
        | Buffer::FeatureLimits
        | Buffer::ClusterBasis
        | Buffer::TangentNeighbors => Extent::Rig,
        Buffer::Basis
        | Buffer::BasisRows
        | Buffer::InfluenceOffsets
        | Buffer::Influences
        | Buffer::InfluenceWeights
        | Buffer::FeatureGains
        | Buffer::RbfWeights
        | Buffer::Pivots
        | Buffer::BandWeights
        | Buffer::FanOffsets
        | Buffer::Fans => Extent::Part,
        Buffer::HandlePositions | Buffer::Displacements | Buffer::VectorExcess | Buffer::Motions => {
            Extent::Input
        }
        Buffer::SquaredDifferences
        | Buffer::SquaredVectorDifferences
        | Buffer::BandOffsets
        | Buffer::ClusterMotions => Extent::Scratch,
        Buffer::Features => Extent::Result(Stage::Strain),
        Buffer::LargeScalePositions => Extent::Result(Stage::LargeScale),
        Buffer::LargeScaleNormals => Extent::Result(Stage::LargeScaleNormals),
        Buffer::LocalDetail => Extent::Result(Stage::Detail),
        Buffer::Positions => Extent::Result(Stage::Positions),
        Buffer::VertexNormals => Extent::Result(Stage::Normals),
    }
}
