//! Faults of capture sessions. Each is an error that says what to do, or a warning with a sound take.

use crate::common::raw::{Raw, off, truth};
use crate::common::stderr;
use rhytid::Take;

/// The demo's first frame is its neutral one.
const NEUTRAL: &str = "--neutral 0..1";

/// A handle that moves: the chin's.
const CHIN: usize = 10;

/// All samples except those of `except` are within 0.1 mm, the error of the smoothed head motion.
fn assert_sound(found: &Take, except: impl Fn(usize, usize) -> bool) {
    let truth = truth();
    assert_eq!(found.frames(), truth.frames());
    assert!(found.positions.iter().flatten().all(|x| x.is_finite()));
    for f in 0..truth.frames() {
        for j in (0..truth.labels.len()).filter(|&j| !except(j, f)) {
            let off = off(found, &truth, j, f);
            assert!(off < 0.1, "frame {f} marker {j}: {off} mm");
        }
    }
}

fn confidence(take: &Take, marker: usize, frame: usize) -> f32 {
    take.confidence.as_ref().map_or(1.0, |all| all[frame * take.labels.len() + marker])
}

#[test]
fn when_tracking_is_lost_the_face_is_held_and_flagged() {
    let raw = Raw::new();
    let lost = 100..160;
    raw.write(&|_, f, p| (!lost.contains(&f)).then_some(p));
    let (found, said, json) = raw.prepared(NEUTRAL);
    // The smoothing of the head's motion reaches a little beyond.
    assert_sound(&found, |_, f| (95..165).contains(&f));
    let m = found.labels.len();
    for j in 0..m {
        assert!(lost.clone().all(|f| confidence(&found, j, f) == 0.0));
        // Held, and then moved to where the marker is seen again.
        let at = |f: usize| found.positions[f * m + j];
        assert!((100..150).all(|f| at(f) == at(99)), "marker {j}");
        let step = |f: usize| (0..3).map(|c| (at(f + 1)[c] - at(f)[c]).powi(2)).sum::<f64>().sqrt();
        let whole = (0..3).map(|c| (at(160)[c] - at(99)[c]).powi(2)).sum::<f64>().sqrt();
        assert!((149..160).all(|f| step(f) <= 0.3 * whole + 1e-9), "marker {j} jumps");
    }
    assert!(
        said.contains(&format!("{m} gaps could not be filled soundly"))
            && said.contains("2.0 s from frame 100"),
        "{said}"
    );
    assert_eq!(json["summary"]["events"]["lost"], m);
    assert_eq!(json["summary"]["lost"], m * lost.len());
    assert_eq!(json["summary"]["events"]["head"], 1);
}

#[test]
fn a_marker_that_is_never_seen_goes_with_its_neighbours() {
    let raw = Raw::new();
    raw.write(&|j, _, p| (j != CHIN).then_some(p));
    let (found, said, json) = raw.prepared(NEUTRAL);
    assert_sound(&found, |j, _| j == CHIN);
    let truth = truth();
    let rest = truth.positions[CHIN];
    let moved = |f: usize| {
        let p = truth.positions[f * truth.labels.len() + CHIN];
        10.0 * (0..3).map(|c| (p[c] - rest[c]).powi(2)).sum::<f64>().sqrt()
    };
    let squares = |of: &dyn Fn(usize) -> f64| (0..truth.frames()).map(|f| of(f).powi(2)).sum::<f64>();
    assert!(
        squares(&|f| off(&found, &truth, CHIN, f)) < 0.3 * squares(&moved),
        "no better than standing still"
    );
    assert!((0..truth.frames()).all(|f| confidence(&found, CHIN, f) == 0.0));
    assert_eq!(json["summary"]["events"]["never_seen"], 1);
    assert!(said.contains(&truth.labels[CHIN]), "{said}");
}

#[test]
fn a_handle_without_a_marker_goes_with_its_neighbours() {
    let mut raw = Raw::new();
    raw.labels[CHIN] = "else".into();
    raw.write(&|_, _, p| Some(p));
    let (found, said, json) = raw.prepared(NEUTRAL);
    assert_sound(&found, |j, _| j == CHIN);
    assert_eq!(json["setup"]["markers"][CHIN], serde_json::Value::Null);
    assert_eq!(json["setup"]["rigid"].as_array().unwrap().len(), 4, "{json}");
    assert_eq!(json["setup"]["unused"], serde_json::json!(["else"]));
    assert!(said.contains(&truth().labels[CHIN]), "{said}");
}

#[test]
fn a_label_that_comes_twice_is_its_first_marker() {
    let mut raw = Raw::new();
    let twice = raw.labels[8].clone();
    raw.labels[8 + 1].clone_from(&twice);
    raw.write(&|_, _, p| Some(p));
    let (found, said, _) = raw.prepared(NEUTRAL);
    assert_sound(&found, |j, _| j == 9);
    assert!(said.contains(&format!("{twice}#2")), "{said}");
}

