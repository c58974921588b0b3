use super::*;
use crate::Playback;
use crate::Selection;
use rhytid_core::{HandleId, NoProgress, StrainEdgeId, channel};
use rhytid_devices::{Guard, choose_devices};
use rhytid_formats::export::{Frame, OutputStage, Recipe};
use rhytid_kernels::normals::vertex_normal;
use std::fs;
use std::path::PathBuf;

struct Fixture {
    folder: tempfile::TempDir,
    rig: Rig,
    take: Take,
}

impl Fixture {
    fn new() -> Self {
        let face = rhytid_demo::face(2_000);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let take = rhytid_demo::performance(&face).slice(0..60);
        Self { folder: tempfile::tempdir().unwrap(), rig, take }
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        fs::write(&path, text).unwrap();
        path
    }

    fn layers(&self, text: &str) -> Result<Layers> {
        Layers::read(&self.write("EDIT.toml", text), &self.rig, Reach::Below)
    }

    fn edited(&self, text: &str) -> Take {
        self.layers(text).unwrap().edit(self.take.clone(), &self.rig).unwrap().take
    }

    fn refused(&self, text: &str) -> String {
        let edited = self.layers(text).and_then(|layers| layers.edit(self.take.clone(), &self.rig));
        edited.unwrap_err().to_string()
    }

    fn handle(&self, i: usize) -> (&str, [f64; 3]) {
        (&self.rig.handles().labels[i], self.rig.handles().rest[i].map(f64::from))
    }

    /// The position of a handle in a frame.
    fn at(&self, take: &Take, frame: usize, handle: usize) -> [f64; 3] {
        let column =
            take.labels.iter().position(|label| *label == self.rig.handles().labels[handle]).unwrap();
        take.positions[frame * take.labels.len() + column]
    }

    /// Positions and normals of each frame.
    fn play(&self, text: &str) -> Vec<[Vec<f32>; 2]> {
        let layers = self.layers(text).unwrap();
        let edited = layers.edit(self.take.clone(), &self.rig).unwrap();
        play(&self.rig, &layers, edited, OutputStage::Full)
    }
}

fn play(rig: &Rig, layers: &Layers, edited: impl Into<EditedTake>, stage: OutputStage) -> Vec<[Vec<f32>; 2]> {
    let edited = &edited.into();
    let selection = Selection::all(edited.clone()).unwrap();
    let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices;
    let mut playback = Playback::new(rig, &devices, 60).unwrap();
    playback = playback.with_layers(layers, edited, &NoProgress).unwrap();
    let mut frames = Vec::new();
    let each = |frame: &Frame<'_>| {
        let normals = frame.get(&channel::NORMALS).unwrap_or_default();
        frames.push([frame.positions().to_vec(), normals.to_vec()]);
        Ok(())
    };
    let recipe = Recipe { stage, ..Recipe::default() };
    playback.play(&selection, &recipe, &NoProgress, each).unwrap();
    frames
}

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|c| (a[c] - b[c]).abs() < 1e-9)
}

/// The order of edits in the file does not matter: gains of the displacement from rest apply first, then
/// additions.
#[test]
fn edits_of_one_marker_combine_as_the_formula_says() {
    let f = Fixture::new();
    let (label, rest) = f.handle(3);
    let parts = [
        format!("[[gain]]\nregion = \"{label}\"\nby = [[10, 1.0], [20, 3.0]]\nease = \"linear\"\n"),
        "[[gain]]\nby = 0.5\n".to_owned(),
        format!(
            "[[offset]]\nregion = \"{label}\"\nmillimetres = [1, -2, 0.5]\namount = [[0, 0], [30, 1]]\nease = \"linear\"\n"
        ),
        format!("[[offset]]\nmarkers = {{ \"{label}\" = [0, 0, 4] }}\n"),
    ];
    let forwards = f.edited(&parts.concat());
    let backwards = f.edited(&parts.iter().rev().cloned().collect::<String>());
    let unit = 1e-3 / f.rig.surface().metres_per_unit;
    for frame in 0..60 {
        let taken = f.at(&f.take, frame, 3);
        let gain = 0.5 * (1.0 + 2.0 * ((frame as f64 - 10.0) / 10.0).clamp(0.0, 1.0));
        let amount = (frame as f64 / 30.0).min(1.0);
        let offset = [amount, -2.0 * amount, 0.5 * amount + 4.0].map(|x| x * unit);
        let expected = std::array::from_fn(|c| rest[c] + gain * (taken[c] - rest[c]) + offset[c]);
        assert!(close(f.at(&forwards, frame, 3), expected), "frame {frame}");
        assert!(close(f.at(&backwards, frame, 3), expected), "frame {frame}");
        let (other, rest) = (f.at(&f.take, frame, 4), f.handle(4).1);
        assert!(close(
            f.at(&forwards, frame, 4),
            std::array::from_fn(|c| rest[c] + 0.5 * (other[c] - rest[c]))
        ));
    }
}

