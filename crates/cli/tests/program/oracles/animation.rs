//! A face that is animated twice: by the program into files, and by the library.

use super::programs::Frames;
use rhytid::core::{Backend, RigidMotion, UpAxis, rig_file};
use rhytid::devices::cpu::Cpu;
use rhytid::formats::export::OutputStage;
use rhytid::formats::take;
use rhytid::playback::Playback;
use rhytid::solve::solve;
use rhytid::{Face, NoProgress, Rig, Take};
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Some frames of a face as the library evaluates them, and a folder for the program's files. Each file is
/// made once for all tests.
pub(super) struct Animation {
    pub rig: Rig,
    pub frames: Frames,
    /// frames × 3V, in mesh units.
    pub positions: Vec<f32>,
    /// frames × 3V.
    pub normals: Vec<f32>,
    /// The head pose in each frame; `None` if the take has none.
    pub head: Option<Vec<RigidMotion>>,
    dir: PathBuf,
    /// The files that already exist.
    exported: Mutex<BTreeSet<String>>,
    range: Range<usize>,
}

impl Animation {
    /// Solves the face and evaluates the frames `range` of the take.
    pub(super) fn new(face: &Face, take: &Take, range: Range<usize>) -> Self {
        // A folder that the next run replaces. It serves all tests, so that none of them removes it.
        let dir = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("oracles").join(&face.name);
        let _ = std::fs::remove_dir_all(&dir);
        std::fs::create_dir_all(&dir).unwrap();
        let rig = solve(face, &NoProgress).unwrap().rounded().unwrap();
        rig_file::write(&dir.join("face.safetensors"), &rig).unwrap();
        take::write(&dir.join("take.csv"), take).unwrap();

        let part = take.slice(range.clone());
        let handles = part.handle_positions(&rig.handles().labels).unwrap();
        let mut playback = Playback::new(&rig, &Cpu::devices().unwrap(), range.len()).unwrap();
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        let each = |of_frame: &[f32], its_normals: &[f32]| {
            positions.extend_from_slice(of_frame);
            normals.extend_from_slice(its_normals);
            Ok(())
        };
        playback.evaluate(&handles, OutputStage::Full, true, &NoProgress, each).unwrap();
        drop(playback);
        let frames = Frames { rate: take.rate(), first: range.start, count: range.len() };
        let animation =
            Self { rig, frames, positions, normals, head: part.head, dir, exported: Mutex::default(), range };
        animation.assert_it_moves();
        animation
    }

    /// A face that hardly moves would agree with any other one.
    fn assert_it_moves(&self) {
        let [first, last] =
            [0, self.frames.count - 1].map(|frame| self.metres(frame, self.rig.surface().up_axis));
        let moved = first.iter().zip(&last).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
        assert!(moved > 1e-3, "from its first frame to its last the face moves by {moved} m only");
    }

    /// Lets the program write a file on the device that the library uses, and returns its path. A file's name
    /// stands for its options.
    pub(super) fn export(&self, file: &str, options: &str) -> PathBuf {
        let path = self.dir.join(file);
        let mut exported = self.exported.lock().unwrap_or_else(PoisonError::into_inner);
        if !exported.insert(file.to_owned()) && path.exists() {
            return path;
        }
        let Range { start, end } = self.range;
        let mut rhytid = crate::common::rhytid("animate face.safetensors take.csv --device cpu:0 --quiet");
        rhytid.args(["-o", file, "--frames", &format!("{start}..{end}")]).args(options.split_whitespace());
        if file.contains(".gl") {
            // Blender puts the vertices into another order.
            rhytid.arg("--vertex-ids");
        }
        rhytid.current_dir(&self.dir).assert().success();
        path
    }

    /// World positions of the vertices in a frame, counted from the first: metres, with `up` as the up axis.
    pub(super) fn metres(&self, frame: usize, up: UpAxis) -> Vec<[f64; 3]> {
        let metres = |p| self.turned(p, up).map(|x| x * self.rig.surface().metres_per_unit);
        self.in_world(&self.positions, frame, 1.0).map(metres).collect()
    }

    /// The normals in the world in a frame, counted from the first, with `up` as the up axis.
    pub(super) fn normals(&self, frame: usize, up: UpAxis) -> Vec<[f64; 3]> {
        self.in_world(&self.normals, frame, 0.0).map(|n| self.turned(n, up)).collect()
    }

    /// A frame's points (`w` = 1) or directions (`w` = 0) as the head holds them, in mesh units and axes.
    fn in_world(&self, values: &[f32], frame: usize, w: f64) -> impl Iterator<Item = [f64; 3]> {
        let motion = self.head.as_ref().map_or(RigidMotion::IDENTITY, |head| head[frame]);
        let [rows @ .., _] = motion.matrix();
        let size = 3 * self.rig.vertices();
        let points = values[frame * size..][..size].as_chunks().0.iter();
        points.map(move |&[x, y, z]| {
            let [x, y, z] = [x, y, z].map(f64::from);
            rows.map(|[a, b, c, t]| a * x + b * y + c * z + t * w)
        })
    }

    /// Turned about the x axis from the mesh's up axis to another.
    fn turned(&self, [x, y, z]: [f64; 3], up: UpAxis) -> [f64; 3] {
        match (self.rig.surface().up_axis, up) {
            (UpAxis::Y, UpAxis::Z) => [x, -z, y],
            (UpAxis::Z, UpAxis::Y) => [x, z, -y],
            _ => [x, y, z],
        }
    }
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
