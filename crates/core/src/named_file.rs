//! Files that other files name: a project's meshes, a `.gltf`'s buffers, the parts of a USD file, a setup's
//! table of markers. A file from another person must not make Rhytid read private files and copy them into a
//! rig.

use crate::Error;
use crate::InputErrorKind;
use crate::Remedy;
use crate::Result;
use std::path::{Component, Path, PathBuf};

/// Where the files that a file names may be.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Reach {
    /// In the folder of the file that names them, or below. Paths are relative, and links lead nowhere else.
    #[default]
    Below,
    /// Anywhere. This is for a file whose author is trusted.
    Anywhere,
}

/// The path of `file`, which `namer` names as its `what`. Whether the file exists is not checked here;
/// reading it will tell.
///
/// # Errors
/// [`Error::Input`] if the file is out of reach, a link that leads nowhere, or exists and is no regular file.
pub fn named_file(namer: &Path, file: &Path, what: &str, reach: Reach) -> Result<PathBuf> {
    let path = namer.parent().unwrap_or(Path::new("")).join(file);
    let wrong =
        |why: String| Error::bad_path(format!("{}: {what} names {}, {why}", namer.display(), file.display()));
    check_reach(namer, file, what, reach)?;
    match path.metadata() {
        Ok(found) if found.is_dir() => Err(wrong("which is a folder, expected a file".into())),
        Ok(found) if !found.is_file() => {
            Err(wrong("which is a device, a pipe or a socket, expected a file".into()))
        }
        Err(_) if path.is_symlink() => {
            Err(wrong("which is a link that leads nowhere; remove it, or put its file there".into()))
        }
        _ => Ok(path),
    }
}

/// Refuses a file or a folder out of reach.
fn check_reach(namer: &Path, file: &Path, what: &str, reach: Reach) -> Result<()> {
    let folder = folder_of(namer);
    if reach == Reach::Anywhere || is_below(folder, file) {
        return Ok(());
    }
    Err(Error::bad_path(format!(
        "{}: {what} names {}, which is not in {} or below; put it there, or allow files elsewhere if you \
         trust whoever wrote this file",
        namer.display(),
        file.display(),
        folder.display()
    ))
    .of_kind(InputErrorKind::OutsideFolder { file: file.to_owned() })
    .with_remedies(&[Remedy::AllowElsewhere]))
}

/// As [`named_file`], for a folder, which has to be there.
///
/// # Errors
/// [`Error::Input`] if the folder is out of reach, does not exist or is a file.
pub fn named_folder(namer: &Path, folder: &Path, what: &str, reach: Reach) -> Result<PathBuf> {
    let path = namer.parent().unwrap_or(Path::new("")).join(folder);
    check_reach(namer, folder, what, reach)?;
    if path.is_dir() {
        return Ok(path);
    }
    Err(Error::bad_path(format!(
        "{}: {what} names {}, which is no folder; paths are relative to the project file",
        namer.display(),
        folder.display()
    ))
    .of_kind(InputErrorKind::NotThere { file: path }))
}

/// As [`named_file`], for a file that is written because `namer` names it. No file decides by itself which
/// kind of file is written.
///
/// # Errors
/// As [`named_file`]; [`Error::Input`] if the file's extension is not `extension`.
pub fn named_output(namer: &Path, file: &Path, what: &str, extension: &str, reach: Reach) -> Result<PathBuf> {
    let path = named_file(namer, file, what, reach)?;
    match path.extension() {
        Some(found) if found.eq_ignore_ascii_case(extension) => Ok(path),
        _ => Err(Error::bad_path(format!(
            "{}: {what} names {}, which would be written, expected a name that ends in .{extension}",
            namer.display(),
            file.display()
        ))),
    }
}

/// Whether `file`, seen from `folder`, is in that folder or below it. Its name and the targets of links
/// count.
pub fn is_below(folder: &Path, file: &Path) -> bool {
    let mut depth = 0_usize;
    for component in file.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => return false,
        }
    }
    let Ok(root) = folder.canonicalize() else { return true };
    // The links of a file that does not exist yet are those of its folders.
    let whole = folder.join(file);
    let found = whole.ancestors().find_map(|part| part.canonicalize().ok());
    found.is_none_or(|found| found.starts_with(&root))
}

/// The folder that a file is in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_below_is_reached() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("face/scans")).unwrap();
        for name in ["secret.obj", "face/scans/neutral.obj"] {
            std::fs::write(at(name), "").unwrap();
        }
        let project = at("face/face.toml");
        let named = |file: &Path, reach| named_file(&project, file, "[mesh] neutral", reach);
        for file in ["scans/neutral.obj", "./scans/../scans/neutral.obj", "not-there.obj"] {
            assert_eq!(named(Path::new(file), Reach::Below).unwrap(), at("face").join(file));
        }
        let mut elsewhere =
            vec![PathBuf::from("../secret.obj"), "scans/../../secret.obj".into(), at("secret.obj")];
        #[cfg(unix)]
        for (link, to) in [("link.obj", "../secret.obj"), ("folder", "..")] {
            std::os::unix::fs::symlink(to, at("face").join(link)).unwrap();
            elsewhere.push(if link == "folder" { "folder/secret.obj".into() } else { link.into() });
        }
        #[cfg(unix)]
        elsewhere.push("folder/not-there.obj".into());
        for file in &elsewhere {
            let Err(Error::Input(said)) = named(file, Reach::Below) else { panic!("{}", file.display()) };
            assert!(said.sentence().contains("[mesh] neutral names"), "{said}");
            assert_eq!(said.kind(), &InputErrorKind::OutsideFolder { file: file.clone() });
            assert_eq!(said.remedies(), [Remedy::AllowElsewhere]);
            named(file, Reach::Anywhere).unwrap();
        }
        for reach in [Reach::Below, Reach::Anywhere] {
            assert!(named(Path::new("scans"), reach).unwrap_err().to_string().contains("is a folder"));
        }
        #[cfg(unix)]
        for to in ["not-there.obj", "../not-there.obj"] {
            let link = at("face/dangling.obj");
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(to, &link).unwrap();
            for reach in [Reach::Below, Reach::Anywhere] {
                let said = named(Path::new("dangling.obj"), reach).unwrap_err().to_string();
                assert!(said.contains("a link that leads nowhere"), "{said}");
            }
        }
        let output =
            |file: &str| named_output(&project, Path::new(file), "[handles] vertices", "csv", Reach::Below);
        assert_eq!(output("markers.CSV").unwrap(), at("face/markers.CSV"));
        for (file, words) in
            [(".profile", "ends in .csv"), ("run.sh", "ends in .csv"), ("../m.csv", "not in")]
        {
            let said = output(file).unwrap_err().to_string();
            assert!(said.contains(words), "{said}");
        }
        #[cfg(unix)]
        {
            let said = named(Path::new("/dev/zero"), Reach::Anywhere).unwrap_err();
            assert!(said.to_string().contains("a device, a pipe or a socket"), "{said}");
        }
    }
}
