//! `rhytid new`

use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::capture::{HandleSettings, place_handles};
use rhytid::core::human;
use rhytid::core::text::quoted;
use rhytid::core::{Example, Handles, Mesh, RawTake, Settings, SurfacePoint, UpAxis};
use rhytid::formats::project::{self, Units};
use rhytid::formats::{FileKind, Reach, mesh, named_file, raw_take, tables};
use rhytid::solve::{Severity, Skin, examine};
use rhytid::{Error, Face, InputErrorKind, Result};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Names of folders beside the neutral in which expressions are searched. The neutral's own folder comes
/// last.
const FOLDERS: [&str; 6] = ["poses", "examples", "expressions", "scans", "shapes", "blendshapes"];

/// Units of meshes, in the order in which they are tried.
const UNITS: [(Units, &str); 5] = [
    (Units::Centimetres, "cm"),
    (Units::Millimetres, "mm"),
    (Units::Metres, "m"),
    (Units::MetresPerUnit(0.1), "0.1"),
    (Units::Inches, "in"),
];

/// The size of faces and heads, with or without shoulders: the diagonal of the bounding box, in metres.
const SIZES: std::ops::Range<f64> = 0.15..0.9;

/// The number of handles without a take.
const HANDLES: usize = 90;

/// Writes a project file and its table of handles, and says what was decided and what comes next.
///
/// # Errors
/// [`Error::Input`] if the folder already has a project, or from the files; [`Error::Io`].
pub(super) fn run(args: &args::New, ui: &Ui) -> Result<()> {
    inputs::expect(&args.neutral, &[FileKind::Mesh, FileKind::Gltf], "rhytid new NEUTRAL.obj -o FOLDER")?;
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
    let neutral = ui.timed("read the neutral", || mesh::read(&args.neutral)).0?;
    let (examples, left_out) = ui.timed("read examples", || examples(args, &neutral)).0;
    check_names(&examples)?;
    let (units, unit_name) = unit(&neutral, args)?;
    let face = Face {
        name: "face".into(),
        metres_per_unit: units.metres_per_unit(),
        up_axis: UpAxis::Y,
        handles: Handles::default(),
        examples: examples.iter().map(|(_, example)| example.clone()).collect(),
        neutral,
        prior: None,
        settings: Settings::default(),
    };
    let Placed { face, take, distances } = ui.timed("place handles", || find_handles(face, args, ui)).0?;

    // Everything is known before the first file is written.
    let text = project_text(args, folder, &face, &examples, unit_name)?;
    let parsed = project::parse(&text, &project.display().to_string())?;
    let files = [&parsed.mesh.neutral].into_iter().chain(parsed.examples.iter().map(|example| &example.mesh));
    let is_elsewhere = |file: &PathBuf| named_file(&project, file, "", Reach::Below).is_err();
    let elsewhere = if files.into_iter().any(is_elsewhere) { " --allow-elsewhere" } else { "" };
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    }
    let distances: Option<Vec<f64>> =
        distances.map(|distances| distances.iter().map(|d| d * face.metres_per_unit * 1e3).collect());
    let doubtful: Vec<bool> = distances.iter().flatten().map(|distance| *distance > 8.0).collect();
    let write = || {
        tables::write_handles(&table, &face.handles, distances.as_deref())?;
        let is_drawn = super::handles::draw(&picture, &face, &doubtful, &[])?;
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
    ui.clear();
    for finding in examine(&face).findings.iter().filter(|finding| finding.severity > Severity::Note) {
        ui.line(&super::doctor::line(finding));
    }
    let summary = serde_json::json!({
        "project": project,
        "handles_table": table,
        "picture": picture,
        "unit": unit_name,
        "up": if face.up_axis == UpAxis::Y { "y" } else { "z" },
        "size_mm": size(&face.neutral).map(|length| length * face.metres_per_unit * 1e3),
        "examples": face.examples.iter().map(|example| &example.name).collect::<Vec<_>>(),
        "left_out": left_out,
        "handles": face.handles.labels.len(),
        "take": take,
        "distances_mm": distances,
    });
    let handles = match (&take, distances) {
        (Some(take), Some(mut distances)) => {
            distances.sort_by(f64::total_cmp);
            let median = distances.get(distances.len() / 2).copied().unwrap_or_default();
            let look = picture.map_or_else(String::new, |path| format!("; look at {}", path.display()));
            format!(
                "{}, from {}: {median:.1} mm from their markers (median){look}",
                face.handles.labels.len(),
                take.display()
            )
        }
        _ => format!("{}, spread over the face: no take was found", face.handles.labels.len()),
    };
    output::done(args.json, ui, &summary, || {
        next_steps(folder, elsewhere, &face, unit_name, &left_out, handles, take.as_deref())
    })
}

