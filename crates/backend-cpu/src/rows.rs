//! Rows of numbers where cache lines begin, so that no register is loaded from two of them.
use bytemuck::{Pod, Zeroable};

/// Vertices in a tile: the basis is read a tile at a time.
pub const TILE: usize = 64;

/// The numbers in a [`Row`]: what the widest registers hold.
pub const ROW: usize = 16;

/// Frames that are evaluated side by side.
pub const GROUP: usize = ROW;

/// A number of each vertex of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct TileRow(pub [f32; TILE]);

/// A number of each of [`ROW`] neighbouring vertices in one frame, or of one vertex in each frame of a group.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Row(pub [f32; ROW]);

/// Likewise a vector.
pub type RowVectors = [Row; 3];

impl TileRow {
    /// Zeros.
    pub const ZERO: Self = Self([0.0; TILE]);
}

impl Row {
    /// Zeros.
    pub const ZERO: Self = Self([0.0; GROUP]);
}

impl AsRef<[f32]> for Row {
    fn as_ref(&self) -> &[f32] {
        &self.0
    }
}

impl AsMut<[f32]> for Row {
    fn as_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}
