//! `rhytid info`: one file per kind of file.

mod animation;
mod curves;
mod project;
mod raw_take;
mod report;
mod rig;
mod shape;
mod shapes;
mod take;

use crate::args::Setup;
use crate::{args, output};
use animation::AnimationInfo;
use curves::CurvesInfo;
use project::ProjectInfo;
use raw_take::RawTakeInfo;
use report::ReportInfo;
use rhytid::core::VertexId;
use rhytid::core::human;
use rhytid::core::{Handles, Mesh, SurfacePoint, input_file, rig_file};
use rhytid::formats::raw_take::{Contents, contents};
use rhytid::formats::{Reach, mesh, tables};
use rhytid::{Error, Result};
use rig::RigInfo;
use serde::Serialize;
use shape::{Shape, list, row};
use shapes::ShapesInfo;
use std::io::Read;
use std::path::Path;
use take::TakeInfo;

/// What `--json` prints; docs/cli.md documents every key.
#[derive(Serialize)]
struct Info {
    file: String,
    file_bytes: u64,
    #[serde(flatten)]
    content: Content,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Content {
    Mesh(Shape),
    Animation(Box<AnimationInfo>),
    Rig(RigInfo),
    Take(TakeInfo),
    RawTake(RawTakeInfo),
    Curves(CurvesInfo),
    Handles(HandlesInfo),
    Project(ProjectInfo),
    Shapes(Box<ShapesInfo>),
    Markers(MarkersInfo),
    Setup(SetupInfo),
    Report(ReportInfo),
}

#[derive(Serialize)]
struct HandlesInfo {
    handles: usize,
    labels: Vec<String>,
    /// Of a handle inside a triangle, the nearest vertex of it.
    handle_vertices: Vec<VertexId>,
    inside_triangles: usize,
}

#[derive(Serialize)]
struct MarkersInfo {
    /// Pairs of handle and marker.
    markers: Vec<[String; 2]>,
}

/// What is known of an actor and a session.
#[derive(Serialize)]
struct SetupInfo {
    keys: Vec<String>,
}

/// Prints what is in a file.
///
/// # Errors
/// [`Error::Input`] if the file is damaged or of no known kind; [`Error::Io`].
pub(super) fn run(args: &args::Info) -> Result<()> {
    let file_bytes = std::fs::metadata(&args.file).map_err(Error::io(&args.file))?.len();
    let info = Info {
        file: args.file.display().to_string(),
        file_bytes,
        content: read(&args.file, args.elsewhere.reach())?,
    };
    if args.json.wanted {
        return output::json(&info);
    }
    let (what, rows) = match &info.content {
        Content::Mesh(shape) => ("mesh".to_owned(), shape.rows("mesh units")),
        Content::Animation(file) => (format!("animation of “{}”", file.name), file.rows()),
        Content::Rig(rig) => (format!("rig of “{}”", rig.name), rig.rows()),
        Content::Take(take) => ("take".to_owned(), take.rows()),
        Content::RawTake(take) => ("raw take".to_owned(), take.rows()),
        Content::Curves(curves) => ("curves".to_owned(), curves.rows()),
        Content::Handles(handles) => {
            let inside = (handles.inside_triangles > 0)
                .then(|| row("inside triangles", handles.inside_triangles.to_string()));
            let rows = [row("handles", list(&handles.labels))].into_iter().chain(inside);
            ("handle table".to_owned(), rows.collect())
        }
        Content::Shapes(file) => (format!("mesh with shapes, “{}”", file.name), file.rows("mesh units")),
        Content::Markers(table) => {
            let pairs: Vec<String> =
                table.markers.iter().map(|[handle, marker]| format!("{handle}={marker}")).collect();
            ("table of markers".to_owned(), vec![row("markers", list(&pairs))])
        }
        Content::Setup(setup) => ("setup of a take".to_owned(), vec![row("says", list(&setup.keys))]),
        Content::Report(report) => (format!("report, {}", report.of), report.rows()),
        Content::Project(project) => (format!("project of “{}”", project.name), project.rows()),
    };
    let title = format!("{}: {what}, {}", info.file, human::bytes(info.file_bytes));
    output::say(&format!("{title}\n{}", output::table(&rows)))
}

fn read(path: &Path, reach: Reach) -> Result<Content> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    Ok(match ending.as_str() {
        "usd" | "usda" | "usdc" | "usdz" => match AnimationInfo::read(path, reach) {
            Ok(animation) => Content::Animation(Box::new(animation)),
            // What is neither has the error of the animation that it may be meant as.
            Err(error) => mesh_or_shapes(path, reach).map_err(|_| error)?,
        },
        "glb" | "gltf" | "vrm" => match AnimationInfo::read(path, reach) {
            Ok(animation) => Content::Animation(Box::new(animation)),
            // A mesh, or a damaged file, whose reader gives the better error.
            Err(_) => mesh_or_shapes(path, reach)?,
        },
        "obj" | "ply" => {
            let mut neutral = mesh::read(path)?;
            give_looks(&mut neutral, path, reach)?;
            Content::Mesh(Shape::from_mesh(&neutral))
        }
        "safetensors" => {
            Content::Rig(RigInfo::from_rig(rig_file::read(path)?, rig_file::read_packing(path)?))
        }
        "json" => Content::Report(ReportInfo::read(path)?),
        "csv" if has_columns(path, &["handle", "marker"])? => {
            let pairs = tables::read_markers(path)?.into_iter();
            Content::Markers(MarkersInfo {
                markers: pairs.map(|(handle, marker)| [handle, marker]).collect(),
            })
        }
        "csv" if has_columns(path, &["vertex"])? => {
            let Handles { labels, points } = tables::read_handles(path)?;
            Content::Handles(HandlesInfo {
                handles: labels.len(),
                labels,
                handle_vertices: points.iter().map(SurfacePoint::nearest_vertex).collect(),
                inside_triangles: points.iter().filter(|point| point.vertex().is_none()).count(),
            })
        }
        "csv" => match contents(path) {
            Contents::Take => Content::Take(TakeInfo::read(path)?),
            Contents::Raw => Content::RawTake(RawTakeInfo::read(path)?),
            Contents::Curves => Content::Curves(CurvesInfo::read(path)?),
        },
        "c3d" | "trc" | "tsv" => Content::RawTake(RawTakeInfo::read(path)?),
        "toml" if is_setup(path) => {
            let setup = Setup::read(path, reach)?;
            setup.clean_up()?;
            Content::Setup(SetupInfo { keys: setup_keys(path)? })
        }
        "toml" => Content::Project(ProjectInfo::read(path, reach)?),
        _ => {
            return Err(Error::unsupported_format(format!(
                "{}: expected a mesh (.obj, .ply, .glb, .gltf), an animation (.usd, .usda, .usdc, .usdz, .glb, .gltf), a rig \
                 (.safetensors), a take (.csv, .c3d, .trc, .tsv), a table of handles or of markers (.csv), a project or a take's setup (.toml) or a \
                 report (.json)",
                path.display()
            )));
        }
    })
}