/// The decisions and the next commands. `elsewhere` is the flag that the solve needs for files outside the
/// project's folder, or empty.
fn next_steps(
    folder: &Path,
    elsewhere: &str,
    face: &Face,
    unit: &str,
    left_out: &[PathBuf],
    handles: String,
    take: Option<&Path>,
) -> String {
    let row = |name: &str, value: String| [name.to_owned(), value];
    let named = |paths: &[String]| if paths.is_empty() { "none".to_owned() } else { paths.join(", ") };
    let names: Vec<String> = face.examples.iter().map(|example| example.name.clone()).collect();
    let [width, y, z] = size(&face.neutral).map(|length| length * face.metres_per_unit * 100.0);
    let (up, height, depth) = if face.up_axis == UpAxis::Y { ("Y", y, z) } else { ("Z", z, y) };
    let mut rows = vec![
        row(
            "unit",
            format!(
                "{unit}, {up} up: the neutral is {width:.0} cm wide, {height:.0} high and {depth:.0} deep"
            ),
        ),
        row("examples", named(&names)),
    ];
    if !left_out.is_empty() {
        let files: Vec<String> = left_out.iter().map(|path| path.display().to_string()).collect();
        rows.push(row("left out", format!("{}: not the neutral's vertices", files.join(", "))));
    }
    rows.push(row("handles", handles));
    let take = take.map_or_else(|| "TAKE.csv".to_owned(), output::word);
    let [project_word, rig, usd] =
        ["face.toml", "face.safetensors", "face.usd"].map(|name| output::word(&folder.join(name)));
    let next = output::next(&[
        format!("rhytid solve {project_word}{elsewhere}"),
        format!("rhytid view {rig} {take}"),
        format!("rhytid animate {rig} {take} -o {usd}"),
    ]);
    format!("{}: a project, made\n{}{next}", folder.join("face.toml").display(), output::table(&rows))
}

/// Meshes with the neutral's vertices, and meshes with other vertices.
fn examples(args: &args::New, neutral: &Mesh) -> (Vec<(PathBuf, Example)>, Vec<PathBuf>) {
    let beside = args.neutral.parent().unwrap_or(Path::new(""));
    let found = FOLDERS.iter().map(|name| beside.join(name)).find(|folder| folder.is_dir());
    let folder = args.examples.clone().or(found).unwrap_or_else(|| beside.to_owned());
    let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    files.sort();
    let is_neutral = |path: &PathBuf| path.canonicalize().ok() == args.neutral.canonicalize().ok();
    files.retain(|path| FileKind::detect(path) == Some(FileKind::Mesh) && !is_neutral(path));
    let (mut examples, mut left_out) = (Vec::new(), Vec::new());
    for path in files {
        match mesh::read_like(neutral, &args.neutral, &path) {
            Ok(positions) => {
                let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                examples.push((path, Example { name, positions, mirror: false, noise: None }));
            }
            Err(_) => left_out.push(path),
        }
    }
    (examples, left_out)
}

/// Refuses two examples of one name, such as `smile.obj` and `smile.ply`.
fn check_names(examples: &[(PathBuf, Example)]) -> Result<()> {
    for (i, (path, example)) in examples.iter().enumerate() {
        if let Some((other, _)) = examples[..i].iter().find(|(_, other)| other.name == example.name) {
            return Err(Error::conflict(format!(
                "{} and {}: both would be the example {}; rename one of them, or move it away",
                other.display(),
                path.display(),
                quoted(&example.name)
            )));
        }
    }
    Ok(())
}

/// The takes in the neutral's folder, by name.
fn takes_beside(neutral: &Path) -> Vec<PathBuf> {
    let folder = neutral.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.sort();
    files.retain(|path| matches!(FileKind::detect(path), Some(FileKind::RawTake | FileKind::Take)));
    files
}

/// A face with its handles.
struct Placed {
    face: Face,
    /// The take whose markers they are, if they are any.
    take: Option<PathBuf>,
    /// The distance of each handle from its marker, in mesh units.
    distances: Option<Vec<f64>>,
}

/// Places the handles at the markers of a take: the one that was given, else the first beside the neutral
/// whose markers fit the face. A warning names the tables that are passed over. Without a take, handles are
/// spread over the face.
fn find_handles(face: Face, args: &args::New, ui: &Ui) -> Result<Placed> {
    let by = |take: &Path, face: Face| {
        let (face, distances) = placed(face, Some(&raw_take::read(take, None)?))?;
        Ok(Placed { face, take: Some(take.to_owned()), distances })
    };
    if let Some(take) = &args.take {
        return by(take, face);
    }
    for take in takes_beside(&args.neutral) {
        match by(&take, face.clone()) {
            Err(error @ Error::Input(_)) => ui.line(&format!(
                "warning: {}: is passed over, since it is no take of this face ({error}); name a take with --take",
                take.display()
            )),
            found => return found,
        }
    }
    let (face, distances) = placed(face, None)?;
    Ok(Placed { face, take: None, distances })
}

