//! Rigs.

use crate::animation::Animation;
use crate::animator::Animator;
use crate::arrays::array;
use crate::command::{callback, words_of};
use crate::take::Take;
use crate::work::work;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhytid::{AnimatorOptions, UploadOptions};
use std::path::PathBuf;
use std::sync::Arc;

/// A solved face. It never changes.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct Rig {
    pub(crate) rig: Arc<rhytid::Rig>,
}

#[pymethods]
impl Rig {
    /// Reads a rig that `save` or the program wrote.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let rig = work(py, None, move |_| rhytid::open_rig(path))?;
        Ok(Self { rig: Arc::new(rig) })
    }

    /// Writes the rig (`.safetensors`). A failed write leaves no partial file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let rig = Arc::clone(&self.rig);
        work(py, None, move |_| rhytid::write_rig(path, &rig))
    }

    /// Plays a take on the rig, on the device `device`, such as `cpu:0`. `auto` is the fastest one whose
    /// results agree with the reference.
    ///
    /// The options are those of `rhytid animate`, such as `fps=24`, `strain=True` and `detail=0.8`.
    #[pyo3(signature = (take, *, device="auto", progress=None, **options))]
    fn play<'py>(
        &self,
        py: Python<'py>,
        take: &Take,
        device: &str,
        progress: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Animation> {
        let mut words = words_of(py, options)?;
        words.push(format!("--device={device}").into());
        let progress = callback(py, progress)?;
        Animation::new(py, Arc::clone(&self.rig), take, words, progress.as_ref())
    }

    /// Makes the rig resident on a device, for batches of up to `frames` frames. Without a device it is the
    /// first GPU, or the processor if there is none.
    #[pyo3(signature = (device=None, frames=1))]
    fn animator(&self, py: Python<'_>, device: Option<String>, frames: usize) -> PyResult<Animator> {
        let rig = Arc::clone(&self.rig);
        let animator = work(py, None, move |_| {
            let options =
                AnimatorOptions { device: device.as_deref(), upload: UploadOptions::frames(frames) };
            rhytid::animator(&rig, &options)
        })?;
        Ok(Animator::new(Arc::clone(&self.rig), animator))
    }

    /// The name of exports.
    #[getter]
    fn name(&self) -> String {
        self.rig.surface().name.clone()
    }

    /// The handles' labels.
    #[getter]
    fn labels(&self) -> Vec<String> {
        self.rig.handles().labels.clone()
    }

    /// The examples' names.
    #[getter]
    fn examples(&self) -> Vec<String> {
        self.rig.examples().names.clone()
    }

    /// Where the handles are at rest: H × 3; a read-only copy.
    #[getter]
    fn handles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let rest = &self.rig.handles().rest;
        array(py, rest.as_flattened().to_vec(), &[rest.len(), 3])
    }

    /// The mesh at rest: V × 3; a read-only copy.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let rest = &self.rig.surface().rest;
        array(py, rest.as_flattened().to_vec(), &[rest.len(), 3])
    }

    /// The triangles of the computation: F × 3 vertices.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u32>>> {
        let triangles = &self.rig.surface().triangles;
        array(py, triangles.as_flattened().to_vec(), &[triangles.len(), 3])
    }

    /// The polygons of the neutral mesh.
    #[getter]
    fn faces(&self) -> Vec<Vec<u32>> {
        self.rig.surface().faces.iter().map(<[u32]>::to_vec).collect()
    }

    /// Metres in one unit: 0.01 for centimetres.
    #[getter]
    fn metres_per_unit(&self) -> f64 {
        self.rig.surface().metres_per_unit
    }

    /// The axis that points up: `y` or `z`.
    #[getter]
    fn up_axis(&self) -> &'static str {
        match self.rig.surface().up_axis {
            rhytid::core::UpAxis::Y => "y",
            rhytid::core::UpAxis::Z => "z",
        }
    }

    fn __repr__(&self) -> String {
        let rig = &self.rig;
        format!(
            "<rhytid.Rig {}: {} vertices, {} handles, {} examples>",
            rig.surface().name,
            rig.vertices(),
            rig.handles().len(),
            rig.examples().len()
        )
    }
}
