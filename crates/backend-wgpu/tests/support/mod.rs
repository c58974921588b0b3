//! Shared by the tests: a random rig, frames for it, the CPU's results, and the tolerance of a device's
//! results.
use rhytid_backend_cpu::Cpu;
use rhytid_core::{
    Animator, BasisStorage, DeviceInfo, Examples, Faces, FineScale, HandleId, HandleSet, Influences, Rig,
    RigParts, Session, Stage, StrainEdgeId, Surface, Table, UpAxis, UploadOptions, VertexId,
};

/// The devices to test on.
pub(crate) fn tested(devices: Vec<DeviceInfo>) -> Vec<DeviceInfo> {
    if devices.is_empty() {
        rhytid_test_support::skip("wgpu finds no device here");
    }
    for device in &devices {
        eprintln!("on {}: {}, {}", device.id(), device.name, device.driver);
    }
    devices
}

/// Numbers in [−1, 1) (splitmix64).
pub(crate) struct Numbers(pub u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn below(&mut self, n: usize) -> u32 {
        (((self.next() + 1.0) / 2.0 * n as f32) as usize).min(n - 1) as u32
    }
}

/// The size of a rig.
#[derive(Clone, Copy)]
pub(crate) struct Sizes {
    pub vertices: usize,
    pub handles: usize,
    pub edges: usize,
    pub examples: usize,
    pub influences: usize,
}

/// A wavy sheet with one unit between neighbours. All other numbers are random. `vertices` is at least 4.
pub(crate) fn rig(seed: u64, sizes: Sizes) -> Rig {
    let Sizes { vertices: count, handles, edges, examples, influences } = sizes;
    let mut numbers = Numbers(seed);
    let width = count.isqrt();
    let rest: Vec<[f32; 3]> =
        (0..count).map(|v| [(v % width) as f32, (v / width) as f32, 0.2 * numbers.next()]).collect();
    let mut triangles = Vec::new();
    for v in 0..count {
        if v % width + 1 < width && v + width + 1 < count {
            let [a, b, c, d] = [v, v + 1, v + width + 1, v + width].map(|i| i as u32);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let centers = examples + 1;
    let handle_vertices = (0..handles).map(|h| VertexId::from_index(h * count / handles));
    let vertices: Vec<VertexId> = handle_vertices.collect();
    let strain_edges = (0..edges)
        .map(|_| {
            let a = numbers.below(handles);
            [a, (a + 1 + numbers.below(handles - 1)) % handles as u32].map(HandleId)
        })
        .collect();
    let basis = (0..count * handles).map(|_| 0.2 * numbers.next()).collect();
    let influence_edges = (0..count)
        .flat_map(|_| {
            let first = numbers.below(edges + 1 - influences);
            (first..first + influences as u32).map(StrainEdgeId)
        })
        .collect();
    let influence_weights = (0..count * influences).map(|_| (numbers.next() + 1.0) / 2.0).collect();
    let tangent_neighbors =
        (0..count).map(|v| VertexId::from_index(if v + 1 < count { v + 1 } else { v - 1 })).collect();
    let pose_features = (0..centers * edges).map(|_| 0.3 * numbers.next()).collect();
    let rbf_weights = (0..count * centers).map(|_| std::array::from_fn(|_| 0.05 * numbers.next())).collect();
    let parts = RigParts {
        handles: HandleSet {
            labels: (0..handles).map(|h| format!("m{h}")).collect(),
            rest: vertices.iter().map(|v| rest[v.index()]).collect(),
            points: vertices.into_iter().map(Into::into).collect(),
            strain_edges,
            rotations: false,
        },
        surface: Surface {
            name: "random".into(),
            metres_per_unit: 0.01,
            up_axis: UpAxis::Y,
            faces: Faces { counts: vec![3; triangles.len()], indices: triangles.as_flattened().to_vec() },
            uvs: None,
            materials: None,
            triangles,
            rest,
            tangent_neighbors,
            joined: None,
        },
        examples: Examples {
            names: (0..examples).map(|p| format!("pose {p}")).collect(),
            handles: Table::filled(examples, handles, [0.0; 3]),
        },
        bending_length: 1.0,
        basis: Table::new(count, handles, basis),
        influences: Influences {
            edges: Table::new(count, influences, influence_edges),
            weights: Table::new(count, influences, influence_weights),
            beta: 1.0,
        },
        fine_scale: FineScale {
            pose_features: Table::new(examples + 1, edges, pose_features),
            rbf_weights: Table::new(count, examples + 1, rbf_weights),
        },
        learned: None,
    };
    Rig::new(parts).expect("numbers of the right shapes and ranges")
}

/// Handle positions of `frames` frames: the rest positions, moved by up to a third of a unit in any
/// direction.
pub(crate) fn frames(seed: u64, rig: &Rig, frames: usize) -> Vec<f32> {
    let mut numbers = Numbers(seed);
    let rest = rig.handles().rest.iter().flatten().copied();
    (0..frames).flat_map(|_| rest.clone()).map(|x| x + 0.3 * numbers.next()).collect()
}

/// Evaluates the batch on the CPU.
pub(crate) fn expected(rig: &Rig, positions: &[f32], basis: BasisStorage) -> Vec<Vec<f32>> {
    let frames = positions.len() / (rig.handles().len() * 3);
    let mut animator = Animator::new(&Cpu, rig, UploadOptions { max_frames: frames, basis }).unwrap();
    animator.evaluate(positions).unwrap();
    all_stages(&mut animator)
}

/// Every stage of the last batch.
pub(crate) fn all_stages<S: Session>(animator: &mut Animator<S>) -> Vec<Vec<f32>> {
    let stages = Stage::ALL.into_iter().map(|stage| {
        let mut out = vec![f32::NAN; 7];
        animator.read(stage, &mut out).unwrap();
        out
    });
    stages.collect()
}

/// Fails if a number differs from the expected one by more than rounding in another order can explain. The
/// numbers are at most tens, and the longest sums have a hundred terms.
pub(crate) fn agree(found: &[Vec<f32>], expected: &[Vec<f32>], context: &str) {
    for ((stage, found), expected) in Stage::ALL.into_iter().zip(found).zip(expected) {
        assert_eq!(found.len(), expected.len(), "{context}: length of {stage:?}");
        for (i, (a, b)) in found.iter().zip(expected).enumerate() {
            let allowed = 2e-5 * (1.0 + b.abs());
            assert!((a - b).abs() <= allowed, "{context}: {stage:?}[{i}] is {a}, expected {b}");
        }
    }
}