/// Gives the materials of a mesh, which was read from `path`, their looks.
fn give_looks(neutral: &mut Mesh, path: &Path, reach: Reach) -> Result<()> {
    if let Some(materials) = &mut neutral.materials {
        mesh::read_looks(path, reach)?.give_to(materials);
    }
    Ok(())
}

/// A mesh, with its shapes if it has some.
fn mesh_or_shapes(path: &Path, reach: Reach) -> Result<Content> {
    let mut read = mesh::read_shapes(path)?;
    give_looks(&mut read.neutral, path, reach)?;
    Ok(match read.shapes.is_empty() {
        true => Content::Mesh(Shape::from_mesh(&read.neutral)),
        false => Content::Shapes(Box::new(ShapesInfo::new(path, &read))),
    })
}

/// Whether a TOML file is TAKE.toml rather than a project, which has a mesh.
fn is_setup(path: &Path) -> bool {
    setup_keys(path)
        .is_ok_and(|keys| !keys.is_empty() && !keys.iter().any(|key| key == "mesh" || key == "handles"))
}

/// The keys at the top of a TOML file.
fn setup_keys(path: &Path) -> Result<Vec<String>> {
    let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
    let text = String::from_utf8_lossy(&bytes);
    let table: toml::Table =
        text.parse().map_err(|error| Error::malformed(format!("{}: {error}", path.display())))?;
    Ok(table.keys().cloned().collect())
}

/// Tables and takes are all CSV: their headers tell them apart.
fn has_columns(path: &Path, columns: &[&str]) -> Result<bool> {
    let mut start = Vec::new();
    let file = std::fs::File::open(path).map_err(Error::io(path))?;
    file.take(256).read_to_end(&mut start).map_err(Error::io(path))?;
    let header = start.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let header = String::from_utf8_lossy(header);
    Ok(columns.iter().all(|column| header.split(',').any(|cell| cell.trim() == *column)))
}
