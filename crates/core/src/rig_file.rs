//! The rig file: safetensors, with what is no array in its metadata. `docs/rig-file.md` says what is in it.
//!
//! Nothing in a file is trusted: what [`read`] returns has passed [`Rig::check`].
use crate::{
    AtomicFile, Error, Faces, FoldStrains, InputErrorKind, Learned, Materials, Result, Rig, UpAxis, Uvs,
    input_file,
};
use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::io::Write;
use std::path::Path;

/// The newest version that this program writes and reads: that of a rig whose handles turn.
pub const VERSION: u32 = 6;

/// The version of another rig of the learned method.
const LEARNED_VERSION: u32 = 5;

/// The version of another rig of the chapter's method, which has not changed.
const CHAPTER_VERSION: u32 = 2;

/// The metadata key under which [`Metadata`] stands, as JSON.
const METADATA_KEY: &str = "rhytid";

/// Everything of a rig that is no array.
#[derive(Debug, Serialize, Deserialize)]
struct Metadata {
    version: u32,
    name: String,
    metres_per_unit: f64,
    up_axis: UpAxis,
    method: String,
    bending_length: f64,
    /// From version 6 on.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    rotations: bool,
    /// `null` for an infinite β, which JSON cannot hold.
    beta: Option<f64>,
    labels: Vec<String>,
    examples: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    learned: Option<LearnedMetadata>,
    /// Where the mesh names any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    materials: Vec<String>,
}

/// What of [`Learned`] is no array.
#[derive(Debug, Serialize, Deserialize)]
struct LearnedMetadata {
    share: f64,
    ridge: f64,
    fold_ridge: f64,
    marker_noise: f64,
    /// Without it there is no bound, which JSON cannot hold: so it was before version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reach: Option<f64>,
    /// Lengths before version 5.
    #[serde(default = "lengths", skip_serializing_if = "is_lengths")]
    fold_strains: FoldStrains,
    /// Of version 4 alone.
    #[serde(default, skip_serializing)]
    fold_axes: Option<String>,
}

fn lengths() -> FoldStrains {
    FoldStrains::Lengths
}

fn is_lengths(strains: &FoldStrains) -> bool {
    *strains == FoldStrains::Lengths
}

/// Read apart from the rest, so that a newer file is told from a broken one.
#[derive(Deserialize)]
struct VersionOnly {
    version: u32,
}

/// Reads a rig file.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] if the file is cut short, of another version, lacks an array, or has a shape,
/// an index or a number out of range.
pub fn read(path: &Path) -> Result<Rig> {
    let bytes = input_file::read(path, input_file::LARGEST_RIG)?;
    decode(&bytes, &path.display().to_string())
}

/// What tells one rig file from another: BLAKE3 of its bytes, as 64 hexadecimal digits.
///
/// # Errors
/// [`Error::Io`].
pub fn hash(path: &Path) -> Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut file = std::fs::File::open(path).map_err(Error::io(path))?;
    std::io::copy(&mut file, &mut hasher).map_err(Error::io(path))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Writes a rig file; it appears under its name only when it is whole.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] if the folder does not exist, or as [`encode`].
pub fn write(path: &Path, rig: &Rig) -> Result<()> {
    let mut file = AtomicFile::create(path)?;
    let bytes = encode(rig)?;
    file.write_all(&bytes).map_err(file.error())?;
    file.finish()
}

