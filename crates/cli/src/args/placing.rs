//! Flags of the commands that make a project from other people's files.

use super::setup::Setup;
use super::values::{
    Elsewhere, Json, MissingChoice, ShapesChoice, UnitChoice, parse_mesh_unit, parse_rate, parse_shapes,
};
use super::{INPUT, SPACE};
use crate::output::word;
use rhytid::Error;
use rhytid::capture::Axes;
use rhytid::formats::export::Treatment;
use rhytid::formats::project::Units;
use rhytid::formats::raw_take::{self, Contents};
use rhytid::formats::take::Missing;
use rhytid::playback::shapes_hash;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Which markers of a take become handles, and what is known of their places.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Placement {
    /// The take's frame near the neutral face, counted from 0, or auto: of the start, the end and a typical
    /// frame, the one that fits the mesh best.
    #[arg(long, value_name = "N", default_value = "auto")]
    pub frame: FrameChoice,

    /// A marker or handle whose vertex is known, and kept; can be given many times. Three or more say where
    /// the face is.
    #[arg(long, value_name = "LABEL=VERTEX")]
    pub at: Vec<LabelAt>,

    /// Markers that are on no skin [default: those that keep their distances and are off the mesh].
    #[arg(long, value_name = "A,B,C", value_delimiter = ',')]
    pub rigid: Option<Vec<String>>,

    /// The actor whose markers count: what stands before the colon of their labels [default: all markers
    /// count].
    #[arg(long, value_name = "ACTOR")]
    pub subject: Option<String>,

    /// The take's frames per second [default: what the file says].
    #[arg(long, value_name = "N", value_parser = parse_rate)]
    pub rate: Option<f64>,
}

impl Placement {
    /// These options as they were given, with a blank before each, to be given again. The frame and the known
    /// vertices are left out.
    pub(crate) fn again(&self) -> String {
        let Self { frame: _, at: _, rigid, subject, rate } = self;
        let rigid = rigid.as_ref().map(|labels| labels.join(","));
        let rate = rate.map(|rate| rate.to_string());
        let given = [("--rigid", rigid), ("--subject", subject.clone()), ("--rate", rate)];
        given.into_iter().map(|(option, value)| again(option, value)).collect()
    }
}

/// An option as it was given, with a blank before it; empty if it was not given.
pub(crate) fn again(option: &str, value: Option<impl AsRef<Path>>) -> String {
    value.map_or_else(String::new, |value| format!(" {option} {}", word(value.as_ref())))
}

/// `rhytid handles`
#[derive(Debug, clap::Args)]
pub(crate) struct Handles {
    /// The project file; its table of handles need not be there yet.
    pub project: PathBuf,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    /// The take whose markers are to be found on the mesh.
    #[arg(required_unless_present = "count", conflicts_with = "count")]
    pub take: Option<PathBuf>,

