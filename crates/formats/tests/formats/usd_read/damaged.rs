//! Any bytes give a layer or an error message.
use super::make;
use crate::animation::{Random, UvKind, with_everything};
use rhytid_core::Error;
use rhytid_formats::usd::read;

/// Reads all there is; returns the sentence if it cannot be read.
pub(super) fn read_all(bytes: &[u8]) -> Option<String> {
    let read = || {
        let read::Opened { layer, mut samples, .. } = read::decode(bytes.to_vec(), "face.usd")?;
        let mut numbers = Vec::new();
        let mut open: Vec<_> = layer.prims.iter().collect();
        while let Some(prim) = open.pop() {
            open.extend(&prim.children);
            numbers.extend(prim.properties.iter().filter_map(|property| match property {
                rhytid_formats::usd::layer::Property::Attribute(attribute) => attribute.samples,
                _ => None,
            }));
        }
        for n in numbers {
            for i in 0..samples.times(n).len() {
                samples.read(n, i)?;
            }
        }
        Ok(())
    };
    match read() {
        Ok(()) => None,
        Err(Error::Input(message)) => {
            assert!(
                message.sentence().starts_with("face.usd") && message.sentence().len() < 1000,
                "{message}"
            );
            Some(message.to_string())
        }
        Err(other) => panic!("expected an input error, found {other:?}"),
    }
}

/// Small files of each kind, by us and by USD's own library.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path(), "0.8.0", &[]);
    let mut files = Vec::new();
    for kind in ["usda", "usdc", "usdz"] {
        let path = folder.path().join(format!("face.{kind}"));
        with_everything(UvKind::PerCorner, 2, 5).export(&path).unwrap();
        files.push((kind, std::fs::read(path).unwrap()));
    }
    for kind in ["usda", "usdc"] {
        files.push((kind, std::fs::read(folder.path().join(format!("small-0.8.0.{kind}"))).unwrap()));
    }
    for (_, file) in &files {
        assert_eq!(read_all(file), None);
    }
    files
}

#[test]
fn every_cut_gives_a_sentence() {
    for (kind, bytes) in files() {
        // Text may lose the line ends behind its last bracket.
        let end = if kind == "usda" { bytes.trim_ascii_end().len() } else { bytes.len() };
        let step = (end / 3000).max(1);
        for len in (0..end).step_by(step).chain(end - 1..end) {
            let Some(message) = read_all(&bytes[..len]) else {
                // Text may end behind any of its outermost brackets.
                let line = bytes[..len].trim_ascii_end().rsplit(|&c| c == b'\n').next().unwrap();
                assert!(
                    kind == "usda" && (line.starts_with(b"#usda 1.") || matches!(line, b")" | b"}")),
                    "{kind} cut to {len}"
                );
                continue;
            };
            assert!(
                message.contains("cut short")
                    || message.contains("damaged")
                    || message.contains("is it a USD file")
                    || message.contains("empty")
                    || message.contains("goes beyond its line"),
                "{message}"
            );
        }
    }
}

#[test]
fn changed_bytes_do_no_harm() {
    for (kind, bytes) in files() {
        let mut random = Random(7);
        let mut refused = 0;
        for _ in 0..2000 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + random.below(4) {
                let at = random.below(bytes.len() as u64) as usize;
                damaged[at] = match random.below(3) {
                    0 => 0xff,
                    1 => damaged[at] ^ 1 << random.below(8),
                    _ => random.below(256) as u8,
                };
            }
            refused += usize::from(read_all(&damaged).is_some());
        }
        assert!(refused > 100, "{kind}: only {refused} of 2000 are refused");
    }
}

#[test]
fn swapped_and_foreign_files_are_named() {
    for (bytes, expected) in [
        (&b""[..], "is empty"),
        (b"glTF\x02\0\0\0", "is it a USD file?"),
        (b"PXR-USDC\0\x08\0\0\0\0\0\0", "cut short"),
        (&[b"PXR-USDC\0\x01".as_slice(), &[0; 90]].concat(), "version 0.1, expected 0.4"),
        (b"#usda 1.0\n(\n    upAxis = 3\n)", "line 3"),
        (b"#usda 1.0\ndef Mesh \"a\"\n{\n    int[] x = [1, 2\n", "line 5"),
        (b"#usda 1.0\ndef Mesh \"a\"\n{\n    int[] x = [1, 2.5]\n}", "found “2.5”"),
    ] {
        let message = read_all(bytes).unwrap();
        assert!(message.contains(expected), "“{message}” lacks “{expected}”");
    }
}

#[test]
fn what_is_nested_too_deep_is_refused() {
    let prims = "def \"a\" { ".repeat(100_000);
    let message = read_all(format!("#usda 1.0\n{prims}").as_bytes()).unwrap();
    assert!(message.contains("more than 64 deep"), "{message}");
    let dictionaries = "dictionary a = { ".repeat(100_000);
    let message = read_all(format!("#usda 1.0\n( customLayerData = {{ {dictionaries}").as_bytes()).unwrap();
    assert!(message.contains("more than 32 deep"), "{message}");
    let brackets = "(".repeat(1_000_000);
    assert!(read_all(format!("#usda 1.0\n( a = {brackets}").as_bytes()).is_some());
}
