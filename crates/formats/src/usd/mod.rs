//! USD: one description of a layer ([`layer`]), written as text or binary ([`LayerWriter`]) and read back ([`read`]).

mod build;
pub mod clips;
mod crate_file;
mod face;
pub mod layer;
mod materials;
mod names;
mod numbers;
mod package;
pub mod read;
mod sample;
mod shapes;
mod surface;
mod text;
mod text_value;
mod writer;

pub(crate) use face::Face;
pub use sample::Sample;
pub(crate) use shapes::write_shapes;
pub use writer::{Encoding, LayerWriter};