/// The bytes of a rig file; the same rig gives the same bytes.
///
/// # Errors
/// [`Error::Input`] if the rig does not pass [`Rig::check`]: it could not be read back.
pub fn encode(rig: &Rig) -> Result<Vec<u8>> {
    rig.check()?;
    let (v, h, f, n) = (rig.vertices(), rig.handles.len(), rig.strain_edges.len(), rig.centers());
    let k = rig.influences();
    let metadata = Metadata {
        version: match rig.learned {
            _ if rig.rotations => VERSION,
            Some(_) => LEARNED_VERSION,
            None => CHAPTER_VERSION,
        },
        name: rig.name.clone(),
        metres_per_unit: rig.metres_per_unit,
        up_axis: rig.up_axis,
        method: if rig.learned.is_some() { "learned" } else { "chapter" }.into(),
        bending_length: rig.bending_length,
        rotations: rig.rotations,
        beta: rig.beta.is_finite().then_some(rig.beta),
        labels: rig.labels.clone(),
        examples: rig.example_names.clone(),
        learned: rig.learned.as_ref().map(|learned| LearnedMetadata {
            share: learned.share,
            ridge: learned.ridge,
            fold_ridge: learned.fold_ridge,
            marker_noise: learned.marker_noise,
            reach: Some(learned.reach).filter(|reach| reach.is_finite()),
            fold_strains: learned.fold_strains,
            fold_axes: None,
        }),
        materials: rig.materials.iter().flat_map(|materials| &materials.names).cloned().collect(),
    };
    let json = serde_json::to_string(&metadata).map_err(|e| Error::Internal(e.to_string()))?;
    let mut tensors = vec![
        ("face_counts", u32s(&rig.faces.counts), vec![rig.faces.len()]),
        ("face_indices", u32s(&rig.faces.indices), vec![rig.faces.indices.len()]),
        ("handles", u32s(&rig.handles), vec![h]),
        ("triangles", u32s(rig.triangles.as_flattened()), vec![rig.triangles.len(), 3]),
        ("rest", f32s(rig.rest.as_flattened()), vec![v, 3]),
        ("basis", f32s(&rig.basis), vec![v, h]),
        ("strain_edges", u32s(rig.strain_edges.as_flattened()), vec![f, 2]),
        ("influence_edges", u32s(&rig.influence_edges), vec![v, k]),
        ("influence_weights", f32s(&rig.influence_weights), vec![v, k]),
        // The tangent neighbours' key is older than their name: files keep it.
        ("frame_neighbors", u32s(&rig.tangent_neighbors), vec![v]),
        ("pose_features", f32s(&rig.pose_features), vec![n, f]),
        ("rbf_weights", f32s(rig.rbf_weights.as_flattened()), vec![v, n, 3]),
        ("example_handles", f32s(rig.example_handles.as_flattened()), vec![n - 1, h, 3]),
    ];
    if let Some(learned) = &rig.learned {
        let a = learned.anchors_per_vertex();
        tensors.extend([
            ("anchors", u32s(&learned.anchors), vec![v, a]),
            ("anchor_weights", f32s(&learned.anchor_weights), vec![v, a]),
            ("feature_gains", f32s(&learned.feature_gains), vec![v, k + a]),
            ("variances", f32s(&learned.variances), vec![v]),
        ]);
        if !learned.example_weights.is_empty() {
            let c = f32s(learned.example_weights.as_flattened());
            tensors.push(("example_weights", c, vec![v, n - 1, 3]));
        }
    }
    if let Some(materials) = &rig.materials {
        tensors.push(("face_materials", u32s(&materials.of_face), vec![materials.of_face.len()]));
    }
    if let Some(uvs) = &rig.uvs {
        tensors.push(("uvs", f32s(uvs.values.as_flattened()), vec![uvs.values.len(), 2]));
        if let Some(corners) = &uvs.corners {
            tensors.push(("uv_indices", u32s(corners), vec![corners.len()]));
        }
    }
    let views = tensors
        .iter()
        .map(|(name, (dtype, bytes), shape)| Ok((*name, TensorView::new(*dtype, shape.clone(), bytes)?)))
        .collect::<std::result::Result<Vec<_>, SafeTensorError>>();
    views
        .and_then(|views| {
            safetensors::serialize(views, Some(HashMap::from([(METADATA_KEY.to_owned(), json)])))
        })
        .map_err(|e| Error::Internal(format!("the rig file cannot be written: {e}")))
}

/// Safetensors is little-endian, whatever the machine.
fn u32s(numbers: &[u32]) -> (Dtype, Vec<u8>) {
    (Dtype::U32, numbers.iter().flat_map(|x| x.to_le_bytes()).collect())
}

