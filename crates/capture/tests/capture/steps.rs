//! Each step's switch: without a step, exactly its fault stays in a made-up take. With all steps the true
//! motion is found.
use glam::{DQuat, DVec3, EulerRot};
use rhytid_capture::{Axes, Cleaned, Kind, Settings, Step, Target, clean};
use rhytid_core::{Error, NoProgress, Progress, RawTake, Take};
use std::f64::consts::TAU;

const HANDLES: usize = 24;
const CAP: usize = 4;
const FRAMES: usize = 480;
const RATE: f64 = 120.0;
/// The actor is smaller than the rig.
const SCALE: f64 = 0.8;
/// Where the markers of these handles are exchanged.
const SWAP: ([usize; 2], std::ops::Range<usize>) = ([9, 10], 300..340);
const GHOST: (usize, usize) = (3, 200);
const GAP: (usize, std::ops::Range<usize>) = (14, 150..190);

/// Largest error of a measured sample in millimetres. The noise is up to 0.32 mm on the rig, and a filter
/// overshoots at its ends.
const MEASURED: f64 = 0.6;

/// Reproducible, from -1 to 1.
fn random(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// The rig's handles in centimetres, with Y up.
fn rest() -> Vec<DVec3> {
    let at = |j: usize| {
        let (x, y) = ((j % 6) as f64 * 2.5 - 6.25, (j / 6) as f64 * 3.0 - 4.5);
        DVec3::new(x, y, 6.0 - 0.08 * x * x + 0.3 * random(j))
    };
    (0..HANDLES).map(at).collect()
}

/// Handle `j` in frame `f` on the rig: at rest in the first second. The forehead hardly moves, as on any
/// face.
fn truth(rest: &[DVec3], j: usize, f: usize) -> DVec3 {
    let t = (f as f64 / RATE - 1.0).max(0.0);
    let r = rest[j];
    let lift = DVec3::Y * 0.6 * (0.4 * r.x).cos() * (TAU * 0.7 * t).sin();
    let push = DVec3::Z * 0.5 * (0.3 * r.y).sin() * (1.0 - (TAU * 0.5 * t).cos());
    const MOVES: [f64; HANDLES / 6] = [1.0, 1.0, 0.4, 0.0];
    r + MOVES[j / 6] * (lift + push)
}

/// From the rig's space, scaled to the actor's size, to the world in mesh axes and centimetres.
fn head(f: usize) -> (DQuat, DVec3) {
    let t = f as f64 / RATE;
    let turn =
        DQuat::from_euler(EulerRot::YXZ, 0.25 * (TAU * 0.4 * t).sin(), 0.1 * (TAU * 0.3 * t).sin(), 0.05);
    (turn, DVec3::new(6.0 * (TAU * 0.2 * t).sin(), 150.0, 3.0))
}

/// Millimetres, with Z up.
fn in_the_file(p: DVec3) -> [f64; 3] {
    [10.0 * p.x, -10.0 * p.z, 10.0 * p.y]
}

fn raw() -> RawTake {
    const CAP_AT: [[f64; 3]; CAP] =
        [[0.0, 13.0, 4.0], [6.0, 10.0, -2.0], [-6.0, 10.5, -1.0], [1.0, 15.0, -5.0]];
    let rest = rest();
    let mut positions = Vec::new();
    for f in 0..FRAMES {
        let (turn, at) = head(f);
        for j in 0..HANDLES + CAP {
            let label = |j: usize| match SWAP {
                ([a, b], frames) if frames.contains(&f) && (j == a || j == b) => a + b - j,
                _ => j,
            };
            let local =
                if j < HANDLES { truth(&rest, label(j), f) } else { DVec3::from_array(CAP_AT[j - HANDLES]) };
            let noise = |axis: usize| random(3 * (f * 64 + j) + axis);
            let mut p = turn * (SCALE * local) + at + 0.015 * DVec3::from_array([0, 1, 2].map(noise));
            if (j, f) == GHOST {
                p += DVec3::new(3.0, 2.0, 1.0);
            }
            let hidden = j == GAP.0 && GAP.1.contains(&f);
            positions.push(if hidden { RawTake::MISSING } else { in_the_file(p) });
        }
    }
    let labels = (0..HANDLES).map(|j| format!("h{j}")).chain((0..CAP).map(|i| format!("cap{i}"))).collect();
    let times = (0..FRAMES).map(|f| 3.0 + f as f64 / RATE).collect();
    let tracks = Take { labels, times, positions, ..Take::default() };
    RawTake { tracks, metres_per_unit: Some(1e-3), ..RawTake::default() }
}

fn target() -> Target {
    Target {
        labels: (0..HANDLES).map(|j| format!("h{j}")).collect(),
        rest: rest(),
        metres_per_unit: 0.01,
        strains: vec![],
        examples: vec![],
    }
}

fn without(skip: &[Step]) -> Cleaned {
    let settings = Settings { skip: skip.iter().copied().collect(), ..Settings::default() };
    clean(raw(), &target(), &settings, &NoProgress).unwrap()
}

/// How far off a sample is, in millimetres on the rig.
fn off(cleaned: &Cleaned, j: usize, f: usize) -> f64 {
    10.0 * DVec3::from_array(cleaned.take.positions[f * HANDLES + j]).distance(truth(&rest(), j, f))
}

/// The largest distance over the samples that are chosen.
fn worst(cleaned: &Cleaned, chosen: impl Fn(usize, usize) -> bool) -> f64 {
    let samples = (0..FRAMES).flat_map(|f| (0..HANDLES).map(move |j| (j, f)));
    samples.filter(|&(j, f)| chosen(j, f)).map(|(j, f)| off(cleaned, j, f)).fold(0.0, f64::max)
}

fn is_in_gap(j: usize, f: usize) -> bool {
    j == GAP.0 && GAP.1.contains(&f)
}

/// Whether a sample is as near to the ghost as a filter spreads it.
fn is_ghost(j: usize, f: usize) -> bool {
    j == GHOST.0 && f.abs_diff(GHOST.1) < 12
}

fn count(cleaned: &Cleaned, kind: Kind) -> usize {
    cleaned.report.events.iter().filter(|event| event.kind == kind).count()
}

/// Mean square of the second differences of a sequence of points: what is fast.
fn roughness(points: impl Iterator<Item = DVec3>) -> f64 {
    let points: Vec<DVec3> = points.collect();
    let seconds = points.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).length_squared());
    seconds.sum::<f64>() / (points.len() - 2) as f64
}

