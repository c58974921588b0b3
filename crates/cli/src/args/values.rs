//! The values of flags that are more than a number or a path.

use super::{GLOBAL, INPUT};
use clap::ValueEnum;
use rhytid::BasisStorage;
use rhytid::core::{LengthUnit, Method};
use rhytid::formats::Reach;
use rhytid::formats::export::{HeadMotion, OutputStage, TextureFiles};
use rhytid::formats::project::Units;
use rhytid::playback::FrameRange;
use serde::Deserialize;
use std::path::PathBuf;
use std::str::FromStr;

/// `--allow-elsewhere`
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::Args)]
pub(crate) struct Elsewhere {
    /// Let files name other files outside their own folder.
    ///
    /// Use it for files of people you trust.
    #[arg(long, help_heading = INPUT)]
    allow_elsewhere: bool,
}

impl Elsewhere {
    /// The option as it was given, with a blank before it, to be given to another command.
    pub(crate) fn again(self) -> &'static str {
        if self.allow_elsewhere { " --allow-elsewhere" } else { "" }
    }

    /// Where the files that other files name may be.
    pub(crate) fn reach(self) -> Reach {
        if self.allow_elsewhere { Reach::Anywhere } else { Reach::Below }
    }
}

/// `--json`
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(crate) struct Json {
    /// Print JSON.
    ///
    /// docs/cli.md lists the keys.
    #[arg(long = "json", help_heading = GLOBAL)]
    pub wanted: bool,
}

/// `--stage`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StageChoice {
    /// The thin shell alone, before any example is used.
    Shell,
    /// The smooth deformation with its learned linear band, without wrinkles.
    LargeScale,
    /// Everything, with the wrinkles of the examples.
    Full,
}

/// `--storage`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StorageChoice {
    /// As the rig has it.
    F32,
    /// Rounded to fp16.
    F16,
    /// In clusters of vertices, as two factors: never off by more than 0.005 mm for 30 mm of motion.
    Clustered,
}

impl From<StorageChoice> for BasisStorage {
    fn from(choice: StorageChoice) -> Self {
        match choice {
            StorageChoice::F32 => Self::F32,
            StorageChoice::F16 => Self::F16,
            StorageChoice::Clustered => Self::Clustered,
        }
    }
}

/// `--method`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodChoice {
    /// The default method of `solve`, in turns with the chapter's.
    Learned,
    /// The chapter's alone.
    Chapter,
}

impl From<MethodChoice> for Method {
    fn from(choice: MethodChoice) -> Self {
        match choice {
            MethodChoice::Learned => Self::default(),
            MethodChoice::Chapter => Self::Chapter,
        }
    }
}

/// `--materials`
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MaterialsChoice {
    /// A primitive for each material, over the same vertices.
    #[default]
    Each,
    /// One primitive with one material, for viewers that keep the morph targets once for each primitive.
    One,
}

/// `--textures`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TexturesChoice {
    /// Copies beside the file, with a hash in their names.
    Copy,
    /// Inside the file.
    Embed,
    /// The files of the neutral, by the paths that it names.
    Refer,
    /// No textures.
    None,
}

impl From<TexturesChoice> for TextureFiles {
    fn from(choice: TexturesChoice) -> Self {
        match choice {
            TexturesChoice::Copy => Self::Copy,
            TexturesChoice::Embed => Self::Embed,
            TexturesChoice::Refer => Self::Refer,
            TexturesChoice::None => Self::None,
        }
    }
}

/// `--missing`
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum MissingChoice {
    /// Keep the marker where it was last seen.
    Hold,
    /// Stop and name frame and marker.
    #[default]
    Error,
}

/// `--unit`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum UnitChoice {
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    In,
    /// Feet.
    Ft,
}

impl UnitChoice {
    /// Its name, as the option has it.
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// The unit of so many metres.
    pub(crate) fn of_metres(metres: f64) -> Option<Self> {
        Self::value_variants().iter().copied().find(|unit| unit.metres() == metres)
    }

