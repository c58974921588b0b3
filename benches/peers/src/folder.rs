//! The files through which peers and this program exchange numbers.
use crate::FRAMES;
use npyz::{AutoSerialize, NpyFile, WriteOptions, WriterBuilder};
use rhytid_core::{Error, Result, Rig, Table, VertexId};
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;
use tempfile::TempDir;

/// Writes the arrays of `rig` that a frame needs, under their names in the rig file, and `handles_over_time`.
/// The folder is removed when it is dropped.
pub(crate) fn write(rig: &Rig, handles_over_time: &[f32]) -> Result<TempDir> {
    let folder = tempfile::tempdir().map_err(Error::io(&std::env::temp_dir()))?;
    let (surface, handles) = (rig.surface(), rig.handles());
    let (influences, fine_scale) = (rig.influences(), rig.fine_scale());
    let (v, h, f) = (rig.vertices(), handles.len(), handles.strain_edges.len());
    let path = folder.path();
    write_array(path, "rest", surface.rest.as_flattened(), &[v, 3])?;
    write_array(path, "triangles", surface.triangles.as_flattened(), &[surface.triangles.len(), 3])?;
    write_array(path, "handle_rest", handles.rest.as_flattened(), &[h, 3])?;
    write_table(path, "basis", rig.basis())?;
    write_array(path, "strain_edges", handles.edge_numbers().as_flattened(), &[f, 2])?;
    write_table(path, "influence_edges", &influences.edges.map(|e| e.0))?;
    write_table(path, "influence_weights", &influences.weights)?;
    write_array(path, "tangent_neighbors", VertexId::numbers(&surface.tangent_neighbors), &[v])?;
    write_table(path, "pose_features", &fine_scale.pose_features)?;
    let weights = &fine_scale.rbf_weights;
    write_array(path, "rbf_weights", weights.as_slice().as_flattened(), &[v, weights.columns(), 3])?;
    write_array(path, "handles_over_time", handles_over_time, &[FRAMES, h, 3])?;
    Ok(folder)
}

fn write_table<T: AutoSerialize + Copy>(folder: &Path, name: &str, table: &Table<T>) -> Result<()> {
    write_array(folder, name, table.as_slice(), &[table.height(), table.columns()])
}

fn write_array<T: AutoSerialize + Copy>(
    folder: &Path,
    name: &str,
    values: &[T],
    shape: &[usize],
) -> Result<()> {
    let path = folder.join(format!("{name}.npy"));
    let file = BufWriter::new(File::create(&path).map_err(Error::io(&path))?);
    let shape: Vec<u64> = shape.iter().map(|&extent| extent as u64).collect();
    let write = || {
        let mut npy = WriteOptions::new().default_dtype().shape(&shape).writer(file).begin_nd()?;
        npy.extend(values.iter().copied())?;
        npy.finish()
    };
    write().map_err(Error::io(&path))
}

/// The array that `peer` wrote as `name`, which must have this shape.
pub(crate) fn read_array(folder: &Path, name: &str, shape: &[usize], peer: &str) -> Result<Vec<f32>> {
    let path = folder.join(format!("{name}.npy"));
    let file = File::open(&path).map_err(Error::io(&path))?;
    let npy = NpyFile::new(BufReader::new(file)).map_err(Error::io(&path))?;
    let expected: Vec<u64> = shape.iter().map(|&extent| extent as u64).collect();
    if npy.shape() != expected {
        let found = npy.shape();
        return Err(Error::Internal(format!("{peer}: {name} has shape {found:?}, expected {expected:?}")));
    }
    npy.into_vec().map_err(Error::io(&path))
}
