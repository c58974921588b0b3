//! Files beside others that name them: a `.gltf`'s numbers, a stitched USD file's manifest.
//! Two files cannot appear at once. So a companion carries a hash of its content in its name,
//! `face.1f0c….bin`, and is put in place first. If the process stops in between, every file that names a
//! companion still has the companion that it was written with.

use rhytid_core::{AtomicFile, Error, Result, folder_of};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Hexadecimal digits of the hash in a name.
const DIGITS: usize = 16;

/// How a kind of companion and the files that name it are called.
#[derive(Debug)]
pub struct Kind {
    /// The extension of the companions.
    pub extension: &'static str,
    /// The extensions of the files that name companions, in lower case.
    pub namers: &'static [&'static str],
    /// Returns every text of such a file that may name companions; there may be more around the names. `None`
    /// if the file cannot be read.
    pub names: fn(&Path) -> Option<Vec<u8>>,
}

/// A companion of the file `main`, being written. Dropped before the end, it leaves nothing behind.
pub struct Companion {
    kind: &'static Kind,
    file: AtomicFile,
    hasher: blake3::Hasher,
    main: PathBuf,
}

impl Companion {
    /// Begins the companion of `main`.
    ///
    /// # Errors
    /// [`Error::Input`] if `main` is a link; [`Error::Io`].
    pub fn create(main: &Path, kind: &'static Kind) -> Result<Self> {
        if main.is_symlink() {
            return Err(Error::bad_path(format!(
                "{}: is a link, but this format also writes a second file, which would be beside the link \
                 and not beside its target; name the target itself",
                main.display()
            )));
        }
        let file = AtomicFile::create(&main.with_file_name(name(main, kind, &"0".repeat(DIGITS))))?;
        Ok(Self { kind, file, hasher: blake3::Hasher::new(), main: main.to_owned() })
    }

    /// Appends bytes to the companion.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.hasher.update(bytes);
        self.file.write_all(bytes).map_err(self.file.error())
    }

    /// The path of a companion that holds the bytes written so far.
    pub fn path(&self) -> PathBuf {
        let hash = self.hasher.finalize().to_hex();
        self.main.with_file_name(name(&self.main, self.kind, &hash[..DIGITS]))
    }

    /// Gives the companion its name and then runs `main`, which finishes the file that names it. At the end,
    /// removes older companions of that file that no file names any more.
    pub fn finish<T>(self, main: impl FnOnce() -> Result<T>) -> Result<T> {
        finish_all(vec![self], main)
    }
}

/// As [`Companion::finish`] for all companions of one file, which may be of several kinds. Without any, it
/// just runs `main`.
pub fn finish_all<T>(companions: Vec<Companion>, main: impl FnOnce() -> Result<T>) -> Result<T> {
    let Some(first) = companions.first() else { return main() };
    let (path, folder) = (first.main.clone(), folder_of(&first.main).to_owned());
    let mut kinds: Vec<&'static Kind> = Vec::new();
    for companion in &companions {
        if kinds.iter().all(|kind| !std::ptr::eq(*kind, companion.kind)) {
            kinds.push(companion.kind);
        }
    }
    // The lock makes two writers of one name take turns. Where folders cannot be locked, the later writer may
    // leave the companions of the other behind.
    let _lock = File::open(folder).and_then(|folder| folder.lock().map(|()| folder));
    let mut new = Vec::new();
    let mut named = Ok(());
    for companion in companions {
        let path = companion.path();
        let was_there = path.exists();
        named = companion.file.finish_as(&path);
        if named.is_err() {
            break;
        }
        new.extend((!was_there).then_some(path));
    }
    let done = named.and_then(|()| main()).inspect_err(|_| {
        for path in &new {
            // If the removal fails too, a file that nobody needs stays behind: the lesser fault.
            let _ = std::fs::remove_file(path);
        }
    })?;
    for kind in kinds {
        remove_unnamed(&path, kind);
    }
    Ok(done)
}

/// The name of the companion with this hash.
fn name(main: &Path, kind: &Kind, hash: &str) -> OsString {
    let mut name = main.file_stem().unwrap_or_default().to_owned();
    name.push(format!(".{hash}.{}", kind.extension));
    name
}

/// Removes the companions of `main` that no file in its folder names any more. If one of the files that may
/// name companions cannot be read, all companions stay.
fn remove_unnamed(main: &Path, kind: &Kind) {
    let Ok(entries) = std::fs::read_dir(folder_of(main)) else { return };
    let names: Vec<OsString> = entries.flatten().map(|entry| entry.file_name()).collect();
    let mut candidates: Vec<(&OsString, &[u8])> =
        names.iter().filter_map(|name| Some((name, hash_of(name, main, kind)?))).collect();
    for name in &names {
        let path = main.with_file_name(name);
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        if candidates.is_empty() || !kind.namers.iter().any(|namer| extension == *namer) || !path.is_file() {
            continue;
        }
        let Some(text) = (kind.names)(&path) else { return };
        candidates.retain(|(_, hash)| !text.windows(DIGITS).any(|part| part == *hash));
    }
    for (name, _) in candidates {
        let _ = std::fs::remove_file(main.with_file_name(name));
    }
}

