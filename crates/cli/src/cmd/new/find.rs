//! The expressions of a neutral: meshes in a folder, and the shapes of one file.

use crate::args;
use rhytid::core::Mesh;
use rhytid::core::text::quoted;
use rhytid::formats::mesh::{self, ALIKE, Selection, Shape, ShapeGroup, Shapes};
use rhytid::formats::project::{ExampleSection, fits};
use rhytid::formats::{FileKind, animation};
use rhytid::{Error, Result};
use serde::Serialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Names of folders beside the neutral in which expressions are searched. The neutral's own folder comes
/// last.
const FOLDERS: [&str; 6] = ["poses", "examples", "expressions", "scans", "shapes", "blendshapes"];

/// What was found.
pub(super) struct Found {
    /// An example each. Meshes are as seen from the working folder.
    pub(super) sections: Vec<ExampleSection>,
    pub(super) left_out: Vec<LeftOut>,
    pub(super) alike: Vec<Alike>,
}

/// A file or shape that is no example.
#[derive(Serialize)]
pub(super) struct LeftOut {
    pub(super) file: PathBuf,
    /// Null for the whole file.
    pub(super) shape: Option<String>,
    pub(super) why: String,
}

/// Two examples that are nearly the same up to a factor.
#[derive(Serialize)]
pub(super) struct Alike {
    pub(super) examples: [String; 2],
    /// The cosine of their displacements.
    pub(super) likeness: f64,
}

/// The expressions of the file `args.neutral`, which has the shapes of `neutral`, and of the files beside it.
///
/// # Errors
/// [`Error::Input`] if two would have one name, or if no shape fits what is wanted.
pub(super) fn examples(args: &args::New, neutral: &Shapes) -> Result<Found> {
    let mut found = Found { sections: Vec::new(), left_out: Vec::new(), alike: Vec::new() };
    let is_neutral = |file: &Path| file.canonicalize().ok() == args.neutral.canonicalize().ok();
    if args.examples.as_deref().is_none_or(is_neutral) {
        found.add_shapes(&args.neutral, &neutral.shapes, &args.shapes);
    }
    for file in files(args)?.into_iter().filter(|file| !is_neutral(file)) {
        match found.add_file(args, &neutral.neutral, &file) {
            Ok(()) => {}
            Err(Error::Input(sentence)) => {
                let sentence = sentence.to_string();
                let named = file.display().to_string();
                let rest = sentence.strip_prefix(&named);
                let why = rest.and_then(|rest| rest.strip_prefix(": ").or(rest.strip_prefix(", ")));
                let why = why.unwrap_or(&sentence).to_owned();
                found.left_out.push(LeftOut { file, shape: None, why });
            }
            Err(error) => return Err(error),
        }
    }
    if !args.shapes.is_empty() && !found.sections.iter().any(ExampleSection::has_shapes) {
        return Err(Error::input(format!(
            "{}: no shape fits {}; rhytid info lists the shapes of a file",
            args.neutral.display(),
            quoted(&args.shapes.join(","))
        )));
    }
    if let Some(given) = args.examples.as_ref().filter(|_| found.sections.is_empty()) {
        let why = match found.left_out.first() {
            Some(LeftOut { file, why, .. }) => format!("has no example ({}: {why})", file.display()),
            None => "has no mesh that could be an example".to_owned(),
        };
        return Err(Error::empty(format!(
            "{}: {why}; name a folder of meshes, or a file with shapes, or leave --examples out",
            given.display()
        )));
    }
    check_names(&found.sections)?;
    Ok(found)
}

/// The file that was named, or the meshes in the folder that was, by name. By default they are beside the
/// neutral.
fn files(args: &args::New) -> Result<Vec<PathBuf>> {
    if let Some(file) = args.examples.as_ref().filter(|given| given.is_file()) {
        return Ok(vec![file.clone()]);
    }
    let beside = args.neutral.parent().unwrap_or(Path::new(""));
    let found = FOLDERS.iter().map(|name| beside.join(name)).find(|folder| folder.is_dir());
    let folder = args.examples.clone().or(found).unwrap_or_else(|| beside.to_owned());
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
    let entries = std::fs::read_dir(listed).map_err(Error::io(listed))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| folder.join(entry.file_name())).collect();
    files.sort();
    let is_mesh =
        |file: &Path| matches!(FileKind::detect(file), Some(FileKind::Mesh | FileKind::Gltf | FileKind::Usd));
    files.retain(|file| is_mesh(file));
    Ok(files)
}

