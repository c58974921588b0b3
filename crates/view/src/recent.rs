//! The files that were opened lately, kept in the user's configuration folder.

use etcetera::BaseStrategy;
use rhytid_core::{AtomicFile, Error, Result};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The most files that are kept.
const MOST: usize = 12;

/// The files that were opened lately, the newest first.
#[derive(Debug, Default)]
pub(crate) struct Recent {
    /// Where they are kept, one in a line. `None` where they are forgotten with the window.
    kept_in: Option<PathBuf>,
    files: Vec<PathBuf>,
}

impl Recent {
    /// The file of this user. `None` without a configuration folder.
    pub(crate) fn of_user() -> Option<PathBuf> {
        let folders = etcetera::choose_base_strategy().ok()?;
        Some(folders.config_dir().join("rhytid").join("recent.txt"))
    }

    /// Those that are kept in a file.
    pub(crate) fn kept_in(file: PathBuf) -> Self {
        // There is none at first.
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let files = text.lines().filter(|line| !line.is_empty()).map(PathBuf::from).take(MOST).collect();
        Self { kept_in: Some(file), files }
    }

    /// Those that are still there, the newest first.
    pub(crate) fn there(&self) -> Vec<PathBuf> {
        self.files.iter().filter(|file| file.exists()).cloned().collect()
    }

    /// Puts a file that was opened at the beginning.
    ///
    /// # Errors
    /// As writing.
    pub(crate) fn add(&mut self, file: &Path) -> Result<()> {
        let file = std::path::absolute(file).map_err(Error::io(file))?;
        if self.files.first() == Some(&file) {
            return Ok(());
        }
        self.files.retain(|other| *other != file);
        self.files.insert(0, file);
        self.files.truncate(MOST);
        let Some(to) = &self.kept_in else { return Ok(()) };
        if let Some(folder) = to.parent() {
            std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
        }
        let mut out = AtomicFile::create(to)?;
        // A name with a line break, or without text, is not kept.
        let lines = self.files.iter().filter_map(|file| file.to_str().filter(|name| !name.contains('\n')));
        for line in lines {
            writeln!(out, "{line}").map_err(out.error())?;
        }
        out.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_kept_newest_first_and_once() {
        let folder = tempfile::tempdir().unwrap();
        let kept = folder.path().join("rhytid").join("recent.txt");
        let names: Vec<PathBuf> = (0..MOST + 2).map(|i| folder.path().join(format!("{i}.csv"))).collect();
        names.iter().for_each(|name| std::fs::write(name, "").unwrap());
        let mut recent = Recent::kept_in(kept.clone());
        assert!(recent.there().is_empty());
        for name in names.iter().chain(&names[..1]) {
            recent.add(name).unwrap();
        }
        let again = Recent::kept_in(kept);
        assert_eq!(again.there(), recent.there());
        assert_eq!(again.there().len(), MOST);
        assert_eq!(again.there()[..2], [names[0].clone(), names[MOST + 1].clone()]);
        std::fs::remove_file(&names[0]).unwrap();
        assert_eq!(again.there()[0], names[MOST + 1], "a file that is gone is not offered");
    }
}
