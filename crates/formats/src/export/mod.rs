//! Animation and shapes on their way out, whatever the format: what is written ([`Scene`] and its frames, [`Shapes`]), how
//! it was made ([`Recipe`]), and the trait that each format implements ([`Exporter`]). [`crate::animation`] chooses
//! the format.

mod exporter;
mod frame;
mod options;
mod recipe;
mod scene;
mod shapes;

pub use exporter::{Deviation, Exporter, Written};
pub use frame::Frame;
pub use options::Options;
pub use recipe::{
    ChannelChoice, Gains, HeadMotion, OutputStage, Recipe, StatedRecipe, Treatment, WrinkleGroup,
    WrinkleGroups,
};
pub use scene::Scene;
pub(crate) use scene::first_not_finite;
pub use shapes::{Shape, Shapes};
