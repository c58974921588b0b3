//! `rhytid new`

mod find;
mod place;
mod text;
mod unit;

use super::placing::{Avatar, FromTake, Placed, space_options};
use crate::args::again;
use crate::progress::Ui;
use crate::{args, inputs, output};
use find::{Alike, Found, LeftOut};
use place::find_handles;
use rhytid::core::UpAxis;
use rhytid::formats::mesh::{self, Selection};
use rhytid::formats::project::{self, Project};
use rhytid::formats::{FileKind, Reach, named_file, refuse_inputs};
use rhytid::solve::head::Region;
use rhytid::solve::{ExampleSpace, Severity, examine, example_spaces};
use rhytid::{Error, Face, InputErrorKind, Result};
use serde::Serialize;
use std::path::Path;
use text::Content;

/// Writes a project file and its table of handles, and says what was decided and what comes next.
///
/// # Errors
/// [`Error::Input`] if the folder already has a project, or from the files; [`Error::Io`].
pub(super) fn run(args: &args::New, ui: &Ui) -> Result<()> {
    let kinds = [FileKind::Mesh, FileKind::Gltf, FileKind::Usd];
    inputs::expect(&args.neutral, &kinds, "rhytid new NEUTRAL.obj -o FOLDER")?;
    let folder = args.output.as_deref().or(args.neutral.parent()).unwrap_or(Path::new(""));
    let project = folder.join("face.toml");
    let table = folder.join("markers.csv");
    let picture = table.with_extension("png");
    for file in [&project, &table, &picture] {
        // A link counts too, even one that leads nowhere: what is written would land elsewhere.
        if file.symlink_metadata().is_ok() {
            return Err(Error::input(format!(
                "{}: is there already; name another folder with -o",
                file.display()
            ))
            .of_kind(InputErrorKind::WouldOverwrite { file: file.clone() }));
        }
    }
    let with_shapes = mesh::has_shapes(&args.neutral);
    let read = || mesh::read_file(&args.neutral, &Selection::default(), with_shapes);
    let neutral = ui.timed("read the neutral", read).0?;
    let Found { sections, left_out, alike } =
        ui.timed("find examples", || find::examples(args, &neutral)).0?;
    let avatar = Avatar::new(&args.neutral, &neutral, args.part.clone())?;
    let head = avatar.head_alone(&neutral.neutral)?;
    let unit = unit::unit(&neutral.neutral, neutral.space, head.as_ref(), args)?;
    let mut content = Content {
        folder,
        neutral: &args.neutral,
        units: unit.units,
        up: neutral.space.up.unwrap_or_default(),
        sections: &sections,
        keys: vec![Vec::new(); sections.len()],
    };
    let Read { face, spaces } = ui.timed("read examples", || read_face(&mut content)).0?;
    let mut placed = ui.timed("place handles", || find_handles(face, &avatar, args, ui)).0?;
    if placed.face.up_axis != content.up {
        // Examples that state their up axis stand otherwise to the neutral now.
        content.up = placed.face.up_axis;
        let face = read_face(&mut content)?.face;
        placed.face = Face { handles: placed.face.handles, ..face };
    }
    if let Some(take) = placed.take.as_ref().filter(|take| !take.found.faults.is_empty()) {
        return Err(refused(args, &placed, take, folder, ui));
    }

    // Everything is known before the first file is written.
    let text = content.text();
    let parsed = project::parse(&text, &project.display().to_string())?;
    let elsewhere = if is_elsewhere(&parsed, &project) { " --allow-elsewhere" } else { "" };
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    }
    let write = || {
        placed.write_table(&table)?;
        let is_drawn = placed.draw(&picture)?;
        output::file(&project, text.as_bytes())?;
        Ok(is_drawn)
    };
    let is_drawn = write().inspect_err(|_| {
        // None of them was there before.
        for file in [&project, &picture, &table] {
            let _ = std::fs::remove_file(file);
        }
    })?;
    let picture = is_drawn.then_some(picture);
    let Placed { face, take, head } = placed;
    let take = take.as_ref();
    let distances = take.map(|take| &*take.distances);
    let take_options = take.map_or_else(Vec::new, |take| space_options(&face, &take.path));
    ui.clear();
    if let Some(take) = take {
        take.warn(ui);
    }
    if let Some(warning) = &unit.warning {
        ui.line(warning);
    }
    for finding in examine(&face).findings.iter().filter(|finding| finding.severity > Severity::Note) {
        ui.line(&super::doctor::line(finding));
    }
    let said = Said {
        folder,
        elsewhere,
        face: &face,
        head: &head,
        unit: text::unit_text(unit.units),
        spaces: &spaces,
        alike: &alike,
        left_out: &left_out,
        handles: handles_said(&face, take, picture.as_deref()),
        rows: take.map(|take| take.rows(ui)).unwrap_or_default(),
        take: take.map(|take| &*take.path),
        take_options: &take_options,
    };
    let summary = Summary {
        project: &project,
        handles_table: &table,
        picture: picture.as_deref(),
        unit: said.unit.trim_matches('"'),
        up: if face.up_axis == UpAxis::Y { "y" } else { "z" },
        head: &head.why,
        size_mm: head.size.map(|length| length * face.metres_per_unit * 1e3),
        examples: face.examples.iter().map(|example| &*example.name).collect(),
        in_another_space: said.spaces.iter().map(|space| InAnotherSpace::new(space, &face)).collect(),
        alike: &alike,
        left_out: &left_out,
        handles: face.handles.labels.len(),
        take: take.map(|take| &*take.path),
        take_options: &take_options,
        frame: take.map(|take| take.found.frame),
        distances_mm: distances,
    };
    output::done(args.json, ui, &summary, || said.text())
}

