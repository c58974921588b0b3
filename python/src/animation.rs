//! Animations: the frames of a take on a rig, one by one or as a file.
//!
//! A thread of its own owns the performance and the rig on its device. It does one job after the other.

use crate::arrays::array;
use crate::command::{callback, words_of};
use crate::error::exception;
use crate::take::Take;
use crate::work::{Monitor, guarded, wait, work};
use numpy::PyArrayDyn;
use pyo3::exceptions::{PyIndexError, PyKeyError, PyRuntimeError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice};
use rhytid::core::DeviceInfo;
use rhytid::playback::{EditedTake, Performance, Playback, Selection, batch_frames};
use rhytid::{Error, Result};
use rhytid_cli::Animation as Options;
use std::collections::VecDeque;
use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

/// What the owner of the device does next.
type Job = Box<dyn FnOnce(&Performance, &mut Playback<'_>) + Send>;

/// The frames of a take on a rig.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct Animation {
    jobs: Mutex<Sender<Job>>,
    source: Source,
    device: DeviceInfo,
    rate: f64,
    frames: usize,
    vertices: usize,
    /// Frames of a piece of work.
    chunk: usize,
}

/// What an animation is made of.
#[derive(Clone)]
struct Source {
    rig: Arc<rhytid::Rig>,
    take: Arc<rhytid::Take>,
    /// The take's file.
    path: Option<PathBuf>,
    /// The options of `rhytid animate`.
    words: Vec<OsString>,
}

impl Source {
    /// The options with further ones, for a file or for frames alone.
    fn options(&self, more: Vec<OsString>, output: Option<&Path>) -> Result<Options> {
        let words = self.words.iter().cloned().chain(more).collect();
        Options::parse(words, self.path.as_deref(), output)
    }

    fn perform(&self, options: &Options) -> Result<Performance> {
        options.perform((*self.rig).clone(), (*self.take).clone())
    }
}

/// What the owner of the device says when it is ready.
struct Ready {
    device: DeviceInfo,
    rate: f64,
    frames: usize,
    chunk: usize,
}

impl Animation {
    /// Plays a take on a rig, on the device that `words` ask for.
    ///
    /// # Errors
    /// As reading and uploading, as exceptions.
    pub(crate) fn new(
        py: Python<'_>,
        rig: Arc<rhytid::Rig>,
        take: &Take,
        words: Vec<OsString>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let words = take.words.iter().cloned().chain(words).collect();
        let source = Source { rig, take: Arc::clone(&take.take), path: take.path.clone(), words };
        let of_job = source.clone();
        let vertices = source.rig.vertices();
        let (jobs, queue) = channel();
        let ready = work(py, progress, move |monitor| {
            let options = of_job.options(Vec::new(), None)?;
            let devices = options.devices(monitor.clone())?;
            let performance = of_job.perform(&options)?;
            let (sender, ready) = channel();
            let own = move || own(&performance, &devices, &monitor, &sender, queue);
            std::thread::Builder::new().spawn(own).map_err(|error| Error::Internal(error.to_string()))?;
            ready.recv().unwrap_or_else(|_| Err(Error::Internal("the device's thread ended".into())))
        })?;
        let Ready { device, rate, frames, chunk } = ready;
        Ok(Self { jobs: Mutex::new(jobs), source, device, rate, frames, vertices, chunk })
    }

    /// Asks for frames. They come one after the other, then the channel ends.
    fn ask(&self, frames: Range<usize>, monitor: Arc<Monitor>) -> Receiver<Result<Vec<Data>>> {
        let (sender, receiver) = channel();
        let job = move |performance: &Performance, playback: &mut Playback<'_>| {
            let played = guarded(|| play(performance, playback, frames, &monitor));
            // Nobody may wait any more.
            let _ = sender.send(played);
        };
        // Without an owner the receiver finds out.
        let _ = self.jobs.lock().unwrap_or_else(PoisonError::into_inner).send(Box::new(job));
        receiver
    }

    fn frame(&self, py: Python<'_>, index: usize) -> PyResult<Frame> {
        let frame = self.in_a_row(py, index..index + 1)?.pop();
        frame.ok_or_else(|| exception(py, &Error::Internal("no frame".into())))
    }

    fn in_a_row(&self, py: Python<'_>, frames: Range<usize>) -> PyResult<Vec<Frame>> {
        if frames.is_empty() {
            return Ok(Vec::new());
        }
        let monitor = Arc::new(Monitor::default());
        let mut receiver = self.ask(frames, Arc::clone(&monitor));
        let frames = wait(py, None, &monitor, &mut receiver)?;
        frames.into_iter().map(|data| Frame::new(py, data)).collect()
    }
}