/// The other take is added at its own times. Markers that it lacks stay, and its ends hold.
#[test]
fn another_take_is_added_at_its_own_times() {
    let f = Fixture::new();
    let (label, rest) = f.handle(5);
    let row = |time: f64, x: f64| format!("{time},{},{},{}\n", rest[0] + x, rest[1], rest[2]);
    f.write("more.csv", &format!("time,{label}_x,{label}_y,{label}_z\n{}{}", row(7.0, 0.2), row(7.4, 0.6)));
    let edited = f.edited("[[add]]\ntake = \"more.csv\"\nframe = 12\namount = 2\n");
    for frame in 0..60 {
        let since = f.take.times[frame] - f.take.times[12];
        let expected = 2.0 * (0.2 + 0.4 * (since / 0.4).clamp(0.0, 1.0));
        let moved = f.at(&edited, frame, 5)[0] - f.at(&f.take, frame, 5)[0];
        assert!((moved - expected).abs() < 1e-6, "frame {frame}: {moved}, not {expected}");
        assert_eq!(f.at(&edited, frame, 6), f.at(&f.take, frame, 6));
    }
}

#[test]
fn held_markers_do_not_move_and_go_over_smoothly() {
    let f = Fixture::new();
    let label = f.handle(2).0;
    let edited = f.edited(&format!("[[hold]]\nregion = \"{label}\"\nframes = \"20..30\"\nease = 4\n"));
    let still = f.at(&f.take, 20, 2);
    for frame in 0..60 {
        let [found, taken] = [&edited, &f.take].map(|take| f.at(take, frame, 2));
        match frame {
            20..30 => assert_eq!(found, still, "frame {frame}"),
            16..34 => {
                let outside = if frame < 20 { 20 - frame } else { frame - 29 };
                let s = 1.0 - outside as f64 / 5.0;
                let amount = s * s * (3.0 - 2.0 * s);
                assert!(close(found, std::array::from_fn(|c| taken[c] + amount * (still[c] - taken[c]))));
            }
            _ => assert_eq!(found, taken, "frame {frame}"),
        }
        assert_eq!(f.at(&edited, frame, 7), f.at(&f.take, frame, 7));
    }
}