/// What `--json` prints; docs/cli.md documents every key.
#[derive(Serialize)]
struct Summary<'a> {
    project: &'a Path,
    handles_table: &'a Path,
    /// Null where no device can draw.
    picture: Option<&'a Path>,
    unit: &'a str,
    up: &'static str,
    /// How the head was found.
    head: &'a str,
    /// The size of the head.
    size_mm: [f64; 3],
    examples: Vec<&'a str>,
    in_another_space: Vec<InAnotherSpace<'a>>,
    alike: &'a [Alike],
    left_out: &'a [LeftOut],
    handles: usize,
    /// Null without a take.
    take: Option<&'a Path>,
    take_options: &'a [String],
    /// The frame that was laid over the mesh; null without a take.
    frame: Option<usize>,
    distances_mm: Option<&'a [f64]>,
}

/// An example that was exported in another space.
#[derive(Serialize)]
struct InAnotherSpace<'a> {
    example: &'a str,
    said: &'a str,
    keys: &'a [String],
}

impl<'a> InAnotherSpace<'a> {
    fn new(space: &'a ExampleSpace, face: &'a Face) -> Self {
        Self { example: &face.examples[space.example].name, said: &space.said, keys: &space.keys }
    }
}

/// A face as its project has it.
struct Read {
    face: Face,
    /// The examples in another space, which have keys now.
    spaces: Vec<ExampleSpace>,
}

/// Reads the face as its project file will have it. Examples in another space get the keys that take them in.
fn read_face(content: &mut Content<'_>) -> Result<Read> {
    // The folder of the project need not be there yet, so it is read as if it were in the working folder.
    let read = |content: &Content<'_>| {
        let here = Content { folder: Path::new(""), keys: content.keys.clone(), ..*content };
        let project = project::parse(&here.text(), "face.toml")?;
        project::load_without_handles(&project, Path::new("face.toml"), Reach::Anywhere)
    };
    let face = read(content)?;
    let spaces = example_spaces(&face);
    if spaces.is_empty() {
        return Ok(Read { face, spaces });
    }
    for space in &spaces {
        // Each section is one example.
        content.keys[space.example].clone_from(&space.keys);
    }
    Ok(Read { face: read(content)?, spaces })
}

/// Whether a file of the project is not below its folder.
fn is_elsewhere(parsed: &Project, project: &Path) -> bool {
    let examples = parsed.examples.iter().map(|example| &example.mesh);
    let mut files = [&parsed.mesh.neutral].into_iter().chain(examples);
    files.any(|file| named_file(project, file, "", Reach::Below).is_err())
}

