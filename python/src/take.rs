//! Takes.

use crate::arrays::{Numbers, array, triples};
use crate::command::{callback, words_of};
use crate::error::exception;
use crate::rig::Rig;
use crate::work::work;
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

/// Marker tracks, in the rig's unit and head space. It never changes.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct Take {
    pub(crate) take: Arc<rhytid::Take>,
    /// The file that it was read from.
    pub(crate) path: Option<PathBuf>,
    /// The options with which it was read.
    pub(crate) words: Vec<OsString>,
}

#[pymethods]
impl Take {
    /// From frames × markers × 3 positions, the markers' labels, and a rate or times in seconds.
    #[new]
    #[pyo3(signature = (positions, labels, *, rate=None, times=None))]
    fn new(
        py: Python<'_>,
        positions: Numbers<'_, f64>,
        labels: &Bound<'_, PyAny>,
        rate: Option<f64>,
        times: Option<Numbers<'_, f64>>,
    ) -> PyResult<Self> {
        let labels: Vec<String> =
            labels.try_iter()?.map(|label| label?.extract()).collect::<PyResult<_>>()?;
        let &[frames, markers, 3] = positions.shape() else {
            return Err(PyValueError::new_err(format!(
                "positions has the shape {:?}, expected frames × markers × 3",
                positions.shape()
            )));
        };
        if markers != labels.len() {
            return Err(PyValueError::new_err(format!(
                "positions has {markers} markers, and there are {} labels",
                labels.len()
            )));
        }
        let mut distinct: Vec<&String> = labels.iter().collect();
        distinct.sort();
        if let Some(twice) = distinct.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(PyValueError::new_err(format!("two markers have the label “{}”", twice[0])));
        }
        let times: Option<Vec<f64>> = times.map(|times| times.as_array().iter().copied().collect());
        let times = match (rate, times) {
            (Some(rate), None) if rate.is_finite() && rate > 0.0 => {
                (0..frames).map(|frame| frame as f64 / rate).collect()
            }
            (None, Some(times)) if times.len() == frames => times,
            (None, Some(times)) => {
                return Err(PyValueError::new_err(format!(
                    "there are {} times for {frames} frames",
                    times.len()
                )));
            }
            (Some(rate), None) => {
                return Err(PyValueError::new_err(format!("rate is {rate}, expected a number above 0")));
            }
            _ => return Err(PyValueError::new_err("give either rate or times")),
        };
        let rises = |pair: &[f64]| pair[0] < pair[1];
        if let Some(frame) = times.windows(2).position(|pair| !rises(pair)) {
            return Err(PyValueError::new_err(format!(
                "times has to rise, and that of frame {} is {} after {}",
                frame + 1,
                times[frame + 1],
                times[frame]
            )));
        }
        let positions = triples(&positions, "positions")?;
        if let Some(i) = positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            let sentence = format!(
                "frame {}: marker {} is at {:?}, expected finite numbers; fill the gap, or write the take as a \
                 file and open that",
                i / markers,
                labels[i % markers],
                positions[i]
            );
            return Err(exception(py, &rhytid::Error::input(sentence)));
        }
        let take = rhytid::Take { labels, times, positions, ..rhytid::Take::default() };
        Ok(Self { take: Arc::new(take), path: None, words: Vec::new() })
    }

    /// Reads a take for a rig: a clean one, or as a capture system wrote it, which is cleaned.
    ///
    /// The options are those of `rhytid animate` that say how a take is read, such as `missing="hold"`.
    #[staticmethod]
    #[pyo3(signature = (path, rig, *, progress=None, **options))]
    fn open<'py>(
        py: Python<'py>,
        path: PathBuf,
        rig: &Rig,
        progress: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Self> {
        let words = words_of(py, options)?;
        let progress = callback(py, progress)?;
        let rig = Arc::clone(&rig.rig);
        let (file, options) = (path.clone(), words.clone());
        let take = work(py, progress.as_ref(), move |monitor| {
            rhytid_cli::Animation::parse(options, Some(&file), None)?.take(&file, &rig, monitor)
        })?;
        Ok(Self { take: Arc::new(take), path: Some(path), words })
    }

    /// Writes the take as Rhytid's CSV, with every digit.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let take = Arc::clone(&self.take);
        work(py, None, move |_| rhytid::formats::take::write(&path, &take))
    }

    /// The markers' labels.
    #[getter]
    fn labels(&self) -> Vec<String> {
        self.take.labels.clone()
    }

    /// Frames × markers × 3 positions in the rig's unit and head space; a read-only copy.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = [self.take.frames(), self.take.labels.len(), 3];
        array(py, self.take.positions.as_flattened().to_vec(), &shape)
    }

    /// The time of each frame in seconds.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.take.times.clone(), &[self.take.frames()])
    }

    /// Frames per second.
    #[getter]
    fn rate(&self) -> f64 {
        self.take.rate()
    }

    fn __len__(&self) -> usize {
        self.take.frames()
    }

    fn __repr__(&self) -> String {
        let take = &self.take;
        format!(
            "<rhytid.Take: {} frames of {} markers, {} fps>",
            take.frames(),
            take.labels.len(),
            take.rate()
        )
    }
}
