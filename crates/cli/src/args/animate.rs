//! `rhytid animate`

use super::channels::Channels;
use super::fine_detail::FineDetail;
use super::live::{FramesChoice, Listen};
use super::placing::TakeReading;
use super::usd_layer::UsdLayer;
use super::values::{HeadChoice, Json, MaterialsChoice, TexturesChoice, parse_millimetres, parse_rate};
use super::{DEVICE, GLTF, INPUT, OUTPUT, QUALITY, SIDE_FILES};
use rhytid::formats::export::WrinkleGroup;
use std::path::PathBuf;

/// `rhytid animate`
#[derive(Debug, clap::Args)]
pub(crate) struct Animate {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// The take: CSV, or the file of a capture system.
    ///
    /// A CSV has time,LABEL_x,LABEL_y,LABEL_z,… in mesh units and head space. The file of a capture system is
    /// cleaned first, as `prepare` does it. If OUT is a folder, there can be several takes, and each gets a
    /// file of its own. With --shapes N, --compressed or --onto, one file can have several takes: each is a
    /// clip of its own, and all share one set of shapes.
    #[arg(value_name = "TAKE", required_unless_present = "listen")]
    pub takes: Vec<PathBuf>,

    /// The file: .usd, .usdc, .usda, .usdz, .glb, .gltf or .pc2; with --onto also .csv.
    ///
    /// The ending is the format. docs/export.md says which format and which options suit which program. A
    /// folder, such as OUT/, gets a .usd for each take, and takes.html with what is wrong with each.
    /// OUT/{take}.glb is another format. What is done and unchanged is left.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    pub output: PathBuf,

    /// The frames A to B-1, counted from 0; either end may be left out.
    ///
    /// With --listen it is the number of frames to record.
    #[arg(long, value_name = "A..B", default_value = "..", hide_default_value = true, help_heading = OUTPUT)]
    pub frames: FramesChoice,

    /// Resample to N frames per second [default: the take's rate].
    #[arg(long, value_name = "N", value_parser = parse_rate, help_heading = OUTPUT)]
    pub fps: Option<f64>,

    /// The time code of the take's first frame [default: its place in the session].
    ///
    /// The place comes from the time code or the first frame that a capture file states. It is 0 for a file
    /// that states none.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000), hide_short_help = true, help_heading = OUTPUT)]
    pub start_frame: Option<u64>,

    /// What becomes of the head's motion.
    #[arg(long, value_enum, default_value_t = HeadChoice::Keep, help_heading = OUTPUT)]
    pub head: HeadChoice,

    /// Where the textures of materials are [default: embed for .glb and .usdz, else copy].
    #[arg(long, value_enum, hide_short_help = true, help_heading = OUTPUT)]
    pub textures: Option<TexturesChoice>,

    #[command(flatten)]
    pub layer: UsdLayer,

    /// USD: samples alone, as a layer over another file that has the mesh.
    ///
    /// The mesh there has the neutral's vertices in their order. docs/export.md shows the steps.
    #[arg(long, hide_short_help = true, conflicts_with_all = ["textures", "subdivision"], help_heading = OUTPUT)]
    pub over: bool,

    #[command(flatten)]
    pub channels: Channels,

    /// Examples that form one channel of --wrinkles, as NAME.
    ///
    /// It can be given many times. By default each example has a channel of its own.
    #[arg(long, value_name = "NAME=A+B", requires = "wrinkles", hide_short_help = true, help_heading = OUTPUT)]
    pub wrinkle_group: Vec<WrinkleGroup>,

    /// Also write a picture of the wrinkles, N × N pixels a channel.
    ///
    /// It is a texture with a tile for each channel of --wrinkles. A CSV beside it says how strongly each
    /// channel is on in each frame; docs/wrinkles.md describes both.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=4096), help_heading = SIDE_FILES)]
    pub masks: Option<u32>,