/// Wrinkles are multiplied where and while the region says so. Elsewhere every bit is as without the edit.
#[test]
fn detail_changes_where_and_when_it_says_and_nothing_else() {
    let f = Fixture::new();
    let mut face = String::new();
    for x in &f.rig.surface().rest {
        let weight = if x[0] > 0.0 { 1.0 } else { 0.0 };
        face += &format!("{} {} {} {weight}\n", x[0], x[1], x[2]);
    }
    let header = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty float left\nelement face \
         0\nproperty list uchar int vertex_indices\nend_header\n",
        f.rig.vertices()
    );
    f.write("left.ply", &(header + &face));
    let region = "[region.left]\nweights = \"left.ply\"\nproperty = \"left\"\n";
    let plain = f.play("");
    let edited =
        f.play(&format!("{region}[[detail]]\nregion = \"left\"\nby = [[20, 1], [30, 0], [40, 1]]\n"));
    let smooth = play(&f.rig, &f.layers("").unwrap(), f.take.clone(), OutputStage::LargeScale);
    let beside: Vec<bool> = {
        let is_left = |v: u32| f.rig.surface().rest[v as usize][0] > 0.0;
        let mut beside = vec![false; f.rig.vertices()];
        let near = f.rig.surface().triangles.iter().filter(|corners| corners.iter().any(|&v| is_left(v)));
        near.flatten().for_each(|&v| beside[v as usize] = true);
        beside
    };
    let mut moved = 0.0_f32;
    for frame in 0..60 {
        let [positions, normals] = &edited[frame];
        if !(21..40).contains(&frame) {
            assert!(*positions == plain[frame][0] && *normals == plain[frame][1], "frame {frame}");
            continue;
        }
        let s = 1.0 - (frame as f32 - 30.0).abs() / 10.0;
        let gain = 1.0 - s * s * (3.0 - 2.0 * s);
        for (v, is_beside) in beside.iter().enumerate() {
            for i in 3 * v..3 * v + 3 {
                let (full, large) = (plain[frame][0][i], smooth[frame][0][i]);
                if f.rig.surface().rest[v][0] > 0.0 {
                    moved = moved.max((full - positions[i]).abs());
                    assert!(
                        (positions[i] - (large + gain * (full - large))).abs() < 1e-5,
                        "frame {frame}, {v}"
                    );
                } else {
                    assert_eq!(positions[i].to_bits(), full.to_bits(), "frame {frame}, {v}");
                }
                if !is_beside {
                    assert_eq!(normals[i].to_bits(), plain[frame][1][i].to_bits(), "frame {frame}, {v}");
                }
            }
        }
    }
    assert!(moved > 1e-3, "no wrinkles there");
}

