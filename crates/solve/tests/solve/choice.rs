//! What is chosen by leaving examples out, and where the linear band fades to the shell.
use rhytid_core::{Example, Face, LearnedSettings, Method, NoProgress};
use rhytid_solve::{Candidate, Solved, solve_in_full};
use rhytid_test_support::sheet;

/// Numbers without a pattern, in −1..1.
fn number(i: usize) -> f64 {
    ((i as f64 * 12.9898).sin() * 43758.5453).fract()
}

/// The sheet with examples whose handles and other vertices have nothing in common, or with examples that are
/// one motion of all of them, more or less of it.
fn face(examples: usize, is_alike: bool) -> Face {
    let mut face = sheet::face();
    let example = |p: usize| {
        let moved = |(v, x): (usize, &[f64; 3])| match is_alike {
            true => [0, 1, 2].map(|c| x[c] + (1.0 + 0.3 * p as f64) * number(3 * v + c)),
            false => [0, 1, 2].map(|c| x[c] + number(97 * p + 3 * v + c)),
        };
        let positions = face.neutral.positions.iter().enumerate().map(moved).collect();
        Example { name: format!("p{p}"), positions, mirror: false, noise: Some(0.0) }
    };
    face.examples = (0..examples).map(example).collect();
    face.settings.align = false;
    face
}

fn solved(face: &Face) -> Solved {
    solve_in_full(face, true, &NoProgress).unwrap()
}

/// The sum of squares over the skin of each example's error if it is left out, relative to the shell's.
fn relative(solved: &Solved) -> Vec<f64> {
    let left_out = solved.left_out.as_ref().unwrap();
    let examples = left_out.errors.columns();
    let sum = |of: &rhytid_core::Table<[f64; 3]>, p: usize| -> f64 {
        let rows = of.rows().zip(&left_out.skin_area);
        rows.map(|(row, area)| area * row[p].iter().map(|x| x * x).sum::<f64>()).sum()
    };
    (0..examples).map(|p| (sum(&left_out.errors, p) / sum(&left_out.of_shell, p)).sqrt()).collect()
}

#[test]
fn few_examples_choose_nothing() {
    for examples in 1..4 {
        let candidates = solved(&face(examples, true)).report.candidates;
        let [Candidate { share, ridge, reach, leave_one_out, .. }] = candidates[..] else {
            panic!("{examples}: {candidates:?}");
        };
        assert_eq!((share, ridge, reach), (0.2, 1e-2, 1.0));
        assert_eq!(leave_one_out.is_nan(), examples == 1);
    }
    let all = solved(&face(4, true)).report.candidates;
    assert_eq!(all.len(), 3 * 6 * 2);
    let least = all.iter().map(Candidate::expected).fold(f64::INFINITY, f64::min);
    let chosen = all[0];
    assert!(chosen.expected() <= 1.1 * least, "{chosen:?}, {least}");
    let smaller =
        all.iter().filter(|c| (c.share, c.reach) == (chosen.share, chosen.reach) && c.ridge < chosen.ridge);
    smaller.for_each(|c| assert!(c.expected() > 1.1 * least, "{c:?} is as good as {chosen:?}"));
}

#[test]
fn the_band_fades_where_left_out_examples_are_no_better_with_it() {
    let unlike = face(6, false);
    let faded = solved(&unlike);
    let mut whole = unlike;
    whole.settings.method = Method::Learned(LearnedSettings {
        fade: false,
        share: Some(faded.report.candidates[0].share),
        ridge: Some(1e-4),
        ..LearnedSettings::default()
    });
    let whole = solved(&whole);
    assert!(whole.report.faded().is_empty() && whole.report.kept.iter().all(|kept| *kept == 1.0));
    let [without, with] = [&whole, &faded].map(relative);
    println!("relative to the shell: whole {without:.2?}, faded {with:.2?}, kept {:.2?}", faded.report.kept);
    assert!(without.iter().any(|error| *error > 1.05), "{without:?}");
    assert!(with.iter().all(|error| *error <= 1.05), "{with:?}");

    // Where one motion predicts the others, nothing fades.
    let alike = solved(&face(6, true));
    assert!(alike.report.faded().is_empty(), "{:?}", alike.report.kept);
    assert!(relative(&alike).iter().all(|error| *error < 0.2), "{:?}", relative(&alike));
}