/// The hash in `name`, if it is the name of a companion of `main`.
fn hash_of<'a>(name: &'a OsStr, main: &Path, kind: &Kind) -> Option<&'a [u8]> {
    let name = name.as_encoded_bytes().strip_prefix(main.file_stem()?.as_encoded_bytes())?;
    let hash = name.strip_prefix(b".")?.strip_suffix(kind.extension.as_bytes())?.strip_suffix(b".")?;
    let is_hash = hash.len() == DIGITS && hash.iter().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f'));
    is_hash.then_some(hash)
}

#[cfg(test)]
mod tests {
    use super::*;

    static KIND: Kind = Kind { extension: "bin", namers: &["gltf"], names: |path| std::fs::read(path).ok() };

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// Writes `main`, which names a companion with the text, and returns the companion's name.
    fn write(main: &Path, text: &str) -> String {
        let mut companion = Companion::create(main, &KIND).unwrap();
        companion.write(text.as_bytes()).unwrap();
        let name = companion.path().file_name().unwrap().to_str().unwrap().to_owned();
        companion.finish(|| std::fs::write(main, &name).map_err(Error::io(main))).unwrap();
        name
    }

    fn text_of(main: &Path) -> String {
        std::fs::read_to_string(main.with_file_name(std::fs::read_to_string(main).unwrap())).unwrap()
    }

    #[test]
    fn it_goes_when_nobody_names_it_any_more() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let main = at("face.gltf");
        // The first file was left behind by a process that was killed. The others belong to somebody else.
        std::fs::write(at("face.0123456789abcdef.bin"), "").unwrap();
        for name in [
            "face.bin",
            "face.0123456789ABCDEF.bin",
            "face.0123456789abcdef.txt",
            "other.0123456789abcdef.bin",
        ] {
            std::fs::write(at(name), "").unwrap();
        }
        let kept = names(folder.path()).len() - 1;
        let first = write(&main, "first");
        assert_eq!(names(folder.path()).len(), kept + 2);
        assert!(!at("face.0123456789abcdef.bin").exists());
        let second = write(&main, "second");
        assert!(!at(&first).exists() && at(&second).exists());
        // The renamed file keeps its companion.
        std::fs::rename(&main, at("renamed.gltf")).unwrap();
        write(&main, "third");
        assert_eq!([text_of(&at("renamed.gltf")), text_of(&main)], ["second", "third"]);
        std::fs::remove_file(at("renamed.gltf")).unwrap();
        write(&main, "third");
        assert_eq!(names(folder.path()).len(), kept + 2);
    }

    #[test]
    fn several_of_several_kinds_appear_together_or_not_at_all() {
        static IMAGE: Kind =
            Kind { extension: "png", namers: &["gltf"], names: |path| std::fs::read(path).ok() };
        let folder = tempfile::tempdir().unwrap();
        let main = folder.path().join("face.gltf");
        let write = |texts: &[(&'static Kind, &str)], works: bool| {
            let (mut companions, mut text) = (Vec::new(), String::new());
            for (kind, content) in texts {
                let mut companion = Companion::create(&main, kind).unwrap();
                companion.write(content.as_bytes()).unwrap();
                text += companion.path().file_name().unwrap().to_str().unwrap();
                companions.push(companion);
            }
            let finish = || {
                if works {
                    std::fs::write(&main, &text).map_err(Error::io(&main))
                } else {
                    Err(Error::bad_path("no"))
                }
            };
            assert_eq!(finish_all(companions, finish).is_ok(), works);
        };
        let all = [(&KIND, "numbers"), (&IMAGE, "skin"), (&IMAGE, "teeth")];
        write(&all, false);
        assert_eq!(names(folder.path()), [""; 0]);
        write(&all, true);
        let before = names(folder.path());
        assert_eq!(before.len(), 4);
        write(&[(&IMAGE, "lashes"), (&KIND, "numbers")], false);
        assert_eq!(names(folder.path()), before);
        // What is not named any more goes, of each kind that was written.
        write(&[(&IMAGE, "skin"), (&KIND, "other numbers")], true);
        let after = names(folder.path());
        assert_eq!(after.len(), 3);
        assert_eq!(after.iter().filter(|name| before.contains(name)).count(), 2);
    }

    #[test]
    fn what_stood_there_stays_whole_when_the_main_file_fails() {
        let folder = tempfile::tempdir().unwrap();
        let main = folder.path().join("face.gltf");
        let fails = |text: &str| {
            let mut companion = Companion::create(&main, &KIND).unwrap();
            companion.write(text.as_bytes()).unwrap();
            companion.finish(|| Err::<(), _>(Error::bad_path("no"))).unwrap_err();
        };
        fails("first");
        assert_eq!(names(folder.path()), [""; 0]);
        write(&main, "first");
        let before = names(folder.path());
        for text in ["first", "second"] {
            fails(text);
            assert_eq!((names(folder.path()), text_of(&main)), (before.clone(), "first".to_owned()));
        }
    }
}
