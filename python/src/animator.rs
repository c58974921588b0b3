//! An animator: handle positions in, vertices out, for live use.

use crate::arrays::{Numbers, array};
use crate::command::stage_named;
use crate::error::exception;
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rhytid::{Session, Stage};
use std::sync::{Arc, Mutex, PoisonError};

/// A rig on a device.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct Animator {
    rig: Arc<rhytid::Rig>,
    state: Mutex<State>,
}

struct State {
    animator: rhytid::Animator<Box<dyn Session>>,
    /// Frames of the last batch; `None` where one frame had no axis of its own.
    frames: Option<usize>,
}

impl Animator {
    pub(crate) fn new(rig: Arc<rhytid::Rig>, animator: rhytid::Animator<Box<dyn Session>>) -> Self {
        Self { rig, state: Mutex::new(State { animator, frames: None }) }
    }
}

#[pymethods]
impl Animator {
    /// Evaluates handle positions as `evaluate`, and returns the vertices' positions: V × 3, or frames × V ×
    /// 3.
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        handles: Numbers<'py, f32>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        self.evaluate(py, handles)?;
        self.read(py, "positions")
    }

    /// Evaluates H × 3 handle positions, or a batch of frames × H × 3. The results stay on the device.
    fn evaluate(&self, py: Python<'_>, handles: Numbers<'_, f32>) -> PyResult<()> {
        let count = self.rig.handles().len();
        let frames = match *handles.shape() {
            [h, 3] if h == count => None,
            [frames, h, 3] if h == count => Some(frames),
            _ => {
                return Err(PyValueError::new_err(format!(
                    "handles has the shape {:?}, expected {count} × 3 for one frame, or frames × {count} × 3",
                    handles.shape()
                )));
            }
        };
        let positions: Vec<f32> = handles.as_array().iter().copied().collect();
        let result = py.detach(|| {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            state.frames = frames;
            state.animator.evaluate(&positions)
        });
        result.map_err(|error| exception(py, &error))
    }

    /// Reads a stage of the last batch, one of `rhytid.STAGES`.
    #[pyo3(signature = (stage="positions"))]
    fn read<'py>(&self, py: Python<'py>, stage: &str) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let stage = stage_named(stage)?;
        let result = py.detach(|| {
            let mut numbers = Vec::new();
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            state.animator.read(stage, &mut numbers).map(|()| (numbers, state.frames))
        });
        let (numbers, frames) = result.map_err(|error| exception(py, &error))?;
        let mut shape: Vec<usize> = frames.into_iter().collect();
        match stage {
            Stage::Strain => shape.push(stage.values_per_frame(&self.rig)),
            _ => shape.extend([self.rig.vertices(), 3]),
        }
        array(py, numbers, &shape)
    }
}
