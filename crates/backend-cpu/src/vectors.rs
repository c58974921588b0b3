//! The kind of registers for the work, chosen when the program runs.
use pulp::{Arch, WithSimd};

/// A kind of vectors.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Vectors {
    /// The widest that the processor has: AVX-512, AVX2 with fused multiply-add, NEON, or single numbers.
    Widest,
    /// Single numbers, so that tests cover old processors.
    #[cfg(test)]
    Single,
    /// AVX2, for tests.
    #[cfg(all(test, target_arch = "x86_64"))]
    Avx2(pulp::x86::V3),
}

impl Vectors {
    /// AVX-512 if it is the kind.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn avx512(self) -> Option<pulp::x86::V4> {
        match self {
            Self::Widest => pulp::x86::V4::try_new(),
            #[cfg(test)]
            _ => None,
        }
    }

    /// AVX2 if it is the kind, or a part of it.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn avx2(self) -> Option<pulp::x86::V3> {
        match self {
            Self::Widest => pulp::x86::V3::try_new(),
            #[cfg(test)]
            Self::Single => None,
            #[cfg(test)]
            Self::Avx2(simd) => Some(simd),
        }
    }

    /// Runs `work` compiled for these vectors. Functions that it calls are compiled for them only if they are
    /// always inlined.
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