/// The size of the bounding box along x, y and z.
fn size(mesh: &Mesh) -> [f64; 3] {
    let [low, high] = mesh.bounds().unwrap_or_default();
    std::array::from_fn(|c| high[c] - low[c])
}

/// The diagonal of the bounding box.
fn across(mesh: &Mesh) -> f64 {
    size(mesh).iter().map(|length| length * length).sum::<f64>().sqrt()
}

/// The unit that was given, else the one in which the neutral has the size of a head.
fn unit(neutral: &Mesh, args: &args::New) -> Result<(Units, &'static str)> {
    let across = across(neutral);
    if let Some(unit) = args.unit {
        let found =
            UNITS.into_iter().find(|(units, _)| (units.metres_per_unit() / unit.metres() - 1.0).abs() < 1e-9);
        return found.ok_or_else(|| Error::input("--unit: a mesh is in mm, cm, m or in"));
    }
    UNITS.into_iter().find(|(units, _)| SIZES.contains(&(across * units.metres_per_unit()))).ok_or_else(
        || {
            Error::out_of_range(format!(
                "{}: its bounding box has a diagonal of {} units, the size of a head in no unit; say which with --unit, or scale it",
                args.neutral.display(),
                human::number(across)
            ))
        },
    )
}

/// The face with its handles and its best up axis, and the distance of each handle from its marker.
fn placed(mut face: Face, raw: Option<&RawTake>) -> Result<(Face, Option<Vec<f64>>)> {
    let Some(raw) = raw else {
        let skin = Skin::from_face(&face).or_else(|_| {
            face.up_axis = UpAxis::Z;
            Skin::from_face(&face)
        })?;
        let vertices = skin.spread(HANDLES, &[]);
        let labels = skin.labels(&vertices);
        face.handles = Handles { labels, points: vertices.into_iter().map(SurfacePoint::from).collect() };
        return Ok((face, None));
    };
    // The right axis is the one in which the markers fit.
    let mut with = |up_axis: UpAxis| {
        face.up_axis = up_axis;
        place_handles(&face, raw, &HandleSettings::default())
    };
    let (y, z) = (with(UpAxis::Y), with(UpAxis::Z));
    let (up_axis, found) = match (y, z) {
        (Ok(y), Ok(z)) if z.cost < 0.8 * y.cost => (UpAxis::Z, z),
        (Err(_), Ok(z)) => (UpAxis::Z, z),
        (y, _) => (UpAxis::Y, y?),
    };
    face.up_axis = up_axis;
    face.handles = found.handles;
    Ok((face, Some(found.distances)))
}

/// The project file with a comment at each choice.
fn project_text(
    args: &args::New,
    folder: &Path,
    face: &Face,
    examples: &[(PathBuf, Example)],
    unit: &str,
) -> Result<String> {
    let in_toml = |path: &Path| toml_text(&relative(folder, path));
    let unit = if unit.parse::<f64>().is_ok() { unit.to_owned() } else { format!("{unit:?}") };
    let up = if face.up_axis == UpAxis::Y { "y" } else { "z" };
    let mut text = format!(
        "# A Rhytid project: paths are relative to this file. All keys:\n# {}project-file.md\n\n\
         # Examples that are not in the neutral's place are put there; false keeps them where they are.\n\
         align = true\n\n\
         [mesh]\n\
         neutral = {}\n\
         units = {unit}   # m, cm, mm, in, or metres per unit\n\
         up = \"{up}\"\n\n\
         [handles]\n\
         vertices = \"markers.csv\"   # look at markers.png\n\n",
        args::DOCS,
        in_toml(&args.neutral)
    );
    for (path, example) in examples {
        let fault = |_| Error::Internal("writing to a text".into());
        writeln!(text, "[[example]]\nname = {}\nmesh = {}\n", toml_text(&example.name), in_toml(path))
            .map_err(fault)?;
    }
    text += "# What no example moves stays, so that the back of the head does not swing. More that is to stay:\n\
             # [pins]\n# box = [[-10, 5, -20], [10, 25, -5]]   # two corners, in mesh units\n";
    Ok(text)
}

/// A text in TOML. It is in single quotes if possible, so that backslashes stay as they are.
fn toml_text(text: &str) -> String {
    if text.contains('\'') || text.contains(char::is_control) {
        toml::Value::from(text).to_string()
    } else {
        format!("'{text}'")
    }
}

/// A file's path relative to a folder; unchanged if they have nothing in common.
fn relative(folder: &Path, file: &Path) -> String {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (from, to) = (absolute(folder), absolute(file));
    let common = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    if common <= 1 {
        return to.display().to_string();
    }
    let up = from.components().skip(common).map(|_| "..".to_owned());
    let down = to.components().skip(common).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}