/// Owns the rig on its device, and does the jobs until nobody has any.
fn own(
    performance: &Performance,
    devices: &[DeviceInfo],
    monitor: &Monitor,
    ready: &Sender<Result<Ready>>,
    jobs: Receiver<Job>,
) {
    let mut playback = match guarded(|| performance.playback(devices, monitor)) {
        Ok(playback) => playback,
        Err(error) => {
            let _ = ready.send(Err(error));
            return;
        }
    };
    let _ = ready.send(Ok(Ready {
        device: playback.device().clone(),
        rate: performance.selection.rate,
        frames: performance.selection.inner.len(),
        chunk: batch_frames(&performance.rig),
    }));
    for job in jobs {
        job(performance, &mut playback);
    }
}

/// The channels of a frame: name, numbers at each vertex, numbers.
struct Data(Vec<(String, usize, Vec<f32>)>);

/// Some frames of the performance, counted from its first.
fn play(
    performance: &Performance,
    playback: &mut Playback<'_>,
    frames: Range<usize>,
    monitor: &Monitor,
) -> Result<Vec<Data>> {
    let Selection { take, inner, rate, first } = &performance.selection;
    let wanted = inner.start + frames.start..inner.start + frames.end;
    // Velocities need the frames around these, which `take` has if they are wanted.
    let around = wanted.start.saturating_sub(1)..(wanted.end + 1).min(take.frames());
    let part: EditedTake = take.slice(around.clone());
    let selection = Selection {
        take: part,
        inner: wanted.start - around.start..wanted.end - around.start,
        rate: *rate,
        first: first + frames.start,
    };
    let mut played = Vec::with_capacity(frames.len());
    playback.play(&selection, &performance.recipe, monitor, |frame| {
        let channels = frame
            .channels()
            .map(|(channel, numbers)| (channel.name.to_string(), channel.width, numbers.to_vec()));
        played.push(Data(channels.collect()));
        Ok(())
    })?;
    Ok(played)
}

#[pymethods]
impl Animation {
    fn __len__(&self) -> usize {
        self.frames
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        if let Ok(slice) = index.cast::<PySlice>() {
            let found = slice.indices(self.frames as isize)?;
            if found.step == 1 {
                // Frames in a row are one piece of work.
                let frames = found.start as usize..found.start as usize + found.slicelength;
                return Ok(self.in_a_row(py, frames)?.into_pyobject(py)?.into_any());
            }
            let mut numbers = Vec::with_capacity(found.slicelength);
            for i in 0..found.slicelength as isize {
                numbers.push(self.frame(py, (found.start + i * found.step) as usize)?);
            }
            return Ok(numbers.into_pyobject(py)?.into_any());
        }
        let Ok(number) = index.extract::<isize>() else {
            return Err(PyTypeError::new_err("a frame has a whole number, or a slice of them"));
        };
        let counted = if number < 0 { number + self.frames as isize } else { number };
        if !(0..self.frames as isize).contains(&counted) {
            return Err(PyIndexError::new_err(format!(
                "frame {number}: the animation has {} frames, counted from 0",
                self.frames
            )));
        }
        Ok(self.frame(py, counted as usize)?.into_pyobject(py)?.into_any())
    }

    fn __iter__(slf: Py<Self>) -> Frames {
        Frames {
            state: Mutex::new(Walk {
                animation: slf,
                next: 0,
                asked: VecDeque::new(),
                here: VecDeque::new(),
            }),
        }
    }