    /// In metres.
    pub(crate) fn metres(self) -> f64 {
        match self {
            UnitChoice::Mm => 1e-3,
            UnitChoice::Cm => 1e-2,
            UnitChoice::M => 1.0,
            UnitChoice::In => 0.0254,
            UnitChoice::Ft => 0.3048,
        }
    }
}

/// `--unit` of a mesh: a name as in a project file, or a number of metres.
pub(super) fn parse_mesh_unit(text: &str) -> Result<Units, String> {
    let number = || text.parse().ok().filter(|metres: &f64| *metres > 0.0 && metres.is_finite());
    if let Some(units) = Units::named(text) {
        return Ok(units);
    }
    // A project file has feet as a number.
    let metres = LengthUnit::named(text).map(|unit| unit.metres).or_else(number);
    let metres = metres.ok_or("expected m, cm, mm, in, ft or a number above 0, the metres in one unit")?;
    Ok(Units::MetresPerUnit(metres))
}

/// `--skip`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StepChoice {
    /// The head's motion stays in.
    Head,
    /// The head's motion is not smoothed.
    HeadLowPass,
    /// The markers stay where the file has them, in the mesh's unit and axes.
    Align,
    /// The rig keeps its proportions: the actor's are assumed to be the same.
    Proportions,
    /// Swapped labels are not looked for.
    Swaps,
    /// Outliers are kept.
    Outliers,
    /// Labels that slide off their markers are kept.
    Slides,
    /// Gaps stay: they are empty cells in the written take.
    Gaps,
    /// The markers are not filtered.
    LowPass,
}

impl From<StepChoice> for rhytid::capture::Step {
    fn from(choice: StepChoice) -> Self {
        match choice {
            StepChoice::Head => Self::Head,
            StepChoice::HeadLowPass => Self::HeadLowPass,
            StepChoice::Align => Self::Align,
            StepChoice::Proportions => Self::Proportions,
            StepChoice::Swaps => Self::Swaps,
            StepChoice::Outliers => Self::Outliers,
            StepChoice::Slides => Self::Slides,
            StepChoice::Gaps => Self::Gaps,
            StepChoice::LowPass => Self::LowPass,
        }
    }
}

/// `--head`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum HeadChoice {
    /// As a transform in the file, which the mesh moves with as a whole.
    Keep,
    /// As if the head never moved.
    Drop,
    /// In every position, normal and velocity; the file has no transform.
    Bake,
}

impl From<HeadChoice> for HeadMotion {
    fn from(choice: HeadChoice) -> Self {
        match choice {
            HeadChoice::Keep => Self::Keep,
            HeadChoice::Drop => Self::Drop,
            HeadChoice::Bake => Self::Bake,
        }
    }
}

impl From<StageChoice> for OutputStage {
    fn from(choice: StageChoice) -> Self {
        match choice {
            StageChoice::Full => Self::Full,
            StageChoice::LargeScale => Self::LargeScale,
            StageChoice::Shell => Self::Shell,
        }
    }
}

impl From<MissingChoice> for rhytid::formats::take::Missing {
    fn from(choice: MissingChoice) -> Self {
        match choice {
            MissingChoice::Hold => Self::Hold,
            MissingChoice::Error => Self::Error,
        }
    }
}

/// Frames or oscillations per second.
pub(super) fn rate(number: f64) -> Result<f64, String> {
    let is_sound = (0.01..=10_000.0).contains(&number);
    if is_sound { Ok(number) } else { Err("expected a number per second, from 0.01 to 10000".to_owned()) }
}

/// For `--fps`, `--rate` and cut-offs: a number, or a fraction such as 30000/1001.
pub(super) fn parse_rate(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().unwrap_or(f64::NAN);
    rate(match text.split_once('/') {
        Some((frames, seconds)) => number(frames) / number(seconds),
        None => number(text),
    })
}

/// For `--detail`.
pub(super) fn parse_gain(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|gain| (0.0..=2.0).contains(gain))
        .ok_or_else(|| "expected a number from 0 to 2".to_owned())
}

