//! Transfer of the real face to itself with other vertices and faces. The result is known.
use crate::remesh::remeshed;
use crate::support::{bare, face, minus, played, processor, rig, rms, wrinkles};
use rhytid_core::NoProgress;
use rhytid_formats::export::OutputStage;
use rhytid_test_support::shared;
use rhytid_transfer::{Settings, transfer};

#[test]
fn the_real_face_on_itself_with_another_mesh() {
    let Some(shared) = shared("") else { return };
    let first = face(&shared, "face");
    let from = rig(&first);
    let again = remeshed(&first);
    assert!(again.mesh.positions.len() < 8000, "{}", again.mesh.positions.len());
    let second = bare(&first, again.mesh.clone(), again.handles.clone());
    let examples = from.examples().handles.as_slice().as_flattened();
    let full = played(&from, examples, OutputStage::Full);
    let wrinkles = wrinkles(&from, &full);
    // Centimetres to millimetres.
    let mm = |[rms, worst]: [f64; 2]| [10.0 * rms, 10.0 * worst];
    for linear_band in [false, true] {
        let settings = Settings { linear_band, landmarks: None };
        let made = transfer(&from, &second, &settings, &processor(), &NoProgress).unwrap();
        assert!(made.report.warnings.is_empty() && made.report.turned_over == 0, "{:?}", made.report);
        assert!(made.report.covered > 0.99 && (made.report.scale - 1.0).abs() < 1e-6, "{:?}", made.report);
        let to = rig(&made.face);
        // At the examples, on the rig that was made.
        let to_full = played(&to, to.examples().handles.as_slice().as_flattened(), OutputStage::Full);
        let shell = to.clone().shell().unwrap();
        let to_shell = played(&shell, to.examples().handles.as_slice().as_flattened(), OutputStage::Shell);
        let (mut wrong, mut all) = (Vec::new(), Vec::new());
        for p in 0..full.len() {
            if linear_band {
                let expected = again.at(&full[p]);
                wrong.extend(to_full[p].iter().zip(&expected).map(|(x, y)| minus(x, y)));
                all.extend(expected.iter().zip(&again.mesh.positions).map(|(x, y)| minus(x, y)));
            } else {
                // The wrinkles on the second face's own shell, which moves as the first face without its
                // wrinkles. No wrinkle moves a handle here.
                let expected = again.at(&wrinkles[p]);
                let found = to_full[p].iter().zip(&to_shell[p]).map(|(x, y)| minus(x, y));
                wrong.extend(found.zip(&expected).map(|(x, y)| minus(&x, y)));
                all.extend(expected);
            }
        }
        let (wrong, all) = (mm(rms(wrong.into_iter())), mm(rms(all.into_iter())));
        println!("linear band {linear_band}: {wrong:.3?} mm of {all:.3?}");
        assert!(wrong[0] < 0.1, "linear band {linear_band}: {wrong:?} mm of {all:?}");
    }
}
