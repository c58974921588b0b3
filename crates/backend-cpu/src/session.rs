//! A rig in host memory, and the choice between one frame and a group of them.
use crate::group::Group;
use crate::lines::GROUP;
use crate::one_frame::OneFrame;
use crate::times::Times;
use crate::uploaded::{Inputs, UploadedRig};
use rhytid_core::{HandleFrames, Result, Rig, Rotations, Session, Stage, UploadOptions};
use rhytid_kernels::{strain, vec3};
use std::ops::Range;
use std::time::Duration;
use web_time::Instant;

/// From this many frames on, a group is faster than single frames.
const FEWEST: usize = 8;

/// A rig in host memory, and the last batch. Positions and normals are kept. Other stages are computed again
/// when they are read.
#[derive(Debug)]
pub struct CpuSession {
    rig: UploadedRig,
    handle_rest: Vec<[f32; 3]>,
    strain_edges: Vec<[u32; 2]>,
    rest_lengths: Vec<f32>,
    one_frame: OneFrame,
    group: Option<Group>,

    /// frames × F.
    features: Vec<f32>,
    /// frames × H.
    displacements: Vec<[f32; 3]>,
    /// frames × 4 × H where the handles turn.
    motions: Vec<[f32; 3]>,
    /// max_frames × V.
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    frames: usize,
    times: Times,
}

impl CpuSession {
    pub(crate) fn new(rig: &Rig, options: UploadOptions) -> Self {
        let (vertices, max_frames) = (rig.vertices(), options.max_frames);
        Self {
            rig: UploadedRig::new(rig, options.basis),
            handle_rest: rig.handles().rest.clone(),
            strain_edges: rig.handles().edge_numbers().to_vec(),
            rest_lengths: rig.handles().rest_lengths(),
            one_frame: OneFrame::new(),
            group: (max_frames >= FEWEST).then(|| Group::new(rig)),
            features: Vec::new(),
            displacements: Vec::new(),
            motions: Vec::new(),
            positions: vec![[0.0; 3]; max_frames * vertices],
            normals: vec![[0.0; 3]; max_frames * vertices],
            frames: 0,
            times: Times::default(),
        }
    }

    /// A stage of the last batch in the session's own memory, as [`Session::read`] would copy it. `None` for
    /// a stage that is not kept. The next batch overwrites it.
    pub fn result(&self, stage: Stage) -> Option<&[f32]> {
        let values = self.frames * self.rig.rest.len();
        match stage {
            Stage::Strain => Some(&self.features),
            Stage::Positions => Some(self.positions[..values].as_flattened()),
            Stage::Normals => Some(self.normals[..values].as_flattened()),
            Stage::LargeScale | Stage::LargeScaleNormals | Stage::Detail => None,
        }
    }

    /// The batch in runs of consecutive frames that are evaluated together.
    fn runs(&self) -> Vec<Range<usize>> {
        let mut runs = Vec::new();
        let mut first = 0;
        while first < self.frames {
            let left = self.frames - first;
            let next = first + if left >= FEWEST { left.min(GROUP) } else { 1 };
            runs.push(first..next);
            first = next;
        }
        runs
    }
}

/// The inputs of a run's frames, from those of the batch.
fn inputs<'a>(
    run: &Range<usize>,
    frames: usize,
    [displacements, motions]: [&'a [[f32; 3]]; 2],
    features: &'a [f32],
) -> Inputs<'a> {
    let of = |length: usize| run.start * (length / frames)..run.end * (length / frames);
    Inputs {
        displacements: &displacements[of(displacements.len())],
        motions: &motions[of(motions.len())],
        features: &features[of(features.len())],
    }
}

