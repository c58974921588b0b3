//! Parts put together, as USD's own library plays them, in its oldest and newest tested version, and as we
//! read them. The programs come from `cargo xtask setup`.

mod levels;

use crate::animation::{Animation, UvKind, with_everything};
use rhytid_core::{Channel, ChannelKind, Error, Remedy, UpAxis};
use rhytid_formats::animation::{open, open_within};
use rhytid_formats::{Reach, usd};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Frames of the whole, and where its parts begin.
const FRAMES: usize = 9;
const BEGINS: [usize; 4] = [0, 4, 5, 7];
const FIRST_TIME_CODE: f64 = 11.0;

fn whole() -> Animation {
    let mut whole = with_everything(UvKind::PerCorner, FRAMES, 21);
    whole.first_time_code = FIRST_TIME_CODE;
    whole.state("first_frame", 11);
    whole.state("end_frame", 20);
    whole
}

/// The frames `begin..end` of `whole`, as `--frames` exports them.
fn cut(whole: &Animation, begin: usize, end: usize) -> Animation {
    let mut part = whole.clone();
    part.frames = whole.frames[begin..end].to_vec();
    part.others.iter_mut().for_each(|other| other.frames = other.frames[begin..end].to_vec());
    part.head = whole.head.as_ref().map(|all| all[begin..end].to_vec());
    part.first_time_code += begin as f64;
    part.state("first_frame", 11 + begin as u64);
    part.state("end_frame", 11 + end as u64);
    part
}

/// Exports the parts into `folder/parts`.
fn export_parts(whole: &Animation, folder: &Path, extension: &str) -> Vec<PathBuf> {
    let parts = folder.join("parts");
    std::fs::create_dir_all(&parts).unwrap();
    let ends = BEGINS[1..].iter().copied().chain([FRAMES]);
    let export = |(begin, end)| {
        let path = parts.join(format!("part {begin}.{extension}"));
        cut(whole, begin, end).export(&path).unwrap();
        path
    };
    BEGINS.into_iter().zip(ends).map(export).collect()
}

/// Pythons with USD 26.11 and 24.3.
fn pythons() -> [PathBuf; 2] {
    [rhytid_test_support::python(), rhytid_test_support::python_usd_24_3()]
}

#[test]
fn usd_plays_the_parts_as_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole();
    for (parts, output) in
        [("usd", "usd"), ("usda", "usda"), ("usd", "usda"), ("usda", "usdc"), ("usdz", "usd")]
    {
        let case = folder.path().join(format!("{parts} in {output}"));
        std::fs::create_dir(&case).unwrap();
        let mut paths = export_parts(&whole, &case, parts);
        paths.reverse();
        whole.export(&case.join("whole.usd")).unwrap();
        let stitched = case.join(format!("stitched.{output}"));
        let done = usd::stitch(&paths, &stitched).unwrap();
        assert_eq!((done.parts, done.frames, done.time_codes), (4, FRAMES, [11.0, 19.0]));
        assert_eq!(done.bytes, std::fs::metadata(&stitched).unwrap().len());
        assert!(done.manifest.exists(), "{}", done.manifest.display());
        let mut written = std::fs::read_dir(&case).unwrap().map(|entry| entry.unwrap().file_name());
        assert_eq!(written.by_ref().count(), 4, "parts, whole, stitched and manifest");
        // The name of the file is nowhere in it, so that it may have another.
        std::fs::rename(stitched, case.join(format!("renamed.{output}"))).unwrap();
    }
    for python in pythons() {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/stitch/check.py");
        let output = Command::new(python).arg(script).arg(folder.path()).output().unwrap();
        let printed = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
        assert!(printed.contains("5 renamed files play as the whole"), "{printed}");
    }
}

#[test]
fn we_read_the_parts_as_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole();
    let paths = export_parts(&whole, folder.path(), "usd");
    let stitched = folder.path().join("stitched.usd");
    usd::stitch(&paths, &stitched).unwrap();
    let plain = folder.path().join("whole.usd");
    whole.export(&plain).unwrap();
    let [mut stitched, mut plain] = [&stitched, &plain].map(|path| open(path).unwrap());
    assert_eq!(stitched.summary(), plain.summary());
    let [mut a, mut b] = [Vec::new(), Vec::new()];
    for frame in (0..FRAMES).rev() {
        for channel in plain.summary().channels.clone() {
            stitched.channel(&channel, frame, &mut a).unwrap();
            plain.channel(&channel, frame, &mut b).unwrap();
            assert!(!a.is_empty() && a == b, "{}", channel.name);
        }
        assert_eq!(stitched.head(frame).unwrap(), plain.head(frame).unwrap());
    }
}

