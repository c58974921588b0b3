//! A rig of random numbers, the devices of this machine, and how results are compared.
use crate::Vulkan;
use rhytid_backend_cpu::Cpu;
use rhytid_core::{
    Animator, DeviceErrorKind, DeviceInfo, Error, Examples, Faces, FineScale, HandleFrames, HandleId,
    HandleSet, Influences, Rig, RigParts, Session, Stage, StrainEdgeId, Surface, Table, UpAxis,
    UploadOptions, VertexId,
};

/// Every Vulkan device.
pub(crate) fn devices() -> Vec<DeviceInfo> {
    let devices = Vulkan::devices_with(false).unwrap();
    if devices.is_empty() {
        rhytid_test_support::skip("there is no Vulkan device");
    }
    devices
}

/// Opens a device with the validation layer; `None` where that is not installed.
pub(crate) fn validated(device: &DeviceInfo) -> Option<Vulkan> {
    match Vulkan::open_with(device, true) {
        Ok(vulkan) => Some(vulkan),
        Err(Error::Device { kind: DeviceErrorKind::Unsupported, message, .. }) => {
            rhytid_test_support::skip(&message);
            None
        }
        Err(other) => panic!("{other}"),
    }
}

/// Pseudo-random numbers, the same every time.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// From −1 to 1.
    pub(crate) fn number(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f32) / (1_u64 << 23) as f32 - 1.0
    }

    fn below(&mut self, end: usize) -> u32 {
        ((f64::from(self.number()) + 1.0) / 2.0 * end as f64).min(end as f64 - 1.0) as u32
    }

    fn numbers(&mut self, n: usize) -> Vec<f32> {
        (0..n).map(|_| self.number()).collect()
    }
}

/// The size of a rig.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Size {
    /// Vertices are columns × rows.
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) handles: usize,
    pub(crate) edges: usize,
    pub(crate) poses: usize,
    pub(crate) influences: usize,
}

pub(crate) const SMALL: Size = Size { columns: 23, rows: 17, handles: 9, edges: 20, poses: 3, influences: 7 };

/// A bumpy sheet whose basis, influences and weights are random.
pub(crate) fn rig(size: Size) -> Rig {
    let Size { columns, rows, handles, edges, poses, influences } = size;
    let (count, centers) = (columns * rows, poses + 1);
    let mut random = Random(1);
    let mut faces = Faces::default();
    let mut triangles = Vec::new();
    for row in 0..rows as u32 - 1 {
        for column in 0..columns as u32 - 1 {
            let a = row * columns as u32 + column;
            let below = a + columns as u32;
            for triangle in [[a, a + 1, below + 1], [a, below + 1, below]] {
                faces.push(&triangle);
                triangles.push(triangle);
            }
        }
    }
    let rest = (0..count)
        .map(|v| [(v % columns) as f32, (v / columns) as f32, 0.3 * random.number()])
        .collect::<Vec<[f32; 3]>>();
    let handle = |h: usize| VertexId::from_index(h * (count / handles));
    let vectors = |numbers: Vec<f32>| numbers.as_chunks::<3>().0.to_vec();
    let vertices: Vec<VertexId> = (0..handles).map(handle).collect();
    let basis = random.numbers(count * handles);
    let strain_edges = (0..edges)
        .map(|_| {
            let a = random.below(handles);
            [a, (a + 1 + random.below(handles - 1)) % handles as u32].map(HandleId)
        })
        .collect();
    let influence_edges = (0..count)
        .flat_map(|_| {
            let first = random.below(edges + 1 - influences);
            (first..first + influences as u32).map(StrainEdgeId)
        })
        .collect();
    let influence_weights = random.numbers(count * influences).iter().map(|a| a.abs()).collect();
    let tangent_neighbors = (0..count)
        .map(|v| VertexId::from_index(if (v + 1) % columns == 0 { v - 1 } else { v + 1 }))
        .collect();
    let pose_features = [vec![0.0; edges], random.numbers(poses * edges)].concat();
    let rbf_weights = vectors(random.numbers(count * centers * 3).iter().map(|w| 0.02 * w).collect());
    let parts = RigParts {
        handles: HandleSet {
            labels: (0..handles).map(|h| h.to_string()).collect(),
            rest: vertices.iter().map(|v| rest[v.index()]).collect(),
            points: vertices.into_iter().map(Into::into).collect(),
            strain_edges,
            rotations: false,
        },
        surface: Surface {
            name: "random".into(),
            metres_per_unit: 0.01,
            up_axis: UpAxis::Y,
            faces,
            uvs: None,
            materials: None,
            triangles,
            rest,
            tangent_neighbors,
            joined: None,
        },
        examples: Examples {
            names: (0..poses).map(|p| p.to_string()).collect(),
            handles: Table::filled(poses, handles, [0.0; 3]),
        },
        bending_length: 1.0,
        basis: Table::new(count, handles, basis),
        influences: Influences {
            edges: Table::new(count, influences, influence_edges),
            weights: Table::new(count, influences, influence_weights),
            beta: 1.0,
        },
        fine_scale: FineScale {
            pose_features: Table::new(poses + 1, edges, pose_features),
            rbf_weights: Table::new(count, poses + 1, rbf_weights),
        },
        learned: None,
    };
    Rig::new(parts).expect("numbers of the right shapes and ranges")
}

/// Handle positions of `frames` different frames.
pub(crate) fn take(rig: &Rig, frames: usize, seed: u64) -> Vec<f32> {
    let mut random = Random(seed);
    let rest = &rig.handles().rest;
    (0..frames).flat_map(|_| rest.clone()).flatten().map(|x| x + 0.2 * random.number()).collect()
}

/// A batch on the CPU: every stage.
pub(crate) fn on_cpu(rig: &Rig, options: UploadOptions, positions: &[f32]) -> Vec<Vec<f32>> {
    let mut animator = Animator::new(&Cpu, rig, options).unwrap();
    animator.evaluate(positions).unwrap();
    Stage::ALL.map(|stage| read(animator.session_mut(), stage)).into()
}

/// A batch on a session: every stage.
pub(crate) fn evaluate(session: &mut impl Session, rig: &Rig, positions: &[f32]) -> Vec<Vec<f32>> {
    let frames = positions.len() / (3 * rig.handles().len());
    session.evaluate(HandleFrames { positions, frames }).unwrap();
    Stage::ALL.map(|stage| read(session, stage)).into()
}

pub(crate) fn read(session: &mut impl Session, stage: Stage) -> Vec<f32> {
    let mut out = vec![f32::NAN; 5];
    session.read(stage, &mut out).unwrap();
    out
}

/// Fails if a number is off by more than a hundred-thousandth of the largest one of its stage.
pub(crate) fn assert_close(found: &[Vec<f32>], expected: &[Vec<f32>]) {
    for ((found, expected), stage) in found.iter().zip(expected).zip(Stage::ALL) {
        assert_eq!(found.len(), expected.len(), "{stage:?}");
        let largest = expected.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        for (i, (a, b)) in found.iter().zip(expected).enumerate() {
            assert!((a - b).abs() <= 1e-5 * largest, "{stage:?}[{i}] is {a}, expected {b}");
        }
    }
}
