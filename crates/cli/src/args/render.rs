//! `rhytid render`

use super::placing::TakeReading;
use super::skin::SkinLight;
use super::values::{StageChoice, parse_gain};
use clap::ValueEnum;
use clap::builder::ArgPredicate;
use rhytid::playback::FrameRange;
use rhytid::render::Look;
use std::path::{Path, PathBuf};

/// `rhytid render`
#[derive(Debug, clap::Args)]
pub(crate) struct Render {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// The take, as for `animate`.
    pub take: PathBuf,

    /// What to write. A .png is a sheet of frames, or a picture for each frame if its name contains {frame}.
    /// An .mp4 is a film of all frames (AV1), a .webp a lossless moving picture.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// The frames A to B-1 of the take, counted from 0; either end can be left out.
    #[arg(long, value_name = "A..B", default_value = "..", hide_default_value = true)]
    pub frames: FrameRange,

    /// For a sheet: the number of frames, spread evenly over --frames.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=400))]
    pub count: u32,

    /// What to show, beside each other [default: shaded; with --compare shaded,error].
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "shaded",
        default_value_if("compare", ArgPredicate::IsPresent, "shaded,error"),
        hide_default_value = true
    )]
    pub show: Vec<Show>,

    /// What to put to the left of each: the face at an earlier stage, or as another rig has it.
    #[arg(long, value_name = "shell|large-scale|RIG", value_parser = parse_before)]
    pub before: Option<BeforeChoice>,

    /// Dense meshes that show the truth, to put beside each: as for `evaluate --truth`.
    #[arg(long, value_name = "TRUTH")]
    pub compare: Option<PathBuf>,

    /// Which frames of the take the truth has: CSV with a column frame, counted from 0 [default: all].
    #[arg(long, value_name = "FRAMES.csv", requires = "compare")]
    pub truth_frames: Option<PathBuf>,

    /// Width and height of each, in pixels [default: 300x400 on a sheet, else 720x960].
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,

    /// Degrees to look from the face's left (positive) or right.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_angle)]
    pub turn: f32,

    /// Degrees to look from above (positive) or below, within 90.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_angle)]
    pub raise: f32,

    /// Show the whole mesh in the picture, instead of the part around the handles.
    #[arg(long)]
    pub whole: bool,

    /// The camera goes once around while the frames go by; around a single frame in --count steps.
    #[arg(long)]
    pub turntable: bool,

    /// Focal length, for film of 36 x 24 mm.
    #[arg(long, value_name = "MM", default_value_t = 85.0, value_parser = parse_lens)]
    pub lens: f32,

    /// The vertex whose influences are shown, counted from 0.
    #[arg(long, value_name = "N")]
    pub vertex: Option<usize>,

    /// For --show matcap: the picture of a ball that fills it, PNG or JPEG [default: clay].
    #[arg(long, value_name = "IMAGE")]
    pub matcap: Option<PathBuf>,

    /// For --show textured: the image, PNG or JPEG, or an .obj, .mtl, .glb or .gltf whose materials name
    /// images.
    #[arg(long, value_name = "FILE")]
    pub texture: Option<PathBuf>,

    /// What is behind the face: red, green and blue as RRGGBB, or none for a transparent picture [default:
    /// the colour of a sheet's paper].
    #[arg(long, value_name = "COLOUR", value_parser = parse_background)]
    pub background: Option<Background>,

    /// The strain that has the last colour, as a part of the length at rest.
    #[arg(long, value_name = "PART", default_value_t = 0.3, value_parser = parse_range)]
    pub strain_range: f32,

    /// The detail that has the last colour, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = parse_range)]
    pub detail_range: f32,

    /// The sigma that has the last colour, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 2.0, value_parser = parse_range)]
    pub sigma_range: f32,

    /// The error that has the last colour, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = parse_range)]
    pub error_range: f32,

    /// Edits of the take: EDIT.toml, which docs/edits.md describes.
    #[arg(long, value_name = "EDIT.toml")]
    pub edit: Option<PathBuf>,

    /// Fade the wrinkles out where they are unreliable, as for `animate`.
    #[arg(long)]
    pub fade_detail: bool,

    /// Multiply the wrinkles by this gain, from 0 to 2.
    #[arg(long, value_name = "GAIN", default_value_t = 1.0, value_parser = parse_gain)]
    pub detail: f64,

    /// How far to go.
    #[arg(long, value_enum, default_value_t = StageChoice::Full)]
    pub stage: StageChoice,

    /// The device to evaluate on, as `rhytid devices` names it. auto takes the device that draws if it is a
    /// GPU and can draw the frames directly. Otherwise auto takes the fastest that conforms, software drivers
    /// last.
    #[arg(long, default_value = "auto")]
    pub device: String,

    /// The device to draw with, one of the backend wgpu [default: that of --device if it is one, else the
    /// first].
    #[arg(long)]
    pub draw_on: Option<String>,

    /// Leave out the connected parts of the mesh that contain these vertices, such as the film of tears
    /// before an eye.
    #[arg(long, value_name = "VERTEX", value_delimiter = ',')]
    pub hide: Vec<usize>,

    #[command(flatten)]
    pub skin: SkinLight,

    #[command(flatten)]
    pub reading: TakeReading,
}