    /// The picture of --masks [default: OUT's name with .masks.png].
    ///
    /// If the name contains {frame}, there is a picture for each frame.
    #[arg(long, value_name = "MASKS.png", requires = "masks", help_heading = SIDE_FILES)]
    pub masks_to: Option<PathBuf>,

    /// Also write the strain of each region in each frame.
    ///
    /// docs/strain.md says what the columns are.
    #[arg(long, value_name = "CURVES.csv", help_heading = SIDE_FILES)]
    pub strain_curves: Option<PathBuf>,

    /// The regions of --strain-curves [default: by handles' names].
    ///
    /// It is the neutral as .obj with groups (“g NAME” before faces).
    #[arg(long, value_name = "GROUPS.obj", requires = "strain_curves", help_heading = SIDE_FILES)]
    pub groups: Option<PathBuf>,

    /// Edits of the take.
    ///
    /// docs/edits.md describes them.
    #[arg(long, value_name = "EDIT.toml", conflicts_with = "listen", help_heading = INPUT)]
    pub edit: Option<PathBuf>,

    // `--shapes N` of TakeReading is an output here: the take as N shapes with curves.
    #[command(flatten)]
    pub reading: TakeReading,

    /// Find only the weights of given shapes: of a file, a folder, a project or a rig.
    ///
    /// They are shapes of the rig's mesh, in a glTF or USD file, a folder of meshes, a project file or a rig.
    /// Each frame comes as near as weights from 0 to 1 allow, and the error is printed. OUT is a mesh with
    /// these shapes and a clip, or the weights as .csv.
    #[arg(long, value_name = "SHAPES", conflicts_with_all = ["compressed", "quantize"], help_heading = OUTPUT)]
    pub onto: Option<PathBuf>,

    #[command(flatten)]
    pub live: Listen,

    #[command(flatten)]
    pub fine_detail: FineDetail,

    /// Make each frame as rigid as possible, for large bends.
    ///
    /// The processor does it, and keeps bends stiff. It is meant for bends of more than 60° on a rig without
    /// examples.
    #[arg(long, help_heading = QUALITY)]
    pub refine: bool,

    /// As few morph targets as --max-error allows.
    ///
    /// Without it, each frame is a morph target.
    #[arg(long, help_heading = GLTF)]
    pub compressed: bool,

    /// How far a vertex may be off in any frame, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 0.1, requires = "compressed", value_parser = parse_millimetres, help_heading = GLTF)]
    pub max_error: f64,

    /// The most morph targets that the file may have, for the program that opens it [default: 256].
    ///
    /// Some game engines show 64. With --compressed, more than N are an error: raise --max-error.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), hide_short_help = true, help_heading = GLTF)]
    pub targets: Option<u16>,

    /// Numbers of 8 and 16 bits (KHR_mesh_quantization), for Blender, three.js and Babylon.js.
    ///
    /// Many other programs do not read them; docs/export.md lists them.
    #[arg(long, help_heading = GLTF)]
    pub quantize: bool,

    /// Compressed buffers (EXT_meshopt_compression), for three.js and Babylon.js.
    ///
    /// Blender does not read them.
    #[arg(long, help_heading = GLTF)]
    pub meshopt: bool,

    /// How materials are kept apart.
    #[arg(long, value_enum, default_value_t = MaterialsChoice::Each, hide_short_help = true, help_heading = GLTF)]
    pub materials: MaterialsChoice,

    /// Also write each vertex's number in the neutral, as the attribute _VERTEX_ID.
    #[arg(long, hide_short_help = true, help_heading = GLTF)]
    pub vertex_ids: bool,

    /// The device to evaluate on, as `rhytid devices` names it.
    ///
    /// auto takes the fastest that conforms, software drivers last.
    #[arg(long, default_value = "auto", help_heading = DEVICE)]
    pub device: String,

    #[command(flatten)]
    pub json: Json,
}
