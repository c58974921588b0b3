//! A whole backend in a few lines: what `docs/adding-a-backend.md` builds. Its buffers are arrays of words, and its
//! kernels are the f32 twins.
mod device;
mod kernels;
mod session;

pub(crate) use device::Toy;
pub(crate) use session::ToySession;
