//! Errors of the library as exceptions of `rhytid`.

use crate::command::keyword;
use pyo3::prelude::*;
use rhytid::Error;
use std::io::ErrorKind;

/// The exception for an error. `rhytid._errors` has the classes. The sentence names keywords where that of
/// the program names options.
pub(crate) fn exception(py: Python<'_>, error: &Error) -> PyErr {
    match make(py, error) {
        Ok(exception) => PyErr::from_value(exception),
        Err(other) => other,
    }
}

fn make<'py>(py: Python<'py>, error: &Error) -> PyResult<Bound<'py, PyAny>> {
    let sentence = keyword(&rhytid_cli::sentence(error));
    let classes = py.import("rhytid._errors")?;
    let class = match error {
        Error::Input(_) => "InputError",
        Error::Io { source, .. } if source.kind() == ErrorKind::NotFound => "MissingFileError",
        Error::Io { .. } => "FileError",
        Error::Device { .. } => "DeviceError",
        Error::Cancelled => "Cancelled",
        _ => "InternalError",
    };
    let exception = match error {
        // Those of the system have a number, from which Python knows them.
        Error::Io { path, source } => {
            classes.getattr(class)?.call1((source.raw_os_error(), sentence, path.display().to_string()))?
        }
        _ => classes.getattr(class)?.call1((sentence,))?,
    };
    if let Error::Input(input) = error {
        exception.setattr("kind", input.kind().name())?;
    }
    Ok(exception)
}
