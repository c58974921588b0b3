//! `rhytid info`: one file per kind of file.

mod animation;
mod project;
mod raw_take;
mod rig;
mod shape;
mod take;

use crate::{args, output};
use animation::AnimationInfo;
use project::ProjectInfo;
use raw_take::RawTakeInfo;
use rhytid::formats::{mesh, tables};
use rhytid::human;
use rhytid::{Error, Handles, Result, rig_file};
use rig::RigInfo;
use serde::Serialize;
use shape::{Shape, list, row};
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
    Handles(HandlesInfo),
    Project(ProjectInfo),
}

#[derive(Serialize)]
struct HandlesInfo {
    handles: usize,
    labels: Vec<String>,
    handle_vertices: Vec<u32>,
}

/// Prints what is in a file.
///
/// # Errors
/// [`Error::Input`] if the file is not whole or of no known kind; [`Error::Io`].
pub(super) fn run(args: &args::Info) -> Result<()> {
    let file_bytes = std::fs::metadata(&args.file).map_err(Error::io(&args.file))?.len();
    let info = Info { file: args.file.display().to_string(), file_bytes, content: read(&args.file)? };
    if args.json {
        return output::json(&info);
    }
    let (what, rows) = match &info.content {
        Content::Mesh(shape) => ("mesh".to_owned(), shape.rows("mesh units")),
        Content::Animation(file) => (format!("animation of “{}”", file.name), file.rows()),
        Content::Rig(rig) => (format!("rig of “{}”", rig.name), rig.rows()),
        Content::Take(take) => ("take".to_owned(), take.rows()),
        Content::RawTake(take) => ("raw take".to_owned(), take.rows()),
        Content::Handles(handles) => ("handle table".to_owned(), vec![row("handles", list(&handles.labels))]),
        Content::Project(project) => (format!("project of “{}”", project.name), project.rows()),
    };
    let title = format!("{}: {what}, {}", info.file, human::bytes(info.file_bytes));
    output::say(&format!("{title}\n{}", output::table(&rows)))
}

fn read(path: &Path) -> Result<Content> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    Ok(match ending.as_str() {
        "usd" | "usda" | "usdc" | "usdz" => Content::Animation(Box::new(AnimationInfo::read(path)?)),
        "glb" | "gltf" => match AnimationInfo::read(path) {
            Ok(animation) => Content::Animation(Box::new(animation)),
            // A mesh, or damaged, which its reader says better.
            Err(_) => Content::Mesh(Shape::of(&mesh::read(path)?)),
        },
        "obj" | "ply" => Content::Mesh(Shape::of(&mesh::read(path)?)),
        "safetensors" => Content::Rig(RigInfo::of(rig_file::read(path)?)),
        "csv" if is_handle_table(path)? => {
            let Handles { labels, vertices } = tables::read_handles(path)?;
            Content::Handles(HandlesInfo { handles: labels.len(), labels, handle_vertices: vertices })
        }
        "csv" if rhytid::formats::raw_take::is_take_csv(path) => Content::Take(TakeInfo::read(path)?),
        "csv" | "c3d" | "trc" | "tsv" => Content::RawTake(RawTakeInfo::read(path)?),
        "toml" => Content::Project(ProjectInfo::of(rhytid::formats::project::read(path)?)),
        _ => {
            return Err(Error::input(format!(
                "{}: expected a mesh (.obj, .ply, .glb, .gltf), an animation (.usd, .usda, .usdc, .usdz, .glb, .gltf), a rig \
                 (.safetensors), a take (.csv, .c3d, .trc, .tsv), a handle table (.csv) or a project (.toml)",
                path.display()
            )));
        }
    })
}

/// Takes and handle tables are both CSV; a take's header has no column `vertex`.
fn is_handle_table(path: &Path) -> Result<bool> {
    let mut start = Vec::new();
    let file = std::fs::File::open(path).map_err(Error::io(path))?;
    file.take(256).read_to_end(&mut start).map_err(Error::io(path))?;
    let header = start.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let header = String::from_utf8_lossy(header);
    Ok(header.split(',').any(|cell| cell.trim() == "vertex"))
}
