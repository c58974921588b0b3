//! NumPy arrays out and in.

use numpy::{
    AllowTypeChange, Element, PyArray1, PyArrayDyn, PyArrayLikeDyn, PyArrayMethods, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The numbers as a read-only array of this shape. The array owns them; nothing is copied.
pub(crate) fn array<'py, T: Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let flat = PyArray1::from_vec(py, numbers);
    flat.call_method1("setflags", (false,))?;
    let array = flat.reshape(shape.to_vec())?;
    array.call_method1("setflags", (false,))?;
    Ok(array)
}

/// Anything that NumPy makes an array of numbers of.
pub(crate) type Numbers<'py, T> = PyArrayLikeDyn<'py, T, AllowTypeChange>;

/// Rows of three numbers out of an array of any number of axes, the last of them of length 3. `what` names
/// the array in errors.
///
/// # Errors
/// `ValueError` for another shape.
pub(crate) fn triples<T: Element + Copy>(array: &Numbers<'_, T>, what: &str) -> PyResult<Vec<[T; 3]>> {
    let shape = array.shape();
    if shape.last() != Some(&3) {
        return Err(PyValueError::new_err(format!(
            "{what} has the shape {shape:?}, expected 3 numbers in the last axis"
        )));
    }
    let flat: Vec<T> = array.as_array().iter().copied().collect();
    Ok(flat.as_chunks().0.to_vec())
}
