use serde::{Deserialize, Serialize};

/// How an animation was made. It stands in the file (USD: `customData` of the default prim, glTF: `extras` of the
/// scene, both under the key `rhytid`), so that the file can be made again and compared.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Origin {
    /// The program's version.
    pub version: String,
    /// The rig file's hash, as [`rhytid_core::rig_file::hash`] gives it.
    pub rig: String,
    /// `full` or `large-scale`.
    pub stage: String,
    /// The first frame of the take that was asked for.
    pub first_frame: u64,
    /// The frame behind the last one that was asked for.
    pub end_frame: u64,
    /// The frames per second that were asked for; 0 for the take's own.
    pub fps: f64,
    /// `hold` or `error`.
    pub missing: String,
    /// Whether detail fades where the take's confidence is below 1. Files from before there was this choice do not say:
    /// it was false.
    #[serde(default)]
    pub fade_detail: bool,
    /// `keep`, `drop` or `bake`: what becomes of the head's motion. Files from before there was this choice do not say: it
    /// was `keep`.
    #[serde(default = "keep")]
    pub head: String,
}

fn keep() -> String {
    "keep".into()
}
