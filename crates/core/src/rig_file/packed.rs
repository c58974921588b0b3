//! Packed rig files: the arrays of a rig file, smaller (`docs/rig-file.md`).
//!
//! Numbers of an array with a [`Step`] are rounded to its multiples; all others are kept as they are. Each
//! number is predicted from the vertices before it that are joined to its vertex. What the prediction leaves
//! is small, and is compressed with LZMA.

use super::{ArrayView, Metadata, Tensor, not_whole, safetensors_file, tensors};
use crate::{Error, InputErrorKind, Result, Rig, SurfacePoint, VertexId, input_file};
use lzma_rust2::{LzmaOptions, LzmaReader, LzmaWriter};
use rayon::prelude::*;
use safetensors::tensor::{Dtype, SafeTensors};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap};
use std::io::{Read, Write};

/// The version of a packed rig.
pub(super) const VERSION: u32 = 12;

/// How far back LZMA looks, in bytes. Writing takes about twelve times as many for each thread.
const DICTIONARY: u32 = 8 << 20;

/// The most memory that the reading of a stream may take beside its bytes, in KiB.
const READER_MEMORY: u32 = 2 * (DICTIONARY >> 10);

/// The arrays whose numbers may be rounded. Each has a row for each vertex.
const ROUNDED: [&str; 8] = [
    "rest",
    "basis",
    "influence_weights",
    "anchor_weights",
    "feature_gains",
    "example_weights",
    "rbf_weights",
    "variances",
];

/// How the numbers of an array are rounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The name of one of [`roundable`].
    pub array: &'static str,
    /// Numbers become multiples of it; positive.
    pub size: f32,
}

impl Step {
    /// The multiple that the bits of a number are rounded to.
    fn code(&self, bits: u32) -> u32 {
        (f64::from(f32::from_bits(bits)) / f64::from(self.size)).round() as i32 as u32
    }

    /// The bits of the number that a multiple stands for.
    fn number(&self, code: u32) -> u32 {
        ((f64::from(code as i32) * f64::from(self.size)) as f32).to_bits()
    }
}

/// What a packed file states of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Packing {
    /// How far the worst vertex of the poses that were compared is from where the whole rig has it, in mesh
    /// units.
    pub worst: f64,
    /// The root of the mean squared distance of all vertices in these poses, in mesh units.
    pub rms: f64,
    /// The root of the mean squared angle between the normals of both rigs, in degrees.
    pub normals: f64,
    /// As `worst`, after triangles are turned back and parts are kept from entering each other.
    pub finished: f64,
    /// How many vertices are farther off than `worst` then, in any of these poses.
    pub finished_beyond: usize,
    /// How many poses were compared: the examples, poses between them and the neutral, and frames of a take.
    pub poses: usize,
    /// [`super::hash_of`] the whole rig.
    pub rig: String,
}

/// The metadata of a packed file.
#[derive(Serialize, Deserialize)]
struct PackedMetadata {
    version: u32,
    /// Of the rig file that this one is unpacked to.
    rig: Metadata,
    packing: Packing,
    arrays: Vec<PackedArray>,
}

/// What is known of an array beside its numbers.
#[derive(Serialize, Deserialize)]
struct PackedArray {
    name: String,
    dtype: Dtype,
    shape: Vec<usize>,
    /// What its numbers are multiples of; `None` for numbers as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    step: Option<f32>,
}

impl PackedArray {
    /// Numbers in one row.
    fn columns(&self) -> usize {
        self.shape.iter().skip(1).product()
    }

    fn rows(&self) -> usize {
        self.shape.first().copied().unwrap_or_default()
    }

    fn step(&self) -> Option<Step> {
        let array = ROUNDED.into_iter().find(|array| *array == self.name)?;
        self.step.map(|size| Step { array, size })
    }
}