impl Session for CpuSession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.frames = frames.frames;
        self.times = Times::default();
        let start = Instant::now();
        let (handle_positions, _) = frames.positions.as_chunks::<3>();
        self.features.resize(self.frames * self.strain_edges.len(), 0.0);
        strain::strain(
            strain::Params {
                frames: self.frames as u32,
                handles: self.handle_rest.len() as u32,
                strain_edges: self.strain_edges.len() as u32,
            },
            handle_positions,
            &self.handle_rest,
            &self.strain_edges,
            &self.rest_lengths,
            &mut self.features,
        );
        self.times.add(Stage::Strain, start);
        let displacement = |(p, rest): (&[f32; 3], &[f32; 3])| vec3::sub(*p, *rest);
        let rest = self.handle_rest.iter().cycle();
        self.displacements = handle_positions.iter().zip(rest).map(displacement).collect();
        let motions = |rotations: &Rotations| rotations.motions(handle_positions);
        self.motions = self.rig.rotations.as_ref().map(motions).unwrap_or_default();
        for run in self.runs() {
            let of = |n: usize| run.start * n..run.end * n;
            let inputs = inputs(&run, self.frames, [&self.displacements, &self.motions], &self.features);
            let results = of(self.rig.rest.len());
            let (positions, normals) = (&mut self.positions[results.clone()], &mut self.normals[results]);
            match &mut self.group {
                Some(group) if run.len() > 1 => {
                    group.evaluate(&self.rig, inputs, positions, normals, &self.times);
                }
                _ => self.one_frame.evaluate(&self.rig, inputs, positions, normals, &self.times),
            }
        }
        Ok(())
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        out.clear();
        if let Some(kept) = self.result(stage) {
            out.extend_from_slice(kept);
            return Ok(());
        }
        out.resize(3 * self.frames * self.rig.rest.len(), 0.0);
        let (out, _) = out.as_chunks_mut::<3>();
        for run in self.runs() {
            let of = |n: usize| run.start * n..run.end * n;
            let inputs = inputs(&run, self.frames, [&self.displacements, &self.motions], &self.features);
            let out = &mut out[of(self.rig.rest.len())];
            match &mut self.group {
                Some(group) if run.len() > 1 => group.stage(&self.rig, inputs, stage, out),
                _ => self.one_frame.stage(&self.rig, inputs, stage, out),
            }
        }
        Ok(())
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        Ok(Some(self.times.durations()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vectors::Vectors;
    use rhytid_core::{BasisStorage, NoProgress};
    use rhytid_solve::solve;

    /// Every stage of the first `frames` frames of the demo's performance.
    fn stages(
        rig: &Rig,
        handles: &[f32],
        frames: usize,
        basis: BasisStorage,
        vectors: Vectors,
    ) -> Vec<Vec<u32>> {
        let mut session = CpuSession::new(rig, UploadOptions { max_frames: frames, basis });
        session.rig.vectors = vectors;
        let positions = &handles[..frames * rig.handles().len() * 3];
        session.evaluate(HandleFrames { positions, frames }).unwrap();
        let read = |stage| {
            let mut out = Vec::new();
            session.read(stage, &mut out).unwrap();
            assert_eq!(out.len(), frames * stage.values_per_frame(rig));
            out.into_iter().map(f32::to_bits).collect()
        };
        Stage::ALL.map(read).into()
    }

    /// Groups, single frames, the rest of a batch, and every kind of vectors give the same bits.
    #[test]
    fn batches_and_vectors_change_no_bit() {
        let face = rhytid_demo::face(1_500);
        let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let handles =
            rhytid_demo::performance(&face).slice(0..40).handle_positions(&rig.handles().labels).unwrap();
        let mut kinds = vec![Vectors::Widest, Vectors::Single];
        #[cfg(target_arch = "x86_64")]
        kinds.extend(pulp::x86::V3::try_new().map(Vectors::Avx2));
        for basis in BasisStorage::ALL {
            let mut one_by_one: Vec<Vec<u32>> = vec![Vec::new(); 6];
            for frame in handles.chunks_exact(rig.handles().len() * 3) {
                let stages = stages(&rig, frame, 1, basis, Vectors::Widest);
                one_by_one.iter_mut().zip(stages).for_each(|(all, stage)| all.extend(stage));
            }
            for vectors in &kinds {
                for frames in [1, 2, FEWEST - 1, FEWEST, 15, 16, 17, 16 + FEWEST, 33, 40] {
                    let found = stages(&rig, &handles, frames, basis, *vectors);
                    for (stage, (all, found)) in Stage::ALL.iter().zip(one_by_one.iter().zip(found)) {
                        assert!(
                            found == all[..found.len()],
                            "{stage:?}, {frames} frames, {basis:?}, {vectors:?}"
                        );
                    }
                }
            }
        }
    }

    /// After a batch that is smaller than the last one, nothing of the last one is left.
    #[test]
    fn the_last_batch_alone_is_read() {
        let face = rhytid_demo::face(1_000);
        let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let handles =
            rhytid_demo::performance(&face).slice(0..9).handle_positions(&rig.handles().labels).unwrap();
        let mut session = CpuSession::new(&rig, UploadOptions::frames(9));
        session.evaluate(HandleFrames { positions: &handles, frames: 9 }).unwrap();
        let (_, last) = handles.split_at(7 * rig.handles().len() * 3);
        session.evaluate(HandleFrames { positions: last, frames: 2 }).unwrap();
        let expected = stages(&rig, last, 2, BasisStorage::F32, Vectors::Widest);
        for (stage, expected) in Stage::ALL.into_iter().zip(expected) {
            let mut out = Vec::new();
            session.read(stage, &mut out).unwrap();
            assert!(out.iter().map(|x| x.to_bits()).eq(expected), "{stage:?}");
            let is_kept = matches!(stage, Stage::Strain | Stage::Positions | Stage::Normals);
            assert_eq!(session.result(stage), is_kept.then_some(&out[..]), "{stage:?}");
        }
    }

    /// Handles that move independently by 30 mm bring some vertex near the bound, and no vertex past it.
    #[test]
    fn fp16_moves_no_vertex_further_than_said() {
        let face = rhytid_demo::face(1_500);
        let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let bound = BasisStorage::F16.largest_error(&rig) as f32;
        assert!(BasisStorage::F32.largest_error(&rig) == 0.0);
        let frames = 64;
        let rest = rig.handles().rest.iter().flatten().copied();
        let motion = BasisStorage::motion(&rig) as f32;
        let sign = |i: usize| if ((i * 2_654_435_761) >> 7) & 1 == 0 { motion } else { -motion };
        let handles: Vec<f32> =
            (0..frames).flat_map(|_| rest.clone()).enumerate().map(|(i, x)| x + sign(i)).collect();
        let smooth = |basis| {
            let mut session = CpuSession::new(&rig, UploadOptions { max_frames: frames, basis });
            session.evaluate(HandleFrames { positions: &handles, frames }).unwrap();
            let mut out = Vec::new();
            session.read(Stage::LargeScale, &mut out).unwrap();
            out
        };
        let (exact, rounded) = (smooth(BasisStorage::F32), smooth(BasisStorage::F16));
        let differences = exact.iter().zip(&rounded).map(|(a, b)| (a - b).abs());
        let largest = differences.fold(0.0, f32::max);
        assert!(largest > 0.2 * bound && largest < bound + 1e-5, "{largest}, bound {bound}");
    }
}