#[test]
fn what_the_rig_does_not_have_is_said() {
    let f = Fixture::new();
    f.write("none.csv", "time,elsewhere_x,elsewhere_y,elsewhere_z\n0,1,2,3\n");
    for (text, words) in [
        (
            "[[gain]]\nregion = \"tail\"\nby = 2\n",
            "EDIT.toml: a region is “tail”, which is no handle of the rig and no region",
        ),
        (
            "[region.a]\nmarkers = [\"tail*\"]\n[[gain]]\nregion = \"a\"\nby = 2\n",
            "[region.a] markers is “tail*”",
        ),
        ("[[offset]]\nmarkers = { tail = [1, 2, 3] }\n", "[[offset]] markers has “tail”, which is no handle"),
        ("[[add]]\ntake = \"none.csv\"\n", "none.csv: has no frame of any of the rig's handles"),
        ("[[add]]\ntake = \"../none.csv\"\n", "which is not in"),
        ("[[add]]\ntake = \"not-there.csv\"\n", "not-there.csv"),
        ("[[correction]]\nmesh = \"none.csv\"\nframe = 3\n", "none.csv: a mesh's file name must end in"),
        ("[[hold]]\nframes = \"50..61\"\n", "[[hold]] of the frames 50..61 at 50: the take has 60"),
        (
            "[region.a]\nweights = \"left.obj\"\nproperty = \"x\"\n[[detail]]\nregion = \"a\"\nby = 0\n",
            "left.obj",
        ),
    ] {
        let error = f.refused(text);
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn the_hash_is_of_what_is_named_too() {
    let f = Fixture::new();
    let label = f.handle(0).0;
    let text = "[[add]]\ntake = \"more.csv\"\n";
    let hash = |x: f64| {
        f.write("more.csv", &format!("time,{label}_x,{label}_y,{label}_z\n0,{x},0,0\n"));
        f.layers(text).unwrap().hash().to_owned()
    };
    assert_eq!(hash(1.0), hash(1.0));
    assert_ne!(hash(1.0), hash(2.0));
    assert_eq!(f.layers(text).unwrap().text(), text);
}

/// A sculpted frame is met, also on top of an earlier layer. Frames that are far from it keep every bit.
#[test]
fn a_sculpted_frame_is_met_and_far_ones_are_as_before() {
    let f = Fixture::new();
    let rig = &f.rig;
    let detail = "[[detail]]\nby = 0.5\n";
    let before = f.play(detail);
    let unit = 1e-3 / rig.surface().metres_per_unit;
    let middle = rig.handles().rest[3].map(f64::from);
    let bump = |x: [f64; 3], v: usize| -> [f64; 3] {
        let rest = rig.surface().rest[v].map(f64::from);
        let far = (0..3).map(|c| (rest[c] - middle[c]).powi(2)).sum::<f64>().sqrt() / (30.0 * unit);
        let by = if far < 1.0 { 3.0 * unit * (1.0 - far * far).powi(2) } else { 0.0 };
        [x[0] + 0.6 * by, x[1] + 0.8 * by, x[2]]
    };
    let sculpted = |frame: &[f32], name: &str| {
        let (x, _) = frame.as_chunks::<3>();
        let positions: Vec<[f64; 3]> = x.iter().enumerate().map(|(v, x)| bump(x.map(f64::from), v)).collect();
        let mesh =
            Mesh { positions: positions.clone(), faces: rig.surface().faces.clone(), ..Mesh::default() };
        mesh::write_obj(&f.folder.path().join(name), &mesh).unwrap();
        positions
    };
    let once = sculpted(&before[25][0], "once.obj");
    let one = format!("{detail}[[correction]]\nmesh = \"once.obj\"\nframe = 25\n");
    let corrected = f.play(&one);
    let twice = sculpted(&corrected[25][0], "twice.obj");
    let two = f.play(&format!("{one}[[correction]]\nmesh = \"twice.obj\"\nframe = 25\n"));
    let off = |frame: &[f32], expected: &[[f64; 3]]| {
        let pairs = frame.iter().zip(expected.as_flattened());
        pairs.map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max) / unit
    };
    assert!(off(&corrected[25][0], &once) < 1e-3, "{} mm", off(&corrected[25][0], &once));
    assert!(off(&two[25][0], &twice) < 1e-3, "{} mm", off(&two[25][0], &twice));
    // The distance that `explain` states, which is made of the same strains.
    let handles = f.take.handle_positions(&rig.handles().labels).unwrap();
    let pose =
        |frame: usize| handles[frame * 3 * rig.handles().len()..][..3 * rig.handles().len()].as_chunks().0;
    let [features, rest] = [rig.handles().vector_strains(pose(25)), vec![[0.0; 3]; rig.handles().features()]];
    let apart = |a: &[[f64; 3]], b: &[[f64; 3]], v: usize| {
        let square = |(e, w): (usize, f64)| w * (0..3).map(|c| (a[e][c] - b[e][c]).powi(2)).sum::<f64>();
        rig.influences_of(v).map(square).sum::<f64>().sqrt()
    };
    let moved: Vec<usize> = (0..rig.vertices()).filter(|&v| bump([0.0; 3], v) != [0.0; 3]).collect();
    let reach = 0.5 * moved.iter().map(|&v| apart(&features, &rest, v)).sum::<f64>() / moved.len() as f64;
    let (mut far, mut near) = (0, 0);
    for frame in 0..60 {
        let here = rig.handles().vector_strains(pose(frame));
        for v in 0..rig.vertices() {
            let bits = |of: &[[Vec<f32>; 2]]| {
                of[frame][0][3 * v..3 * v + 3].iter().map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            let [a, b] = [&before, &corrected].map(|frames| &frames[frame][0][3 * v..3 * v + 3]);
            let moved = (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>().sqrt() / unit;
            let largest = (0..3).map(|c| bump([0.0; 3], v)[c].powi(2)).sum::<f64>().sqrt() / unit;
            let s = apart(&here, &features, v) / reach;
            if largest == 0.0 || s >= 1.05 {
                assert_eq!(bits(&before), bits(&corrected), "frame {frame}, vertex {v}");
                far += usize::from(largest > 0.0);
            } else if s < 0.95 {
                let expected = largest * (1.0 - s).powi(4) * (4.0 * s + 1.0);
                assert!(
                    (moved - expected).abs() < 0.1 * largest + 0.01,
                    "frame {frame}, vertex {v}: {moved}, {expected}"
                );
                near += usize::from(expected > 0.5);
            }
        }
    }
    assert!(far > 1000 && near > 100, "{far} far, {near} near");
}

/// Edited and unedited markers are met. A vertex that no edited marker drives has the same bits as without
/// the edit.
#[test]
fn what_no_edited_marker_holds_keeps_every_bit() {
    let f = Fixture::new();
    let rig = &f.rig;
    let left: Vec<usize> = (0..rig.handles().len()).filter(|&h| f.handle(h).1[0] > 2.0).collect();
    assert!(left.len() > 2 && left.len() * 2 < rig.handles().len());
    let labels: Vec<String> = left.iter().map(|&h| format!("{:?}", rig.handles().labels[h])).collect();
    let text = format!(
        "[region.left]\nmarkers = [{}]\n[[gain]]\nregion = \"left\"\nby = [[10, 1], [20, 1.5], [40, 1.5], [50, 1]]\n",
        labels.join(", ")
    );
    let (plain, edited, take) = (f.play(""), f.play(&text), f.edited(&text));
    // The shell decides how far a marker reaches.
    let held = |v: usize| {
        let row = rig.basis().row(v);
        // A vertex without a row is influenced by its anchors.
        if row.iter().all(|b| *b == 0.0) {
            return 0.2;
        }
        left.iter().map(|&h| f64::from(row[h])).sum::<f64>()
    };
    let (mut kept, mut moved) = (0, 0.0_f32);
    for frame in 0..60 {
        let [positions, normals] = &edited[frame];
        if !(11..50).contains(&frame) {
            assert!(*positions == plain[frame][0] && *normals == plain[frame][1], "frame {frame}");
            continue;
        }
        for (h, v) in rig.handles().held().enumerate() {
            let place = f.at(&take, frame, h);
            let x = &positions[3 * v.index()..][..3];
            assert!((0..3).all(|c| (f64::from(x[c]) - place[c]).abs() < 1e-4), "frame {frame}, handle {h}");
        }
        for v in 0..rig.vertices() {
            let [a, b] = [&plain, &edited].map(|frames| &frames[frame][0][3 * v..3 * v + 3]);
            if held(v) < 0.049 {
                assert!(
                    a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits()),
                    "frame {frame}, vertex {v}"
                );
                kept += 1;
            } else if held(v) > 0.5 {
                moved = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(moved, f32::max);
            }
        }
    }
    assert!(kept > 10_000 && moved > 0.02, "{kept} kept, moved by {moved}");
    // The edit's contribution changes no faster from frame to frame than the edit and the face themselves.
    let added = |frame: usize, i: usize| edited[frame][0][i] - plain[frame][0][i];
    let step = |frame: usize| {
        let steps = (0..3 * rig.vertices()).map(|i| (added(frame + 1, i) - added(frame, i)).abs());
        steps.fold(0.0, f32::max)
    };
    let marker_step = |frame: usize| {
        let added = |frame: usize, h: usize| {
            let [a, b] = [&take, &f.take].map(|take| f.at(take, frame, h));
            [0, 1, 2].map(|c| (a[c] - b[c]) as f32)
        };
        let steps = left.iter().flat_map(|&h| {
            let [a, b] = [added(frame + 1, h), added(frame, h)];
            [0, 1, 2].map(|c| (a[c] - b[c]).abs())
        });
        steps.fold(0.0, f32::max)
    };
    for frame in 9..50 {
        let (face, marker) = (step(frame), marker_step(frame));
        assert!(face < 2.0 * marker + 0.02, "frame {frame}: {face}, the markers {marker}");
    }
}

/// A label has no meaning in playback: a take without edits plays the same with any names of its markers.
#[test]
fn a_marker_of_any_name_changes_nothing() {
    let f = Fixture::new();
    let markers = f.take.labels.len();
    let mut odd = f.take.clone();
    odd.labels.push(format!("{} as it was", f.rig.handles().labels[4]));
    let rows = f.take.positions.chunks_exact(markers);
    odd.positions = rows.flat_map(|row| row.iter().copied().chain([[1.0, 2.0, 3.0]])).collect();
    let none = f.layers("").unwrap();
    let [plain, found] = [f.take.clone(), odd].map(|take| play(&f.rig, &none, take, OutputStage::Full));
    assert!(plain == found, "a marker that no handle has moves the face");
}

/// A partial evaluation gives the same result as two whole takes that are blended and scaled by the formulas.
#[test]
fn markers_and_wrinkles_that_are_edited_at_once_come_to_what_the_formulas_say() {
    let f = Fixture::new();
    let rig = &f.rig;
    let triangles = rig.surface().vertex_triangles();
    let by_side: Vec<usize> = {
        let mut handles: Vec<usize> = (0..rig.handles().len()).collect();
        handles.sort_by(|a, b| f.handle(*b).1[0].total_cmp(&f.handle(*a).1[0]));
        handles
    };
    let none = f.layers("").unwrap();
    let [plain, plain_smooth] =
        [OutputStage::Full, OutputStage::LargeScale].map(|stage| play(rig, &none, f.take.clone(), stage));
    for markers in [2, by_side.len() - 3] {
        let chosen = &by_side[..markers];
        let labels: Vec<String> = chosen.iter().map(|&h| format!("{:?}", rig.handles().labels[h])).collect();
        let keys = |by: f64| format!("[[10, 1], [20, {by}], [40, {by}], [50, 1]]\nease = \"linear\"\n");
        let text = format!(
            "[region.a]\nmarkers = [{}]\n[[gain]]\nregion = \"a\"\nby = {}[[detail]]\nregion = \"a\"\nby = {}",
            labels.join(", "),
            keys(1.2),
            keys(0.5)
        );
        let layers = f.layers(&text).unwrap();
        let take = layers.edit(f.take.clone(), rig).unwrap();
        let found = play(rig, &layers, take.clone(), OutputStage::Full);
        let shown_smooth = play(rig, &layers, take.clone(), OutputStage::LargeScale);
        // The same markers without the take before the edits: the whole face follows them.
        let unbounded = &take.take;
        let [whole, whole_smooth] = [OutputStage::Full, OutputStage::LargeScale]
            .map(|stage| play(rig, &none, unbounded.clone(), stage));
        let held = |v: usize| {
            let row = rig.basis().row(v);
            let of = |h: usize| if chosen.contains(&h) { 1.0 } else { 0.0 };
            let sum = match row.iter().any(|b| *b != 0.0) {
                true => row.iter().enumerate().map(|(h, b)| f64::from(*b) * of(h)).sum::<f64>(),
                false => {
                    let edges = rig.handles().strain_edges.len();
                    let of_feature = |e: usize| match rig.handles().strain_edges.get(e) {
                        Some([a, b]) => 0.5 * (of(a.index()) + of(b.index())),
                        None => of(e - edges),
                    };
                    let all: f64 = rig.influences_of(v).map(|(_, w)| w).sum();
                    rig.influences_of(v).map(|(e, w)| w / all * of_feature(e)).sum()
                }
            };
            let s = ((sum - 0.05) / 0.9).clamp(0.0, 1.0);
            s * s * (3.0 - 2.0 * s)
        };
        let wrinkles = of_handles(rig, chosen);
        let (mut far, mut moved, mut wrinkled) = (0.0_f64, 0.0_f64, 0.0_f64);
        for frame in 0..60 {
            let at = frame as f64;
            let s = ((at - 10.0) / 10.0).min((50.0 - at) / 10.0).clamp(0.0, 1.0);
            for (v, wrinkle) in wrinkles.iter().enumerate() {
                let w = held(v);
                let gain = 1.0 + wrinkle * (0.5 - 1.0) * s;
                for i in 3 * v..3 * v + 3 {
                    let between = |a: &[[Vec<f32>; 2]], b: &[[Vec<f32>; 2]]| {
                        let [a, b] = [a, b].map(|frames| f64::from(frames[frame][0][i]));
                        a + w * (b - a)
                    };
                    let smooth = between(&plain_smooth, &whole_smooth);
                    let full = between(&plain, &whole);
                    let x = f64::from(found[frame][0][i]);
                    far = far.max((x - (smooth + gain * (full - smooth))).abs());
                    far = far.max((f64::from(shown_smooth[frame][0][i]) - smooth).abs());
                    moved = moved.max((full - f64::from(plain[frame][0][i])).abs());
                    wrinkled = wrinkled.max((x - full).abs());
                }
            }
            let (positions, _) = found[frame][0].as_chunks::<3>();
            for (v, normal) in found[frame][1].as_chunks::<3>().0.iter().enumerate() {
                let expected = vertex_normal(positions, &rig.surface().triangles, triangles.at(v));
                let off = (0..3).map(|c| (normal[c] - expected[c]).abs()).fold(0.0, f32::max);
                assert!(off < 1e-4, "{markers} markers, frame {frame}, vertex {v}: {normal:?}, {expected:?}");
            }
        }
        assert!(far < 2e-5, "{markers} markers: {far}");
        assert!(moved > 1e-3 && wrinkled > 1e-3, "{markers} markers: moved {moved}, wrinkled {wrinkled}");
    }
}

/// V: the share of these handles among all that drive a vertex's wrinkles.
fn of_handles(rig: &Rig, handles: &[usize]) -> Vec<f64> {
    let of_edge = |e: StrainEdgeId| {
        let is_one = |h: HandleId| f64::from(u8::from(handles.contains(&h.index())));
        let ends = rig.handles().strain_edges[e.index()].map(is_one);
        0.5 * (ends[0] + ends[1])
    };
    let of_vertex = |v: usize| {
        let influences = rig.influences().at(v);
        let all: f64 = influences.clone().map(|(_, w)| f64::from(w)).sum();
        let of = influences.map(|(e, w)| f64::from(w) * of_edge(e)).sum::<f64>();
        if all > 0.0 { of / all } else { 0.0 }
    };
    (0..rig.vertices()).map(of_vertex).collect()
}

/// A gain that is the same in all frames does the same in the rig as on its frames, and it changes nothing
/// else.
#[test]
fn what_is_the_same_in_all_frames_is_put_into_the_rig() {
    let f = Fixture::new();
    let label = f.handle(3).0;
    let constant =
        format!("[[detail]]\nregion = \"{label}\"\nby = 0.25\n[[detail]]\nby = [[3, 1.5], [8, 1.5]]\n");
    let keyed = format!("{constant}[[detail]]\nby = [[10, 1], [20, 0.5]]\n");
    let plain = f.play("");
    for text in [constant, keyed] {
        let expected = f.play(&text);
        let mut layers = f.layers(&text).unwrap();
        let rig = layers.settle(f.rig.clone()).unwrap();
        assert_ne!(rig.fine_scale().rbf_weights, f.rig.fine_scale().rbf_weights);
        let found = play(&rig, &layers, f.take.clone(), OutputStage::Full);
        let apart = |a: &[[Vec<f32>; 2]], b: &[[Vec<f32>; 2]]| {
            let pairs = a.iter().flat_map(|[x, _]| x).zip(b.iter().flat_map(|[x, _]| x));
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        assert!(apart(&found, &expected) < 1e-5, "{}", apart(&found, &expected));
        assert!(apart(&found, &plain) > 1e-3);
        // The gain is applied only once.
        let rig = layers.settle(rig).unwrap();
        assert_eq!(play(&rig, &layers, f.take.clone(), OutputStage::Full), found);
    }
}