/// The bytes of a packed file; the same rig and steps give the same bytes. Arrays without a step are kept as
/// they are, and so are the rows of vertices that handles are at.
///
/// # Errors
/// [`Error::Internal`] if the libraries that write it fail.
pub fn encode(rig: &Rig, steps: &[Step], packing: &Packing) -> Result<Vec<u8>> {
    let tensors = tensors(rig);
    let mesh = mesh_of(rig);
    let kept = mesh.with_copies(corners(rig));
    let describe = |tensor: &Tensor| PackedArray {
        name: tensor.name.into(),
        dtype: tensor.dtype,
        shape: tensor.shape.clone(),
        step: steps.iter().find(|step| step.array == tensor.name).map(|step| step.size),
    };
    let arrays: Vec<PackedArray> = tensors.iter().map(describe).collect();
    let streams: Result<Vec<Vec<u8>>> = tensors
        .par_iter()
        .zip(&arrays)
        .map(|(tensor, array)| compressed(&array.differences(&tensor.bytes, &mesh, &kept)))
        .collect();
    let streams = streams?;
    let metadata =
        PackedMetadata { version: VERSION, rig: Metadata::of_rig(rig), packing: packing.clone(), arrays };
    let json = serde_json::to_string(&metadata).map_err(|e| Error::Internal(e.to_string()))?;
    let views = tensors.iter().zip(&streams).map(|(tensor, bytes)| ArrayView {
        name: tensor.name,
        dtype: Dtype::U8,
        shape: vec![bytes.len()],
        bytes,
    });
    safetensors_file(views, Some(json)).map_err(|e| Error::Internal(e.to_string()))
}

/// An array whose numbers may be rounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roundable {
    /// Its name in the file.
    pub array: &'static str,
    /// How many numbers each vertex has.
    pub columns: usize,
    /// The largest size of a number, in the array's unit; above 0.
    pub largest: f32,
}

/// The arrays of a rig whose numbers may be rounded, without those that are empty or 0 everywhere.
pub fn roundable(rig: &Rig) -> Vec<Roundable> {
    let of_tensor = |tensor: Tensor| {
        let array = ROUNDED.into_iter().find(|array| *array == tensor.name)?;
        let numbers = tensor.bytes.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word));
        let largest = numbers.fold(0.0, |most: f32, x| most.max(x.abs()));
        let columns = tensor.shape.iter().skip(1).product();
        (largest > 0.0).then_some(Roundable { array, columns, largest })
    };
    tensors(rig).into_iter().filter_map(of_tensor).collect()
}

/// The rig that a packed file with these steps unpacks to.
///
/// # Errors
/// As [`super::decode`].
pub fn rounded(rig: &Rig, steps: &[Step]) -> Result<Rig> {
    let mut tensors = tensors(rig);
    let kept = mesh_of(rig).with_copies(corners(rig));
    for tensor in &mut tensors {
        let Some(step) = steps.iter().find(|step| step.array == tensor.name) else { continue };
        let columns = tensor.shape.iter().skip(1).product::<usize>();
        let rows = tensor.bytes.as_chunks_mut::<4>().0.chunks_mut(columns.max(1)).enumerate();
        for (_, row) in rows.filter(|(v, _)| !kept.contains(v)) {
            row.iter_mut()
                .for_each(|word| *word = step.number(step.code(u32::from_le_bytes(*word))).to_le_bytes());
        }
    }
    let bytes = safetensors_file(tensors.iter().map(Tensor::view), None);
    let bytes = bytes.map_err(|e| Error::Internal(e.to_string()))?;
    super::of_arrays(Metadata::of_rig(rig), &bytes, &rig.surface().name)
}

fn mesh_of(rig: &Rig) -> Joined {
    let joined = rig.surface().joined.as_deref().map(VertexId::numbers);
    Joined::new(rig.vertices(), &rig.surface().triangles, joined)
}

/// The vertices that handles are at.
fn corners(rig: &Rig) -> impl Iterator<Item = usize> {
    rig.handles().points.iter().flat_map(SurfacePoint::triangle).map(VertexId::index)
}

/// What a packed file unpacks to.
pub(super) struct Unpacked {
    pub metadata: Metadata,
    /// The bytes of a safetensors file with all arrays, without metadata.
    pub arrays: Vec<u8>,
}

/// What a packed file states of itself; `None` for a rig file that is not packed.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] if the file is no rig.
pub fn read_packing(path: &std::path::Path) -> Result<Option<Packing>> {
    let bytes = input_file::read(path, input_file::LARGEST_RIG)?;
    let name = path.display().to_string();
    if super::version(&bytes, &name)? != VERSION {
        return Ok(None);
    }
    Ok(Some(of_file(&bytes, &name)?.packing))
}

fn of_file(bytes: &[u8], name: &str) -> Result<PackedMetadata> {
    let json = super::json(bytes, name)?;
    serde_json::from_str(&json).map_err(|e| damaged(name, &format!("its metadata cannot be read ({e})")))
}

