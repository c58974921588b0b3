//! Examples in another space than the neutral.

use super::*;
use rhytid_geometry::Axes;

/// The sheet with its example changed, point by point.
fn moved(change: impl Fn([f64; 3]) -> [f64; 3]) -> Face {
    with(|face| face.examples[0].positions.iter_mut().for_each(|x| *x = change(*x)))
}

/// Checks that the example is an error with these words, and that the solve says the same.
fn refused(face: &Face, words: &[&str]) {
    let report = examine(face);
    let found: Vec<(Severity, &str)> = report.findings.iter().map(|f| (f.severity, f.code)).collect();
    assert_eq!(found, [(Severity::Error, "example-in-another-space")], "{report:#?}");
    says(&report.findings[0].message, words);
    let said = solve(face, &NoProgress).unwrap_err().to_string();
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
}

#[test]
fn another_unit_is_named() {
    for (factor, words) in [
        (0.01, ["100 times smaller", "as if it were in metres", "unit = \"m\""]),
        (0.1, ["10 times smaller", "as if it were in decimetres", "unit = 0.1"]),
        (10.0, ["10 times larger", "as if it were in millimetres", "unit = \"mm\""]),
        (1.0 / 2.54, ["2.54 times smaller", "as if it were in inches", "unit = \"in\""]),
        (0.9, ["1.11 times smaller", "scale = 1.111", "[[example]]"]),
    ] {
        let [x, y, z] = [3.0, -7.0, 2.0];
        let face = moved(|p| [factor * (p[0] + x), factor * (p[1] + y), factor * (p[2] + z)]);
        refused(&face, &[&["example smile is"], &words[..]].concat());
    }
    // An example that is a little larger is an expression.
    assert!(!examine(&moved(|p| p.map(|x| 1.02 * x))).has_errors());
}

#[test]
fn other_axes_are_named() {
    for axes in Axes::with_mirror_images().filter(|axes| *axes != Axes::SAME) {
        // What takes it back is its inverse.
        let back = Axes::with_mirror_images()
            .find(|back| back.apply(axes.apply([1.0, 2.0, 3.0])) == [1.0, 2.0, 3.0])
            .unwrap();
        // The sheet is the same on both sides of its own x, but its columns are in an order.
        let face = moved(|p| axes.apply(p));
        let what = if axes.is_mirror_image() {
            "is a mirror image of the neutral"
        } else {
            "has other axes than the neutral"
        };
        refused(&face, &[what, &format!("axes = \"{back}\"")]);
    }
    let face = moved(|p| Axes::Y_UP_TO_Z_UP.apply(p).map(|x| 0.01 * x));
    refused(&face, &["100 times smaller", "and has other axes", "unit = \"m\" and axes = \"+x+z-y\""]);
    // A head that is turned between two scans is the alignment's.
    let turned = moved(|[x, y, z]| [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y, z]);
    assert!(!examine(&turned).has_errors());
}