#[test]
fn parts_by_another_version_of_the_program_are_parts() {
    let folder = tempfile::tempdir().unwrap();
    let paths = export_parts(&whole(), folder.path(), "usd");
    let mut part = cut(&whole(), 4, 5);
    part.state("version", "1.2.4");
    part.export(&paths[1]).unwrap();
    let stitched = folder.path().join("stitched.usd");
    usd::stitch(&paths, &stitched).unwrap();
    assert_eq!(open(&stitched).unwrap().summary().frames, FRAMES);
}

/// Only who needs the choice, as `rhytid verify` does, refuses a word that is not known.
#[test]
fn words_of_a_later_version_are_read_and_kept() {
    for extension in ["usd", "usda"] {
        let folder = tempfile::tempdir().unwrap();
        let mut later = whole();
        later.state("stage", "pores");
        later.state("missing", "guess");
        later.state("pores", true);
        let paths = export_parts(&later, folder.path(), extension);
        let stitched = folder.path().join(format!("stitched.{extension}"));
        usd::stitch(&paths, &stitched).unwrap();
        assert_eq!(open(&stitched).unwrap().summary().recipe, Some(later.recipe));

        cut(&whole(), 4, 5).export(&paths[1]).unwrap();
        let message = sentence(usd::stitch(&paths, &stitched));
        assert!(message.contains("stage: full and pores"), "{message}");
    }
}

#[test]
fn a_manifest_that_is_missing_or_of_other_parts_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let mut whole = whole();
    let paths = export_parts(&whole, folder.path(), "usd");
    let stitched = folder.path().join("stitched.usd");
    let renamed = folder.path().join("renamed.usd");
    let manifest = usd::stitch(&paths, &stitched).unwrap().manifest;
    std::fs::rename(&stitched, &renamed).unwrap();
    assert!(open(&renamed).is_ok());

    // Others are stitched under the old name, which leaves the manifest alone.
    let others = folder.path().join("others");
    whole.with_normals = false;
    let other = usd::stitch(&export_parts(&whole, &others, "usd"), &stitched).unwrap().manifest;
    assert!(open(&stitched).is_ok() && open(&renamed).is_ok());

    std::fs::copy(&other, &manifest).unwrap();
    let message = sentence(open(&renamed));
    assert!(message.contains(".manifest.usdc: does not declare /face/face_mesh.normals"), "{message}");
    std::fs::write(&manifest, "#usda 1.0\n").unwrap();
    let message = sentence(open(&renamed));
    assert!(message.contains("does not declare /face, which has samples"), "{message}");
    std::fs::remove_file(&manifest).unwrap();
    let message = sentence(open(&renamed));
    assert!(message.contains("manifest") && message.contains("is not there"), "{message}");
}

#[test]
fn a_file_that_cannot_be_written_leaves_no_manifest() {
    let folder = tempfile::tempdir().unwrap();
    let paths = export_parts(&whole(), folder.path(), "usd");
    let out = folder.path().join("out");
    std::fs::create_dir_all(out.join("taken.usd")).unwrap();
    assert!(sentence(usd::stitch(&paths, &out.join("taken.usd"))).contains("is a folder"));
    let names: Vec<_> = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 1, "{names:?}");
}

#[test]
fn parts_that_changed_since_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole();
    let paths = export_parts(&whole, folder.path(), "usd");
    let stitched = folder.path().join("stitched.usd");
    usd::stitch(&paths, &stitched).unwrap();
    for path in &paths {
        let at = paths.iter().position(|p| p == path).unwrap();
        let end = BEGINS.get(at + 1).copied().unwrap_or(FRAMES);
        let mut part = cut(&whole, BEGINS[at], end);
        part.state("rig", "another");
        part.export(path).unwrap();
    }
    let message = sentence(open(&stitched));
    assert!(message.contains("stitch them again"), "{message}");
}

#[track_caller]
fn sentence<T>(result: rhytid_core::Result<T>) -> String {
    match result {
        Err(Error::Input(message)) => message.to_string(),
        Err(other) => panic!("expected an input error, found {other:?}"),
        Ok(_) => panic!("expected an input error, found success"),
    }
}

#[test]
fn parts_that_do_not_follow_one_another_are_named_with_their_frames() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.usd");
    let paths = export_parts(&whole(), folder.path(), "usd");
    let [a, b, c, d] = &paths[..] else { panic!("four parts") };

    let message = sentence(usd::stitch(&[a.clone(), d.clone(), b.clone()], &output));
    assert!(message.contains("frames 16 to 17 are in no part"), "{message}");
    assert!(
        message.contains("part 4.usd ends with 15") && message.contains("part 7.usd begins with 18"),
        "{message}"
    );

    let message = sentence(usd::stitch(&[a.clone(), b.clone(), a.clone(), c.clone()], &output));
    assert!(message.contains("overlap") && message.contains("part 0.usd"), "{message}");
    assert!(message.contains("ends with frame 14 and the second begins with 11, expected 15"), "{message}");
    assert!(!output.exists());
}

