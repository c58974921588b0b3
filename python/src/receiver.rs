//! Markers that come over the network while they are captured.

use crate::arrays::array;
use crate::error::exception;
use crate::rig::Rig;
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhytid::live;
use std::net::SocketAddr;
use std::sync::{Mutex, PoisonError};

/// Listens for the handles of a rig. `docs/live.md` says what a sender sends.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct Receiver {
    receiver: Mutex<live::Receiver>,
    address: SocketAddr,
}

/// The newest frame that came.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct LiveFrame {
    /// The sender's number.
    #[pyo3(get)]
    number: i64,
    /// The sender's time in seconds.
    #[pyo3(get)]
    time: f64,
    /// H × 3 handle positions, in the rig's unit and head space; a read-only array.
    #[pyo3(get)]
    positions: Py<PyArrayDyn<f32>>,
    /// H numbers: 1 where the marker is seen, and falling to 0 after it was last seen; a read-only array.
    #[pyo3(get)]
    confidence: Py<PyArrayDyn<f32>>,
}

#[pymethods]
impl Receiver {
    /// Listens at an address of this machine. Port 0 is any free port.
    #[new]
    #[pyo3(signature = (rig, address=None))]
    fn new(py: Python<'_>, rig: &Rig, address: Option<&str>) -> PyResult<Self> {
        let address = match address {
            None => live::ADDRESS,
            Some(text) => text.parse().map_err(|_| {
                PyValueError::new_err(format!(
                    "address is “{text}”, expected an address and a port, such as {}",
                    live::ADDRESS
                ))
            })?,
        };
        let handles = rig.rig.handles();
        let receiver = live::Receiver::bind(address, &handles.labels, &handles.rest)
            .map_err(|error| exception(py, &error))?;
        let address = receiver.address();
        Ok(Self { receiver: Mutex::new(receiver), address })
    }

    /// Reads what has come, without waiting: the newest frame, or `None` before the first.
    fn newest(&self, py: Python<'_>) -> PyResult<Option<LiveFrame>> {
        let mut receiver = self.receiver.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = receiver.newest().map_err(|error| exception(py, &error))?;
        let Some(live::LiveFrame { number, time, positions, confidence, .. }) = newest else {
            return Ok(None);
        };
        let flat = positions.as_flattened().to_vec();
        Ok(Some(LiveFrame {
            number,
            time,
            positions: array(py, flat, &[positions.len(), 3])?.unbind(),
            confidence: array(py, confidence.to_vec(), &[confidence.len()])?.unbind(),
        }))
    }

    /// What came, in numbers: `frames`, and datagrams that were `late`, `bad` or of `other` messages. `lost`
    /// are numbers of frames that never came.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let live::Counts { frames, late, lost, bad, other } =
            self.receiver.lock().unwrap_or_else(PoisonError::into_inner).counts();
        let counts = PyDict::new(py);
        for (name, count) in
            [("frames", frames), ("late", late), ("lost", lost), ("bad", bad), ("other", other)]
        {
            counts.set_item(name, count)?;
        }
        Ok(counts)
    }

    /// Sentences about what is likely wrong with the sender.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        let receiver = self.receiver.lock().unwrap_or_else(PoisonError::into_inner);
        let stream = receiver.stream();
        let others = stream.other_messages().into_iter().chain(stream.other_labels());
        stream.warnings().iter().cloned().chain(others).collect()
    }

    /// The address at which it listens.
    #[getter]
    fn address(&self) -> String {
        self.address.to_string()
    }
}