#[test]
fn with_all_steps_the_truth_comes_out() {
    let all = without(&[]);
    assert!(worst(&all, |_, _| true) < 1.0, "{}", worst(&all, |_, _| true));
    assert!(worst(&all, |j, f| !is_in_gap(j, f)) < MEASURED, "{}", worst(&all, |j, f| !is_in_gap(j, f)));
    let kinds = [Kind::Swap, Kind::Outlier, Kind::Model, Kind::Spline];
    assert_eq!((kinds.map(|kind| count(&all, kind)), all.report.events.len()), ([1, 1, 1, 1], 4));
    let found = &all.report.setup;
    assert!((found.scale / SCALE - 1.0).abs() < 2e-3 && found.axes == "+x+z-y", "{found:?}");
    assert_eq!((found.metres_per_unit, found.rigid.len()), (1e-3, CAP));
    assert_eq!(all.take.times, raw().tracks.times);
    // The head: what takes the rig, at the actor's size, to where the markers were.
    for (f, motion) in all.take.head.as_ref().unwrap().iter().enumerate() {
        let (turn, at) = head(f);
        let found = DQuat::from_array(motion.rotation);
        assert!(found.angle_between(turn).to_degrees() < 0.15, "frame {f}: {found} {turn}");
        assert!(
            DVec3::from_array(motion.translation).distance(at) < 0.04,
            "frame {f}: {:?} {at}",
            motion.translation
        );
    }
}

#[test]
fn the_neutral_face_is_the_rest_pose() {
    let found = without(&[Step::LowPass]);
    let neutral = found.report.setup.neutral.clone();
    assert!(
        neutral.end <= 125 && neutral.len() == 60,
        "the face is at rest in the first second: {neutral:?}"
    );
    for (j, rest) in rest().iter().enumerate() {
        let at = neutral.clone().map(|f| DVec3::from_array(found.take.positions[f * HANDLES + j]));
        let mean = at.sum::<DVec3>() / neutral.len() as f64;
        assert!(mean.distance(*rest) < 1e-9, "marker {j}: {mean} {rest}");
    }
}

#[test]
fn without_head() {
    let found = without(&[Step::Head]);
    assert!(found.take.head.is_none());
    assert!(worst(&found, |_, f| f > 60) > 20.0);
    // Each frame is still a motion of the right shape: distances are those of the truth.
    let at = |j: usize, f: usize| DVec3::from_array(found.take.positions[f * HANDLES + j]);
    let length = |f: usize| truth(&rest(), 0, f).distance(truth(&rest(), 5, f));
    assert!((0..FRAMES).all(|f| (at(0, f).distance(at(5, f)) - length(f)).abs() < 0.06));
}

#[test]
fn without_the_heads_low_pass() {
    let path = |cleaned: &Cleaned| {
        let motions = cleaned.take.head.as_ref().unwrap().iter();
        roughness(motions.map(|motion| DQuat::from_array(motion.rotation) * (10.0 * DVec3::X)))
    };
    let (smooth, rough) = (path(&without(&[])), path(&without(&[Step::HeadLowPass])));
    assert!(rough > 10.0 * smooth, "{rough} {smooth}");
}

#[test]
fn without_alignment() {
    let found = without(&[Step::Align]);
    assert_eq!(found.report.setup.axes, "+x+y+z");
    // Without the alignment, positions are in the mesh's unit where the file has them. Only the head's motion
    // is out, and the actor keeps its size.
    let at = |j: usize| DVec3::from_array(found.take.positions[j]);
    let length = SCALE * rest()[0].distance(rest()[5]);
    assert!((at(0).distance(at(5)) - length).abs() < 0.05);
    assert!(at(0).z > 100.0, "the file has Z up: {}", at(0));
    let given = Settings {
        skip: [Step::Align].into(),
        axes: Some("+x+z-y".parse::<Axes>().unwrap()),
        ..Settings::default()
    };
    let turned = clean(raw(), &target(), &given, &NoProgress).unwrap();
    assert!(turned.take.positions[0][1] > 100.0, "{:?}", turned.take.positions[0]);
}

