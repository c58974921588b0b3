//! Animation and shapes on their way out, whatever the format: what is written ([`Scene`] and its frames, [`Shapes`]), how
//! it was made ([`Provenance`]), and the trait that each format implements ([`Exporter`]). [`crate::animation`] chooses
//! the format.

mod exporter;
mod options;
mod provenance;
mod scene;
mod shapes;

pub use exporter::{Deviation, Exporter, Frame, Written};
pub use options::Options;
pub use provenance::{HeadMotion, OutputStage, Provenance, Word};
pub use scene::Scene;
pub(crate) use scene::first_not_finite;
pub use shapes::{Shape, Shapes};
