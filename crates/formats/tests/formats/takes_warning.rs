//! The warning about labels that nobody asked for.
use rhytid_formats::take::{Missing, decode};
use rhytid_test_support::Logged;

#[test]
fn labels_that_are_not_wanted_are_one_warning() {
    let take = |labels: usize| {
        let columns: String = (0..labels).map(|i| format!(",m{i}_x,m{i}_y,m{i}_z")).collect();
        format!("time{columns}\n0{}\n1{}\n", ",1".repeat(labels * 3), ",2".repeat(labels * 3))
    };
    let wanted = ["m1".to_owned()];
    let said = |labels: usize, wanted: Option<&[String]>| {
        let logged = Logged::start();
        decode(take(labels).as_bytes(), "take.csv", wanted, Missing::Error).unwrap();
        logged.lines()
    };

    assert_eq!(
        said(11, Some(&wanted)),
        ["WARN take.csv: columns of no handle are left out (10 labels): \
          \"m0\", \"m2\", \"m3\", \"m4\", \"m5\", \"m6\", \"m7\", \"m8\" and 2 more"]
    );
    assert_eq!(
        said(3, Some(&wanted)),
        ["WARN take.csv: columns of no handle are left out (2 labels): \"m0\", \"m2\""]
    );
    assert_eq!(said(3, None), [""; 0]);
}