/// `--show`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Show {
    /// Lit at every pixel.
    Shaded,
    /// Lit at every vertex.
    Gouraud,
    /// Lit by triangles.
    Flat,
    /// As skin: with light that spreads below it, shadows, and a shiny surface (--light, --exposure, --tone).
    Skin,
    /// The edges of the mesh's polygons.
    Wireframe,
    /// As a ball of clay, or the ball of --matcap, looks where its surface has the same direction.
    Matcap,
    /// Shaded, in the colours of --texture.
    Textured,
    /// Shaded, with the markers, and how much longer (red) or shorter (blue) the strain edges between them
    /// are than at rest.
    Markers,
    /// Shaded, with the strain edges (red) and anchors (blue) that drive the wrinkles of --vertex.
    Influences,
    /// Shaded, with the tangent frames of some vertices.
    Frames,
    /// How much longer (red) or shorter (blue) the skin is than at rest.
    Strain,
    /// The first principal strain, that of the direction in which the skin is stretched most.
    Strain1,
    /// The second principal strain, that of the direction in which it is squeezed most, or stretched least.
    Strain2,
    /// How far the wrinkles move each vertex.
    Detail,
    /// How far each vertex may be from where a scan of the frame would put it.
    Sigma,
    /// How far each vertex is from its place in --compare.
    Error,
}

impl Show {
    /// Whether the host must compute it from a frame, beyond positions and normals.
    pub(crate) fn is_made_on_the_host(self) -> bool {
        !matches!(
            self,
            Self::Shaded
                | Self::Gouraud
                | Self::Flat
                | Self::Skin
                | Self::Wireframe
                | Self::Matcap
                | Self::Textured
        )
    }

    /// `None` for skin, and for the ones that show numbers.
    pub(crate) fn look(self) -> Option<Look> {
        match self {
            Self::Shaded | Self::Markers | Self::Influences | Self::Frames => Some(Look::Smooth),
            Self::Gouraud => Some(Look::Gouraud),
            Self::Flat => Some(Look::Flat),
            Self::Wireframe => Some(Look::Wireframe),
            Self::Matcap => Some(Look::Matcap),
            Self::Textured => Some(Look::Textured),
            Self::Skin
            | Self::Strain
            | Self::Strain1
            | Self::Strain2
            | Self::Detail
            | Self::Sigma
            | Self::Error => None,
        }
    }
}

/// `--before`
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum BeforeChoice {
    Stage(StageChoice),
    Rig(PathBuf),
}

impl BeforeChoice {
    /// The rig's file, if it is one.
    pub(crate) fn rig(&self) -> Option<&Path> {
        match self {
            Self::Stage(_) => None,
            Self::Rig(path) => Some(path),
        }
    }

    /// The choice as on the command line.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Stage(stage) => {
                stage.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
            }
            Self::Rig(path) => path.display().to_string(),
        }
    }
}

fn parse_before(text: &str) -> Result<BeforeChoice, String> {
    match text {
        "shell" => Ok(BeforeChoice::Stage(StageChoice::Shell)),
        "large-scale" => Ok(BeforeChoice::Stage(StageChoice::LargeScale)),
        file if file.contains('.') => Ok(BeforeChoice::Rig(file.into())),
        _ => Err("expected shell, large-scale or a rig file".to_owned()),
    }
}

/// `--background`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Background(pub [u8; 4]);

fn parse_background(text: &str) -> Result<Background, String> {
    let number = (text.len() == 6).then(|| u32::from_str_radix(text, 16).ok()).flatten();
    match (text, number) {
        ("none", _) => Ok(Background([0; 4])),
        (_, Some(number)) => {
            let [_, r, g, b] = number.to_be_bytes();
            Ok(Background([r, g, b, 255]))
        }
        _ => Err("expected six digits such as 20a0ff, or none".to_owned()),
    }
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let number = |text: &str| text.parse().ok().filter(|n| (1..=32_768).contains(n));
    text.split_once('x')
        .and_then(|(width, height)| Some([number(width)?, number(height)?]))
        .ok_or_else(|| "expected width x height in pixels, each 1 to 32768, such as 1280x720".to_owned())
}

fn parse_angle(text: &str) -> Result<f32, String> {
    let angle = text.parse().ok().filter(|x: &f32| x.abs() <= 360.0);
    angle.ok_or_else(|| "expected degrees from -360 to 360".to_owned())
}

fn parse_lens(text: &str) -> Result<f32, String> {
    let lens = text.parse().ok().filter(|x| (8.0..=2000.0).contains(x));
    lens.ok_or_else(|| "expected millimetres from 8 to 2000".to_owned())
}

fn parse_range(text: &str) -> Result<f32, String> {
    let range = text.parse().ok().filter(|x| (1e-3..=1e3).contains(x));
    range.ok_or_else(|| "expected a number from 0.001 to 1000".to_owned())
}
