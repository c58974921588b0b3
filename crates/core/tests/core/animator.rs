//! What the animator passes on to a backend. The backend of these tests only keeps a record.

use rhytid_core::{
    Animator, Backend, BasisStorage, DeviceErrorKind, DeviceInfo, Error, HandleFrames, NoProgress, Result,
    Rig, RigParts, Session, Stage, Table, UploadOptions, VertexId,
};
use rhytid_solve::solve;
use rhytid_test_support::changed;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// What reached the device.
#[derive(Debug, Default)]
struct Record {
    /// Vertices of the rig and `max_frames` of each upload.
    uploads: Vec<(usize, usize)>,
    /// Frames and positions of each batch.
    batches: Vec<(usize, Vec<f32>)>,
    /// Stages read.
    reads: Vec<Stage>,
}

/// A device that computes nothing: every stage is the positions of its handles.
#[derive(Debug, Default)]
struct Recorder {
    record: Arc<Mutex<Record>>,
}

struct RecorderSession {
    record: Arc<Mutex<Record>>,
}

fn lost() -> Error {
    Error::Device { kind: DeviceErrorKind::Lost, device: "recorder:0".into(), message: "unplugged".into() }
}

impl Backend for Recorder {
    const NAME: &'static str = "recorder";
    type Session = RecorderSession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Ok(vec![])
    }

    fn open(_device: &DeviceInfo) -> Result<Self> {
        Ok(Self::default())
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<RecorderSession> {
        self.record.lock().unwrap().uploads.push((rig.vertices(), options.max_frames));
        Ok(RecorderSession { record: self.record.clone() })
    }
}

impl Session for RecorderSession {
    /// Lost where a position is 1000.
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        if frames.positions.contains(&1000.0) {
            return Err(lost());
        }
        self.record.lock().unwrap().batches.push((frames.frames, frames.positions.to_vec()));
        Ok(())
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        let mut record = self.record.lock().unwrap();
        record.reads.push(stage);
        out.clone_from(&record.batches.last().unwrap().1);
        Ok(())
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        Ok(None)
    }
}

fn rig() -> Rig {
    solve(&rhytid_test_support::sheet::face(), &NoProgress).unwrap().rounded().unwrap()
}

/// An animator of five handles for batches of three frames, and the record of its device.
fn animator() -> (Animator<RecorderSession>, Arc<Mutex<Record>>) {
    let recorder = Recorder::default();
    (Animator::new(&recorder, &rig(), UploadOptions::frames(3)).unwrap(), recorder.record)
}

#[track_caller]
fn refused<T>(result: Result<T>, words: &[&str]) {
    match result {
        Err(Error::Input(message)) => {
            for word in words {
                assert!(message.sentence().contains(word), "{word}: {message}");
            }
        }
        Err(other) => panic!("{words:?}: {other:?}"),
        Ok(_) => panic!("{words:?}: let through"),
    }
}

#[test]
fn whole_batches_go_through_as_they_are() {
    let (mut animator, record) = animator();
    assert_eq!(animator.max_frames(), 3);
    let mut out = vec![7.0; 99];
    for frames in [1, 3, 2] {
        let positions: Vec<f32> = (0..frames * 15).map(|i| i as f32).collect();
        animator.evaluate(&positions).unwrap();
        animator.read(Stage::Positions, &mut out).unwrap();
        assert_eq!(out, positions);
    }
    animator.read(Stage::Strain, &mut out).unwrap();
    let record = record.lock().unwrap();
    assert_eq!(record.uploads, [(25, 3)]);
    assert_eq!(
        record.batches.iter().map(|b| (b.0, b.1.len())).collect::<Vec<_>>(),
        [(1, 15), (3, 45), (2, 30)]
    );
    assert_eq!(record.reads, [Stage::Positions, Stage::Positions, Stage::Positions, Stage::Strain]);
}

#[test]
fn broken_batches_do_not_reach_the_device() {
    let (mut animator, record) = animator();
    for length in [1, 3, 14, 16, 29, 46] {
        let words = [format!("has {length} numbers"), "a multiple of 5 handles × 3".into()];
        refused(animator.evaluate(&vec![0.0; length]), &words.each_ref().map(String::as_str));
    }
    refused(animator.evaluate(&[]), &["has 0 numbers", "above 0"]);
    refused(animator.evaluate(&[0.0; 60]), &["has 4 frames, expected at most 3"]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut positions = vec![0.0; 45];
        positions[15 + 3 * 4 + 1] = bad;
        let words = [format!("frame 1 of a batch: handle 4 is at {bad}")];
        refused(animator.evaluate(&positions), &[&words[0], "expected a finite position"]);
    }
    assert!(record.lock().unwrap().batches.is_empty());
}

#[test]
fn nothing_is_read_before_it_is_there() {
    let (mut animator, record) = animator();
    let mut out = vec![7.0; 2];
    for stage in Stage::ALL {
        refused(animator.read(stage, &mut out), &["nothing to read"]);
    }
    assert_eq!(out, [7.0; 2]);
    // A batch that is refused keeps the last results. A batch that fails on the device does not.
    animator.evaluate(&[1.0; 15]).unwrap();
    refused(animator.evaluate(&[]), &[]);
    animator.read(Stage::Normals, &mut out).unwrap();
    assert_eq!(out, [1.0; 15]);
    assert!(matches!(
        animator.evaluate(&[1000.0; 15]),
        Err(Error::Device { kind: DeviceErrorKind::Lost, .. })
    ));
    refused(animator.read(Stage::Normals, &mut out), &["the last one failed"]);
    animator.evaluate(&[2.0; 15]).unwrap();
    animator.read(Stage::Normals, &mut out).unwrap();
    assert_eq!((out, record.lock().unwrap().reads.len()), (vec![2.0; 15], 2));
}

