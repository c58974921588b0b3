//! USD layers out: as text, binary or in a package ([`LayerWriter`]), and animations and shapes as such
//! layers.
//!
//! Writers share nothing with the readers but the layer, so that neither side hides the faults of the other.

mod baked;
mod choices;
mod crate_file;
mod face;
mod layer_writer;
mod materials;
mod names;
mod numbers;
mod package;
mod sample;
mod shapes;
mod surface;
mod text;
mod text_value;
mod textures;
mod variants;

pub(crate) use baked::baked_layer;
pub use baked::{Baked, Goal};
pub(crate) use choices::Choices;
pub(super) use crate_file::CrateWriter;
pub use face::Face;
pub(crate) use face::animation_layer;
pub use layer_writer::{Encoding, LayerWriter};
pub use sample::Sample;
pub use shapes::write_shapes;
pub(super) use surface::custom_data;
pub(crate) use textures::{Assets, accept};
pub(crate) use variants::write_variants;
