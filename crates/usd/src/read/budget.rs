//! Limits for reading a file.

/// How deep prims may be within prims.
pub(super) const MOST_PRIMS_DEEP: usize = 64;

/// How much memory a file may still take. In a damaged or hostile file, a few bytes can stand for very many:
/// by compression, or by values that are referred to again and again. So the decoded bytes are counted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Budget {
    left: u64,
}

impl Budget {
    /// Far more than any true file of `len` bytes needs: its points take twelve bytes a vertex uncompressed,
    /// its compressed topology some twenty in memory.
    pub(super) fn of_file(len: u64) -> Self {
        Self { left: len.saturating_mul(16).saturating_add(64 << 20) }
    }

    /// Takes `bytes` from the budget; false if there are not enough.
    pub(super) fn take(&mut self, bytes: u64) -> bool {
        let left = self.left.checked_sub(bytes);
        self.left = left.unwrap_or(0);
        left.is_some()
    }
}
