//! The head's motion in a take's CSV.
use rhytid_core::{Error, RigidMotion, Take};
use rhytid_formats::take::{Missing, decode, read, write};

const HEADER: &str = "time,a_x,a_y,a_z,head_qw,head_qx,head_qy,head_qz,head_tx,head_ty,head_tz\n";

fn take(text: &str, missing: Missing) -> Result<Take, String> {
    decode(text.as_bytes(), "take.csv", None, missing).map_err(|error| match error {
        Error::Input(sentence) => sentence.to_string(),
        other => panic!("expected an input error, found {other:?}"),
    })
}

fn head(text: &str, missing: Missing) -> Vec<RigidMotion> {
    take(text, missing).unwrap().head.unwrap()
}

#[test]
fn the_scalar_comes_first_in_the_file() {
    let found = head(&format!("{HEADER}0,1,2,3,0.5,-0.5,0.5,0.5,10,20,30\n"), Missing::Error);
    assert_eq!(found, [RigidMotion { rotation: [-0.5, 0.5, 0.5, 0.5], translation: [10.0, 20.0, 30.0] }]);
    // A half turn about z takes x to −x.
    let found = head(&format!("{HEADER}0,1,2,3,0,0,0,1,0,0,0\n"), Missing::Error);
    assert_eq!(found[0].matrix()[0][0], -1.0);
}

#[test]
fn rounded_quaternions_become_rotations() {
    let found =
        head(&format!("{HEADER}0,1,2,3,0.9970317,0.0659889,-0.0026195,0.0395786,0,150,0\n"), Missing::Error);
    assert!(found[0].is_rigid() && (found[0].rotation[3] - 0.9970317).abs() < 1e-6, "{found:?}");
    let rounder = head(&format!("{HEADER}0,1,2,3,0.997,0.066,-0.003,0.040,0,150,0\n"), Missing::Error);
    let length: f64 = rounder[0].rotation.iter().map(|x| x * x).sum();
    assert!((length - 1.0).abs() < 1e-12, "{length}");
}

#[test]
fn a_missing_motion_is_held_or_an_error() {
    let text = format!("{HEADER}0,1,2,3,,,,,,,\n1,1,2,3,0,1,0,0,4,5,6\n2,1,2,3,nan,0,0,0,0,0,0\n");
    let known = RigidMotion { rotation: [1.0, 0.0, 0.0, 0.0], translation: [4.0, 5.0, 6.0] };
    assert_eq!(head(&text, Missing::Hold), [RigidMotion::IDENTITY, known, known]);
    let sentence = take(&text, Missing::Error).unwrap_err();
    assert!(
        sentence.contains("line 2") && sentence.contains("\"head_qw\" of the head's motion is empty"),
        "{sentence}"
    );
}

#[test]
fn what_is_no_motion_is_refused() {
    for (columns, cells, expected) in [
        ("head_qw,head_qx", "1,0", "lacks the columns \"head_qy\", \"head_qz\""),
        ("head_qw,head_qw", "1,1", "are both \"head_qw\""),
    ] {
        let sentence =
            take(&format!("time,a_x,a_y,a_z,{columns}\n0,1,2,3,{cells}\n"), Missing::Error).unwrap_err();
        assert!(sentence.contains(expected), "{sentence}");
    }
    for (cells, expected) in [
        ("1,1,0,0,0,0,0", "has the length 1.41"),
        ("0,0,0,0,0,0,0", "has the length 0, expected 1"),
        ("1e200,0,0,0,0,0,0", "has the length"),
        ("1,0,0,0,0,inf,0", "\"head_ty\" of the head's motion is \"inf\""),
        ("1,0,0,0,0,x,0", "\"head_ty\" of the head's motion is \"x\""),
    ] {
        let sentence = take(&format!("{HEADER}0,1,2,3,{cells}\n"), Missing::Error).unwrap_err();
        assert!(sentence.contains("frame 0") && sentence.contains(expected), "{sentence}");
    }
    // Text is never held.
    assert!(take(&format!("{HEADER}0,1,2,3,1,0,0,0,0,x,0\n"), Missing::Hold).is_err());
}

#[test]
fn written_takes_keep_every_bit() {
    let s = 1.0 / 3.0_f64;
    let turned = RigidMotion { rotation: [s, s, s, (1.0 - s).sqrt()], translation: [0.1, -1e-7, 1e5] };
    assert!(turned.is_rigid());
    let take = Take {
        labels: vec!["a".into()],
        times: vec![0.0, 0.5],
        positions: vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
        head: Some(vec![turned, RigidMotion::IDENTITY]),
        ..Take::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("take.csv");
    write(&path, &take).unwrap();
    // With a rig's labels, the head is no column to be left out.
    assert_eq!(read(&path, Some(&take.labels), Missing::Error).unwrap(), take);

    let short = Take { head: Some(vec![turned]), ..take };
    assert!(write(&path, &short).unwrap_err().to_string().contains("1 head motions, expected 2"));
}
