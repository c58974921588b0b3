//! What a device computes is compared with what the processor computes of the same, now and then: a driver that does nothing and
//! says that all went well, or goes wrong later, would otherwise be in every frame that comes after.

use rayon::prelude::*;
use rhytid_core::{
    Animator, Device, DeviceErrorKind, DeviceInfo, Error, Result, Rig, Session, Stage, UploadOptions,
};
use std::time::{Duration, Instant};

/// Vertices that are compared when a rig is uploaded.
const AT_FIRST: usize = 1024;
/// Vertices that are compared of one frame later on.
const LATER: usize = 64;
/// How long no comparison is made after one.
const PAUSE: Duration = Duration::from_secs(1);
/// Two devices differ by rounding: by less than this part of the face's diagonal, and of what handles move by.
const ROUNDING: f32 = 1e-4;
/// No face goes farther from its rest pose than this many diagonals, and this many times as far as its handles make its vertices go.
const FARTHEST: f32 = 4.0;

/// Watches one device.
pub(crate) struct Watch<'a> {
    rig: &'a Rig,
    options: UploadOptions,
    device: String,
    processor: Device,
    diagonal: f32,
    bounds: [[f32; 3]; 2],
    /// The most that a vertex moves where every handle moves by 1.
    gain: f32,
    last: Instant,
    /// Of the next vertices to be compared.
    seed: usize,
}

impl<'a> Watch<'a> {
    /// Looks at a device that `rig` was just uploaded to; `None` where there is nothing to compare with, as for the processor
    /// itself.
    ///
    /// # Errors
    /// [`Error::Device`] if the device does not do one frame as the processor does it.
    pub(crate) fn begin(
        rig: &'a Rig,
        options: UploadOptions,
        info: &DeviceInfo,
        animator: &mut Animator<Box<dyn Session>>,
    ) -> Result<Option<Self>> {
        if info.backend == "cpu" {
            return Ok(None);
        }
        let Some(processor) = rhytid_backends::find("cpu:0") else { return Ok(None) };
        let processor = rhytid_backends::open(&processor)?;
        let (low, high) = rig.rest.iter().fold(([f32::MAX; 3], [f32::MIN; 3]), |(low, high), x| {
            ([0, 1, 2].map(|c| low[c].min(x[c])), [0, 1, 2].map(|c| high[c].max(x[c])))
        });
        let diagonal = (0..3).map(|c| (high[c] - low[c]).powi(2)).sum::<f32>().sqrt();
        let gain = |row: &[f32]| row.iter().map(|b| b.abs()).sum::<f32>();
        let gain = rig.basis.par_chunks(rig.handles.len().max(1)).map(gain).reduce(|| 1.0, f32::max);
        let options = UploadOptions { max_frames: 1, ..options };
        let mut watch = Self {
            rig,
            options,
            device: info.id(),
            processor,
            diagonal,
            bounds: [low, high],
            gain,
            last: Instant::now(),
            seed: 0,
        };
        // An example is a frame that the rig knows; without any, handles that move apart.
        let rest = rig.handles.iter().map(|&v| rig.rest[v as usize]);
        let handles: Vec<f32> = match rig.example_handles.get(..rig.handles.len()) {
            Some(example) => example.as_flattened().to_vec(),
            None => rest.flat_map(|x| x.map(|x| 1.01 * x + 0.001 * diagonal)).collect(),
        };
        let mut found = Vec::new();
        animator.evaluate(&handles)?;
        animator.read(Stage::Positions, &mut found)?;
        watch.batch(&handles, Stage::Positions, &found)?;
        watch.compare(&handles, Stage::Positions, &found, AT_FIRST)?;
        Ok(Some(watch))
    }

