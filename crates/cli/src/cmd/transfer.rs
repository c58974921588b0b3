//! `rhytid transfer`

use super::solve;
use crate::drawing::with_pictures;
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::{Example, Mesh, human, rig_file};
use rhytid::formats::{FileKind, mesh, project, refuse_inputs, tables};
use rhytid::report::Page;
use rhytid::transfer::{Missing, Settings, TransferReport, Transferred, transfer};
use rhytid::{Error, Face, Result};
use std::path::{Path, PathBuf};

/// Makes examples for the second face, solves it, and says what was found.
///
/// # Errors
/// As reading, transferring, solving and writing.
pub(super) fn run(args: &args::Transfer, ui: &Ui) -> Result<()> {
    let usage = "rhytid transfer --from A.safetensors --to B.toml -o B.safetensors";
    inputs::expect(&args.from, &[FileKind::Rig], usage)?;
    inputs::project(&args.to, usage)?;
    solve::check_output(&args.output)?;
    let files = project::files(&project::read_project(&args.to)?, &args.to);
    let read = [&args.from].into_iter().chain(&args.landmarks).chain(&files);
    refuse_inputs(&[&args.output], read.map(PathBuf::as_path))?;
    let landmarks = args.landmarks.as_deref().map(tables::read_landmarks).transpose()?;
    let from = ui.timed("read the rig", || rig_file::read(&args.from)).0?;
    let to = ui.timed("read", || inputs::face(&args.to, args.elsewhere.reach(), ui)).0?;
    let settings = Settings { landmarks, linear_band: args.with_linear_band };
    let Transferred { face, report, maps } = transfer(&from, &to, &settings, &[inputs::processor()?], ui)?;
    ui.clear();
    report.warnings.iter().for_each(|warning| ui.line(&format!("warning: {warning}")));
    if report.examples.is_empty() {
        return Err(Error::empty(format!(
            "{}: has each example of the first face already ({}), so there is nothing to transfer",
            args.to.display(),
            report.own.join(", ")
        )));
    }
    // The examples are written at the end, but an existing file is refused before the work.
    let kept = args.examples.as_deref().map(|dir| Kept::new(dir, &face, &report, &files)).transpose()?;
    let solved = solve::solve_face(face, &args.output, ui)?;
    if let Some(kept) = &kept {
        kept.write()?;
    }
    if let Some(dir) = &args.report {
        let title = output::title(&args.to, &report.to);
        let page = Page { folder: dir, title: &title };
        let write =
            |painter: Option<&_>| rhytid::report::write_transfer(page, &report, &maps, &solved.rig, painter);
        // For programs that show numbers at vertices, `view` among them.
        let rest = solved.rig.surface().rest.iter().map(|x| x.map(f64::from)).collect();
        let mesh = Mesh { positions: rest, faces: solved.rig.surface().faces.clone(), ..Mesh::default() };
        let numbers = [("distance_mm", &*maps.distance_mm), ("stretch", &*maps.stretch)];
        std::fs::create_dir_all(dir).map_err(Error::io(dir))?;
        mesh::write_numbers(&dir.join("maps.ply"), &mesh, &numbers)?;
        ui.timed("write the report", || with_pictures("the report's pictures are", write)).0?;
    }
    ui.clear();
    if args.json.wanted {
        return output::json(&report);
    }
    if ui.is_quiet() {
        return Ok(());
    }
    let next = output::next(&[format!("rhytid view {}", output::word(&args.output))]);
    let kept = kept.map(|kept| kept.lines()).unwrap_or_default();
    output::say(&format!("{}\n{}{next}{kept}", text(&report), solve::text(&solved, &args.output, ui)))
}

/// The new examples, as meshes to write.
struct Kept {
    dir: PathBuf,
    neutral: Mesh,
    /// Those that are not there yet, with their positions.
    missing: Vec<(PathBuf, Vec<[f64; 3]>)>,
    /// The names and files of all.
    names: Vec<(String, PathBuf)>,
}

