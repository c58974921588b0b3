//! The program's commands, and the conversion of its words.

use crate::work::work;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;
use rhytid::Stage;
use rhytid::core::ChannelKind;
use std::borrow::Cow;
use std::ffi::OsString;

/// Runs a command with the words that follow the program's name. Returns what it prints as JSON.
#[pyfunction]
#[pyo3(signature = (words, progress=None))]
pub(crate) fn call<'py>(
    py: Python<'py>,
    words: Vec<OsString>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let value = work(py, progress, |monitor| rhytid_cli::call(words, monitor))?;
    Ok(pythonize(py, &value)?)
}

/// Runs the whole program, for the script `rhytid`. Returns the exit code.
#[pyfunction]
pub(crate) fn run(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| rhytid_cli::run(words))
}

/// Says which words start the program. Drivers are tried in such children.
#[pyfunction]
pub(crate) fn started_by(words: Vec<OsString>) {
    rhytid_cli::started_by(words);
}

/// The commands with their options, as plain values.
#[pyfunction]
pub(crate) fn option_list(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    Ok(pythonize(py, &rhytid_cli::option_list())?)
}

/// A sentence with keywords where it names options of the program: `take_unit` for `--take-unit`. Command
/// lines between backticks stay.
#[pyfunction]
pub(crate) fn keyword(sentence: &str) -> String {
    let parts = sentence.split('`').enumerate();
    let parts = parts.map(|(i, part)| if i % 2 == 0 { without_dashes(part) } else { part.to_owned() });
    parts.collect::<Vec<_>>().join("`")
}

fn without_dashes(text: &str) -> String {
    let mut parts = text.split("--");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.find(|c: char| !c.is_ascii_alphanumeric() && c != '-').unwrap_or(part.len());
        let (name, rest) = part.split_at(end);
        match name.starts_with(|c: char| c.is_ascii_lowercase()) {
            true => text += &name.replace('-', "_"),
            false => text = text + "--" + name,
        }
        text += rest;
    }
    text
}

/// The words for keyword arguments that are options of the program.
///
/// # Errors
/// For a value that no option has.
pub(crate) fn words_of(py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<OsString>> {
    let Some(options) = options else { return Ok(Vec::new()) };
    py.import("rhytid._options")?.call_method1("words", (options,))?.extract()
}

/// The function that is told of progress, for a `progress` argument.
///
/// # Errors
/// `TypeError` for anything else than a truth value or a function.
pub(crate) fn callback<'py>(
    py: Python<'py>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let Some(progress) = progress else { return Ok(None) };
    let found = py.import("rhytid._progress")?.call_method1("callback", (progress,))?;
    Ok(Some(found).filter(|found| !found.is_none()))
}

/// The stage of this name.
///
/// # Errors
/// `ValueError` with the names that there are.
pub(crate) fn stage_named(name: &str) -> PyResult<Stage> {
    Stage::ALL.into_iter().find(|stage| stage.name() == name).ok_or_else(|| {
        PyValueError::new_err(format!("there is no stage “{name}”, expected one of {}", stages().join(", ")))
    })
}

/// The names of all stages, in the order of the computation.
#[pyfunction]
pub(crate) fn stages() -> Vec<&'static str> {
    Stage::ALL.into_iter().map(Stage::name).collect()
}

/// The kinds of channels that a frame can have, each with whether it is there by default.
#[pyfunction]
pub(crate) fn channel_kinds() -> Vec<(&'static str, bool)> {
    ChannelKind::ALL.into_iter().map(|kind| (kind.name(), kind.is_default())).collect()
}

/// The pixels of a PNG: height, width, and RGBA of 8 bits, row by row.
#[pyfunction]
pub(crate) fn decode_png(bytes: &[u8]) -> PyResult<(u32, u32, Cow<'static, [u8]>)> {
    let fault = |error: png::DecodingError| PyValueError::new_err(error.to_string());
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::ALPHA);
    let mut reader = decoder.read_info().map_err(fault)?;
    let size = reader.output_buffer_size().unwrap_or_default();
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(fault)?;
    if (info.color_type, info.bit_depth) != (png::ColorType::Rgba, png::BitDepth::Eight) {
        return Err(PyValueError::new_err("the picture has other pixels than RGBA of 8 bits"));
    }
    pixels.truncate(info.buffer_size());
    Ok((info.height, info.width, Cow::Owned(pixels)))
}