    /// Looks at a batch: all of it is where a face can be, and from time to time a few vertices of its last frame are where the
    /// processor has them.
    ///
    /// # Errors
    /// [`Error::Device`] if not.
    pub(crate) fn batch(&mut self, handles: &[f32], stage: Stage, found: &[f32]) -> Result<()> {
        if !matches!(stage, Stage::Positions | Stage::LargeScale) {
            return Ok(());
        }
        let (per_frame, of_frame) = (self.rig.handles.len() * 3, self.rig.vertices() * 3);
        for (handles, found) in handles.chunks_exact(per_frame).zip(found.chunks_exact(of_frame)) {
            if let Some(vertex) = self.out_of_bounds(handles, found) {
                // Unless the handles are where no face has them, so that the processor finds the same.
                self.compare_vertices(handles, stage, found, &[vertex as u32])?;
            }
        }
        if self.last.elapsed() > PAUSE {
            let (handles, found) = (&handles[handles.len() - per_frame..], &found[found.len() - of_frame..]);
            self.compare(handles, stage, found, LATER)?;
            self.last = Instant::now();
        }
        Ok(())
    }

    /// The first vertex that is farther away than any face goes, or not a number.
    fn out_of_bounds(&self, handles: &[f32], found: &[f32]) -> Option<usize> {
        let rest = self.rig.handles.iter().flat_map(|&v| self.rig.rest[v as usize]);
        let moved = handles.iter().zip(rest).map(|(x, rest)| (x - rest).abs()).fold(0.0, f32::max);
        let most = FARTHEST * (self.diagonal + self.gain * moved);
        let [low, high] = self.bounds;
        let (low, high) = (low.map(|x| x - most), high.map(|x| x + most));
        // In blocks without an exit, which a processor compares many at a time.
        let is_in = |block: &[[f32; 3]]| {
            block
                .iter()
                .fold(true, |all, x| (0..3).fold(all, |all, c| all & (x[c] >= low[c]) & (x[c] <= high[c])))
        };
        let (found, _) = found.as_chunks::<3>();
        let block = found.par_chunks(4096).position_first(|block| !is_in(block))?;
        let first = block * 4096;
        found[first..].iter().position(|x| !is_in(std::slice::from_ref(x))).map(|v| first + v)
    }

    /// Compares `count` vertices, others each time, spread over the face.
    fn compare(&mut self, handles: &[f32], stage: Stage, found: &[f32], count: usize) -> Result<()> {
        let v = self.rig.vertices();
        let step = v.div_ceil(count).max(1);
        // Steps of the golden section leave no part of the face for long.
        let first = (self.seed * 0x9e37) % step;
        self.seed += 1;
        let vertices: Vec<u32> = (first..v).step_by(step).map(|v| v as u32).collect();
        self.compare_vertices(handles, stage, found, &vertices)
    }

