//! Numbers in whole cache lines, so that no register is loaded from two lines.
use bytemuck::{Pod, Zeroable};
use rhytid_kernels::tile::TILE;

/// Vertices in a *panel*: four tiles. The basis of a panel fills several of the widest registers in one
/// frame.
pub(crate) const PANEL: usize = 4 * TILE;

/// Frames in a *group*: frames of a batch that are evaluated side by side. One vertex's number in all of them
/// is a [`Line`].
pub(crate) const GROUP: usize = TILE;

/// A number of each vertex of a tile in one frame, which is a row. Or a number of one vertex in each frame of
/// a group. A line fills one of the widest registers.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Line(pub [f32; TILE]);

/// Vectors in the same way, with a line for each coordinate.
pub(crate) type Line3 = [Line; 3];

/// A row of each tile of a panel.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct PanelRows(pub [f32; PANEL]);

impl Line {
    /// Zeros.
    pub(crate) const ZERO: Self = Self([0.0; TILE]);
}

impl PanelRows {
    /// Zeros.
    pub(crate) const ZERO: Self = Self([0.0; PANEL]);
}

impl AsRef<[f32]> for Line {
    fn as_ref(&self) -> &[f32] {
        &self.0
    }
}

impl AsMut<[f32]> for Line {
    fn as_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}
