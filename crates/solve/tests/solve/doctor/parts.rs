//! Examples with identical parts in another order.

use super::*;

/// Where the parts begin, behind the sheet's 25 vertices. Each has 6.
const FIRST: [usize; 3] = [25, 31, 37];

/// The sheet with three identical parts below. The example moves them by 1 along y, as a jaw does.
fn with_parts() -> Face {
    with(|face| {
        for x in [0.0, 10.0, 20.0] {
            add_piece(face, 2, 3, [x, -30.0, 0.0]);
        }
        face.examples[0].positions[25..].iter_mut().for_each(|x| x[1] += 1.0);
    })
}

/// The example's two parts exchanged.
fn exchange(face: &mut Face, a: usize, b: usize) {
    (0..6).for_each(|i| face.examples[0].positions.swap(FIRST[a] + i, FIRST[b] + i));
}

/// What the doctor says of exchanged parts.
fn said(face: &Face) -> Vec<String> {
    let findings = examine(face).findings.into_iter();
    findings.filter(|finding| finding.code == "parts-exchanged").map(|finding| finding.message).collect()
}

#[test]
fn parts_in_order_are_left_in_peace() {
    assert_eq!(said(&with_parts()), [""; 0]);
    // They may move a good way towards each other.
    let mut face = with_parts();
    face.examples[0].positions[25..31].iter_mut().for_each(|x| x[0] += 6.0);
    face.examples[0].positions[31..37].iter_mut().for_each(|x| x[0] -= 6.0);
    assert_eq!(said(&face), [""; 0]);
}

#[test]
fn two_parts_that_are_exchanged_are_named() {
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let mut face = with_parts();
        exchange(&mut face, a, b);
        let found = said(&face);
        assert_eq!(found.len(), 1);
        let pair = format!("the parts of vertices {} and {};", FIRST[a], FIRST[b]);
        let cure = "export the example with its parts in the neutral's order";
        says(&found[0], &["example smile has parts in each other's place", &pair, cure]);
        assert!(!examine(&face).has_errors());
    }
}
