//! Limits of what a file is given.

/// How deep prims may be within prims.
pub(super) const MOST_PRIMS_DEEP: usize = 64;

/// How much memory a file may still take. A few bytes of a damaged or hostile file can stand for very many
/// (compression, values that are referred to again and again), so that what is decoded is counted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Budget {
    left: u64,
}

impl Budget {
    /// Far more than any true file of `len` bytes needs: its points take twelve bytes a vertex uncompressed, its
    /// compressed topology some twenty in memory.
    pub(super) fn of_file(len: u64) -> Self {
        Self { left: len.saturating_mul(16).saturating_add(64 << 20) }
    }

    /// Takes `bytes`; false if they are not there.
    pub(super) fn take(&mut self, bytes: u64) -> bool {
        let left = self.left.checked_sub(bytes);
        self.left = left.unwrap_or(0);
        left.is_some()
    }
}