impl Found {
    /// Adds the examples of a file.
    ///
    /// # Errors
    /// Why the file has none.
    fn add_file(&mut self, args: &args::New, neutral: &Mesh, file: &Path) -> Result<()> {
        if mesh::has_shapes(file)
            && let Ok(animation) = animation::open(file)
        {
            let summary = animation.summary();
            if summary.recipe.is_some() {
                return Err(Error::input("is an animation that Rhytid has exported"));
            }
            if FileKind::detect(file) == Some(FileKind::Usd) && summary.frames > 1 && !summary.fitted {
                return Err(Error::input(
                    "is an animation; write time = N at an [[example]] to take the pose at the time code N",
                ));
            }
        }
        let read = mesh::read_file(file, &Selection::default(), mesh::has_shapes(file))?;
        let order = mesh::order(&read.neutral, neutral, &args.neutral, file)?;
        if !read.shapes.is_empty() {
            self.add_shapes(file, &read.shapes, &args.shapes);
            return Ok(());
        }
        if order.of_neutral(read.neutral.positions, &neutral.positions) == neutral.positions {
            return Err(Error::input("is the neutral itself"));
        }
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mesh = file.to_owned();
        self.sections.push(ExampleSection { name: Some(name), mesh, ..ExampleSection::default() });
        Ok(())
    }

    /// Adds the shapes of a file that one of the patterns fits, or all without a pattern. Shapes of the left
    /// and right side are one example.
    fn add_shapes(&mut self, file: &Path, shapes: &[Shape], patterns: &[String]) {
        let is_wanted =
            |name: &str| patterns.is_empty() || patterns.iter().any(|pattern| fits(pattern, name));
        let mut leave_out = |shape: &Shape, why: &str| {
            let (file, why) = (file.to_owned(), why.to_owned());
            self.left_out.push(LeftOut { file, shape: Some(shape.name.clone()), why });
        };
        let mut groups: Vec<ShapeGroup> = Vec::new();
        for ShapeGroup { name, shapes: members } in mesh::shape_groups(shapes) {
            let mut kept = Vec::new();
            for member in members {
                let shape = &shapes[member];
                if shape.moved.is_empty() {
                    leave_out(shape, "moves nothing");
                } else if is_wanted(&shape.name) || is_wanted(&name) {
                    kept.push(member);
                }
            }
            if let [alone] = kept[..] {
                groups.push(ShapeGroup { name: shapes[alone].name.clone(), shapes: kept });
            } else if !kept.is_empty() {
                groups.push(ShapeGroup { name, shapes: kept });
            }
        }
        self.find_alike(&groups, shapes);
        for ShapeGroup { name, shapes: members } in groups {
            let shape = members.iter().map(|member| shapes[*member].name.clone()).collect();
            let mesh = file.to_owned();
            self.sections.push(ExampleSection { name: Some(name), mesh, shape, ..ExampleSection::default() });
        }
    }

    fn find_alike(&mut self, groups: &[ShapeGroup], shapes: &[Shape]) {
        let summed: Vec<Shape> = groups.iter().map(|group| sum(group, shapes)).collect();
        for (i, shape) in summed.iter().enumerate() {
            let likeness = |other: &Shape| (mesh::likeness(other, shape), other.name.clone());
            let most = summed[..i].iter().map(likeness).max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((likeness, other)) = most.filter(|(likeness, _)| *likeness > ALIKE) {
                self.alike.push(Alike { examples: [other, shape.name.clone()], likeness });
            }
        }
    }
}

/// The shapes of a group as one.
fn sum(group: &ShapeGroup, shapes: &[Shape]) -> Shape {
    let mut moved: HashMap<u32, [f64; 3]> = HashMap::new();
    for member in &group.shapes {
        for (v, by) in &shapes[*member].moved {
            let sum = moved.entry(*v).or_default();
            sum.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
        }
    }
    let mut moved: Vec<(u32, [f64; 3])> = moved.into_iter().collect();
    moved.sort_unstable_by_key(|(v, _)| *v);
    Shape { name: group.name.clone(), moved }
}

/// Refuses two examples of one name, such as `smile.obj` and `smile.ply`.
fn check_names(sections: &[ExampleSection]) -> Result<()> {
    let mut known: HashMap<&Option<String>, &Path> = HashMap::new();
    for section in sections {
        if let Some(other) = known.insert(&section.name, &section.mesh) {
            return Err(Error::conflict(format!(
                "{} and {}: both would be the example {}; rename one of them, or move it away",
                other.display(),
                section.mesh.display(),
                quoted(section.name.as_deref().unwrap_or_default())
            )));
        }
    }
    Ok(())
}
