//! Animations that become shorter behind an open reader's back: an error at the frame that is gone.
use crate::animation::{UvKind, with_everything};
use rhytid_core::Error;
use rhytid_formats::animation;
use rhytid_formats::export::Options;
use std::io::ErrorKind;

#[test]
fn what_is_gone_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let options = Options { force: true, ..Options::default() };
    for extension in ["usda", "usdc", "usdz", "glb", "gltf"] {
        let path = folder.path().join(format!("face.{extension}"));
        with_everything(UvKind::PerCorner, 60, 5).for_file(&path).export_with(&path, &options).unwrap();
        let mut reader = animation::open(&path).unwrap();
        // The text is short, and its numbers are beside it.
        let numbers = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let numbers = match extension {
            "gltf" => numbers.into_iter().find(|path| path.extension().is_some_and(|e| e == "bin")).unwrap(),
            _ => path,
        };
        let size = std::fs::metadata(&numbers).unwrap().len();
        std::fs::OpenOptions::new().write(true).open(&numbers).unwrap().set_len(size / 3).unwrap();
        let mut out = Vec::new();
        let errors = (0..60).filter_map(|frame| reader.positions(frame, &mut out).err());
        match errors.last() {
            // What is read whole, at the beginning.
            None => assert_eq!(extension, "usda"),
            Some(Error::Io { source, .. }) => {
                assert_eq!(source.kind(), ErrorKind::UnexpectedEof, "{extension}");
            }
            Some(other) => panic!("{extension}: {other:?}"),
        }
    }
}