/// Unpacks a file; `name` stands for it in messages.
///
/// # Errors
/// [`Error::Input`] if the file is damaged.
pub(super) fn unpack(bytes: &[u8], name: &str) -> Result<Unpacked> {
    let PackedMetadata { rig, arrays, .. } = of_file(bytes, name)?;
    let file = SafeTensors::deserialize(bytes).map_err(|e| not_whole(name, &e))?;
    let numbers =
        |array: &PackedArray| array.shape.iter().try_fold(1_usize, |n, extent| n.checked_mul(*extent));
    let total = arrays.iter().try_fold(0_u64, |sum, array| sum.checked_add(numbers(array)? as u64 * 4));
    if total.is_none_or(|total| total > input_file::LARGEST_RIG) {
        return Err(damaged(name, "its arrays are larger than those of any rig"));
    }
    let open = |array: &PackedArray| {
        let fail = |what: &str| damaged(name, &format!("array `{}` {what}", array.name));
        let view = file.tensor(&array.name).map_err(|_| fail("is not there"))?;
        uncompressed(view.data(), array.largest()).ok_or_else(|| fail("is cut short or cannot be unpacked"))
    };
    let streams: Result<Vec<Vec<u8>>> = arrays.par_iter().map(open).collect();
    let streams = streams?;
    // Arrays that the others are predicted by.
    let alone = |wanted: &str| -> Result<Option<Vec<u32>>> {
        let Some(at) = arrays.iter().position(|array| array.name == wanted) else { return Ok(None) };
        let words = arrays[at].alone(&streams[at]);
        words
            .map(Some)
            .ok_or_else(|| damaged(name, &format!("array `{wanted}` has another size than its shape")))
    };
    let needed =
        |wanted: &str| alone(wanted)?.ok_or_else(|| damaged(name, &format!("has no array `{wanted}`")));
    let vertices = arrays.iter().find(|array| array.name == "rest").map_or(0, PackedArray::rows);
    let triangles = needed("triangles")?;
    let (triangles, rest) = triangles.as_chunks::<3>();
    let joined = alone("joined_vertices")?;
    let handles = needed("handles")?;
    let is_there = |v: &u32| (*v as usize) < vertices;
    let all = triangles.as_flattened().iter().chain(&handles).chain(joined.iter().flatten());
    let in_order = joined.iter().flatten().enumerate().all(|(v, first)| *first as usize <= v);
    let has_all = joined.as_ref().is_none_or(|joined| joined.len() == vertices);
    if !rest.is_empty() || !all.into_iter().all(is_there) || !in_order || !has_all {
        return Err(damaged(name, "its triangles, handles or joined vertices are none of its vertices"));
    }
    let mesh = Joined::new(vertices, triangles, joined.as_deref());
    let kept = mesh.with_copies(handles.iter().map(|v| *v as usize));
    let restored: Result<Vec<Vec<u8>>> = arrays
        .par_iter()
        .zip(&streams)
        .map(|(array, stream)| {
            let bytes = array.restored(stream, &mesh, &kept);
            bytes.ok_or_else(|| {
                damaged(name, &format!("array `{}` has another size than its shape", array.name))
            })
        })
        .collect();
    let restored = restored?;
    let views = arrays.iter().zip(&restored).map(|(array, bytes)| ArrayView {
        name: &array.name,
        dtype: array.dtype,
        shape: array.shape.clone(),
        bytes,
    });
    let arrays = safetensors_file(views, None).map_err(|e| not_whole(name, &e))?;
    Ok(Unpacked { metadata: rig, arrays })
}

fn damaged(name: &str, what: &str) -> Error {
    Error::rig_damaged(format!("{name}: {what}; pack the rig again")).of_kind(InputErrorKind::CutShort)
}

/// The bytes as an `.lzma` file.
fn compressed(bytes: &[u8]) -> Result<Vec<u8>> {
    // The bytes have no alignment, and the last byte says much about the next one.
    let options = LzmaOptions { dict_size: DICTIONARY, lc: 4, pb: 0, ..LzmaOptions::with_preset(9) };
    let write = || {
        let mut writer = LzmaWriter::new_use_header(Vec::new(), &options, Some(bytes.len() as u64))?;
        writer.write_all(bytes)?;
        writer.finish()
    };
    write().map_err(|e: std::io::Error| Error::Internal(e.to_string()))
}

