//! What animation files of all formats have in common:
//!
//! - [`Scene`], [`Frame`] and [`Shapes`]: what is written.
//! - [`Recipe`]: how an animation was made.
//! - [`Exporter`] and [`AnimationReader`]: the traits that a format implements.
//! - [`morphs`]: frames as sums of few shapes.
//! - [`companion`]: files beside the files that name them.
//!
//! ```
//! use rhytid_export::{OutputStage, Recipe};
//!
//! let recipe = Recipe { detail: 0.5, ..Recipe::default() };
//! assert_eq!(recipe.stage, OutputStage::Full);
//! ```
#![forbid(unsafe_code)]

mod clip_names;
pub mod companion;
mod exporter;
mod frame;
pub mod morphs;
mod options;
mod prim_path;
mod reader;
mod recipe;
mod scene;
mod shapes;

pub use clip_names::unique_names;
pub use exporter::{Deviation, Exporter, Written};
pub use frame::Frame;
pub use options::{Options, Subdivision, TextureFiles};
pub use prim_path::{PrimPath, is_prim_name};
pub use reader::{AnimationReader, StatedError, Summary, clip_number};
pub use recipe::{
    ChannelChoice, Gains, HeadMotion, OutputStage, Recipe, StatedRecipe, Treatment, WrinkleGroup,
    WrinkleGroups,
};
pub use scene::{Clip, Scene};
pub use shapes::{Shape, ShapeSet, Shapes};
