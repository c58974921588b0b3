//! The confidence of markers in a take's CSV.
use rhytid_core::{Error, RigidMotion, Take};
use rhytid_formats::take::{Missing, decode, read, write};

fn take(text: &str, wanted: Option<&[&str]>) -> Result<Take, String> {
    let wanted: Option<Vec<String>> =
        wanted.map(|labels| labels.iter().map(|&label| label.to_owned()).collect());
    decode(text.as_bytes(), "take.csv", wanted.as_deref(), Missing::Error).map_err(|error| match error {
        Error::Input(sentence) => sentence.to_string(),
        other => panic!("expected an input error, found {other:?}"),
    })
}

const TWO: &str = "time,b_confidence,a_x,a_y,a_z,b_x,b_y,b_z\n0,1,1,2,3,4,5,6\n1,0.25,1,2,3,4,5,6\n";

#[test]
fn a_column_is_of_its_marker_and_the_others_are_1() {
    let found = take(TWO, None).unwrap();
    assert_eq!(found.labels, ["a", "b"]);
    assert_eq!(found.confidence, Some(vec![1.0, 1.0, 1.0, 0.25]));
    assert_eq!(take(TWO, Some(&["b", "a"])).unwrap().confidence, Some(vec![1.0, 1.0, 0.25, 1.0]));
    assert_eq!(take(TWO, Some(&["a"])).unwrap().confidence, None);
}

#[test]
fn without_doubt_there_is_none() {
    assert_eq!(take(&TWO.replace("0.25", "1"), None).unwrap().confidence, None);
    assert_eq!(take("time,a_x,a_y,a_z\n0,1,2,3\n", None).unwrap().confidence, None);
}

#[test]
fn labels_may_end_like_the_column() {
    let text = "time,a_confidence_x,a_confidence_y,a_confidence_z,a_x,a_y,a_z,a_confidence,a_confidence_confidence\n\
                0,1,2,3,4,5,6,0.5,0\n";
    let found = take(text, None).unwrap();
    assert_eq!(found.labels, ["a_confidence", "a"]);
    assert_eq!(found.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(found.confidence, Some(vec![0.0, 0.5]));
}

#[test]
fn what_is_no_confidence_is_refused() {
    for cell in ["1.5", "-0.1", "NaN", "inf", "sure", ""] {
        let shown = if cell.is_empty() { "empty".to_owned() } else { format!("{cell:?}") };
        let expected = format!(
            "take.csv, line 3: frame 1: \"b_confidence\" of marker \"b\" is {shown}, \
             expected a number from 0 (a guess) to 1 (measured)"
        );
        let text = TWO.replace("0.25", cell);
        assert_eq!(take(&text, None).unwrap_err(), expected);
        // Columns that are not wanted are not checked.
        assert!(take(&text, Some(&["a"])).is_ok());
    }
    let twice =
        TWO.replace("time,", "time,b_confidence,").replace("\n0,", "\n0,1,").replace("\n1,", "\n1,1,");
    let sentence = take(&twice, None).unwrap_err();
    assert!(sentence.contains("columns 2 and 3 of the header are both \"b_confidence\""), "{sentence}");
    assert!(take(&twice, Some(&["a"])).is_ok());

    let stray = TWO.replace("b_confidence", "nose_confidence");
    assert_eq!(
        take(&stray, None).unwrap_err(),
        "take.csv, line 1: the header has \"nose_confidence\", and no marker \"nose\"; give it its columns LABEL_x, \
         LABEL_y and LABEL_z, or leave this one out"
    );
    assert_eq!(take(&stray, Some(&["b"])).unwrap().confidence, None);
}

fn doubtful() -> Take {
    let third = 1.0_f32 / 3.0;
    Take {
        labels: ["a", "b", "c"].map(String::from).to_vec(),
        times: vec![0.0, 0.5],
        positions: vec![[1.0, 2.0, 3.0]; 6],
        head: Some(vec![RigidMotion::IDENTITY; 2]),
        confidence: Some(vec![1.0, 1.0, third, 1.0, f32::MIN_POSITIVE / 8.0, 1.0 - f32::EPSILON]),
    }
}

#[test]
fn written_takes_keep_every_bit_and_have_the_columns_that_they_need() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("take.csv");
    let bits =
        |take: &Take| take.confidence.as_ref().map(|all| all.iter().map(|x| x.to_bits()).collect::<Vec<_>>());
    write(&path, &doubtful()).unwrap();
    let header = std::fs::read_to_string(&path).unwrap().lines().next().unwrap().to_owned();
    assert!(header.ends_with("head_tz,b_confidence,c_confidence") && !header.contains("a_conf"), "{header}");
    let found = read(&path, None, Missing::Error).unwrap();
    assert_eq!(found, doubtful());
    assert_eq!(bits(&found), bits(&doubtful()));

    let sure = Take { confidence: Some(vec![1.0; 6]), ..doubtful() };
    write(&path, &sure).unwrap();
    assert_eq!(read(&path, None, Missing::Error).unwrap(), Take { confidence: None, ..sure });
}

#[test]
fn confidences_that_would_not_read_back_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("take.csv");
    for (confidence, words) in [
        (vec![1.0; 5], "5 confidences, expected one for each of its 6 positions"),
        (vec![1.0, 1.0, 1.0, 1.0, f32::NAN, 1.0], "frame 1: the confidence of marker \"b\" is NaN"),
        (vec![1.0, 1.0, 1.5, 1.0, 1.0, 1.0], "frame 0: the confidence of marker \"c\" is 1.5"),
    ] {
        let take = Take { confidence: Some(confidence), ..doubtful() };
        let sentence = write(&path, &take).unwrap_err().to_string();
        assert!(sentence.contains("not written") && sentence.contains(words), "{sentence}");
        assert!(!path.exists());
    }
}