/// What an `.lzma` file holds; `None` if it is broken or holds more than `most` bytes.
fn uncompressed(file: &[u8], most: u64) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let reader = LzmaReader::new_mem_limit(file, READER_MEMORY, None).ok()?;
    reader.take(most + 1).read_to_end(&mut bytes).ok()?;
    (bytes.len() as u64 <= most).then_some(bytes)
}

impl PackedArray {
    /// The most bytes of its stream: its numbers, and the rows that are kept.
    fn largest(&self) -> u64 {
        8 * self.shape.iter().product::<usize>() as u64
    }

    /// Whether numbers are predicted from neighbours on the mesh, and not from the row before.
    fn is_on(&self, mesh: &Joined) -> bool {
        self.rows() == mesh.before.len() && (self.step().is_some() || self.shape.len() > 1)
    }

    /// What is left of the numbers by their prediction: the lowest bytes of all numbers, column by column,
    /// then the next ones. Rows that are kept follow.
    fn differences(&self, bytes: &[u8], mesh: &Joined, kept: &BTreeSet<usize>) -> Vec<u8> {
        if self.dtype == Dtype::U8 {
            return bytes.to_vec();
        }
        let (rows, columns) = (self.rows(), self.columns());
        let words: Vec<u32> = bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        let codes = match self.step() {
            Some(step) => words.iter().map(|word| step.code(*word)).collect(),
            None => words.clone(),
        };
        let mut predicted = vec![0; columns];
        let mut left = Vec::with_capacity(codes.len());
        for row in 0..rows {
            self.predict(&codes, row, mesh, &mut predicted);
            let codes = &codes[row * columns..][..columns];
            left.extend(
                codes.iter().zip(&predicted).map(|(code, predicted)| zigzag(code.wrapping_sub(*predicted))),
            );
        }
        let mut stream = Vec::with_capacity(4 * left.len());
        for byte in 0..4 {
            for column in 0..columns {
                stream.extend((0..rows).map(|row| (left[row * columns + column] >> (8 * byte)) as u8));
            }
        }
        for row in kept.iter().filter(|_| self.step().is_some()) {
            words[row * columns..][..columns].iter().for_each(|word| stream.extend(word.to_le_bytes()));
        }
        stream
    }

    /// The bytes of the array; `None` if the stream has another length.
    fn restored(&self, stream: &[u8], mesh: &Joined, kept: &BTreeSet<usize>) -> Option<Vec<u8>> {
        let numbers: usize = self.shape.iter().product();
        if self.dtype == Dtype::U8 {
            return (stream.len() == numbers).then(|| stream.to_vec());
        }
        let (rows, columns) = (self.rows(), self.columns());
        let kept_rows = if self.step().is_some() { kept.len() } else { 0 };
        let is_by_vertex = rows == mesh.before.len();
        if stream.len() != 4 * (numbers + kept_rows * columns) || kept_rows > 0 && !is_by_vertex {
            return None;
        }
        let (planes, kept_words) = stream.split_at(4 * numbers);
        let mut codes = vec![0_u32; numbers];
        let mut predicted = vec![0; columns];
        for row in 0..rows {
            self.predict(&codes, row, mesh, &mut predicted);
            for (column, predicted) in predicted.iter().enumerate() {
                let byte = |k: usize| planes[k * numbers + column * rows + row];
                let left = u32::from_le_bytes([0, 1, 2, 3].map(byte));
                codes[row * columns + column] = predicted.wrapping_add(unzigzag(left));
            }
        }
        let step = self.step();
        let number = |code: u32| step.map_or(code, |step| step.number(code));
        let mut bytes: Vec<u8> = codes.into_iter().flat_map(|code| number(code).to_le_bytes()).collect();
        if kept_rows > 0 && columns > 0 {
            for (row, words) in kept.iter().zip(kept_words.chunks(4 * columns)) {
                bytes[4 * row * columns..][..4 * columns].copy_from_slice(words);
            }
        }
        Some(bytes)
    }