fn f32s(numbers: &[f32]) -> (Dtype, Vec<u8>) {
    (Dtype::F32, numbers.iter().flat_map(|x| x.to_le_bytes()).collect())
}

/// Reads the bytes of a rig file; `name` stands for it in messages.
///
/// # Errors
/// [`Error::Input`], as [`read`].
pub fn decode(bytes: &[u8], name: &str) -> Result<Rig> {
    let fail = |what: String| Error::rig_damaged(format!("{name}: {what}"));
    let not_whole = |e: SafeTensorError| {
        let kind = match e {
            SafeTensorError::HeaderTooSmall
            | SafeTensorError::InvalidHeaderLength
            | SafeTensorError::MetadataIncompleteBuffer => InputErrorKind::CutShort,
            _ => InputErrorKind::Malformed { line: None },
        };
        fail(format!("is no whole safetensors file ({e}); it may be cut short: solve or copy it again"))
            .of_kind(kind)
    };
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(not_whole)?;
    let json = header.metadata().as_ref().and_then(|m| m.get(METADATA_KEY)).ok_or_else(|| {
        fail(format!("is a safetensors file, but no rig: it has no `{METADATA_KEY}` in its metadata"))
            .of_kind(InputErrorKind::UnsupportedFormat)
    })?;
    let broken = |e| fail(format!("its metadata cannot be read ({e}); solve the rig again"));
    let VersionOnly { version } = serde_json::from_str(json).map_err(broken)?;
    if !(CHAPTER_VERSION..=VERSION).contains(&version) {
        return Err(fail(format!(
            "is a rig file of version {version}, expected {CHAPTER_VERSION} to {VERSION}; solve the rig again with this \
             program"
        )).of_kind(InputErrorKind::UnsupportedVersion));
    }
    let metadata: Metadata = serde_json::from_str(json).map_err(broken)?;
    let tensors = SafeTensors::deserialize(bytes).map_err(not_whole)?;
    let arrays = Arrays { tensors, name };
    let rest = vectors::<3>(arrays.f32s("rest", &[None, Some(3)])?);
    let v = Some(rest.len());
    let handles = arrays.u32s("handles", &[None])?;
    let h = Some(handles.len());
    let strain_edges = pairs(arrays.u32s("strain_edges", &[None, Some(2)])?);
    let n = Some(metadata.examples.len() + 1);
    let uvs = match arrays.has("uvs") {
        true => Some(Uvs {
            values: vectors::<2>(arrays.f32s("uvs", &[None, Some(2)])?),
            corners: match arrays.has("uv_indices") {
                true => Some(arrays.u32s("uv_indices", &[None])?),
                false => None,
            },
        }),
        false if arrays.has("uv_indices") => {
            return Err(fail("has an array `uv_indices`, but no `uvs`; solve the rig again".into()));
        }
        false => None,
    };
    let materials = match arrays.has("face_materials") || !metadata.materials.is_empty() {
        true => {
            let of_face = arrays.u32s("face_materials", &[None])?;
            Some(Materials { names: metadata.materials, of_face })
        }
        false => None,
    };
    let learned = match metadata.learned {
        None if version != CHAPTER_VERSION && metadata.method != "chapter" => {
            return Err(fail(
                "its metadata cannot be read (missing field `learned`); solve the rig again".into(),
            ));
        }
        None => None,
        Some(LearnedMetadata { fold_axes: Some(axes), .. }) => {
            return Err(fail(format!(
                "is a rig file of version {version} with folds along the axes `{axes}`, which no other version has; solve the rig \
                 again"
            )).of_kind(InputErrorKind::UnsupportedVersion));
        }
        Some(LearnedMetadata { share, ridge, fold_ridge, marker_noise, reach, fold_strains, .. }) => {
            Some(Learned {
                share,
                ridge,
                fold_ridge,
                marker_noise,
                reach: reach.unwrap_or(f64::INFINITY),
                fold_strains,
                anchors: arrays.u32s("anchors", &[v, None])?,
                anchor_weights: arrays.f32s("anchor_weights", &[v, None])?,
                feature_gains: arrays.f32s("feature_gains", &[v, None])?,
                example_weights: match share > 0.0 && !metadata.examples.is_empty() {
                    true => vectors(arrays.f32s("example_weights", &[v, n.map(|n| n - 1), Some(3)])?),
                    false => Vec::new(),
                },
                variances: arrays.f32s("variances", &[v])?,
            })
        }
    };
    let rig = Rig {
        name: metadata.name,
        metres_per_unit: metadata.metres_per_unit,
        up_axis: metadata.up_axis,
        labels: metadata.labels,
        example_names: metadata.examples,
        faces: Faces {
            counts: arrays.u32s("face_counts", &[None])?,
            indices: arrays.u32s("face_indices", &[None])?,
        },
        uvs,
        materials,
        bending_length: metadata.bending_length,
        rotations: metadata.rotations,
        beta: metadata.beta.unwrap_or(f64::INFINITY),
        triangles: arrays.u32s("triangles", &[None, Some(3)])?.as_chunks().0.to_vec(),
        basis: arrays.f32s("basis", &[v, h])?,
        influence_edges: arrays.u32s("influence_edges", &[v, None])?,
        influence_weights: arrays.f32s("influence_weights", &[v, None])?,
        tangent_neighbors: arrays.u32s("frame_neighbors", &[v])?,
        pose_features: arrays.f32s("pose_features", &[n, Some(strain_edges.len())])?,
        rbf_weights: vectors::<3>(arrays.f32s("rbf_weights", &[v, n, Some(3)])?),
        example_handles: vectors::<3>(arrays.f32s("example_handles", &[n.map(|n| n - 1), h, Some(3)])?),
        rest,
        handles,
        strain_edges,
        learned,
    };
    rig.check().map_err(|error| {
        error.reworded(|what| format!("{name}: {what}; the file is damaged: solve the rig again"))
    })?;
    Ok(rig)
}