impl Kept {
    fn new(dir: &Path, face: &Face, report: &TransferReport, read: &[PathBuf]) -> Result<Self> {
        let made = face.examples.iter().filter(|example| report.examples.contains(&example.name));
        let mut examples: Vec<(PathBuf, Example)> = Vec::new();
        let mut names = Vec::new();
        for example in made {
            let harmless = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
            let mut name: String = example.name.chars().map(harmless).collect();
            while examples.iter().any(|(path, _)| *path == dir.join(format!("{name}.obj"))) {
                name.push('_');
            }
            examples.push((dir.join(format!("{name}.obj")), example.clone()));
        }
        let outputs: Vec<&Path> = examples.iter().map(|(path, _)| path.as_path()).collect();
        refuse_inputs(&outputs, read.iter().map(PathBuf::as_path))?;
        let mut missing = Vec::new();
        for (path, example) in examples {
            if output::is_missing(&path, || Ok(mesh::read(&path)?.positions == example.positions))? {
                missing.push((path.clone(), example.positions.clone()));
            }
            names.push((example.name, path));
        }
        Ok(Self { dir: dir.to_owned(), neutral: face.neutral.clone(), missing, names })
    }

    fn write(&self) -> Result<()> {
        std::fs::create_dir_all(&self.dir).map_err(Error::io(&self.dir))?;
        for (path, positions) in &self.missing {
            let mesh = Mesh { positions: positions.clone(), ..self.neutral.clone() };
            mesh::write_obj(path, &mesh)?;
        }
        Ok(())
    }

    /// The lines to add to the project file.
    fn lines(&self) -> String {
        let mut lines = "\n\nTo be added to the project file, where the examples are to be kept:".to_owned();
        for (name, path) in &self.names {
            let path = path.display().to_string();
            lines += &format!("\n[[example]]\nname = {name:?}\nmesh = {path:?}");
        }
        lines
    }
}

fn text(found: &TransferReport) -> String {
    let number = |x: f64| human::number((x * 100.0).round() / 100.0);
    let per_cent = |x: f64| format!("{} %", human::number((1000.0 * x).round() / 10.0));
    let what = if found.linear_band { "all motion" } else { "wrinkles" };
    let mut text = format!(
        "{} of {} on {}: {} by {}, {} of the size",
        what,
        found.from,
        found.to,
        human::counted(found.examples.len(), "example"),
        if found.same_topology {
            "the same vertices".to_owned()
        } else {
            human::counted(found.landmarks.len(), "landmark")
        },
        per_cent(found.scale)
    );
    let mut rows =
        vec![["with a counterpart".to_owned(), format!("{} of the skin", per_cent(found.covered))]];
    let bare = found.bare.iter().map(|bare| {
        let why = match bare.why {
            Missing::OtherPart => "in parts without a landmark",
            Missing::BeyondTheBorder => "beyond the border of the first face",
            Missing::FacesAway => "near what faces away",
            Missing::TooFar => "far from the first face",
            Missing::Elsewhere => "near what moves otherwise",
        };
        format!("{} {why}", human::count(bare.vertices))
    });
    let bare: Vec<String> = bare.collect();
    if !bare.is_empty() {
        rows.push(["vertices without".to_owned(), bare.join(", ")]);
    }
    if !found.bare_handles.is_empty() {
        rows.push(["handles without".to_owned(), found.bare_handles.join(", ")]);
    }
    if !found.same_topology {
        let spread = found.distance_mm;
        rows.push([
            "apart".to_owned(),
            format!("{} mm (median), 95 % below {} mm", number(spread.median), number(spread.p95)),
        ]);
    }
    rows.push([
        "stretched".to_owned(),
        format!("by {} (median), 95 % below {}", per_cent(found.stretch.median), per_cent(found.stretch.p95)),
    ]);
    if !found.own.is_empty() {
        rows.push(["its own, kept".to_owned(), found.own.join(", ")]);
    }
    text += &format!("\n{}\n", output::table(&rows));
    text
}
