//! The flags of commands that write USD: where the face is in the layer.

use super::OUTPUT;
use rhytid::Error;
use rhytid::formats::export::{PrimPath, Subdivision};

/// Where the face is in a USD layer, and how programs smooth it.
#[derive(Debug, clap::Args)]
pub(crate) struct UsdLayer {
    /// USD: where the face is, such as /char/anna/face [default: /NAME of the mesh].
    ///
    /// Metadata of the layer names the first of these prims as the default prim.
    #[arg(long, value_name = "PATH", value_parser = parse_path, hide_short_help = true, help_heading = OUTPUT)]
    pub prim_path: Option<PrimPath>,

    /// USD: the name of the mesh below it [default: the last name of --prim-path with _mesh].
    #[arg(long, value_name = "NAME", hide_short_help = true, help_heading = OUTPUT)]
    pub mesh_name: Option<String>,

    /// USD: the metre as the file's unit, for programs that do not read units, such as Blender 4.2.
    ///
    /// A transform scales the mesh to it. The points stay in mesh units, to the last bit.
    #[arg(long, hide_short_help = true, help_heading = OUTPUT)]
    pub metres: bool,

    /// USD: how programs subdivide the mesh before they show it.
    #[arg(long, value_enum, default_value_t = SubdivisionChoice::None, hide_short_help = true, help_heading = OUTPUT)]
    pub subdivision: SubdivisionChoice,
}

/// `--subdivision`
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum SubdivisionChoice {
    /// Not at all: the vertices are shown where they are.
    None,
    /// After Catmull and Clark: smooth, with points near the vertices.
    #[value(name = "catmullClark")]
    CatmullClark,
}

impl From<SubdivisionChoice> for Subdivision {
    fn from(choice: SubdivisionChoice) -> Self {
        match choice {
            SubdivisionChoice::None => Self::None,
            SubdivisionChoice::CatmullClark => Self::CatmullClark,
        }
    }
}

impl UsdLayer {
    /// Each of these flags, and whether it was given.
    pub(crate) fn given(&self) -> [(bool, &'static str); 4] {
        [
            (self.prim_path.is_some(), "--prim-path"),
            (self.mesh_name.is_some(), "--mesh-name"),
            (self.metres, "--metres"),
            (self.subdivision != SubdivisionChoice::None, "--subdivision"),
        ]
    }
}

fn parse_path(text: &str) -> Result<PrimPath, String> {
    text.parse().map_err(|error: Error| error.to_string())
}
