//! Packed rig files: what is kept, what is rounded, and what is refused.

use proptest::prelude::*;
use rhytid_core::rig_file::{self, Packing, Step};
use rhytid_core::{Face, NoProgress, Rig, VertexId};
use rhytid_solve::solve;
use rhytid_test_support::points::beside;
use rhytid_test_support::split::split;
use rhytid_test_support::{eye, lips, sheet};
use std::collections::BTreeSet;
use std::sync::LazyLock;

const PACKING: Packing = Packing {
    worst: 0.25,
    rms: 0.125,
    normals: 0.5,
    finished: 0.375,
    finished_beyond: 3,
    poses: 7,
    rig: String::new(),
};

fn solved(face: &Face) -> Rig {
    solve(face, &NoProgress).unwrap().rounded().unwrap()
}

/// Rigs with handles at vertices and inside triangles, with eyeballs, with openings, and with vertices that
/// are one point.
static RIGS: LazyLock<Vec<Rig>> = LazyLock::new(|| {
    let mut inside = sheet::face();
    inside.handles.points = beside(&inside.neutral, &inside.handles.points, [0.5, 0.25, 0.25]);
    let halves = split(&sheet::face(), |face, _| face).face;
    [sheet::face(), inside, halves, eye::face(), lips::face()].iter().map(solved).collect()
});

static PACKED: LazyLock<Vec<u8>> =
    LazyLock::new(|| rig_file::pack(&RIGS[0], &steps(0.01), &PACKING).unwrap());

fn steps(size: f32) -> Vec<Step> {
    RIGS.iter().flat_map(rig_file::roundable).map(|found| Step { array: found.array, size }).collect()
}

/// The vertices that handles are at, with all vertices of the same points.
fn held(rig: &Rig) -> BTreeSet<usize> {
    let mut held: BTreeSet<usize> = rig.handles().held().map(VertexId::index).collect();
    for (v, first) in rig.surface().copies() {
        if held.contains(&first.index()) {
            held.insert(v.index());
        }
    }
    held
}

#[test]
fn without_steps_every_bit_is_kept() {
    for rig in &*RIGS {
        let bytes = rig_file::pack(rig, &[], &PACKING).unwrap();
        assert!(rig_file::decode(&bytes, "small").unwrap() == *rig);
        assert_eq!(bytes, rig_file::pack(rig, &[], &PACKING).unwrap());
        assert!(bytes.len() < rig_file::encode(rig).unwrap().len());
    }
}

#[test]
fn numbers_become_the_nearest_multiples_and_handles_stay() {
    for rig in &*RIGS {
        let size = 0.01;
        let bytes = rig_file::pack(rig, &steps(size), &PACKING).unwrap();
        let found = rig_file::decode(&bytes, "small").unwrap();
        assert!(found == rig_file::rounded(rig, &steps(size)).unwrap());
        let held = held(rig);
        let of_rig = |rig: &Rig| -> Vec<Vec<f32>> {
            (0..rig.vertices())
                .map(|v| {
                    [rig.surface().rest[v].as_slice(), rig.basis().row(v), rig.influences().weights.row(v)]
                        .concat()
                })
                .collect()
        };
        let mut changed = 0;
        for (v, (before, after)) in of_rig(rig).into_iter().zip(of_rig(&found)).enumerate() {
            for (before, after) in before.into_iter().zip(after) {
                changed += usize::from(before != after);
                if held.contains(&v) {
                    assert_eq!(before, after, "vertex {v}");
                    continue;
                }
                assert!((before - after).abs() <= 0.5001 * size, "vertex {v}: {before}, {after}");
                let multiple = f64::from(after) / f64::from(size);
                assert!((multiple - multiple.round()).abs() < 1e-4, "vertex {v}: {after}");
            }
        }
        assert!(changed > rig.vertices());
        // What has no step is as it was.
        assert_eq!(found.surface().faces, rig.surface().faces);
        assert_eq!(found.handles(), rig.handles());
        assert_eq!(found.influences().edges, rig.influences().edges);
        assert_eq!(found.examples(), rig.examples());
    }
}

#[test]
fn a_file_states_how_it_was_packed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.safetensors");
    std::fs::write(&path, &*PACKED).unwrap();
    assert_eq!(rig_file::read_packing(&path).unwrap(), Some(PACKING));
    rig_file::write(&path, &RIGS[0]).unwrap();
    assert_eq!(rig_file::read_packing(&path).unwrap(), None);
}

#[test]
fn a_file_that_is_cut_short_is_refused() {
    for length in 0..PACKED.len() {
        let error = rig_file::decode(&PACKED[..length], "small").unwrap_err().to_string();
        assert!(error.starts_with("small: "), "{length}: {error}");
    }
}

proptest! {
    #[test]
    fn damage_never_panics(
        places in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4)
    ) {
        let mut bytes = PACKED.clone();
        for (place, byte) in places {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        let _ = rig_file::decode(&bytes, "small");
    }
}