    /// Writes a file: `.usd`, `.usda`, `.usdc`, `.usdz`, `.glb`, `.gltf` or `.pc2`. It is the file that
    /// `rhytid animate` writes.
    ///
    /// The options are those of `rhytid animate`; they add to those of `play`. Returns the file, its frames
    /// and its bytes.
    #[pyo3(signature = (path, *, progress=None, **options))]
    fn write<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        progress: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let words = words_of(py, options)?;
        let progress = callback(py, progress)?;
        let source = self.source.clone();
        let device = self.device.clone();
        let written = work(py, progress.as_ref(), move |monitor| {
            let options = source.options(words, Some(&path))?;
            let performance = source.perform(&options)?;
            let file = options.export_options(&performance, monitor.clone())?;
            let mut playback = performance.playback(&[device], &*monitor)?;
            let written = playback.export(&performance, &path, &file, &*monitor)?;
            Ok((written, path, performance.selection.inner.len()))
        })?;
        let (written, path, frames) = written;
        let summary = PyDict::new(py);
        summary.set_item("output", path)?;
        summary.set_item("frames", frames)?;
        summary.set_item("bytes", written.bytes)?;
        Ok(summary)
    }

    /// Frames per second.
    #[getter]
    fn rate(&self) -> f64 {
        self.rate
    }

    /// The device on which the rig is.
    #[getter]
    fn device(&self) -> String {
        self.device.id()
    }

    fn __repr__(&self) -> String {
        format!(
            "<rhytid.Animation: {} frames of {} vertices, {} fps, on {}>",
            self.frames,
            self.vertices,
            self.rate,
            self.device.id()
        )
    }
}

/// The walk through an animation, a piece of work ahead.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct Frames {
    state: Mutex<Walk>,
}

struct Walk {
    animation: Py<Animation>,
    /// The first frame that nobody asked for yet.
    next: usize,
    asked: VecDeque<Asked>,
    here: VecDeque<Data>,
}

/// Frames that are on their way.
struct Asked {
    monitor: Arc<Monitor>,
    receiver: Receiver<Result<Vec<Data>>>,
}

impl Walk {
    /// Asks for frames until two pieces are on their way.
    fn ask_ahead(&mut self) {
        let animation = self.animation.get();
        while self.asked.len() < 2 && self.next < animation.frames {
            let end = (self.next + animation.chunk).min(animation.frames);
            let monitor = Arc::new(Monitor::default());
            let receiver = animation.ask(self.next..end, Arc::clone(&monitor));
            self.asked.push_back(Asked { monitor, receiver });
            self.next = end;
        }
    }
}

#[pymethods]
impl Frames {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Frame>> {
        // A thread that waited for the lock with Python's lock in its hands would wait for ever.
        let Ok(mut walk) = self.state.try_lock() else {
            return Err(PyRuntimeError::new_err("another thread is at this walk; begin one for each thread"));
        };
        if walk.here.is_empty() {
            walk.ask_ahead();
            let Some(mut asked) = walk.asked.pop_front() else { return Ok(None) };
            // The next piece is computed while this one is looked at.
            walk.ask_ahead();
            walk.here = wait(py, None, &asked.monitor, &mut asked.receiver)?.into();
        }
        walk.here.pop_front().map(|data| Frame::new(py, data)).transpose()
    }
}

impl Drop for Walk {
    /// Nobody wants what was asked for.
    fn drop(&mut self) {
        self.asked.iter().for_each(|asked| asked.monitor.stop());
    }
}

/// A frame: an array for each channel.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct Frame {
    channels: Vec<(String, Py<PyArrayDyn<f32>>)>,
}

impl Frame {
    fn new(py: Python<'_>, data: Data) -> PyResult<Self> {
        let arrays = data.0.into_iter().map(|(name, width, numbers)| {
            let rows = numbers.len() / width;
            let shape = if width == 1 { vec![rows] } else { vec![rows, width] };
            Ok((name, array(py, numbers, &shape)?.unbind()))
        });
        Ok(Self { channels: arrays.collect::<PyResult<_>>()? })
    }
}

#[pymethods]
impl Frame {
    /// The names of the channels.
    fn keys(&self) -> Vec<String> {
        self.channels.iter().map(|(name, _)| name.clone()).collect()
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyArrayDyn<f32>>> {
        let found = self.channels.iter().find(|(known, _)| known == name);
        found.map(|(_, array)| array.clone_ref(py)).ok_or_else(|| {
            PyKeyError::new_err(format!(
                "the frame has no channel “{name}”; it has {}; ask `play` for more",
                self.keys().join(", ")
            ))
        })
    }

    /// V × 3 positions in the rig's unit; read-only.
    #[getter]
    fn positions(&self, py: Python<'_>) -> PyResult<Py<PyArrayDyn<f32>>> {
        self.__getitem__(py, "positions")
    }

    /// V × 3 normals of length 1; read-only. With `no_normals=True` in `play` there are none.
    #[getter]
    fn normals(&self, py: Python<'_>) -> PyResult<Py<PyArrayDyn<f32>>> {
        self.__getitem__(py, "normals")
    }

    fn __repr__(&self) -> String {
        format!("<rhytid.Frame: {}>", self.keys().join(", "))
    }
}
