//! `rhytid demo`

use super::{animate, solve};
use crate::progress::{Ui, timed};
use crate::{args, call, output, start};
use rhytid::core::human;
use rhytid::core::{Example, Handles, Mesh, StrainEdges};
use rhytid::formats::project::{
    self, Edges, ExampleSection, FineScaleSection, HandlesSection, LargeScaleSection, LearnedSection,
    MeshSection, Method, PinsSection, Project, StrainSection, Units,
};
use rhytid::formats::take::Missing;
use rhytid::formats::{Reach, mesh, tables, take};
use rhytid::playback::FrameRange;
use rhytid::{Error, Face, Progress, Result, Take};
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The largest size of an animated file in bytes, roughly. Longer takes are cut to a range of frames.
const MAX_FILE_BYTES: usize = 1_000_000_000;

/// An animated file.
struct Animation {
    file: &'static str,
    /// About how many bytes it needs per vertex and frame while it is written.
    bytes_per_vertex: usize,
    compressed: bool,
}

/// A web page cannot hold a target for each frame, so its file is compressed.
const ANIMATIONS: [Animation; 2] = [
    Animation { file: "face.usd", bytes_per_vertex: 24, compressed: false },
    Animation { file: "face.glb", bytes_per_vertex: 24, compressed: true },
];

/// The film. It should take a small part of the whole time on two processors.
#[cfg(feature = "film")]
const FILM_FRAMES: usize = 60;
#[cfg(feature = "film")]
const FILM_SIZE: [u32; 2] = [360, 480];

/// A step of the demo.
#[derive(Serialize)]
struct Step {
    #[serde(rename = "step")]
    name: String,
    seconds: f64,
    made: String,
}

impl Step {
    fn time(&self) -> Duration {
        Duration::from_secs_f64(self.seconds)
    }
}

/// What was done, for the table at the end.
#[derive(Default)]
struct Steps(Vec<Step>);

impl Steps {
    fn add(&mut self, name: &str, made: String, time: Duration) {
        self.0.push(Step { name: name.to_owned(), seconds: time.as_secs_f64(), made });
    }

    /// The steps from the project file to the rig file.
    fn add_solved(&mut self, solved: &solve::Solved) {
        let made = format!(
            "{}, {}, bending length {} {}",
            human::counted(solved.rig.handles().strain_edges.len(), "strain edge"),
            human::counted(solved.rig.influences().per_vertex(), "influence"),
            human::number(solved.rig.bending_length()),
            human::unit(solved.rig.surface().metres_per_unit)
        );
        let written = format!("face.safetensors, {}", human::bytes(solved.bytes));
        self.add("read it back", "face.toml and the files it names".to_owned(), solved.reading);
        self.add("examine the face", "no errors: it can be solved".to_owned(), solved.examining);
        self.add("solve", made, solved.solving);
        self.add("write the rig", written, solved.writing);
    }
}

/// Makes a face and a performance, writes them as files, and runs `solve` and `animate` on these files.
///
/// # Errors
/// [`Error::Io`] if the folder cannot be written; [`Error::Input`] if the user stops it.
pub(super) fn run(args: &args::Demo, ui: &Ui) -> Result<()> {
    let mut steps = Steps::default();
    let result = demo(args, ui, &mut steps);
    if matches!(result, Err(Error::Cancelled)) {
        let dir = args.dir.display();
        return Err(Error::input(format!("stopped before the end; the files finished so far are in {dir}")));
    }
    result?;
    let summary = serde_json::json!({ "folder": args.dir, "steps": steps.0 });
    output::done(args.json, ui, &summary, || {
        let row = |step: &Step| [step.name.clone(), human::duration(step.time()), step.made.clone()];
        let rows: Vec<[String; 3]> = steps.0.iter().map(row).collect();
        output::table(&rows) + "\n" + &next_steps(&args.dir)
    })
}