#[test]
fn parts_of_other_animations_are_refused() {
    type Damage = fn(&mut Animation);
    let damages: [(&str, Damage); 14] = [
        ("rig: other and 0123456789abcdef", |a| a.state("rig", "other")),
        ("stage: large-scale and full", |a| a.state("stage", "large-scale")),
        ("fps: 24", |a| a.state("fps", 24.0)),
        ("missing: error and hold", |a| a.state("missing", "error")),
        ("fade_detail: false and true", |a| a.state("fade_detail", false)),
        ("head: bake and drop", |a| a.state("head", "bake")),
        ("treatment: ", |a| a.state("treatment", serde_json::json!({ "rate": 25.0 }))),
        ("something_new: 3 and none", |a| a.state("something_new", 3)),
        ("the channel strain is different in each", |a| {
            let vertices = a.rest.len();
            let strain = a.others.iter_mut().find(|other| other.channel.name == "strain").unwrap();
            strain.channel = Channel::of_file("strain", 1);
            strain.frames.iter_mut().for_each(|numbers| numbers.truncate(vertices));
        }),
        ("frames per second: 25 and 30", |a| a.rate = 25.0),
        ("metres per unit: 1 and 0.01", |a| a.metres_per_unit = 1.0),
        ("the up axis: Z and Y", |a| a.up_axis = UpAxis::Z),
        ("with normals: no and yes", |a| a.with_normals = false),
        ("their faces are different", |a| a.faces.indices.swap(0, 1)),
    ];
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.usd");
    let paths = export_parts(&whole(), folder.path(), "usd");
    for (expected, damage) in damages {
        let mut part = cut(&whole(), 4, 5);
        damage(&mut part);
        part.export(&paths[1]).unwrap();
        let message = sentence(usd::stitch(&paths, &output));
        assert!(message.contains(expected), "“{message}” lacks “{expected}”");
        assert!(message.contains("part 0.usd") && message.contains("part 4.usd"), "{message}");
    }
    assert!(!output.exists());
}

#[test]
fn outputs_that_make_no_sense_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let paths = export_parts(&whole(), folder.path(), "usd");
    for name in ["out.usdz", "out.glb", "out.txt"] {
        let message = sentence(usd::stitch(&paths, &folder.path().join(name)));
        assert!(message.contains("stitched into .usd, .usdc or .usda"), "{message}");
    }
    let before = std::fs::read(&paths[1]).unwrap();
    let message = sentence(usd::stitch(&paths, &folder.path().join("parts/../parts/part 4.usd")));
    assert!(message.contains("which this command reads"), "{message}");
    assert_eq!(std::fs::read(&paths[1]).unwrap(), before);
    assert!(sentence(usd::stitch(&[], &folder.path().join("out.usd"))).contains("no parts"));

    let stitched = folder.path().join("stitched.usd");
    usd::stitch(&paths, &stitched).unwrap();
    let message = sentence(usd::stitch(&[stitched], &folder.path().join("out.usd")));
    assert!(message.contains("name its parts instead"), "{message}");
}

#[test]
fn the_parts_may_be_beside_or_above_the_output() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole();
    let paths = export_parts(&whole, folder.path(), "usda");
    std::fs::create_dir_all(folder.path().join("out/deep")).unwrap();
    for output in ["parts/stitched.usda", "out/deep/stitched.usda"] {
        let output = folder.path().join(output);
        usd::stitch(&paths, &output).unwrap();
        assert_eq!(open_within(&output, Reach::Anywhere).unwrap().summary().frames, FRAMES);
        // What is above is read only when that is asked for.
        let below = open(&output).map(|reader| reader.summary().frames);
        match (output.starts_with(folder.path().join("parts")), below) {
            (true, Ok(FRAMES)) => {}
            (false, Err(Error::Input(e))) => assert_eq!(e.remedies(), [Remedy::AllowElsewhere], "{e}"),
            (_, below) => panic!("{below:?}"),
        }
        let text = std::fs::read_to_string(&output).unwrap();
        assert!(!text.contains(folder.path().to_str().unwrap()), "{text}");
    }
}

/// Every channel that there is, by itself: a part without it is refused.
#[test]
fn a_part_without_a_channel_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.usd");
    let paths = export_parts(&whole(), folder.path(), "usd");
    let channels = cut(&whole(), 4, 5).channels();
    let kinds = channels.iter().filter_map(|channel| channel.kind).collect::<BTreeSet<_>>();
    assert_eq!(kinds, BTreeSet::from(ChannelKind::ALL), "a kind of channels is in no test's animation");
    for channel in channels {
        let mut part = cut(&whole(), 4, 5);
        part.with_normals = channel.name != "normals";
        part.others.retain(|other| other.channel.name != channel.name);
        part.export(&paths[1]).unwrap();
        let message = sentence(usd::stitch(&paths, &output));
        assert!(message.contains(&format!("with {}: no and yes", channel.name)), "{message}");
    }
}
