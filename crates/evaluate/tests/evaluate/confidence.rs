//! What a rig knows of its own errors, on a face that is made in code.
use rhytid_core::{Face, NoProgress, Rig, Take};
use rhytid_evaluate::Regions;
use rhytid_evaluate::coverage::{coverage, take_sigma};
use rhytid_solve::{EXTRAPOLATION, solve};

fn rig(face: &Face) -> Rig {
    solve(face, &NoProgress).unwrap().rounded().unwrap()
}

/// Rest, and the handles above the middle pulled up by `up` mesh units, one after the other.
fn pulls(rig: &Rig, up: f64) -> (Take, Vec<usize>) {
    let rest: Vec<[f64; 3]> = rig.handles().rest.iter().map(|x| x.map(f64::from)).collect();
    let middle = rest.iter().map(|x| x[1]).sum::<f64>() / rest.len() as f64;
    let pulled: Vec<usize> = (0..rest.len()).filter(|&h| rest[h][1] > middle + 2.0).collect();
    let mut positions = rest.clone();
    for &h in &pulled {
        let mut frame = rest.clone();
        frame[h][1] += up;
        positions.extend(frame);
    }
    let times = (0..=pulled.len()).map(|frame| frame as f64 / 30.0).collect();
    let take = Take { labels: rig.handles().labels.clone(), times, positions, confidence: None, head: None };
    (take, pulled)
}

#[test]
fn what_no_example_moves_is_unknown_rather_than_certain() {
    let mut face = rhytid_demo::face(4_000);
    let rest = face.neutral.positions.clone();
    let handles = face.handles.at(&rest);
    let middle = handles.iter().map(|x| x[1]).sum::<f64>() / handles.len() as f64;
    // The examples are of the lower half alone.
    for example in &mut face.examples {
        for (x, rest) in example.positions.iter_mut().zip(&rest) {
            let keep = ((middle + 1.0 - rest[1]) / 2.0).clamp(0.0, 1.0);
            *x = [0, 1, 2].map(|c| rest[c] + keep * (x[c] - rest[c]));
        }
    }
    let rig = rig(&face);
    let regions = Regions::by_handles(&rig);
    let (take, pulled) = pulls(&rig, 1.0);
    assert!(pulled.len() > 5, "{}", pulled.len());
    let sigma = take_sigma(&rig, &take, &regions, &NoProgress).unwrap();
    assert_eq!(sigma.frames_mm[0], 0.0, "nothing is uncertain at rest");
    assert!(sigma.frames_mm[1..].iter().all(|sigma| *sigma > 0.1), "{:?}", sigma.frames_mm);
    let far: usize = sigma.far.iter().map(|stretch| stretch.frames).sum();
    assert!(far > pulled.len() / 2, "{far} of {} are far: {:?}", pulled.len(), sigma.far);
    assert!(sigma.far.iter().all(|stretch| stretch.times > EXTRAPOLATION && stretch.farthest > 0));
    // The noise of markers is not far from anything.
    let (still, _) = pulls(&rig, 0.005);
    assert_eq!(take_sigma(&rig, &still, &regions, &NoProgress).unwrap().far, []);
}

#[test]
fn the_performance_that_the_examples_are_of_is_covered_and_a_thrown_one_is_not() {
    let face = rhytid_demo::face(4_000);
    let rig = rig(&face);
    let regions = Regions::by_handles(&rig);
    let take = rhytid_demo::performance(&face);
    let found = coverage(&rig, &take, &regions, None, 3, 3, &NoProgress).unwrap();
    let sigma = found.sigma.unwrap();
    assert_eq!(sigma.far, [], "{:?}", sigma.far);
    assert!(found.left < 1.0 && found.scans.len() == 3);
    assert!(
        found.scans.windows(2).all(|pair| pair[1].left <= pair[0].left) && found.scans[0].left < found.left
    );
    let most = |scan: &rhytid_evaluate::coverage::Scan| scan.regions[0].taken;
    assert!(found.scans.iter().all(|scan| (0.0..=1.0).contains(&most(scan)) && scan.edges.len() == 3));

    let rest: Vec<[f64; 3]> = take
        .labels
        .iter()
        .map(|label| {
            let h = rig.handles().labels.iter().position(|known| known == label).unwrap();
            rig.handles().rest[h].map(f64::from)
        })
        .collect();
    let mut thrown = take.clone();
    for (x, rest) in thrown.positions.iter_mut().zip(rest.iter().cycle()) {
        *x = [0, 1, 2].map(|c| rest[c] + 5.0 * (x[c] - rest[c]));
    }
    let sigma = take_sigma(&rig, &thrown, &regions, &NoProgress).unwrap();
    let worst = sigma.far.iter().map(|stretch| stretch.times).fold(0.0, f64::max);
    assert!(worst > 2.0 * EXTRAPOLATION, "{worst}");
    // Candidates are all that is chosen from, whether their markers were seen or not.
    let candidates = [7, 3, 50];
    let found = coverage(&rig, &take, &regions, Some(&candidates), 9, 9, &NoProgress).unwrap();
    let mut chosen: Vec<usize> = found.scans.iter().map(|scan| scan.frame).collect();
    chosen.sort();
    assert_eq!(chosen, [3, 7, 50]);
    let error = coverage(&rig, &take, &regions, Some(&[take.frames()]), 1, 1, &NoProgress).unwrap_err();
    assert!(error.to_string().contains("can't be scanned"), "{error}");
    let guessed = Take { confidence: Some(vec![0.5; take.positions.len()]), ..take };
    assert_eq!(coverage(&rig, &guessed, &regions, None, 9, 9, &NoProgress).unwrap().scans, []);
}
