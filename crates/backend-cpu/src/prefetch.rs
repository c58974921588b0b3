//! Requests for memory shortly before it is needed, where the processor does not predict the order of the
//! work.

/// Bytes of a cache line.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

/// The instruction that requests memory, where the processor has one. It changes no result.
#[derive(Clone, Copy)]
pub(crate) struct Prefetch {
    #[cfg(target_arch = "x86_64")]
    simd: Option<pulp::x86::V1>,
}

impl Prefetch {
    pub(crate) fn new() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            simd: pulp::x86::V1::try_new(),
        }
    }

    /// Requests all of `bytes`, without waiting.
    #[inline(always)]
    pub(crate) fn ask(self, bytes: &[u8]) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = self.simd {
            for line in bytes.chunks(LINE) {
                simd.sse._mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(line.as_ptr().cast());
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = bytes;
    }
}
