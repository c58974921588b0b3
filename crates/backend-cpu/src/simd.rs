//! The widest vectors that the processor has, chosen when the program runs.

/// Runs `work` compiled for them. What it calls must be small enough to be inlined; loops over lanes become vectors. There is no fused
/// multiply-add in it, so that every result has the twin's bits.
#[inline(always)]
pub fn widest<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
