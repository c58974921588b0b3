//! `rhytid animate`

use super::channels::Channels;
use super::live::{FramesChoice, Listen};
use super::placing::TakeReading;
use super::values::{
    HeadChoice, StageChoice, parse_gain, parse_millimetres, parse_rate, parse_region, parse_shapes,
};
use rhytid::formats::export::WrinkleGroup;
use std::path::PathBuf;

/// `rhytid animate`
#[derive(Debug, clap::Args)]
pub(crate) struct Animate {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// The take. CSV with time,LABEL_x,LABEL_y,LABEL_z,… in mesh units and head space, or the file of a
    /// capture system. The latter is cleaned first, as `prepare` does it.
    #[arg(required_unless_present = "listen")]
    pub take: Option<PathBuf>,

    /// The file to write; its ending is the format: .usd, .usdc, .usda, .usdz, .glb, .gltf or .pc2.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// The device to evaluate on, as `rhytid devices` names it; auto takes the fastest that conforms,
    /// software drivers last.
    #[arg(long, default_value = "auto")]
    pub device: String,

    #[command(flatten)]
    pub live: Listen,

    /// The frames A to B-1 of the take, counted from 0; either end can be left out. With --listen: the number
    /// of frames to record.
    #[arg(long, value_name = "A..B", default_value = "..", hide_default_value = true)]
    pub frames: FramesChoice,

    /// How far to go.
    #[arg(long, value_enum, default_value_t = StageChoice::Full)]
    pub stage: StageChoice,

    /// Resample to N frames per second [default: the take's own rate].
    #[arg(long, value_name = "N", value_parser = parse_rate)]
    pub fps: Option<f64>,

    #[command(flatten)]
    pub reading: TakeReading,

    /// Fade the wrinkles out where their markers were filled rather than measured, as the take's confidence
    /// says. Also fade them where a frame is far outside the examples.
    #[arg(long)]
    pub fade_detail: bool,

    /// Multiply the wrinkles by this gain, from 0 (no wrinkles, large scale only) to 2.
    #[arg(long, value_name = "GAIN", default_value_t = 1.0, value_parser = parse_gain)]
    pub detail: f64,

    /// The same gain about one handle or in one region; can be given many times, and as the table “detail” of
    /// TAKE.toml. Regions follow from the handles' names: brows, lids, nose, cheeks, lips, chin, jaw,
    /// forehead, ears, neck.
    #[arg(long, value_name = "REGION=GAIN", value_parser = parse_region)]
    pub detail_of: Vec<(String, f64)>,

    /// Edits of the take: EDIT.toml, which docs/edits.md describes.
    #[arg(long, value_name = "EDIT.toml", conflicts_with = "listen")]
    pub edit: Option<PathBuf>,

    /// Refine each frame on the processor, as rigid as possible and stiff in bending. It is meant for bends
    /// of more than 60° on a rig without examples.
    #[arg(long)]
    pub refine: bool,

    /// What to do with the head's motion, if the take has it.
    #[arg(long, value_enum, default_value_t = HeadChoice::Keep)]
    pub head: HeadChoice,

    #[command(flatten)]
    pub channels: Channels,

    /// Examples whose wrinkles form one channel of --wrinkles, under a name of your choice; can be given many
    /// times [default: each example by itself].
    #[arg(long, value_name = "NAME=EXAMPLE+EXAMPLE", requires = "wrinkles")]
    pub wrinkle_group: Vec<WrinkleGroup>,

    /// Write also the wrinkles as one picture over the texture coordinates, with a tile of N × N pixels for
    /// each channel of --wrinkles. A CSV beside it says how far each channel is switched on in each frame;
    /// docs/wrinkles.md describes both.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=4096))]
    pub masks: Option<u32>,

    /// The picture of --masks; with {frame} in its name, one for each frame [default: beside OUT, under its
    /// name with .masks.png].
    #[arg(long, value_name = "MASKS.png", requires = "masks")]
    pub masks_to: Option<PathBuf>,

    /// Write also, as CSV, how much each region of the face is stretched and squeezed in each frame;
    /// docs/strain.md says what the columns are.
    #[arg(long, value_name = "CURVES.csv")]
    pub strain_curves: Option<PathBuf>,

    /// Regions of --strain-curves: the neutral as .obj with groups (“g NAME” before faces) [default: by the
    /// names of the handles].
    #[arg(long, value_name = "GROUPS.obj", requires = "strain_curves")]
    pub groups: Option<PathBuf>,

    /// glTF: as few morph targets as --max-error allows, instead of one for each frame.
    #[arg(long)]
    pub compressed: bool,

    /// glTF: how far a vertex may be from its place in any frame, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 0.1, requires = "compressed", value_parser = parse_millimetres)]
    pub max_error: f64,

    /// glTF or USD: the take as N shapes with curves, for engines and for shape keys. The error is not
    /// limited; it is printed and written to the file.
    #[arg(long, value_name = "N", conflicts_with = "compressed", value_parser = parse_shapes)]
    pub shapes: Option<usize>,

    /// glTF: numbers of 8 and 16 bits (KHR_mesh_quantization).
    #[arg(long)]
    pub quantize: bool,

    /// glTF: compressed buffers (EXT_meshopt_compression); three.js and Babylon.js read them, Blender does
    /// not.
    #[arg(long)]
    pub meshopt: bool,

    /// glTF: also more than 256 morph targets or 1 GiB.
    #[arg(long)]
    pub force: bool,
}
