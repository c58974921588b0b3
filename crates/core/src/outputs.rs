//! Outputs that would overwrite their inputs.

use crate::Error;
use crate::InputErrorKind;
use crate::Result;
use crate::folder_of;
use crate::protected::would_overwrite;
use same_file::is_same_file;
use std::path::{Path, PathBuf};

/// Refuses outputs that would overwrite a file that is read, or another output. Names, links and `..` do not
/// hide that two files are one. Call this before the work. What is read later is refused by
/// [`protect_inputs`](crate::protect_inputs).
///
/// # Errors
/// [`Error::Input`].
pub fn refuse_inputs<'a>(
    outputs: &[&Path],
    inputs: impl IntoIterator<Item = &'a Path> + Clone,
) -> Result<()> {
    for (i, output) in outputs.iter().enumerate() {
        if let Some(input) = inputs.clone().into_iter().find(|input| are_one(output, input)) {
            return Err(would_overwrite(output, input));
        }
        if let Some(other) = outputs[..i].iter().find(|other| is_one(output, other)) {
            return Err(Error::input(format!(
                "{}: is given for two outputs, because it is the same file as {}; choose two names",
                output.display(),
                other.display()
            ))
            .of_kind(InputErrorKind::WouldOverwrite { file: (*other).to_owned() }));
        }
    }
    Ok(())
}

/// Whether two names are of one file. A name without a file is of none. Pipes are left out, since the
/// comparison opens its files, and opening a pipe waits for the other end.
pub(crate) fn are_one(a: &Path, b: &Path) -> bool {
    let is_file = |path: &Path| std::fs::metadata(path).is_ok_and(|found| found.is_file());
    is_file(a) && is_file(b) && is_same_file(a, b).unwrap_or(false)
}

/// Whether two outputs are one file. They need not exist yet.
fn is_one(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| -> Option<PathBuf> {
        Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?))
    };
    are_one(a, b) || place(a).is_some_and(|a| place(b).is_some_and(|b| a == b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_is_known_by_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("sub")).unwrap();
        for name in ["rig", "take"] {
            std::fs::write(at(name), name).unwrap();
        }
        std::fs::hard_link(at("rig"), at("hard")).unwrap();
        let (rig, take) = (at("rig"), at("take"));
        let refused = |outputs: &[&Path]| {
            refuse_inputs(outputs, [&rig, &take].map(PathBuf::as_path)).map_err(|e| e.to_string())
        };
        let mut names = vec![at("rig"), at("sub/../rig"), at("hard")];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("rig", at("soft")).unwrap();
            names.push(at("soft"));
        }
        for name in &names {
            assert!(refused(&[name]).unwrap_err().contains("which this command reads"), "{}", name.display());
        }
        refused(&[&at("new"), &at("sub/new")]).unwrap();
        assert!(refused(&[&at("new"), &at("sub/../new")]).unwrap_err().contains("is given for two outputs"));
    }
}
