//! What becomes of the fine detail.

use super::QUALITY;
use super::values::{StageChoice, parse_gain, parse_region};
use rhytid::formats::export::OutputStage;
use rhytid::{Error, Result};

/// `--stage`, `--fade-detail`, `--detail` and `--detail-of`
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct FineDetail {
    /// How far to go.
    #[arg(long, value_enum, default_value_t = StageChoice::Full, help_heading = QUALITY)]
    pub stage: StageChoice,

    /// Fade wrinkles out where they are unreliable.
    ///
    /// Wrinkles fade where markers were filled rather than measured, as the take's confidence says. They also
    /// fade where a frame is far outside the examples.
    #[arg(id = "fade_detail", long = "fade-detail", help_heading = QUALITY)]
    pub fade: bool,

    /// Multiply the wrinkles, from 0 (none) to 2.
    #[arg(id = "detail", long = "detail", value_name = "GAIN", default_value_t = 1.0, value_parser = parse_gain, help_heading = QUALITY)]
    pub gain: f64,

    /// The same in one region or about one handle.
    ///
    /// It can be given many times, and as the table “detail” of TAKE.toml. Regions follow from the handles'
    /// names: brows, lids, nose, cheeks, lips, chin, jaw, forehead, ears, neck.
    #[arg(id = "detail_of", long = "detail-of", value_name = "REGION=GAIN", value_parser = parse_region, help_heading = QUALITY)]
    pub gains: Vec<(String, f64)>,
}

impl FineDetail {
    /// Refuses options that the stage would ignore.
    ///
    /// # Errors
    /// [`Error::Input`].
    pub(crate) fn check(&self) -> Result<()> {
        let for_detail = [
            (self.fade, "--fade-detail"),
            (!self.gains.is_empty(), "--detail-of"),
            (self.gain != 1.0, "--detail"),
        ];
        match for_detail.into_iter().find(|(is_given, _)| *is_given && self.stage != StageChoice::Full) {
            Some((_, option)) => Err(Error::conflict(format!(
                "{option} is for --stage full, found --stage {}, which has no detail; leave one of them out",
                OutputStage::from(self.stage)
            ))),
            None => Ok(()),
        }
    }
}