    fn compare_vertices(&self, handles: &[f32], stage: Stage, found: &[f32], vertices: &[u32]) -> Result<()> {
        let part = self.rig.part(vertices);
        let mut expected = Vec::new();
        let mut processor = self.processor.upload(&part, self.options)?;
        processor.evaluate(handles)?;
        processor.read(stage, &mut expected)?;
        let size = expected.iter().map(|x| x.abs()).fold(self.diagonal, f32::max);
        for (&v, expected) in vertices.iter().zip(expected.as_chunks::<3>().0) {
            let found = &found[3 * v as usize..][..3];
            let apart = (0..3).map(|c| (found[c] - expected[c]).powi(2)).sum::<f32>().sqrt();
            if apart.is_nan() || apart > ROUNDING * size {
                return Err(Error::Device {
                    kind: DeviceErrorKind::Driver,
                    device: self.device.clone(),
                    message: format!(
                        "its driver computes wrongly: vertex {v} is at {found:?}, and the processor finds {expected:?}"
                    ),
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluator::tests::{Flaky, info};
    use rhytid_backend_cpu::Cpu;
    use rhytid_core::{BasisStorage, Method, NoProgress};

    fn rig(method: Method) -> Rig {
        let mut face = rhytid_demo::face(2_000);
        face.settings.method = method;
        rhytid_solve::solve(&face, &NoProgress).unwrap().cast()
    }

    fn evaluated(rig: &Rig, options: UploadOptions, handles: &[f32]) -> [Vec<f32>; 2] {
        let mut animator = Animator::new(&Cpu, rig, options).unwrap();
        animator.evaluate(handles).unwrap();
        [Stage::LargeScale, Stage::Positions].map(|stage| {
            let mut out = Vec::new();
            animator.read(stage, &mut out).unwrap();
            out
        })
    }

    fn smile(rig: &Rig) -> Vec<f32> {
        let second = &rig.example_handles[rig.handles.len()..2 * rig.handles.len()];
        second.iter().flat_map(|x| x.map(|x| x + 0.1)).collect()
    }

    #[test]
    fn a_part_goes_where_it_goes_in_the_whole() {
        for method in [Method::default(), Method::Chapter] {
            let rig = rig(method);
            let handles = smile(&rig);
            let v = rig.vertices() as u32;
            for basis in [BasisStorage::F32, BasisStorage::F16] {
                let options = UploadOptions { max_frames: 1, basis };
                let whole = evaluated(&rig, options, &handles);
                for vertices in
                    [vec![v / 2], vec![v - 1, 0, 17], (0..v).step_by(7).collect(), (0..v).collect()]
                {
                    let part = rig.part(&vertices);
                    assert!(vertices.len() < v as usize / 2 || part.vertices() == v as usize);
                    for (whole, part) in whole.iter().zip(evaluated(&part, options, &handles)) {
                        for (&v, x) in vertices.iter().zip(part.as_chunks::<3>().0) {
                            let expected = &whole[3 * v as usize..][..3];
                            let apart = (0..3).map(|c| (x[c] - expected[c]).abs()).fold(0.0, f32::max);
                            assert!(apart < 1e-5, "vertex {v} of {}: {apart}", vertices.len());
                        }
                    }
                }
            }
        }
    }

    /// A device of another backend, which computes as the processor does.
    fn device() -> DeviceInfo {
        DeviceInfo { backend: "flaky", ..info("sound") }
    }

    fn watched<'a>(rig: &'a Rig, options: UploadOptions) -> Watch<'a> {
        let open = Device::open::<Flaky>(&device()).unwrap();
        Watch::begin(rig, options, &device(), &mut open.upload(rig, options).unwrap()).unwrap().unwrap()
    }

    fn sentence(result: Result<()>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn what_is_nowhere_near_is_found_at_once_and_what_is_wrong_within_seconds() {
        let rig = rig(Method::default());
        let options = UploadOptions::frames(4);
        let mut watch = watched(&rig, options);
        let handles = smile(&rig);
        let [_, right] = evaluated(&rig, options, &handles);
        watch.batch(&handles, Stage::Positions, &right).unwrap();
        for wrong in [f32::NAN, f32::INFINITY, -1e6, 500.0] {
            let mut found = right.clone();
            found[3 * 100 + 1] = wrong;
            let said = sentence(watch.batch(&handles, Stage::Positions, &found));
            assert!(said.contains("computes wrongly: vertex 100 is at"), "{wrong}: {said}");
        }
        // A tenth of a millimetre in one vertex of a thousand, somewhere: a look a second at other vertices each time.
        let mut found = right.clone();
        found.chunks_exact_mut(3 * 1000).for_each(|many| many[0] += 0.1);
        watch.batch(&handles, Stage::Positions, &found).unwrap();
        let v = rig.vertices();
        let looks = (0..v.div_ceil(LATER)).position(|_| {
            watch.last = Instant::now().checked_sub(2 * PAUSE).unwrap();
            watch.batch(&handles, Stage::Positions, &found).is_err()
        });
        assert!(looks.is_some(), "never found");
    }

    #[test]
    fn handles_that_are_nowhere_are_no_fault_of_the_device() {
        let rig = rig(Method::Chapter);
        let options = UploadOptions::frames(1);
        let mut watch = watched(&rig, options);
        let mut handles = smile(&rig);
        handles[4] += 1e5;
        let [_, found] = evaluated(&rig, options, &handles);
        watch.batch(&handles, Stage::Positions, &found).unwrap();
    }

    #[test]
    fn a_device_that_computes_nothing_is_refused_at_the_upload() {
        let rig = rig(Method::default());
        let options = UploadOptions::frames(1);
        let info = DeviceInfo { name: "nothing".into(), ..device() };
        let mut animator = Device::open::<Flaky>(&info).unwrap().upload(&rig, options).unwrap();
        let error = Watch::begin(&rig, options, &info, &mut animator).err().unwrap().to_string();
        assert!(error.contains("computes wrongly"), "{error}");
    }
}
