//! `rhytid render`

use super::fine_detail::FineDetail;
use super::placing::TakeReading;
use super::skin::SkinLight;
use super::values::{Json, StageChoice, parse_rate};
use super::{CAMERA, DEVICE, INPUT, OUTPUT, SHOW};
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

    /// The picture or film: .png, .mp4 or .webp.
    ///
    /// A .png is a sheet of frames, or a picture for each frame if its name contains {frame}. An .mp4 is a
    /// film of all frames (AV1), a .webp a lossless moving picture.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    pub output: PathBuf,

    /// The frames A to B-1, counted from 0; either end may be left out.
    #[arg(long, value_name = "A..B", default_value = "..", hide_default_value = true, help_heading = OUTPUT)]
    pub frames: FrameRange,

    /// Resample to N frames per second, as `animate` does [default: the take's rate].
    ///
    /// A film of 60 frames per second takes half the time with --fps 30.
    #[arg(long, value_name = "N", value_parser = parse_rate, conflicts_with = "compare", help_heading = OUTPUT)]
    pub fps: Option<f64>,

    /// The frames of a sheet, spread evenly over --frames.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=400), help_heading = OUTPUT)]
    pub count: u32,

    /// Pixels of each picture [default: 720x960, on a sheet 300x400].
    #[arg(long, value_name = "WxH", value_parser = parse_size, help_heading = OUTPUT)]
    pub size: Option<[u32; 2]>,

    /// RRGGBB, or none for transparent [default: a sheet's paper].
    #[arg(long, value_name = "COLOUR", value_parser = parse_background, help_heading = OUTPUT)]
    pub background: Option<Background>,

    /// What to show, side by side [default: shaded].
    ///
    /// With --compare the default is shaded,error.
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "shaded",
        default_value_if("compare", ArgPredicate::IsPresent, "shaded,error"),
        hide_default_value = true,
        help_heading = SHOW
    )]
    pub show: Vec<Show>,

    /// To the left of each: an earlier stage, or another rig.
    #[arg(long, value_name = "shell|large-scale|RIG", value_parser = parse_before, help_heading = SHOW)]
    pub before: Option<BeforeChoice>,

    /// The vertex of --show influences, counted from 0.
    #[arg(long, value_name = "N", help_heading = SHOW)]
    pub vertex: Option<usize>,

    /// The picture of a ball for --show matcap [default: clay].
    #[arg(long, value_name = "IMAGE", help_heading = SHOW)]
    pub matcap: Option<PathBuf>,

    /// The image of --show textured [default: the looks in the rig].
    ///
    /// It is a PNG or JPEG, or an .obj, .mtl, .glb, .gltf or .usd whose materials name images.
    #[arg(long, value_name = "FILE", help_heading = SHOW)]
    pub texture: Option<PathBuf>,

    /// Leave out the parts of the mesh with these vertices.
    ///
    /// A part is connected. An example is the film of tears before an eye.
    #[arg(long, value_name = "VERTEX", value_delimiter = ',', help_heading = SHOW)]
    pub hide: Vec<usize>,

    /// The last colour of --show strain, relative to the rest.
    #[arg(long, value_name = "PART", default_value_t = 0.3, value_parser = parse_range, help_heading = SHOW)]
    pub strain_range: f32,

    /// The last colour of --show detail, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = parse_range, help_heading = SHOW)]
    pub detail_range: f32,

    /// The last colour of --show sigma, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 2.0, value_parser = parse_range, help_heading = SHOW)]
    pub sigma_range: f32,

    /// The last colour of --show error, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = parse_range, help_heading = SHOW)]
    pub error_range: f32,

    /// Draw maps without light, in exactly the colours of the legend.
    #[arg(long, help_heading = SHOW)]
    pub unlit: bool,

    #[command(flatten)]
    pub skin: SkinLight,

    /// From the face's left (positive) or right, in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_angle, help_heading = CAMERA)]
    pub turn: f32,

    /// From above (positive) or below, within 90 degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_angle, help_heading = CAMERA)]
    pub raise: f32,

    /// Show the whole mesh, and not only the part around the handles.
    #[arg(long, help_heading = CAMERA)]
    pub whole: bool,

    /// Go once around the face while the frames go by.
    ///
    /// Around a single frame, the camera goes in --count steps.
    #[arg(long, help_heading = CAMERA)]
    pub turntable: bool,

    /// Focal length, for film of 36 x 24 mm.
    #[arg(long, value_name = "MM", default_value_t = 85.0, value_parser = parse_lens, help_heading = CAMERA)]
    pub lens: f32,

    /// Edits of the take.
    ///
    /// docs/edits.md describes them.
    #[arg(long, value_name = "EDIT.toml", help_heading = INPUT)]
    pub edit: Option<PathBuf>,

    /// Dense meshes of the true face, as for `evaluate --truth`.
    #[arg(long, value_name = "TRUTH", help_heading = INPUT)]
    pub compare: Option<PathBuf>,

    /// The frames that --compare has, as a column frame [default: all].
    #[arg(long, value_name = "FRAMES.csv", requires = "compare", help_heading = INPUT)]
    pub truth_frames: Option<PathBuf>,

    #[command(flatten)]
    pub reading: TakeReading,

    #[command(flatten)]
    pub fine_detail: FineDetail,

    /// The device to evaluate on, as `rhytid devices` names it.
    ///
    /// auto takes the device that draws if it is a GPU and can draw the frames directly. Otherwise auto takes
    /// the fastest that conforms, software drivers last.
    #[arg(long, default_value = "auto", help_heading = DEVICE)]
    pub device: String,

    /// The device to draw with, of the backend wgpu.
    ///
    /// By default it is that of --device if it is one of wgpu, else the first.
    #[arg(long, help_heading = DEVICE)]
    pub draw_on: Option<String>,

    #[command(flatten)]
    pub json: Json,
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
