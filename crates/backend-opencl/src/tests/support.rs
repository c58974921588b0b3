//! Random rigs, a comparison, and tests that run in a process of their own.
use crate::OpenCl;
use rhytid_backend_cpu::Cpu;
use rhytid_core::{
    Animator, Backend, DeviceInfo, Examples, Faces, FineScale, HandleId, HandleSet, Influences, Rig,
    RigParts, Session, Stage, StrainEdgeId, Surface, Table, UpAxis, UploadOptions, VertexId,
};
use rhytid_test_support::skip;
use std::process::{Command, Output};

/// The variable with the test for which a child process is started.
const CHILD: &str = "RHYTID_CHILD_TEST";

/// Every device of this machine.
pub(crate) fn devices() -> Vec<DeviceInfo> {
    let devices = OpenCl::devices().unwrap();
    if devices.is_empty() {
        skip("there is no OpenCL device here");
    }
    devices
}

/// Pseudo-random numbers, the same everywhere.
pub(crate) struct Numbers(pub u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        self.0 >> 33
    }

    /// Below `end`.
    fn index(&mut self, end: usize) -> u32 {
        (self.next() % end as u64) as u32
    }

    /// In 0..1.
    fn unit(&mut self) -> f32 {
        (self.next() % 1000) as f32 / 1000.0
    }

    fn vector(&mut self, size: f32) -> [f32; 3] {
        [(); 3].map(|()| size * (2.0 * self.unit() - 1.0))
    }
}

/// A jittered sheet with V vertices, H handles, F strain edges, P examples and K influences.
pub(crate) fn rig([v, h, f, p, k]: [usize; 5]) -> Rig {
    let mut numbers = Numbers((v + h) as u64);
    let width = (v as f64).sqrt().ceil() as usize;
    let rest: Vec<[f32; 3]> = (0..v)
        .map(|i| {
            let [x, y, z] = numbers.vector(0.2);
            [(i % width) as f32 + x, (i / width) as f32 + y, z]
        })
        .collect();
    let mut triangles = vec![[0, 0, v as u32 - 1]];
    for i in (0..v).filter(|i| i % width + 1 < width && i + width + 1 < v) {
        let [a, b, c, d] = [i, i + 1, i + width + 1, i + width].map(|i| i as u32);
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let strain_edges = (0..f)
        .map(|_| {
            let a = numbers.index(h);
            [a, (a + 1 + numbers.index(h - 1)) % h as u32].map(HandleId)
        })
        .collect();
    let vertices: Vec<VertexId> = (0..h).map(|i| VertexId::from_index(i * v / h)).collect();
    let basis = (0..v * h).map(|_| numbers.unit() / h as f32).collect();
    let influence_edges = (0..v)
        .flat_map(|_| {
            let first = numbers.index(f + 1 - k);
            (first..first + k as u32).map(StrainEdgeId)
        })
        .collect();
    let influence_weights = (0..v * k).map(|_| numbers.unit()).collect();
    let tangent_neighbors = (0..v).map(|i| VertexId::from_index((i + 1) % v)).collect();
    let pose_features = (0..(p + 1) * f).map(|_| 0.3 * numbers.unit()).collect();
    let rbf_weights = (0..v * (p + 1)).map(|_| numbers.vector(0.1)).collect();
    let parts = RigParts {
        handles: HandleSet {
            labels: (0..h).map(|h| h.to_string()).collect(),
            rest: vertices.iter().map(|v| rest[v.index()]).collect(),
            points: vertices.into_iter().map(Into::into).collect(),
            strain_edges,
            rotations: false,
        },
        surface: Surface {
            name: "sheet".into(),
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
            names: (0..p).map(|p| p.to_string()).collect(),
            handles: Table::filled(p, h, [0.0; 3]),
        },
        bending_length: 1.0,
        basis: Table::new(v, h, basis),
        influences: Influences {
            edges: Table::new(v, k, influence_edges),
            weights: Table::new(v, k, influence_weights),
            beta: 1.0,
        },
        fine_scale: FineScale {
            pose_features: Table::new(p + 1, f, pose_features),
            rbf_weights: Table::new(v, p + 1, rbf_weights),
        },
        learned: None,
    };
    Rig::new(parts).expect("numbers of the right shapes and ranges")
}

/// frames × H × 3: the handles, moved at random.
pub(crate) fn frames(rig: &Rig, frames: usize, seed: u64) -> Vec<f32> {
    let mut numbers = Numbers(seed);
    let mut positions = Vec::new();
    for _ in 0..frames {
        for rest in &rig.handles().rest {
            let u = numbers.vector(0.5);
            positions.extend((0..3).map(|c| rest[c] + u[c]));
        }
    }
    positions
}

/// The rig on the CPU backend, which gives the same bits as the kernels' references.
pub(crate) fn on_cpu(rig: &Rig, options: UploadOptions) -> Animator<impl Session> {
    Animator::new(&Cpu, rig, options).unwrap()
}

/// Asserts that every stage of a device's last batch agrees with the CPU's, to 2⁻¹⁵ of the largest number in
/// it.
pub(crate) fn assert_agreement<A: Session, B: Session>(
    device: &mut Animator<A>,
    cpu: &mut Animator<B>,
    what: &str,
) {
    let (mut found, mut expected) = (Vec::new(), Vec::new());
    for stage in Stage::ALL {
        device.read(stage, &mut found).unwrap();
        cpu.read(stage, &mut expected).unwrap();
        assert_eq!(found.len(), expected.len(), "{what}: {stage:?}");
        let largest = expected.iter().fold(0.0f32, |largest, x| largest.max(x.abs()));
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let difference = (found - expected).abs();
            assert!(
                difference <= largest * 2.0f32.powi(-15),
                "{what}: {stage:?}[{i}] is {found}, expected {expected} where the largest is {largest}"
            );
        }
    }
}

/// Whether this process was started for the test of this name. In any other process, tests that need one do
/// nothing.
pub(crate) fn is_child_for(test: &str) -> bool {
    std::env::var(CHILD).as_deref() == Ok(test)
}

/// Runs one test in a process of its own, started by `launcher`.
pub(crate) fn run_child(test: &str, launcher: &[&str], environment: &[(&str, &str)]) -> Output {
    let this = std::env::current_exe().unwrap();
    let mut command = match launcher {
        [] => Command::new(this),
        [program, arguments @ ..] => {
            let mut command = Command::new(program);
            command.args(arguments).arg(this);
            command
        }
    };
    command.args(["--exact", "--nocapture", "--test-threads=1", test]).env(CHILD, test);
    command.envs(environment.iter().copied()).output().unwrap()
}

/// The child's output. Asserts that it ran its one test to the end.
pub(crate) fn output_of_success(output: &Output) -> String {
    let [written, errors] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    // This is enough to see the reason.
    let errors: String = errors.chars().take(5000).collect();
    assert!(output.status.success(), "{}\n{written}\n{errors}", output.status);
    assert!(written.contains("test result: ok. 1 passed"), "{written}\n{errors}");
    written.into_owned()
}