#[test]
fn a_prefix_and_another_case_are_no_other_label() {
    let mut raw = Raw::new();
    for (j, label) in raw.labels.iter_mut().enumerate() {
        *label = if j % 2 == 0 { format!("Anna:{label}") } else { label.to_uppercase() };
    }
    raw.write(&|_, _, p| Some(p));
    assert_sound(&raw.prepared(NEUTRAL).0, |_, _| false);
}

#[test]
fn a_subject_is_chosen_by_its_name() {
    let mut raw = Raw::new();
    raw.labels.iter_mut().for_each(|label| label.insert_str(0, "Anna:"));
    raw.write(&|_, _, p| Some(p));
    assert_sound(&raw.prepared(&format!("{NEUTRAL} --subject anna")).0, |_, _| false);
    let output = raw.prepare("--subject Ben");
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("no subject of the take is called \"Ben\"; it has \"Anna\""), "{said}");
}

#[test]
fn a_torn_face_is_an_error_unless_it_is_forced() {
    let raw = Raw::new();
    let torn = |j: usize, f: usize| j == CHIN && (30..150).contains(&f);
    raw.write(&|j, f, p| Some(if torn(j, f) { [p[0] + 9000.0, p[1], p[2]] } else { p }));
    let options = format!("{NEUTRAL} --skip slides,outliers");
    let output = raw.prepare(&options);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let named = format!("cannot be a face's: {} is ", truth().labels[CHIN]);
    assert!(said.contains(&named) && said.contains("(see --force)"), "{said}");
    assert!(!raw.path("clean.csv").exists());
    let (_, said, _) = raw.prepared(&format!("{options} --force"));
    assert!(said.contains("warning: ") && said.contains(&named), "{said}");
}

#[test]
fn without_a_unit_the_one_that_fits_is_taken() {
    for (units, factor, words) in
        [("", 1.0, "assumed to be mm"), ("furlong", 0.1, "assumed to be cm"), ("m", 1.0, "assumed to be mm")]
    {
        let mut raw = Raw::new();
        raw.units = units;
        raw.write(&|_, _, p| Some(p.map(|x| factor * x)));
        let (found, said, json) = raw.prepared(NEUTRAL);
        assert_sound(&found, |_, _| false);
        assert!(said.contains(words), "{units}: {said}");
        assert_eq!(json["setup"]["unit_is_guessed"], true);
    }
}

#[test]
fn without_a_rate_the_times_tell_it() {
    let mut raw = Raw::new();
    raw.rate = "0";
    raw.write(&|_, _, p| Some(p));
    let (found, said, json) = raw.prepared(NEUTRAL);
    assert_sound(&found, |_, _| false);
    assert!(said.contains("there is no frame rate") && json["rate"] == 30.0, "{said}");
}

#[test]
fn what_cannot_be_cleaned_is_refused() {
    let refused = |raw: &Raw, options: &str, words: &[&str]| {
        let output = raw.prepare(options);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("raw.trc") && words.iter().all(|word| said.contains(word)), "{said}");
        assert!(
            !raw.path("clean.csv").exists()
                && said.lines().filter(|line| line.starts_with("error: ")).count() == 1,
            "{said}"
        );
    };
    let all = |_: usize, _: usize, p: [f64; 3]| Some(p);

    let mut raw = Raw::new();
    raw.frames = 0;
    raw.write(&all);
    refused(&raw, "", &["no frames"]);

    // Other names, and markers that fit no face, since all lie in one plane.
    let mut raw = Raw::new();
    raw.labels.iter_mut().skip(3).for_each(|label| label.insert(0, '?'));
    raw.write(&|j, _, _| Some([(j % 10) as f64 * 40.0, 0.0, (j / 10) as f64 * 90.0]));
    refused(&raw, "", &["3 of the rig's", "expected at least 4", "give a map"]);

    let mut raw = Raw::new();
    raw.labels.iter_mut().for_each(String::clear);
    raw.write(&|j, _, p| (j < 3).then_some(p));
    refused(&raw, "", &["0 of the rig's", "#1", "give a map"]);

    let raw = Raw::new();
    raw.write(&|_, _, _| None);
    refused(&raw, "", &["is seen in any frame"]);
    // Only the cap.
    let handles = truth().labels.len();
    raw.write(&|j, _, p| (j >= handles).then_some(p));
    refused(&raw, "", &["is seen in any frame"]);
    // Two markers alone.
    raw.write(&|j, _, p| (j < 2).then_some(p));
    refused(&raw, "", &[]);
    // All on one line.
    raw.write(&|j, _, [x, ..]| Some([x + j as f64, 0.0, 0.0]));
    refused(&raw, NEUTRAL, &[]);
    // All in one place.
    raw.write(&|_, _, _| Some([1.0, 2.0, 3.0]));
    refused(&raw, NEUTRAL, &[]);
}
