//! From a raw take to a clean one: pure functions, one clean-up step a file.
#![forbid(unsafe_code)]

mod axes;
mod clean;
pub mod coverage;
mod events;
mod fit;
mod gaps;
mod head;
mod labels;
mod low_pass;
mod low_rank;
mod neighbours;
mod neutral;
mod outliers;
mod placing;
mod report;
mod settings;
mod swaps;
mod tracks;

pub use axes::Axes;
pub use clean::{Cleaned, Target, clean};
pub use report::{Event, Found, Kind, Report};
pub use settings::{Settings, Step};