fn demo(args: &args::Demo, ui: &Ui, steps: &mut Steps) -> Result<()> {
    let dir = args.dir.as_path();
    let poses = dir.join("poses");
    std::fs::create_dir_all(&poses).map_err(Error::io(&poses))?;

    let (face, time) = ui.timed("make a face", || rhytid_demo::face(args.vertices as usize));
    let made = format!(
        "{} vertices, {}, {}",
        human::count(face.neutral.positions.len()),
        human::counted(face.handles.labels.len(), "handle"),
        human::counted(face.examples.len(), "example")
    );
    steps.add("make a face", made, time);

    let (take, time) = timed(|| rhytid_demo::performance(&face));
    let rate = human::number(take.rate());
    let made = format!("{} at {rate} frames per second", human::counted(take.frames(), "frame"));
    steps.add("make a performance", made, time);

    let (written, time) = timed(|| write_inputs(dir, &face, &take, ui));
    steps.add("write the input", written?, time);

    let ranges = ANIMATIONS.map(|animation| range(&face, &take, animation.bytes_per_vertex));
    #[cfg(feature = "film")]
    let filmed = around_strongest(&face, &take, FILM_FRAMES);
    let frames = take.frames();
    drop((face, take));

    let rig = dir.join("face.safetensors");
    steps.add_solved(&solve::solve(&dir.join("face.toml"), &rig, None, Reach::Below, ui)?);
    for (animation, range) in ANIMATIONS.iter().zip(ranges) {
        animate(dir, &rig, animation, range, frames, ui, steps)?;
    }
    #[cfg(feature = "wgpu")]
    {
        draw(dir, &rig, "face.png", FrameRange::default(), None, ui, steps)?;
        #[cfg(feature = "film")]
        draw(dir, &rig, "face.mp4", filmed, Some(FILM_SIZE), ui, steps)?;
    }
    Ok(())
}

/// The words of a command that makes `file` of the rig and the performance.
fn words(command: &str, dir: &Path, rig: &Path, file: &str) -> Vec<OsString> {
    let mut output = OsString::from("--output=");
    output.push(dir.join(file));
    vec![command.into(), output, "--".into(), rig.into(), dir.join("performance.csv").into()]
}

/// An animated file of a range of all `frames`.
fn animate(
    dir: &Path,
    rig: &Path,
    animation: &Animation,
    range: FrameRange,
    frames: usize,
    ui: &Ui,
    steps: &mut Steps,
) -> Result<()> {
    let Animation { file, compressed, .. } = *animation;
    let mut job = call::parse_animate(words("animate", dir, rig, file))?;
    job.frames = args::FramesChoice::Range(range);
    job.compressed = compressed;
    let done = animate::animate(&job, ui)?;
    let mut made =
        format!("{file}, {}, {}", human::counted(done.frames(), "frame"), human::bytes(done.written.bytes));
    if range != FrameRange::default() {
        let first = range.start.unwrap_or(0);
        made += &format!(
            " (frames {first} to {} of {frames}: with all of them the file would exceed 1 GB)",
            first + done.frames() - 1
        );
    }
    steps.add(&format!("animate on {}", done.device.id()), made, done.time);
    Ok(())
}

/// A sheet or a film, if this machine can draw.
#[cfg(feature = "wgpu")]
fn draw(
    dir: &Path,
    rig: &Path,
    file: &str,
    frames: FrameRange,
    size: Option<[u32; 2]>,
    ui: &Ui,
    steps: &mut Steps,
) -> Result<()> {
    let mut job = call::parse_render(words("render", dir, rig, file))?;
    job.frames = frames;
    job.size = size;
    job.turn = 20.0;
    match super::render::draw(&job, ui) {
        Ok(done) => {
            let made =
                format!("{file}, {}, {}", human::counted(done.pictures, "picture"), human::bytes(done.bytes));
            steps.add(&format!("draw on {}", done.draws()), made, done.time);
            Ok(())
        }
        Err(Error::Device { message, .. }) => {
            log::warn!("{file} is left out: {message}");
            Ok(())
        }
        Err(other) => Err(other),
    }
}