    /// Without a take: so many handles, spread over the front of the face.
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(4..=4096),
        conflicts_with_all = ["frame", "rigid", "subject", "unit", "rate"]
    )]
    pub count: Option<u32>,

    #[command(flatten)]
    pub placement: Placement,

    /// The part of the mesh that is the head: an object, a group or a material [default: the one that
    /// examples move, or that has the name or the shape of a head].
    #[arg(long, value_name = "NAME")]
    pub part: Option<String>,

    /// The take's unit [default: what the file says, or what fits the mesh's size].
    #[arg(long, value_enum)]
    pub unit: Option<UnitChoice>,

    /// The table to write [default: the one that the project file names, if it is not there yet].
    #[arg(short, long, value_name = "markers.csv")]
    pub output: Option<PathBuf>,

    /// The picture to write [default: beside the table, under its name with .png].
    #[arg(long, value_name = "PICTURE.png")]
    pub picture: Option<PathBuf>,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid new`
#[derive(Debug, clap::Args)]
pub(crate) struct New {
    /// The neutral scan.
    pub neutral: PathBuf,

    /// The folder to write the project to; made if it does not exist [default: the neutral's].
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,

    /// The expressions: a folder of meshes or of files with shapes, or one such file [default: poses,
    /// examples, expressions or scans beside the neutral, or its own].
    #[arg(long, value_name = "PLACE")]
    pub examples: Option<PathBuf>,

    /// The take whose markers become handles [default: one beside the neutral; else handles are spread over
    /// the face].
    #[arg(long, value_name = "TAKE")]
    pub take: Option<PathBuf>,

    #[command(flatten)]
    pub placement: Placement,

    /// Shapes of glTF and USD files to take as examples, such as "mouth*,jawOpen" [default: all].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub shapes: Vec<String>,

    /// The part of the neutral that is the head: an object, a group or a material [default: the one that
    /// examples move, or that has the name or the shape of a head].
    #[arg(long, value_name = "NAME")]
    pub part: Option<String>,

    /// The neutral's unit: mm, cm, m, in, or the metres in one unit [default: the one that its file states,
    /// else the one in which it has the size of a head].
    #[arg(long, value_name = "UNIT", value_parser = parse_mesh_unit)]
    pub unit: Option<Units>,

    #[command(flatten)]
    pub json: Json,
}

/// The space of a take's CSV that is not in the rig's space; each option is exact.
#[derive(Debug, Clone, Default, PartialEq, clap::Args)]
pub(crate) struct TakeSpace {
    /// The unit of a take's CSV [default: the mesh's].
    #[arg(long, value_enum, value_name = "UNIT", help_heading = SPACE)]
    pub take_unit: Option<UnitChoice>,

    /// Its axes, such as +x+z-y [default: the mesh's].
    ///
    /// They are the axes of the CSV that the mesh's x, y and z are. -x+y+z is a mirror image.
    #[arg(long, value_name = "AXES", allow_hyphen_values = true, help_heading = SPACE)]
    pub take_axes: Option<Axes>,

    /// Its frames per second, if its times are not seconds.
    #[arg(long, value_name = "N", value_parser = parse_rate, help_heading = SPACE)]
    pub take_rate: Option<f64>,
}

/// How to read a take that a rig plays.
#[derive(Debug, Clone, Default, PartialEq, clap::Args)]
pub(crate) struct TakeReading {
    /// What to do where a marker is missing.
    #[arg(long, value_enum, default_value_t = MissingChoice::Error, help_heading = INPUT)]
    pub missing: MissingChoice,

    /// For a raw take: actor and session, as for `prepare`.
    #[arg(long, value_name = "TAKE.toml", help_heading = INPUT)]
    pub setup: Option<PathBuf>,

    /// For curves: the shapes that they weigh [default: the rig's examples]. For `animate` also N.
    ///
    /// SHAPES is a glTF or USD file with blend shapes, a folder of meshes, a pattern of their names, a
    /// project file, or another rig. --shapes N of `animate` writes the take as N shapes with curves, in USD
    /// or glTF. This is for game engines and for shape keys. The error is not limited. It is printed and
    /// written to the file. Both can be given.
    #[arg(long, value_name = "SHAPES|N", value_parser = parse_shapes, help_heading = INPUT)]
    pub shapes: Vec<ShapesChoice>,

    /// Take the noise of the markers out; they are then met within their noise, not exactly.
    #[arg(long, help_heading = INPUT)]
    pub soft_markers: bool,

    /// Go on in spite of an error that names this option.
    #[arg(long, help_heading = INPUT)]
    pub force: bool,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    #[command(flatten)]
    pub space: TakeSpace,
}

impl TakeReading {
    /// The shapes that curves weigh.
    pub(crate) fn shapes_of_curves(&self) -> Option<&Path> {
        self.shapes.iter().rev().find_map(|choice| match choice {
            ShapesChoice::Of(path) => Some(path.as_path()),
            ShapesChoice::Write(_) => None,
        })
    }

    /// The number of shapes to write.
    pub(crate) fn shapes_to_write(&self) -> Option<usize> {
        self.shapes.iter().rev().find_map(|choice| match choice {
            ShapesChoice::Write(number) => Some(*number),
            ShapesChoice::Of(_) => None,
        })
    }

    /// These options as the recipe of an animation file states them for a take.
    ///
    /// # Errors
    /// As [`Setup::read`] and reading the table that it names.
    pub(crate) fn treatment(&self, take: Option<&Path>) -> rhytid::Result<Treatment> {
        // What a setup says about a clean take is a separate part of the recipe.
        let contents = take.map(raw_take::contents);
        let setup = self.setup.as_deref().filter(|_| contents == Some(Contents::Raw));
        let setup_hash = setup.map(|setup| Setup::hash(setup, self.elsewhere.reach()));
        Ok(Treatment {
            metres_per_unit: self.space.take_unit.map(UnitChoice::metres),
            axes: self.space.take_axes.map(|axes| axes.to_string()),
            rate: self.space.take_rate,
            setup_hash: setup_hash.transpose()?,
            shapes_hash: self.shapes_of_curves().map(shapes_hash).transpose()?,
            soft_markers: self.soft_markers,
        })
    }

    /// The same take, read as a file's recipe states it. If these options name another space, they win: the
    /// take may be in another file by now.
    ///
    /// [`Error::Input`] if the setup differs, or if the recipe has a unit or axes that this program does not
    /// know.
    pub(crate) fn with_stated(
        mut self,
        take: &Path,
        missing: Missing,
        stated: &Treatment,
    ) -> rhytid::Result<Self> {
        let unknown = |what: String| {
            Error::unsupported_version(format!(
                "was made with {what}, which this program does not know; export it again"
            ))
        };
        self.missing = match missing {
            Missing::Error => MissingChoice::Error,
            Missing::Hold => MissingChoice::Hold,
            Missing::Leave => return Err(unknown("missing = \"leave\"".into())),
        };
        self.soft_markers = stated.soft_markers;
        let given = self.treatment(Some(take))?;
        match (&given.setup_hash, &stated.setup_hash) {
            (given, stated) if given == stated => {}
            // Older files do not say.
            (Some(_), None) => {}
            (None, _) => {
                return Err(Error::mismatch("was made with a setup; give the same with --setup TAKE.toml"));
            }
            (Some(_), Some(_)) => {
                return Err(Error::mismatch(
                    "was made with another setup, or another table of markers that it names",
                ));
            }
        }
        if given.shapes_hash != stated.shapes_hash {
            return Err(Error::mismatch(match (&given.shapes_hash, &stated.shapes_hash) {
                (None, _) => "was made with shapes that curves weigh; give the same with --shapes SHAPES",
                (_, None) => "was made without other shapes than the rig's examples; leave --shapes out",
                _ => "was made with other shapes, or one of their files has changed",
            }));
        }
        let is_given = given.metres_per_unit.is_some() || given.axes.is_some() || given.rate.is_some();
        if !is_given {
            let unit = |metres: f64| {
                UnitChoice::of_metres(metres).ok_or_else(|| unknown(format!("a take in units of {metres} m")))
            };
            let axes =
                |axes: &String| axes.parse().map_err(|_| unknown(format!("a take along the axes {axes}")));
            self.space = TakeSpace {
                take_unit: stated.metres_per_unit.map(unit).transpose()?,
                take_axes: stated.axes.as_ref().map(axes).transpose()?,
                take_rate: stated.rate,
            };
        }
        Ok(self)
    }
}

/// A frame, or the one that suits best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FrameChoice(pub Option<usize>);

impl FromStr for FrameChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self(None)),
            _ => text
                .parse()
                .map(|frame| Self(Some(frame)))
                .map_err(|_| "expected a frame, counted from 0, or auto".into()),
        }
    }
}

/// A label and a vertex.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct LabelAt {
    pub label: String,
    pub vertex: u32,
}

impl FromStr for LabelAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (label, vertex) = text.split_once('=').filter(|(label, _)| !label.is_empty()).unwrap_or_default();
        let vertex =
            vertex.parse().map_err(|_| "expected LABEL=VERTEX, the vertex counted from 0".to_owned())?;
        Ok(Self { label: label.to_owned(), vertex })
    }
}
