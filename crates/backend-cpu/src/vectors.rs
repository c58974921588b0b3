//! The processor's registers that the work is done in, found when the program runs.
use pulp::{Arch, WithSimd};

/// A kind of vectors.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Vectors {
    /// The widest that the processor has: AVX-512, AVX2 with fused multiply-add, NEON, or single numbers.
    Widest,
    /// Single numbers, so that tests see what an old processor computes.
    #[cfg(test)]
    Single,
    /// AVX2, likewise.
    #[cfg(all(test, target_arch = "x86_64"))]
    Avx2(pulp::x86::V3),
}

impl Vectors {
    /// Runs `work` compiled for these vectors, with everything in it that is inlined for certain.
    pub(crate) fn run<W: WithSimd>(self, work: W) -> W::Output {
        match self {
            Self::Widest => Arch::new().dispatch(work),
            #[cfg(test)]
            Self::Single => pulp::Simd::vectorize(pulp::Scalar, work),
            #[cfg(all(test, target_arch = "x86_64"))]
            Self::Avx2(simd) => pulp::Simd::vectorize(simd, work),
        }
    }
}
