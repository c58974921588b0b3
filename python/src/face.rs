//! Faces: the input of a solve.

use crate::arrays::{Numbers, array, triples};
use crate::command::callback;
use crate::error::exception;
use crate::rig::Rig;
use crate::work::work;
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;
use rhytid::core::{Example, Faces, Handles, LengthUnit, Mesh, Settings, UpAxis, VertexId};
use rhytid::formats::Reach;
use std::path::PathBuf;
use std::sync::Arc;

/// A neutral face with its handles and examples. It never changes.
#[pyclass(frozen, module = "rhytid")]
pub(crate) struct Face {
    face: Arc<rhytid::Face>,
    path: Option<PathBuf>,
}

/// A list as it is, and an array as a list.
///
/// # Errors
/// What the array raises.
fn list_of<'py>(values: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    if values.hasattr("tolist")? { values.call_method0("tolist") } else { Ok(values.clone()) }
}

/// The names and values of a dictionary, or of a list of pairs.
///
/// # Errors
/// `TypeError` for anything else.
fn pairs<'py, T: for<'a> FromPyObject<'a, 'py, Error: Into<PyErr>>>(
    named: &Bound<'py, PyAny>,
) -> PyResult<Vec<(String, T)>> {
    let items = match named.cast::<PyDict>() {
        Ok(dictionary) => dictionary.items().into_any(),
        Err(_) => named.clone(),
    };
    let mut found = Vec::new();
    for item in items.try_iter()? {
        let (name, value): (String, Bound<'py, PyAny>) = item?.extract()?;
        found.push((name, value.extract().map_err(Into::into)?));
    }
    Ok(found)
}

#[pymethods]
impl Face {
    /// From arrays: V × 3 vertices, and faces as lists of vertices or as an array. The handles are vertices
    /// by their labels, and the examples are V × 3 positions by their names: dictionaries, or pairs.
    #[new]
    // They are keywords in Python.
    #[allow(clippy::too_many_arguments)]
    #[pyo3(signature = (vertices, faces, handles, examples=None, *, unit="cm", up="y", name="face"))]
    fn new(
        py: Python<'_>,
        vertices: Numbers<'_, f64>,
        faces: &Bound<'_, PyAny>,
        handles: &Bound<'_, PyAny>,
        examples: Option<&Bound<'_, PyAny>>,
        unit: &str,
        up: &str,
        name: &str,
    ) -> PyResult<Self> {
        let positions = triples(&vertices, "vertices")?;
        let mut polygons = Faces::default();
        for face in list_of(faces)?.try_iter()? {
            polygons.push(&list_of(&face?)?.extract::<Vec<u32>>()?);
        }
        let known = LengthUnit::ALL.map(|unit| unit.name).join(", ");
        let unit = LengthUnit::named(unit)
            .ok_or_else(|| PyValueError::new_err(format!("unit is “{unit}”, expected one of {known}")))?;
        let up_axis = match up {
            "y" => UpAxis::Y,
            "z" => UpAxis::Z,
            _ => return Err(PyValueError::new_err(format!("up is “{up}”, expected \"y\" or \"z\""))),
        };
        let mut placed = Handles::default();
        for (label, vertex) in pairs::<u32>(handles)? {
            placed.labels.push(label);
            placed.points.push(VertexId(vertex).into());
        }
        let mut poses = Vec::new();
        for (name, positions) in examples.map(pairs::<Numbers<'_, f64>>).transpose()?.into_iter().flatten() {
            let positions = triples(&positions, &format!("the example “{name}”"))?;
            poses.push(Example { name, positions, mirror: false, noise: None });
        }
        let face = rhytid::Face {
            name: name.to_owned(),
            neutral: Mesh { positions, faces: polygons, ..Mesh::default() },
            metres_per_unit: unit.metres,
            up_axis,
            handles: placed,
            examples: poses,
            prior: None,
            settings: Settings::default(),
        };
        // A fault of the arrays is found here, and not at the solve.
        rhytid::solve::check(&face).map_err(|error| exception(py, &error))?;
        Ok(Self { face: Arc::new(face), path: None })
    }

    /// Reads a project file and all that it names. The files are in the project's folder or below it, unless
    /// `allow_elsewhere` is set.
    #[staticmethod]
    #[pyo3(signature = (path, *, allow_elsewhere=false))]
    fn open(py: Python<'_>, path: PathBuf, allow_elsewhere: bool) -> PyResult<Self> {
        let reach = if allow_elsewhere { Reach::Anywhere } else { Reach::Below };
        let file = path.clone();
        let face = work(py, None, move |monitor| rhytid_cli::open_face(&file, reach, monitor))?;
        Ok(Self { face: Arc::new(face), path: Some(path) })
    }

    /// Solves the face: the rig that animates it.
    #[pyo3(signature = (*, progress=None))]
    fn solve<'py>(&self, py: Python<'py>, progress: Option<&Bound<'py, PyAny>>) -> PyResult<Rig> {
        let face = Arc::clone(&self.face);
        let progress = callback(py, progress)?;
        let rig = work(py, progress.as_ref(), move |monitor| rhytid::solve(&face, &*monitor))?;
        Ok(Rig { rig: Arc::new(rig) })
    }

    /// What would harm a solve: a list of findings with `severity`, `code`, `message` and `vertices`, the
    /// worst first.
    fn doctor<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let face = Arc::clone(&self.face);
        let report = work(py, None, move |_| Ok(rhytid::solve::examine(&face)))?;
        Ok(pythonize(py, &report.findings)?)
    }

    /// The project file; `None` for a face of arrays.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.path.clone()
    }

    /// The name of the rig and of exports.
    #[getter]
    fn name(&self) -> String {
        self.face.name.clone()
    }

    /// The handles' labels.
    #[getter]
    fn labels(&self) -> Vec<String> {
        self.face.handles.labels.clone()
    }

    /// The examples' names.
    #[getter]
    fn examples(&self) -> Vec<String> {
        self.face.examples.iter().map(|example| example.name.clone()).collect()
    }

    /// The neutral mesh: V × 3; a read-only copy.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let positions = &self.face.neutral.positions;
        array(py, positions.as_flattened().to_vec(), &[positions.len(), 3])
    }

    /// The polygons of the neutral mesh.
    #[getter]
    fn faces(&self) -> Vec<Vec<u32>> {
        self.face.neutral.faces.iter().map(<[u32]>::to_vec).collect()
    }

    /// Metres in one unit: 0.01 for centimetres.
    #[getter]
    fn metres_per_unit(&self) -> f64 {
        self.face.metres_per_unit
    }

    fn __repr__(&self) -> String {
        let face = &self.face;
        format!(
            "<rhytid.Face {}: {} vertices, {} handles, {} examples>",
            face.name,
            face.neutral.positions.len(),
            face.handles.len(),
            face.examples.len()
        )
    }
}
