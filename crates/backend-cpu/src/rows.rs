//! Rows of numbers where cache lines begin, so that no register is loaded from two of them.
use bytemuck::{Pod, Zeroable};
use rhytid_kernels::table::TILE;

/// Frames that are evaluated side by side: what the widest registers hold.
pub const GROUP: usize = 16;

/// A number of each vertex of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct TileRow(pub [f32; TILE]);

/// A number of each frame of a group.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct GroupRow(pub [f32; GROUP]);

/// A vector of each vertex of a tile.
pub type TileVectors = [TileRow; 3];

/// A vector of each frame of a group.
pub type GroupVectors = [GroupRow; 3];

impl TileRow {
    /// Zeros.
    pub const ZERO: Self = Self([0.0; TILE]);
}

impl GroupRow {
    /// Zeros.
    pub const ZERO: Self = Self([0.0; GROUP]);
}

impl AsRef<[f32]> for TileRow {
    fn as_ref(&self) -> &[f32] {
        &self.0
    }
}

impl AsMut<[f32]> for TileRow {
    fn as_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}

impl AsRef<[f32]> for GroupRow {
    fn as_ref(&self) -> &[f32] {
        &self.0
    }
}

impl AsMut<[f32]> for GroupRow {
    fn as_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}
