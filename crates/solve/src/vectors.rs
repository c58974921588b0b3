//! Loops compiled for the widest vectors of the processor.
use pulp::{Arch, Simd, WithSimd};

/// Runs `work`, compiled for the widest vectors of the processor. `work` and the functions that it calls must
/// always be inlined; otherwise they are compiled for the vectors that every processor has.
#[inline(always)]
pub(crate) fn widest<R>(work: impl FnMut() -> R) -> R {
    Arch::new().dispatch(Work(work))
}

/// `Arch::dispatch` takes closures, too. It calls them as `FnOnce`. If a closure borrows what it captures,
/// the compiler puts a function in between that is never inlined. As `FnMut`, a closure is called itself.
struct Work<F>(F);

impl<R, F: FnMut() -> R> WithSimd for Work<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> R {
        (self.0)()
    }
}
