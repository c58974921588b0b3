//! `rhytid transfer`

use super::{Elsewhere, Json};
use std::path::PathBuf;

/// `rhytid transfer`
#[derive(Debug, clap::Args)]
pub(crate) struct Transfer {
    /// The rig of the face that has the wrinkles.
    #[arg(long, value_name = "A.safetensors")]
    pub from: PathBuf,

    /// The project file of the face that gets them; it needs handles and no examples.
    #[arg(long, value_name = "B.toml")]
    pub to: PathBuf,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    /// The rig file to write.
    #[arg(short, long, value_name = "B.safetensors")]
    pub output: PathBuf,

    /// Which handles correspond: CSV with the columns from and to, labels of either face [default: handles of
    /// the same label].
    #[arg(long, value_name = "PAIRS.csv")]
    pub landmarks: Option<PathBuf>,

    /// Carry over the first face's whole motion with its linear band, not its wrinkles alone.
    #[arg(long, alias = "with-smooth-band")]
    pub with_linear_band: bool,

    /// The folder to write the new examples to, as .obj; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    pub examples: Option<PathBuf>,

    /// The folder to write transfer.html, with maps of distances and stretches, and transfer.json to; made if
    /// it does not exist.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,

    #[command(flatten)]
    pub json: Json,
}
