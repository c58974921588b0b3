//! The text of a new project file.

use crate::args;
use rhytid::core::UpAxis;
use rhytid::formats::project::{ExampleSection, Units};
use std::path::{Component, Path, PathBuf};

/// What a project says.
pub(super) struct Content<'a> {
    /// The folder of the project file.
    pub(super) folder: &'a Path,
    /// As seen from the working folder.
    pub(super) neutral: &'a Path,
    pub(super) units: Units,
    pub(super) up: UpAxis,
    /// Of each, its mesh is as seen from the working folder.
    pub(super) sections: &'a [ExampleSection],
    /// Further keys of each section, such as `unit = "m"`.
    pub(super) keys: Vec<Vec<String>>,
}

impl Content<'_> {
    /// The project file with a comment at each choice.
    pub(super) fn text(&self) -> String {
        let in_toml = |path: &Path| toml_text(&relative(self.folder, path));
        let mut text = format!(
            "# A Rhytid project: paths are relative to this file. All keys:\n# {}project-file.md\n\n\
             # Examples that are not in the neutral's place are put there; false keeps them where they are.\n\
             align = true\n\n\
             [mesh]\n\
             neutral = {}\n\
             units = {}   # m, cm, mm, in, or metres per unit\n\
             up = \"{}\"\n\n\
             [handles]\n\
             vertices = \"markers.csv\"   # look at markers.png\n\n",
            args::DOCS,
            in_toml(self.neutral),
            unit_text(self.units),
            if self.up == UpAxis::Y { "y" } else { "z" }
        );
        if self.sections.iter().any(|section| section.shape.len() > 1) {
            text += "# Shapes of both sides are worn together, as one example.\n";
        }
        for (section, keys) in self.sections.iter().zip(&self.keys) {
            let name = section.name.as_deref().unwrap_or_default();
            text += &format!("[[example]]\nname = {}\nmesh = {}\n", toml_text(name), in_toml(&section.mesh));
            if !section.shape.is_empty() {
                let shapes: Vec<String> = section.shape.iter().map(|shape| toml_text(shape)).collect();
                text += &match &shapes[..] {
                    [shape] => format!("shape = {shape}\n"),
                    shapes => format!("shape = [{}]\n", shapes.join(", ")),
                };
            }
            for key in keys {
                text += &format!("{key}\n");
            }
            text += "\n";
        }
        text += "# What no example moves stays, so that the back of the head does not swing. More that is to stay:\n\
                 # [pins]\n# box = [[-10, 5, -20], [10, 25, -5]]   # two corners, in mesh units\n";
        text
    }
}

/// A unit as a project names it.
pub(super) fn unit_text(units: Units) -> String {
    match units {
        Units::MetresPerUnit(metres) => metres.to_string(),
        named => format!("\"{named}\""),
    }
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
    let (from, to) = (absolute(folder), absolute(file));
    let common = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    if common <= 1 {
        return to.display().to_string();
    }
    let up = from.components().skip(common).map(|_| "..".to_owned());
    let down = to.components().skip(common).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// A path from the root on, without `..`.
fn absolute(path: &Path) -> PathBuf {
    let here = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    let mut clean = PathBuf::new();
    for part in std::path::absolute(here).unwrap_or_else(|_| here.to_owned()).components() {
        if part == Component::ParentDir {
            clean.pop();
        } else {
            clean.push(part);
        }
    }
    clean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_project() {
        for (folder, file, expected) in [
            ("", "neutral.obj", "neutral.obj"),
            ("a", "a/poses/smile.obj", "poses/smile.obj"),
            ("a/b", "a/neutral.obj", "../neutral.obj"),
            ("a/../b", "neutral.obj", "../neutral.obj"),
            ("/x/y", "/x/z/a.obj", "../z/a.obj"),
            ("/x", "/y/a.obj", "/y/a.obj"),
        ] {
            assert_eq!(relative(Path::new(folder), Path::new(file)), expected, "{folder} {file}");
        }
    }
}