/// What `--shapes` says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ShapesChoice {
    /// The number of shapes that `animate` writes.
    Write(usize),
    /// The shapes that curves weigh.
    Of(PathBuf),
}

/// For `--shapes`.
pub(super) fn parse_shapes(text: &str) -> Result<ShapesChoice, String> {
    match text.parse::<f64>() {
        Ok(_) => {
            let number = text.parse().ok().filter(|n| *n > 0).map(ShapesChoice::Write);
            number.ok_or_else(|| "expected a whole number of shapes, 1 or more".to_owned())
        }
        Err(_) => Ok(ShapesChoice::Of(text.into())),
    }
}

/// A time that may be 0.
pub(super) fn seconds(number: f64) -> Result<f64, String> {
    let is_sound = (0.0..=1e6).contains(&number);
    if is_sound { Ok(number) } else { Err("expected seconds, from 0 to 1000000".to_owned()) }
}

/// For `--max-gap`.
pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    seconds(text.parse().unwrap_or(f64::NAN))
}

/// `--map`
pub(super) fn parse_pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((handle, label)) if !handle.is_empty() && !label.is_empty() => Ok((handle.into(), label.into())),
        _ => Err("expected a handle and the label of its marker, such as chin=M12".to_owned()),
    }
}

/// `--filter`
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FilterChoice {
    /// No filter.
    None,
    /// A low-pass filter with this cut-off in Hz.
    LowPass(f64),
}

impl FromStr for FilterChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => Ok(Self::None),
            text => parse_rate(text)
                .map(Self::LowPass)
                .map_err(|_| "expected none, or a cut-off in Hz, from 0.01 to 10000".to_owned()),
        }
    }
}

/// A part of a take in which one marker, or two, are repaired by hand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Stretch<const N: usize> {
    /// The markers.
    pub labels: [String; N],
    /// The frames.
    pub frames: FrameRange,
}

impl<const N: usize> FromStr for Stretch<N> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = if N == 1 {
            "LABEL:A..B, such as chin:120..160"
        } else {
            "A,B:FROM..TO, such as lip1,lip2:900..940"
        };
        let expected = || format!("expected {form}");
        let (labels, frames) = text.rsplit_once(':').ok_or_else(expected)?;
        // A single label may contain a comma.
        let labels: Vec<String> = labels.splitn(N, ',').map(|label| label.trim().to_owned()).collect();
        let labels: [String; N] = labels.try_into().map_err(|_| expected())?;
        if labels.iter().any(String::is_empty) || (N > 1 && labels[0] == labels[N - 1]) {
            return Err(expected());
        }
        Ok(Self { labels, frames: frames.parse()? })
    }
}

impl<const N: usize> Stretch<N> {
    /// The frames, which end with the take where no end is given.
    pub(super) fn range(&self) -> std::ops::Range<usize> {
        self.frames.start.unwrap_or(0)..self.frames.end.unwrap_or(usize::MAX)
    }
}

/// `--detail-of`
pub(super) fn parse_region(text: &str) -> Result<(String, f64), String> {
    let parts = text.rsplit_once('=').filter(|(region, _)| !region.is_empty() && !region.contains(';'));
    let (region, number) =
        parts.ok_or_else(|| "expected a region and a gain, such as brows=0.5".to_owned())?;
    Ok((region.to_owned(), parse_gain(number)?))
}

/// `--pose`
pub(super) fn parse_pose(text: &str) -> Result<(String, usize), String> {
    let parts = text.rsplit_once('=').filter(|(example, _)| !example.is_empty());
    parts
        .and_then(|(example, frame)| Some((example.to_owned(), frame.trim().parse().ok()?)))
        .ok_or_else(|| "expected an example and a frame of the raw take, such as smile=512".to_owned())
}

/// For `--max-error`.
pub(super) fn parse_millimetres(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if (1e-6..=1e6).contains(&error) => Ok(error),
        _ => Err("expected millimetres, from 0.000001 to 1000000".to_owned()),
    }
}
