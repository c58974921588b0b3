//! The flags of commands that write further files of a rig, and that check what was written.

use super::placing::TakeSpace;
use super::usd_layer::UsdLayer;
use super::values::{Elsewhere, Json, MaterialsChoice, TexturesChoice};
use std::path::PathBuf;

/// `rhytid stitch`
#[derive(Debug, clap::Args)]
pub(crate) struct Stitch {
    /// The parts, in any order: USD files of one rig and take that follow one another without a gap.
    #[arg(required = true)]
    pub parts: Vec<PathBuf>,

    /// The file to write: .usd, .usdc or .usda.
    #[arg(short, long, value_name = "OUT.usd")]
    pub output: PathBuf,

    /// The files are one take on several levels of detail, the whole face first. OUT is .usda and has a
    /// variant for each.
    #[arg(long)]
    pub levels: bool,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid export-shapes`
#[derive(Debug, clap::Args)]
pub(crate) struct ExportShapes {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// The file to write; its ending is the format: .usd, .usdc, .usda, .usdz, .glb or .gltf.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Also write three shapes for each handle, which move it by one mesh unit along x, y and z. Together
    /// they give every large-scale motion exactly.
    #[arg(long)]
    pub handles: bool,

    /// Leave the normals out.
    #[arg(long)]
    pub no_normals: bool,

    /// Where the textures of materials are [default: embed for .glb and .usdz, else copy].
    #[arg(long, value_enum)]
    pub textures: Option<TexturesChoice>,

    #[command(flatten)]
    pub layer: UsdLayer,

    /// glTF: the most morph targets that the file may have [default: 256].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub targets: Option<u16>,

    /// glTF: how materials are kept apart.
    #[arg(long, value_enum, default_value_t = MaterialsChoice::Each)]
    pub materials: MaterialsChoice,

    /// glTF: also more than 256 shapes or 1 GiB.
    #[arg(long)]
    pub force: bool,

    /// The device to evaluate on, as `rhytid devices` names it; auto takes the fastest that conforms,
    /// software drivers last.
    #[arg(long, default_value = "auto")]
    pub device: String,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid verify`
#[derive(Debug, clap::Args)]
pub(crate) struct Verify {
    /// The file that `animate` or `stitch` wrote.
    #[arg(value_name = "OUT")]
    pub file: PathBuf,

    /// The rig that it was made with.
    #[arg(long)]
    pub rig: PathBuf,

    /// The take that it was made from.
    #[arg(long)]
    pub take: PathBuf,

    /// The clip of the take, in a file of several [default: the one called as the take's file].
    #[arg(long, value_name = "NAME")]
    pub clip: Option<String>,

    /// The edits that `animate` was given.
    #[arg(long, value_name = "EDIT.toml")]
    pub edit: Option<PathBuf>,

    /// For a raw take: the setup that `animate` was given.
    #[arg(long, value_name = "TAKE.toml")]
    pub setup: Option<PathBuf>,

    /// For curves: the shapes that `animate` was given.
    #[arg(long, value_name = "SHAPES")]
    pub shapes: Option<PathBuf>,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    /// The device to evaluate on, as `rhytid devices` names it; auto takes the fastest that conforms,
    /// software drivers last.
    #[arg(long, default_value = "auto")]
    pub device: String,

    #[command(flatten)]
    pub json: Json,

    #[command(flatten)]
    pub space: TakeSpace,
}