/// The error for a take whose markers do not fit. A picture shows what is wrong, if a device can draw.
fn refused(args: &args::New, placed: &Placed, take: &FromTake, folder: &Path, ui: &Ui) -> Error {
    let picture = folder.join("misfit.png");
    let is_input = refuse_inputs(&[&picture], [&*args.neutral, &*take.path]).is_err();
    let has_folder = folder.as_os_str().is_empty() || std::fs::create_dir_all(folder).is_ok();
    let is_drawn = !is_input && has_folder && placed.draw(&picture).unwrap_or(false);
    ui.clear();
    take.warn(ui);
    let mut command =
        format!("rhytid new {} --take {}", output::word(&args.neutral), output::word(&take.path));
    let shapes = (!args.shapes.is_empty()).then(|| args.shapes.join(","));
    command += &again("-o", args.output.as_ref());
    command += &again("--examples", args.examples.as_ref());
    command += &again("--shapes", shapes);
    command += &again("--part", args.part.as_ref());
    command += &again("--unit", args.unit.map(|unit| unit.to_string()));
    command += &args.placement.again();
    Error::no_fit(take.fault(&command, is_drawn.then_some(&*picture)).unwrap_or_default())
}

/// What is said of the handles.
fn handles_said(face: &Face, take: Option<&FromTake>, picture: Option<&Path>) -> String {
    let count = face.handles.labels.len();
    let Some(take) = take else {
        return format!("{count}, spread over the face: no take was found");
    };
    let look = picture.map_or_else(String::new, |path| format!("; look at {}", path.display()));
    format!("{count}, from {}{look}", take.path.display())
}

/// What is printed for people.
struct Said<'a> {
    folder: &'a Path,
    /// The flag that the solve needs for files outside the project's folder, or empty.
    elsewhere: &'a str,
    face: &'a Face,
    head: &'a Region,
    unit: String,
    spaces: &'a [ExampleSpace],
    alike: &'a [Alike],
    left_out: &'a [LeftOut],
    handles: String,
    /// What the take says of them.
    rows: Vec<[String; 2]>,
    take: Option<&'a Path>,
    /// The options of `animate` that bring the take into the face's space.
    take_options: &'a [String],
}

impl Said<'_> {
    /// The decisions and the next commands.
    fn text(&self) -> String {
        let Self { folder, elsewhere, face, head, .. } = self;
        let row = |name: &str, value: String| [name.to_owned(), value];
        let names: Vec<&str> = face.examples.iter().map(|example| &*example.name).collect();
        let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let [width, y, z] = head.size.map(|length| length * face.metres_per_unit * 100.0);
        let (up, height, depth) = if face.up_axis == UpAxis::Y { ("Y", y, z) } else { ("Z", z, y) };
        let unit = self.unit.trim_matches('"');
        let size =
            format!("{unit}, {up} up: the head is {width:.0} cm wide, {height:.0} high and {depth:.0} deep");
        let mut rows = vec![row("unit", size), row("head", head.why.clone()), row("examples", names)];
        for alike in self.spaces.chunk_by(|a, b| a.said == b.said) {
            let ExampleSpace { said, keys, .. } = &alike[0];
            let names: Vec<&str> = alike.iter().map(|space| &*face.examples[space.example].name).collect();
            let (names, keys) = (names.join(", "), keys.join(" and "));
            let each = if alike.len() > 1 { "each " } else { "" };
            rows.push(row("in another space", format!("{names} {each}{said}: taken in by {keys}")));
        }
        for Alike { examples: [a, b], likeness } in self.alike {
            rows.push(row(
                "alike",
                format!("{a} and {b}, to {:.1} %: leave one of them out", likeness * 100.0),
            ));
        }
        for LeftOut { file, shape, why } in self.left_out {
            let shape = shape.as_ref().map_or_else(String::new, |shape| format!(", {shape}"));
            rows.push(row("left out", format!("{}{shape}: {why}", file.display())));
        }
        rows.push(row("handles", self.handles.clone()));
        rows.extend_from_slice(&self.rows);
        let options: String = self.take_options.iter().map(|option| format!(" {option}")).collect();
        if !options.is_empty() {
            rows.push(row("the take's space", format!("is another: taken in by{options}")));
        }
        let take = self.take.map_or_else(|| "TAKE.csv".to_owned(), output::word);
        let [project, rig, usd] =
            ["face.toml", "face.safetensors", "face.usd"].map(|name| output::word(&folder.join(name)));
        let next = output::next(&[
            format!("rhytid solve {project}{elsewhere}"),
            format!("rhytid view {rig} {take}"),
            format!("rhytid animate {rig} {take} -o {usd}{options}"),
        ]);
        format!("{}: a project, made\n{}{next}", folder.join("face.toml").display(), output::table(&rows))
    }
}
