//! The enumerations of C. The compiler asks for a value of each value of the library, or a test does.
//!
//! C programs pass them as numbers, because a value that Rust does not know must be an error.
use crate::status::{Failure, Result};
use rhytid::core::DeviceKind;
use rhytid::{BasisStorage, Missing, Stage};

/// One result of the runtime, in the order in which they are computed. V is the number of vertices.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RhytidStage {
    /// The ratios of the lengths of the strain edges: frames × strain edges.
    Strain = 0,
    /// The large-scale motion: frames × V × 3, mesh units.
    LargeScale = 1,
    /// The normals of the large-scale motion: frames × V × 3, of length 1, or 0 at a vertex without area.
    LargeScaleNormals = 2,
    /// The wrinkles alone, in tangent frames or along the axes of the mesh: frames × V × 3, mesh units.
    Detail = 3,
    /// The vertices: frames × V × 3, mesh units.
    Positions = 4,
    /// The normals of the vertices, as RHYTID_STAGE_LARGE_SCALE_NORMALS.
    Normals = 5,
}

/// How many stages there are: the length of the array of rhytid_animator_stage_times().
pub const RHYTID_STAGE_COUNT: usize = 6;
const _: () = assert!(RHYTID_STAGE_COUNT == Stage::ALL.len());

/// How a device keeps the basis, by far the largest part of a rig.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RhytidBasis {
    /// As the rig has it, in 32 bits. This is the default.
    F32 = 0,
    /// Rounded to 16 bits: half the memory. Markers are still met.
    F16 = 1,
    /// As factors of clusters of vertices: a third to an eighth of the memory. Markers are still met.
    Clustered = 2,
}

/// What is done where a marker is missing from a frame of a take: its cells are empty or no number.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RhytidMissing {
    /// It is an error, which names the frame and the marker. This is the default.
    Error = 0,
    /// The marker stays where it was last seen, or begins where it is first seen.
    Hold = 1,
    /// Its positions are NaN. Your program fills them before it evaluates the frame.
    Leave = 2,
}

/// The processor behind a device.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RhytidDeviceKind {
    /// A processor. Behind a GPU's API it is a software driver.
    Cpu = 0,
    /// A GPU that shares the processor's memory.
    IntegratedGpu = 1,
    /// A GPU with memory of its own.
    DiscreteGpu = 2,
    /// A part of a GPU, given to a virtual machine.
    VirtualGpu = 3,
    /// Anything else, or a device whose driver does not tell.
    Other = 4,
}

impl RhytidStage {
    pub(crate) fn of(stage: Stage) -> Self {
        match stage {
            Stage::Strain => Self::Strain,
            Stage::LargeScale => Self::LargeScale,
            Stage::LargeScaleNormals => Self::LargeScaleNormals,
            Stage::Detail => Self::Detail,
            Stage::Positions => Self::Positions,
            Stage::Normals => Self::Normals,
        }
    }
}

impl RhytidBasis {
    pub(crate) fn of(basis: BasisStorage) -> Self {
        match basis {
            BasisStorage::F32 => Self::F32,
            BasisStorage::F16 => Self::F16,
            BasisStorage::Clustered => Self::Clustered,
        }
    }
}

impl RhytidMissing {
    pub(crate) fn of(missing: Missing) -> Self {
        match missing {
            Missing::Error => Self::Error,
            Missing::Hold => Self::Hold,
            Missing::Leave => Self::Leave,
        }
    }
}

impl RhytidDeviceKind {
    /// `None` for a kind that the library has and C does not: a test finds none.
    pub(crate) fn of(kind: DeviceKind) -> Option<Self> {
        Some(match kind {
            DeviceKind::Cpu => Self::Cpu,
            DeviceKind::IntegratedGpu => Self::IntegratedGpu,
            DeviceKind::DiscreteGpu => Self::DiscreteGpu,
            DeviceKind::VirtualGpu => Self::VirtualGpu,
            DeviceKind::Other => Self::Other,
            _ => return None,
        })
    }
}

/// The stage of this number.
pub(crate) fn stage(number: u32) -> Result<Stage> {
    let found = Stage::ALL.into_iter().find(|&stage| RhytidStage::of(stage) as u32 == number);
    found.ok_or_else(|| unknown("stage", number, "RhytidStage"))
}

/// The storage of this number.
pub(crate) fn basis(number: u32) -> Result<BasisStorage> {
    let found = BasisStorage::ALL.into_iter().find(|&basis| RhytidBasis::of(basis) as u32 == number);
    found.ok_or_else(|| unknown("basis", number, "RhytidBasis"))
}

/// The policy of this number.
#[cfg_attr(not(feature = "takes"), expect(dead_code, reason = "only takes have missing markers"))]
pub(crate) fn missing(number: u32) -> Result<Missing> {
    let found = Missing::ALL.into_iter().find(|&missing| RhytidMissing::of(missing) as u32 == number);
    found.ok_or_else(|| unknown("missing", number, "RhytidMissing"))
}

fn unknown(argument: &str, number: u32, of: &str) -> Failure {
    Failure::argument(format!("{argument} is {number}, expected a value of {of}"))
}
