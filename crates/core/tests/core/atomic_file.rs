//! Files that appear only when they are whole.
use rhytid_core::{AtomicFile, Error};
use std::fs;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[track_caller]
fn refused(path: &Path, words: &[&str]) {
    match AtomicFile::create(path) {
        Err(Error::Input(message)) => {
            for word in words {
                assert!(message.sentence().contains(word), "{word}: {message}");
            }
        }
        other => panic!("{}: {other:?}", path.display()),
    }
}

#[test]
fn dropped_before_the_end_it_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    // This is more than the buffer holds, so bytes do reach the disk.
    let much = vec![1u8; 3 << 20];
    let mut file = AtomicFile::create(&path).unwrap();
    assert_eq!(file.path(), path);
    file.write_all(&much).unwrap();
    assert!(!path.exists());
    drop(file);
    assert_eq!(names(folder.path()), [""; 0]);

    fs::write(&path, "old").unwrap();
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(&much).unwrap();
    file.flush().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"old");
    drop(file);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["out.glb"]);
}

#[test]
fn finished_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    for content in ["a first content", "another"] {
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"?").unwrap();
        file.write_all(&content.as_bytes()[1..]).unwrap();
        // A length or a count is often known only at the end.
        file.seek(SeekFrom::Start(0)).unwrap();
        file.write_all(&content.as_bytes()[..1]).unwrap();
        file.finish().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), content);
        assert_eq!(names(folder.path()), ["out.glb"]);
    }
}

#[test]
fn a_spool_has_no_name_and_is_gone_when_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let file = AtomicFile::create(&folder.path().join("out.glb")).unwrap();
    let mut spool = file.spool().unwrap();
    spool.write_all(b"later").unwrap();
    spool.seek(SeekFrom::Start(0)).unwrap();
    let mut text = String::new();
    spool.read_to_string(&mut text).unwrap();
    assert_eq!(text, "later");
    drop(spool);
    file.finish().unwrap();
    assert_eq!(names(folder.path()), ["out.glb"]);
}

#[test]
fn a_name_that_is_no_file_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing");
    refused(&missing.join("out.glb"), &["out.glb: the folder ", "missing does not exist; create it first"]);
    refused(folder.path(), &["is a folder, expected the name of a file"]);
    // A name with a separator at its end asks for a folder, whether the folder exists or not.
    refused(&folder.path().join("out.glb/"), &["out.glb/", "is a folder"]);
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    refused(&file.join("out.glb"), &["the folder ", "file is a file; choose another one"]);
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn a_bare_name_is_in_the_current_folder() {
    // The file is never finished, so the test leaves no file in the repository.
    let name = PathBuf::from("write-beside-test.partial");
    let file = AtomicFile::create(&name).unwrap();
    assert_eq!(file.path(), name);
    drop(file);
    assert!(!name.exists());
}

#[cfg(unix)]
#[test]
fn others_may_read_it_as_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let ordinary = folder.path().join("ordinary");
    fs::File::create(&ordinary).unwrap();
    let path = folder.path().join("out.glb");
    AtomicFile::create(&path).unwrap().finish().unwrap();
    assert_eq!(mode(&path), mode(&ordinary), "{:o}", mode(&path));
}

/// An error of the disk names the file that was asked for, not the temporary one.
#[test]
fn errors_name_the_file_that_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    let file = AtomicFile::create(&path).unwrap();
    let error = file.error()(std::io::Error::other("no space left"));
    assert_eq!(error.to_string(), format!("{}: no space left", path.display()));
    // Meanwhile a folder of that name appears.
    fs::create_dir(&path).unwrap();
    fs::write(path.join("inside"), "").unwrap();
    assert!(matches!(file.finish(), Err(Error::Io { path: named, .. }) if named == path));
    assert_eq!(names(folder.path()), ["out.glb"]);
}

#[cfg(unix)]
mod unix {
    use super::{AtomicFile, fs, names, refused};
    use std::io::Write;
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::path::Path;

    fn write(path: &Path, text: &str) {
        let mut file = AtomicFile::create(path).unwrap();
        file.write_all(text.as_bytes()).unwrap();
        file.finish().unwrap();
    }

    #[test]
    fn a_file_that_is_replaced_keeps_its_mode() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        for mode in [0o600, 0o664, 0o755] {
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            write(&path, "new");
            assert_eq!(fs::read_to_string(&path).unwrap(), "new");
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o7777, mode);
        }
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        refused(&path, &["out.csv: is read-only", "choose another name"]);
        assert_eq!(names(folder.path()), ["out.csv"]);
    }

    #[test]
    fn links_stay_and_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("there")).unwrap();
        fs::write(at("there/file.csv"), "old").unwrap();
        symlink("there/file.csv", at("link.csv")).unwrap();
        symlink("link.csv", at("second.csv")).unwrap();
        symlink("there/not_yet.csv", at("dangling.csv")).unwrap();
        write(&at("second.csv"), "new");
        write(&at("dangling.csv"), "made");
        for link in ["link.csv", "second.csv", "dangling.csv"] {
            assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink(), "{link}");
        }
        assert_eq!(fs::read_to_string(at("there/file.csv")).unwrap(), "new");
        assert_eq!(fs::read_to_string(at("there/not_yet.csv")).unwrap(), "made");
        symlink("b.csv", at("a.csv")).unwrap();
        symlink("a.csv", at("b.csv")).unwrap();
        refused(&at("a.csv"), &["a.csv: is a link that leads back to itself"]);
    }

    #[test]
    fn what_is_no_regular_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket.csv");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        refused(&socket, &["socket.csv: is a device, a pipe or a socket"]);
        symlink("socket.csv", folder.path().join("link.csv")).unwrap();
        refused(&folder.path().join("link.csv"), &["link.csv: is a device, a pipe or a socket"]);
        assert!(fs::symlink_metadata(&socket).is_ok());
    }
}