/// The table without its last element.
fn shorter<T: Clone>(table: &Table<T>) -> Table<T> {
    let (_, elements) = table.as_slice().split_last().unwrap();
    Table::new(1, elements.len(), elements.to_vec())
}

#[test]
fn what_is_not_sound_is_no_rig() {
    let refused_rig =
        |word: &str, change: &dyn Fn(&mut RigParts)| refused(changed(&rig(), |parts| change(parts)), &[word]);
    refused_rig("found 0, 0 and 0", &|r| {
        (r.surface.rest, r.handles.points, r.surface.faces) = Default::default();
    });
    refused_rig("handles", &|r| r.handles.points.clear());
    refused_rig("labels has 4 elements, expected 5", &|r| r.handles.labels.truncate(4));
    refused_rig("handle_rest has 4 elements, expected 5", &|r| r.handles.rest.truncate(4));
    refused_rig("handle_rest[3] is not where its point is at rest (vertex 20)", &|r| {
        r.handles.rest[3][1] += 1.0;
    });
    refused_rig("basis has 124 elements, expected 125", &|r| r.basis = shorter(&r.basis));
    refused_rig("basis is 5 × 25, expected 25 × 5", &|r| {
        r.basis = Table::new(5, 25, r.basis.as_slice().to_vec());
    });
    refused_rig("influence_edges", &|r| r.influences.edges = shorter(&r.influences.edges));
    refused_rig("influence_weights", &|r| r.influences.weights = shorter(&r.influences.weights));
    refused_rig("frame_neighbors", &|r| r.surface.tangent_neighbors.truncate(24));
    refused_rig("pose_features", &|r| r.fine_scale.pose_features = shorter(&r.fine_scale.pose_features));
    refused_rig("rbf_weights has 49 elements, expected 50", &|r| {
        r.fine_scale.rbf_weights = shorter(&r.fine_scale.rbf_weights);
    });
    refused_rig("pose_features", &|r| r.examples.names.push("another".into()));
    refused_rig("triangles", &|r| r.surface.triangles.truncate(31));
    refused_rig("handles[0] is 25", &|r| r.handles.points[0] = VertexId(25).into());
    refused_rig("basis[6] is NaN", &|r| r.basis.as_mut_slice()[6] = f32::NAN);
    refused_rig("metres_per_unit", &|r| r.surface.metres_per_unit = f64::NAN);
    refused_rig("bending_length", &|r| r.bending_length = f64::INFINITY);
    refused_rig("beta", &|r| r.influences.beta = f64::NAN);
    let recorder = Recorder::default();
    refused(
        Animator::new(&recorder, &rig(), UploadOptions::frames(0)),
        &["at least 1 frame", "max_frames = 0"],
    );
    assert!(recorder.record.lock().unwrap().uploads.is_empty());
}

/// Numbers from which no frame can be computed in f32.
#[test]
fn what_f32_cannot_hold_is_refused() {
    let exact = solve(&rhytid_test_support::sheet::face(), &NoProgress).unwrap();
    for (large, words) in
        [(1e300, "basis[7] is 1e300, expected a smaller number"), (-1e16, "basis[7] is -1e16")]
    {
        refused(changed(&exact, |r| r.basis.row_mut(1)[2] = large), &[words]);
    }
    assert!(changed(&exact, |r| r.basis.row_mut(1)[2] = 1e6).unwrap().rounded().is_ok());
    assert_eq!(exact.rounded().unwrap().widened().rounded().unwrap(), exact.rounded().unwrap());
}

#[test]
fn wrinkles_that_f32_cannot_hold_are_not_scaled() {
    refused(rig().scale_wrinkles(|v| if v == 13 { 1e300 } else { 1.0 }), &["rbf_weights[80] is"]);
    assert_eq!(rig().scale_wrinkles(|_| 1.0).unwrap(), rig());
}

#[test]
fn sessions_of_every_backend_fit_behind_one_type() {
    let (first, record) = animator();
    let mut all: Vec<Animator<Box<dyn Session>>> = vec![first.boxed(), animator().0.boxed()];
    let mut out = Vec::new();
    refused(all[0].read(Stage::Strain, &mut out), &["nothing to read"]);
    refused(all[0].evaluate(&[0.0; 60]), &["at most 3"]);
    all[0].evaluate(&[3.0; 30]).unwrap();
    // A batch that was evaluated before boxing can be read after it.
    let (mut before, _) = animator();
    before.evaluate(&[4.0; 15]).unwrap();
    let mut after = before.boxed();
    after.read(Stage::Strain, &mut out).unwrap();
    assert_eq!((out.as_slice(), after.max_frames()), (&[4.0; 15][..], 3));
    let worker = std::thread::spawn(move || {
        let mut out = Vec::new();
        all[0].read(Stage::LargeScale, &mut out).map(|()| out)
    });
    assert_eq!(worker.join().unwrap().unwrap(), [3.0; 30]);
    assert_eq!(record.lock().unwrap().batches, [(2, vec![3.0; 30])]);
}

#[test]
fn a_basis_that_fp16_cannot_hold_is_refused_as_fp16_only() {
    let recorder = Recorder::default();
    let rig = changed(&rig(), |r| r.basis.row_mut(2)[1] = 70_000.0).unwrap();
    let fp16 = UploadOptions { max_frames: 1, basis: BasisStorage::F16 };
    refused(Animator::new(&recorder, &rig, fp16), &["vertex 2", "70000", "65504", "f32"]);
    assert!(recorder.record.lock().unwrap().uploads.is_empty());
    Animator::new(&recorder, &rig, UploadOptions::frames(1)).unwrap();
}
