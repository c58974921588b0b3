//! A whole backend in a few lines, as `docs/adding-a-backend.md` builds it. Its buffers are arrays of words,
//! and its kernels are the f32 references.
mod device;
mod kernels;
mod session;

pub(crate) use device::Toy;
pub(crate) use session::ToySession;