/// A file that `solve` and `animate` read.
enum Input<'a> {
    Neutral(&'a Mesh),
    Pose(&'a Mesh, &'a Example),
    Handles(&'a Handles),
    Take(&'a Take),
    Project(&'a Project),
}

impl Input<'_> {
    fn is_in(&self, path: &Path) -> Result<bool> {
        Ok(match self {
            Self::Neutral(mesh) => mesh::read(path)? == **mesh,
            Self::Pose(neutral, example) => mesh::read(path)? == pose(neutral, example),
            Self::Handles(handles) => tables::read_handles(path)? == **handles,
            Self::Take(take) => take::read(path, None, Missing::Leave)? == **take,
            Self::Project(project) => project::read_project(path)? == **project,
        })
    }

    fn write(&self, path: &Path) -> Result<()> {
        match self {
            Self::Neutral(mesh) => mesh::write_obj(path, mesh),
            Self::Pose(neutral, example) => mesh::write_obj(path, &pose(neutral, example)),
            Self::Handles(handles) => tables::write_handles(path, handles, None),
            Self::Take(take) => take::write(path, take),
            Self::Project(project) => project::write(path, project),
        }
    }
}

fn pose(neutral: &Mesh, example: &Example) -> Mesh {
    Mesh { positions: example.positions.clone(), ..neutral.clone() }
}

/// Writes the files that are not there yet. Files that somebody has changed stay, and are an error.
fn write_inputs(dir: &Path, face: &Face, take: &Take, ui: &Ui) -> Result<String> {
    let mut inputs = vec![(PathBuf::from("neutral.obj"), Input::Neutral(&face.neutral))];
    let mut examples = Vec::new();
    for example in &face.examples {
        let file = PathBuf::from("poses").join(format!("{}.obj", example.name));
        inputs.push((file.clone(), Input::Pose(&face.neutral, example)));
        examples.push(ExampleSection {
            name: Some(example.name.clone()),
            mesh: file,
            mirror: example.mirror,
            ..ExampleSection::default()
        });
    }
    let meshes = inputs.len();
    inputs.push(("markers.csv".into(), Input::Handles(&face.handles)));
    inputs.push(("performance.csv".into(), Input::Take(take)));
    let project = project_of(face, examples)?;
    inputs.push(("face.toml".into(), Input::Project(&project)));
    let mut missing = Vec::new();
    for (file, input) in &inputs {
        let path = dir.join(file);
        if output::is_missing(&path, || input.is_in(&path))? {
            missing.push((path, input));
        }
    }
    for (i, (path, input)) in missing.iter().enumerate() {
        ui.report("write the input", i as u64, missing.len() as u64);
        if ui.cancelled() {
            return Err(Error::Cancelled);
        }
        input.write(path)?;
    }
    Ok(format!("face.toml, neutral.obj, {} in poses/, markers.csv, performance.csv", meshes - 1))
}

fn project_of(face: &Face, examples: Vec<ExampleSection>) -> Result<Project> {
    if face.settings.strain_edges != StrainEdges::Auto {
        return Err(Error::Internal("the demo's strain edges are not auto".to_owned()));
    }
    let units = match face.metres_per_unit {
        0.01 => Units::Centimetres,
        other => Units::MetresPerUnit(other),
    };
    Ok(Project {
        method: Method::Learned,
        align: true,
        mesh: MeshSection {
            name: Some(face.name.clone()),
            neutral: "neutral.obj".into(),
            prim: None,
            units: Some(units),
            up: Some(face.up_axis),
            weld: None,
            textures: None,
        },
        handles: HandlesSection { vertices: "markers.csv".into() },
        examples,
        prior: None,
        pins: PinsSection::default(),
        contact: face.settings.contact,
        large_scale: LargeScaleSection {
            bending_length: face.settings.bending_length,
            bind: face.settings.bind,
            rotations: face.settings.rotations,
        },
        strain: StrainSection { edges: Edges::Auto },
        fine_scale: FineScaleSection { max_influences: face.settings.max_influences },
        learned: LearnedSection::default(),
    })
}

/// All frames, or as many as fit into a file.
fn range(face: &Face, take: &Take, bytes_per_vertex: usize) -> FrameRange {
    let room = MAX_FILE_BYTES / (face.neutral.positions.len() * bytes_per_vertex).max(1);
    around_strongest(face, take, room.max(1))
}

/// All frames, or `count` around the strongest expression.
fn around_strongest(face: &Face, take: &Take, count: usize) -> FrameRange {
    if take.frames() <= count {
        return FrameRange::default();
    }
    let start = strongest_frame(face, take).saturating_sub(count / 2).min(take.frames() - count);
    FrameRange { start: Some(start), end: Some(start + count) }
}

/// The frame whose handles are farthest from rest, all together.
fn strongest_frame(face: &Face, take: &Take) -> usize {
    let Ok(positions) = take.handle_positions(&face.handles.labels) else { return 0 };
    let rest: Vec<f32> =
        (face.handles.at(&face.neutral.positions).iter().flatten()).map(|x| *x as f32).collect();
    let motion = |frame: &[f32]| frame.iter().zip(&rest).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
    let frames = positions.chunks_exact(rest.len().max(1)).map(motion).enumerate();
    frames.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(frame, _)| frame)
}

fn next_steps(dir: &Path) -> String {
    // The program's name as it was called, so that the lines can be pasted even if it is not on the path.
    let rhytid = output::word(Path::new(&start::name()));
    let [rig, take, project] =
        ["face.safetensors", "performance.csv", "face.toml"].map(|name| output::word(&dir.join(name)));
    let dir = dir.display();
    output::next(&[
        format!(
            "open {dir}/face.usd in Blender (File > Import) and press play; {dir}/face.glb is for viewers and the web"
        ),
        format!("{rhytid} view {rig} {take}"),
        format!("{rhytid} animate {rig} {take} -o coarse.usd --stage large-scale"),
        format!(
            "with your own scans: edit {project}, then {rhytid} doctor, solve and animate; see {}getting-started.md",
            args::DOCS
        ),
    ])
}