#[test]
fn without_swaps() {
    let found = without(&[Step::Swaps]);
    assert_eq!(count(&found, Kind::Swap), 0);
    let inside = |j: usize, f: usize| SWAP.0.contains(&j) && (310..330).contains(&f);
    assert!(worst(&found, inside) > 20.0);
    // A filter reaches a little beyond.
    let near = |j: usize, f: usize| SWAP.0.contains(&j) && (285..355).contains(&f);
    assert!(worst(&found, |j, f| !near(j, f) && !is_in_gap(j, f)) < MEASURED);
}

#[test]
fn without_outliers() {
    let found = without(&[Step::Outliers]);
    assert_eq!(count(&found, Kind::Outlier), 0);
    assert!(off(&found, GHOST.0, GHOST.1) > 10.0);
    assert!(worst(&found, |j, f| !is_ghost(j, f) && !is_in_gap(j, f)) < MEASURED);
}

#[test]
fn without_gaps() {
    let found = without(&[Step::Gaps]);
    assert_eq!((count(&found, Kind::Left), count(&found, Kind::Model)), (2, 0));
    for f in 0..FRAMES {
        for j in 0..HANDLES {
            let is_open = is_in_gap(j, f) || (j, f) == GHOST;
            assert_eq!(off(&found, j, f).is_nan(), is_open, "frame {f}, marker {j}");
        }
    }
    assert!(worst(&found, |j, f| !is_in_gap(j, f) && (j, f) != GHOST) < MEASURED);
}

#[test]
fn without_the_low_pass() {
    let path = |cleaned: &Cleaned| {
        let positions = &cleaned.take.positions;
        roughness((0..FRAMES).map(|f| DVec3::from_array(positions[f * HANDLES + 20])))
    };
    let (smooth, found) = (without(&[]), without(&[Step::LowPass]));
    assert_eq!((smooth.report.low_pass_hz, found.report.low_pass_hz), (Some(12.0), None));
    assert!(path(&found) > 10.0 * path(&smooth), "{} {}", path(&found), path(&smooth));
    let given = Settings { low_pass: Some(6.0), ..Settings::default() };
    let given = clean(raw(), &target(), &given, &NoProgress).unwrap();
    assert!(path(&given) < 0.8 * path(&smooth), "{} {}", path(&given), path(&smooth));
}

#[test]
fn frames_at_another_rate_keep_their_times() {
    for fps in [24.0, 25.0, 30.0, 60.0] {
        let settings = Settings { fps: Some(fps), ..Settings::default() };
        let found = clean(raw(), &target(), &settings, &NoProgress).unwrap();
        assert_eq!(found.take.frames(), ((FRAMES - 1) as f64 / RATE * fps) as usize + 1);
        for (i, time) in found.take.times.iter().enumerate() {
            assert!((time - (3.0 + i as f64 / fps)).abs() < 1e-9);
            let at = DVec3::from_array(found.take.positions[i * HANDLES + 20]);
            let frame = (time - 3.0) * RATE;
            let (before, s) = (frame.floor() as usize, frame.fract());
            let truth = |f: usize| truth(&rest(), 20, f.min(FRAMES - 1));
            assert!(10.0 * at.distance(truth(before).lerp(truth(before + 1), s)) < MEASURED, "{fps} {i}");
        }
    }
}

#[test]
fn a_limit_for_gaps_flags_them() {
    let settings = Settings { max_gap: 0.2, ..Settings::default() };
    let found = clean(raw(), &target(), &settings, &NoProgress).unwrap();
    assert_eq!((count(&found, Kind::Lost), count(&found, Kind::Model)), (1, 0));
    let confidence = found.take.confidence.unwrap();
    assert!(GAP.1.clone().all(|f| confidence[f * HANDLES + GAP.0] == 0.0));
}

#[test]
fn confidence_is_below_one_where_samples_were_filled_and_nowhere_else() {
    let confidence = without(&[]).take.confidence.unwrap();
    for (i, confidence) in confidence.into_iter().enumerate() {
        let (j, f) = (i % HANDLES, i / HANDLES);
        let expected = match () {
            () if is_in_gap(j, f) => 0.5,
            () if (j, f) == GHOST => 0.8,
            () => 1.0,
        };
        assert_eq!(confidence, expected, "frame {f}, marker {j}");
    }
}

#[test]
fn it_stops_when_asked_to() {
    struct Stop;
    impl Progress for Stop {
        fn report(&self, _step: &'static str, _done: u64, _total: u64) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let stopped = clean(raw(), &target(), &Settings::default(), &Stop);
    assert!(matches!(stopped, Err(Error::Cancelled)));
}
