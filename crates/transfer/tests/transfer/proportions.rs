//! Generated faces of other proportions, with other meshes. The expected result is the first face's
//! expression with the same change of proportions.
use crate::support::{bare, minus, processor, rig, rms};
use rhytid_core::NoProgress;
use rhytid_solve::solve;
use rhytid_transfer::{Settings, transfer};

/// A head that is wider below and longer above, with a longer nose, and a twentieth larger as a whole.
fn other_head([x, y, z]: [f64; 3]) -> [f64; 3] {
    let below = 1.0 / (1.0 + ((y + 5.0) / 2.5).exp());
    let nose = (-(x * x / 3.0 + (y + 3.0) * (y + 3.0) / 6.0)).exp();
    [1.05 * x * (1.0 + 0.15 * below), 1.05 * (y + 0.08 * y * (1.0 - below)), 1.05 * (z + 0.6 * nose)]
}

#[test]
fn another_heads_expressions_are_those_of_its_proportions() {
    let first = rhytid_demo::face(6_000);
    let from = rig(&first);
    let mut truth = rhytid_demo::face(4_500);
    truth.neutral.positions.iter_mut().for_each(|p| *p = other_head(*p));
    for example in &mut truth.examples {
        example.positions.iter_mut().for_each(|p| *p = other_head(*p));
    }
    let second = bare(&truth, truth.neutral.clone(), truth.handles.points.clone());
    let settings = Settings { linear_band: true, landmarks: None };
    let made = transfer(&from, &second, &settings, &processor(), &NoProgress).unwrap();
    println!("{:?} {:?} {:?}", made.report.distance_mm, made.report.stretch, made.report.warnings);
    assert!(made.report.turned_over == 0 && made.report.covered > 0.97, "{:?}", made.report);
    for (made, truth) in made.face.examples.iter().zip(&truth.examples) {
        let [off, worst] = rms(made.positions.iter().zip(&truth.positions).map(|(x, y)| minus(x, y)));
        let [size, most] =
            rms(truth.positions.iter().zip(&second.neutral.positions).map(|(x, y)| minus(x, y)));
        println!(
            "{}: {:.2} mm, {:.2} at most, of {:.2}, {:.2}",
            made.name,
            10.0 * off,
            10.0 * worst,
            10.0 * size,
            10.0 * most
        );
        assert!(off < 0.15 * size, "{}: {off} of {size}", made.name);
    }
    // The result is solved as any face is, and its markers are met.
    let to = solve(&made.face, &NoProgress).unwrap();
    for (h, v) in to.handles().held().enumerate() {
        let row = to.basis().row(v.index());
        assert!(row.iter().enumerate().all(|(i, b)| *b == f64::from(u8::from(i == h))), "handle {h}");
    }
}