    /// The numbers of an array that is predicted by itself alone.
    fn alone(&self, stream: &[u8]) -> Option<Vec<u32>> {
        let bytes = self.restored(stream, &Joined::default(), &BTreeSet::new())?;
        Some(bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }

    /// Predicts a row from rows before it.
    fn predict(&self, codes: &[u32], row: usize, mesh: &Joined, predicted: &mut [u32]) {
        let columns = predicted.len();
        let at = |row: usize| &codes[row * columns..][..columns];
        if row == 0 {
            return predicted.fill(0);
        }
        if !self.is_on(mesh) {
            return predicted.copy_from_slice(at(row - 1));
        }
        match &mesh.before[row] {
            Before::Copy(v) => predicted.copy_from_slice(at(*v as usize)),
            Before::Nothing => predicted.copy_from_slice(at(row - 1)),
            Before::Neighbours { last, .. } if self.step().is_none() => {
                predicted.copy_from_slice(at(*last as usize));
            }
            Before::Neighbours { corners, .. } => {
                for (column, predicted) in predicted.iter_mut().enumerate() {
                    let code = |v: u32| i64::from(at(v as usize)[column] as i32);
                    let sum: i64 = corners.iter().map(|[a, b, c]| code(*a) + code(*b) - code(*c)).sum();
                    let count = corners.len() as i64;
                    *predicted = (2 * sum + count).div_euclid(2 * count) as u32;
                }
            }
        }
    }
}

/// Small numbers of either sign as small numbers.
fn zigzag(x: u32) -> u32 {
    (x << 1) ^ ((x as i32 >> 31) as u32)
}

fn unzigzag(x: u32) -> u32 {
    (x >> 1) ^ (x & 1).wrapping_neg()
}

/// What a vertex is predicted from, for each vertex.
#[derive(Default)]
struct Joined {
    before: Vec<Before>,
}

/// The vertices before a vertex.
enum Before {
    /// The vertex is the same point as this one.
    Copy(u32),
    Neighbours {
        /// The last of them.
        last: u32,
        /// Triangles a, b, c of which a and b make another triangle with the vertex, which is near a + b − c.
        /// If there is none, each neighbour a as a, a, a.
        corners: Vec<[u32; 3]>,
    },
    Nothing,
}

impl Joined {
    /// `joined` has the lowest vertex of each vertex's point, if several vertices are one point.
    fn new(vertices: usize, triangles: &[[u32; 3]], joined: Option<&[u32]>) -> Self {
        let mut neighbours = vec![Vec::new(); vertices];
        let mut across: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
        for &[a, b, c] in triangles {
            for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                neighbours[a as usize].extend([b, c].into_iter().filter(|&v| v < a));
                across.entry([b.min(c), b.max(c)]).or_default().push(a);
            }
        }
        let mut corners = vec![Vec::new(); vertices];
        for ([a, b], opposite) in across {
            // Beyond an edge of three triangles, none is the other one.
            if let [x, y] = opposite[..] {
                let (last, c) = (x.max(y), x.min(y));
                if a.max(b) < last && last != c {
                    corners[last as usize].push([a, b, c]);
                }
            }
        }
        let before = |(v, (mut corners, neighbours)): (usize, (Vec<[u32; 3]>, Vec<u32>))| {
            if let Some(first) = joined.map(|joined| joined[v]).filter(|first| (*first as usize) < v) {
                return Before::Copy(first);
            }
            let Some(&last) = neighbours.iter().max() else { return Before::Nothing };
            corners.sort_unstable();
            if corners.is_empty() {
                corners =
                    neighbours.into_iter().collect::<BTreeSet<u32>>().into_iter().map(|v| [v; 3]).collect();
            }
            Before::Neighbours { last, corners }
        };
        Self { before: corners.into_iter().zip(neighbours).enumerate().map(before).collect() }
    }

    /// These vertices and all copies of them.
    fn with_copies(&self, vertices: impl Iterator<Item = usize>) -> BTreeSet<usize> {
        let mut all: BTreeSet<usize> = vertices.collect();
        for (v, before) in self.before.iter().enumerate() {
            if let Before::Copy(first) = before
                && all.contains(&(*first as usize))
            {
                all.insert(v);
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_takes_no_more_memory_than_its_array() {
        let bytes: Vec<u8> = (0..10_000_u32).map(|i| ((i * i) >> 7) as u8).collect();
        let file = compressed(&bytes).unwrap();
        assert_eq!(uncompressed(&file, 10_000), Some(bytes));
        assert_eq!(uncompressed(&file, 9_999), None);
        assert_eq!(uncompressed(&file[..file.len() / 2], 10_000), None);
        // The size of the dictionary stands behind the first byte.
        let mut large = file.clone();
        large[1..5].copy_from_slice(&(1_u32 << 30).to_le_bytes());
        assert_eq!(uncompressed(&large, 10_000), None);
    }
}
