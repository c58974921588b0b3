//! A test with one realistic face, in addition to the suite's generated ones. Its positions are read from the
//! device and compared with the f64 reference.
use rhytid_conformance::evaluate;
use rhytid_core::Rig;

/// The allowed distance of a vertex from the reference's, as a part of the diagonal of the face's bounding
/// box.
pub const ALLOWED: f64 = 2e-5;

/// The result for a face.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// V.
    pub vertices: usize,
    /// frames × H × 3: the positions of the handles, in mesh units.
    pub handle_positions: Vec<f32>,
    /// frames × V × 3: the device's positions, in mesh units.
    pub positions: Vec<f32>,
    /// The largest distance of a vertex from the reference's, as a part of the diagonal of the face's
    /// bounding box. Infinite where the device gave another number of vertices, or NaN.
    pub off: f64,
}

impl Face {
    /// Compares `positions`, frames × V × 3, with the reference's result for `handle_positions`, frames × H ×
    /// 3.
    pub fn new(rig: &Rig, handle_positions: Vec<f32>, positions: Vec<f32>) -> Self {
        let reference = rig.widened();
        let handles: Vec<[f64; 3]> = points(&handle_positions);
        let expected = evaluate(&reference, &handles).positions;
        let found = points(&positions);
        let distance =
            |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
        let distances = found.iter().zip(&expected).map(distance);
        // A NaN distance must not pass for a small one.
        let worst =
            distances.fold(0.0, |worst: f64, d| if d.is_nan() { f64::INFINITY } else { worst.max(d) });
        let off = if found.len() == expected.len() {
            worst / diagonal(&reference.surface().rest)
        } else {
            f64::INFINITY
        };
        Self { vertices: rig.vertices(), handle_positions, positions, off }
    }

    /// Whether every vertex is where it should be.
    pub fn passed(&self) -> bool {
        self.off <= ALLOWED
    }

    /// The number of evaluated frames.
    pub fn frames(&self) -> usize {
        self.positions.len() / (3 * self.vertices.max(1))
    }
}

/// The poses in which a rig is evaluated: at rest, and then each example by half and in full. frames × H × 3,
/// mesh units.
pub fn poses(rig: &Rig) -> Vec<f32> {
    let rest = &rig.handles().rest;
    let mut poses = rest.as_flattened().to_vec();
    for example in rig.examples().handles.rows() {
        for gain in [0.5, 1.0] {
            let between =
                rest.iter().zip(example).flat_map(|(r, e)| [0, 1, 2].map(|c| r[c] + gain * (e[c] - r[c])));
            poses.extend(between);
        }
    }
    poses
}

fn points(numbers: &[f32]) -> Vec<[f64; 3]> {
    numbers.as_chunks().0.iter().map(|p: &[f32; 3]| p.map(f64::from)).collect()
}

/// The diagonal of the bounding box.
fn diagonal(points: &[[f64; 3]]) -> f64 {
    let extent = |c: usize| {
        let (low, high) = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[c]), high.max(p[c])));
        high - low
    };
    (0..3).map(|c| extent(c).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_backend_cpu::Cpu;
    use rhytid_core::{Backend, Device, NoProgress, Stage, UploadOptions};

    #[test]
    fn the_processor_passes_and_a_vertex_out_of_place_does_not() {
        let rig = rhytid_solve::solve(&rhytid_demo::face(2_000), &NoProgress).unwrap().rounded().unwrap();
        let poses = poses(&rig);
        let frames = 1 + 2 * rig.examples().names.len();
        assert_eq!(poses.len(), frames * rig.handles().len() * 3);
        let device = Device::open::<Cpu>(&Cpu::devices().unwrap()[0]).unwrap();
        let mut animator = device.upload(&rig, UploadOptions::frames(frames)).unwrap();
        animator.evaluate(&poses).unwrap();
        let mut positions = Vec::new();
        animator.read(Stage::Positions, &mut positions).unwrap();

        let face = |positions: &[f32]| Face::new(&rig, poses.clone(), positions.to_vec());
        let sound = face(&positions);
        assert!(sound.passed() && sound.off > 0.0, "{}", sound.off);
        assert_eq!(sound.frames(), frames);
        let last = positions.len() - 1;
        for spoiled in [positions[last] + 0.01, f32::NAN] {
            let mut positions = positions.clone();
            positions[last] = spoiled;
            assert!(!face(&positions).passed(), "{spoiled}");
        }
        assert!(!face(&positions[..last]).passed());
        assert!(!face(&[]).passed());
    }
}