fn vectors<const N: usize>(numbers: Vec<f32>) -> Vec<[f32; N]> {
    numbers.as_chunks::<N>().0.to_vec()
}

fn pairs(numbers: Vec<u32>) -> Vec<[u32; 2]> {
    numbers.as_chunks::<2>().0.to_vec()
}

/// The arrays of a file, each checked for type and shape as it is taken out.
struct Arrays<'a> {
    tensors: SafeTensors<'a>,
    name: &'a str,
}

impl Arrays<'_> {
    fn has(&self, array: &str) -> bool {
        self.tensors.tensor(array).is_ok()
    }

    /// `shape` has `None` where any extent will do.
    fn bytes(&self, array: &str, dtype: Dtype, shape: &[Option<usize>]) -> Result<&[u8]> {
        let fail = |what: String| Error::rig_damaged(format!("{}: {what}; solve the rig again", self.name));
        let view = self.tensors.tensor(array).map_err(|_| fail(format!("has no array `{array}`")))?;
        let fits = view.shape().len() == shape.len()
            && view.shape().iter().zip(shape).all(|(found, expected)| expected.is_none_or(|e| e == *found));
        if view.dtype() != dtype || !fits {
            let extents: Vec<String> =
                shape.iter().map(|e| e.map_or("any".into(), |e| e.to_string())).collect();
            return Err(fail(format!(
                "array `{array}` is {:?} {:?}, expected {dtype:?} [{}]",
                view.dtype(),
                view.shape(),
                extents.join(", ")
            )));
        }
        Ok(view.data())
    }

    fn u32s(&self, array: &str, shape: &[Option<usize>]) -> Result<Vec<u32>> {
        let bytes = self.bytes(array, Dtype::U32, shape)?;
        Ok(bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect())
    }

    fn f32s(&self, array: &str, shape: &[Option<usize>]) -> Result<Vec<f32>> {
        let bytes = self.bytes(array, Dtype::F32, shape)?;
        Ok(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
    }
}
