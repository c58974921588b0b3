//! The rig file: safetensors, with metadata for everything that is no array. `docs/rig-file.md` describes it.
//!
//! Nothing in a file is trusted: every rig that [`read`] returns has passed [`Rig::new`].
mod arrays;
mod packed;
mod points;

use crate::openings::{ACROSS, LEADERS};
use crate::{
    AtomicFile, Contact, Error, HandleId, InputErrorKind, Material, Materials, Openings, Result, Rig,
    StatedLook, StrainEdgeId, SurfacePoint, Table, Texture, Tissue, UpAxis, VertexId, WrinkleStrains,
    input_file,
};
use arrays::Arrays;
pub use packed::{Packing, Roundable, Step, encode as pack, read_packing, roundable, rounded};
pub use points::encode_points;
use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::io::Write;
use std::path::Path;

/// The version of a rig with materials about whose look more than a name is known.
pub const VERSION: u32 = 11;

/// The version of a rig in which several vertices are one point of the surface.
const JOINED_VERSION: u32 = 10;

/// The version of a rig in which lids slide on eyeballs, or skin meets skin.
const CONTACT_VERSION: u32 = 9;

/// The version of a rig in which nothing touches, made with a prior.
const PRIOR_VERSION: u32 = 8;

/// The version of a rig with handles that are at no vertex, made without a prior.
const POINTS_VERSION: u32 = 7;

/// The version of a rig whose handles turn.
const TURNING_VERSION: u32 = 6;

/// The version of a rig of the learned method whose handles do not turn.
const LEARNED_VERSION: u32 = 5;

/// The version of a rig of the chapter's method whose handles do not turn.
const CHAPTER_VERSION: u32 = 2;

/// The versions that can be read.
const VERSIONS: [u32; 9] = [
    CHAPTER_VERSION,
    LEARNED_VERSION,
    TURNING_VERSION,
    POINTS_VERSION,
    PRIOR_VERSION,
    CONTACT_VERSION,
    JOINED_VERSION,
    VERSION,
    packed::VERSION,
];

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
    /// Not in versions 2 and 5.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    rotations: bool,
    /// `null` for an infinite β, which JSON cannot hold.
    beta: Option<f64>,
    labels: Vec<String>,
    examples: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    learned: Option<LearnedMetadata>,
    /// Only if the mesh names materials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    materials: Vec<String>,
    /// One for each of `materials`; empty if only names are known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    looks: Vec<LookMetadata>,
    /// The images of `looks`, in the order of their bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    textures: Vec<TextureMetadata>,
}

/// What is known of a material beside its name.
#[derive(Debug, Serialize, Deserialize)]
struct LookMetadata {
    tissue: Tissue,
    stated: StatedLook,
}

/// Everything of a [`Texture`] but its bytes.
#[derive(Debug, Serialize, Deserialize)]
struct TextureMetadata {
    name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    path: Option<String>,
    /// How many bytes it has.
    bytes: u64,
}

/// Everything of [`crate::Learned`] that is no array.
#[derive(Debug, Serialize, Deserialize)]
struct LearnedMetadata {
    share: f64,
    ridge: f64,
    #[serde(alias = "fold_ridge")]
    wrinkle_ridge: f64,
    marker_noise: f64,
    /// A missing key means no bound: JSON cannot hold infinity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reach: Option<f64>,
    /// A missing key means lengths.
    #[serde(default = "lengths", skip_serializing_if = "is_lengths", alias = "fold_strains")]
    wrinkle_strains: WrinkleStrains,
}

fn lengths() -> WrinkleStrains {
    WrinkleStrains::Lengths
}

fn is_lengths(strains: &WrinkleStrains) -> bool {
    *strains == WrinkleStrains::Lengths
}

/// Read before the rest, so that a file of another version is told apart from a broken one.
#[derive(Deserialize)]
struct VersionOnly {
    version: u32,
}

/// Reads a rig file.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] if the file is cut short, of another version, lacks an array, or has a
/// shape, an index or a number out of range.
pub fn read(path: &Path) -> Result<Rig> {
    let bytes = input_file::read(path, input_file::LARGEST_RIG)?;
    decode(&bytes, &path.display().to_string())
}

/// The hash of a rig file: BLAKE3 of its bytes, as 64 hexadecimal digits.
///
/// # Errors
/// [`Error::Io`].
pub fn hash(path: &Path) -> Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut file = input_file::open(path)?;
    std::io::copy(&mut file, &mut hasher).map_err(Error::io(path))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// The hash of a rig in memory: [`hash()`] of the file that [`write()`] would make.
///
/// # Errors
/// As [`encode`].
pub fn hash_of(rig: &Rig) -> Result<String> {
    Ok(blake3::hash(&encode(rig)?).to_hex().to_string())
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
/// [`Error::Internal`] if the libraries that write it fail.
pub fn encode(rig: &Rig) -> Result<Vec<u8>> {
    let json = serde_json::to_string(&Metadata::of_rig(rig)).map_err(|e| Error::Internal(e.to_string()))?;
    safetensors_file(tensors(rig).iter().map(Tensor::view), Some(json))
        .map_err(|e| Error::Internal(format!("the rig file cannot be written: {e}")))
}

/// The bytes of a safetensors file with these arrays, and with `metadata` under [`METADATA_KEY`].
fn safetensors_file<'a>(
    arrays: impl Iterator<Item = ArrayView<'a>>,
    metadata: Option<String>,
) -> std::result::Result<Vec<u8>, SafeTensorError> {
    let mut views = Vec::new();
    for ArrayView { name, dtype, shape, bytes } in arrays {
        views.push((name, TensorView::new(dtype, shape, bytes)?));
    }
    safetensors::serialize(views, metadata.map(|json| HashMap::from([(METADATA_KEY.to_owned(), json)])))
}

/// All arrays of a rig, in the order in which they are passed on.
fn tensors(rig: &Rig) -> Vec<Tensor> {
    let (surface, handles, examples) = (rig.surface(), rig.handles(), rig.examples());
    let (influences, fine_scale) = (rig.influences(), rig.fine_scale());
    let faces = &surface.faces;
    let mut tensors = vec![
        Tensor::u32s("face_counts", &faces.counts, vec![faces.len()]),
        Tensor::u32s("face_indices", &faces.indices, vec![faces.indices.len()]),
        Tensor::u32s("triangles", surface.triangles.as_flattened(), vec![surface.triangles.len(), 3]),
        Tensor::f32s("rest", surface.rest.as_flattened(), vec![surface.rest.len(), 3]),
        Tensor::table("basis", rig.basis()),
        Tensor::u32s(
            "strain_edges",
            handles.edge_numbers().as_flattened(),
            vec![handles.strain_edges.len(), 2],
        ),
        Tensor::ids("influence_edges", &influences.edges, StrainEdgeId::numbers),
        Tensor::table("influence_weights", &influences.weights),
        // Files keep an older name for the tangent neighbours.
        Tensor::u32s(
            "frame_neighbors",
            VertexId::numbers(&surface.tangent_neighbors),
            vec![surface.tangent_neighbors.len()],
        ),
        Tensor::table("pose_features", &fine_scale.pose_features),
        Tensor::vectors("rbf_weights", &fine_scale.rbf_weights),
        Tensor::vectors("example_handles", &examples.handles),
    ];
    if let Some(joined) = &surface.joined {
        tensors.push(Tensor::u32s("joined_vertices", VertexId::numbers(joined), vec![joined.len()]));
    }
    tensors.extend(Tensor::points(&handles.points));
    if let Some(learned) = rig.learned() {
        tensors.extend([
            Tensor::ids("anchors", &learned.anchors, HandleId::numbers),
            Tensor::table("anchor_weights", &learned.anchor_weights),
            Tensor::table("feature_gains", &learned.feature_gains),
            Tensor::f32s("variances", &learned.variances, vec![learned.variances.len()]),
        ]);
        if !learned.prior_lengths.is_empty() {
            let lengths = &learned.prior_lengths;
            tensors.push(Tensor::f32s("prior_lengths", lengths, vec![lengths.len()]));
        }
        tensors.extend(Tensor::eyeballs(&learned.contact));
        tensors.extend(Tensor::openings(&learned.contact.openings));
        if !learned.example_weights.is_empty() {
            tensors.push(Tensor::vectors("example_weights", &learned.example_weights));
        }
    }
    if let Some(Materials { of_face, textures, .. }) = &surface.materials {
        tensors.push(Tensor::u32s("face_materials", of_face, vec![of_face.len()]));
        if !textures.is_empty() {
            let mut bytes = Vec::new();
            textures.iter().for_each(|texture| bytes.extend_from_slice(&texture.bytes));
            let shape = vec![bytes.len()];
            tensors.push(Tensor { name: "texture_bytes", dtype: Dtype::U8, shape, bytes });
        }
    }
    if let Some(uvs) = &surface.uvs {
        tensors.push(Tensor::f32s("uvs", uvs.values.as_flattened(), vec![uvs.values.len(), 2]));
        if let Some(corners) = &uvs.corners {
            tensors.push(Tensor::u32s("uv_indices", corners, vec![corners.len()]));
        }
    }
    tensors
}

/// An array of a file. Safetensors is little-endian on every machine.
struct Tensor {
    name: &'static str,
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

/// An array of a file, with its name and its bytes elsewhere.
struct ArrayView<'a> {
    name: &'a str,
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: &'a [u8],
}

impl Tensor {
    fn view(&self) -> ArrayView<'_> {
        ArrayView { name: self.name, dtype: self.dtype, shape: self.shape.clone(), bytes: &self.bytes }
    }

    /// One vertex of each handle or, where some are inside triangles, three with their weights.
    fn points(points: &[SurfacePoint]) -> Vec<Self> {
        let vertices: Option<Vec<VertexId>> = points.iter().map(SurfacePoint::vertex).collect();
        if let Some(vertices) = vertices {
            return vec![Self::u32s("handles", VertexId::numbers(&vertices), vec![points.len()])];
        }
        let corners: Vec<VertexId> = points.iter().flat_map(SurfacePoint::triangle).collect();
        let weights: Vec<f32> = points.iter().flat_map(|p| p.weights().map(|w| w as f32)).collect();
        vec![
            Self::u32s("handles", VertexId::numbers(&corners), vec![points.len(), 3]),
            Self::f32s("handle_weights", &weights, vec![points.len(), 3]),
        ]
    }

    /// Nothing without an eyeball.
    fn eyeballs(contact: &Contact) -> Vec<Self> {
        let Contact { eyeballs, lids, .. } = contact;
        if eyeballs.is_empty() {
            return Vec::new();
        }
        let corners: Vec<VertexId> = eyeballs.iter().flat_map(|eyeball| eyeball.corners).collect();
        let weights: Vec<f32> = eyeballs.iter().flat_map(|eyeball| eyeball.weights).collect();
        let vertices: Vec<u32> =
            lids.iter().flat_map(|lid| [lid.vertex.0, lid.eyeball, lid.leader]).collect();
        let distances: Vec<f32> = lids.iter().flat_map(|lid| [lid.nearest, lid.farthest]).collect();
        vec![
            Self::u32s("eyeball_corners", VertexId::numbers(&corners), vec![eyeballs.len(), 4]),
            Self::f32s("eyeball_weights", &weights, vec![eyeballs.len(), 4]),
            Self::u32s("lid_vertices", &vertices, vec![lids.len(), 3]),
            Self::f32s("lid_distances", &distances, vec![lids.len(), 2]),
        ]
    }

    /// Nothing without an opening.
    fn openings(openings: &Openings) -> Vec<Self> {
        let Openings { rims, followers } = openings;
        if rims.is_empty() {
            return Vec::new();
        }
        let vertices: Vec<VertexId> = rims.iter().map(|rim| rim.vertex).collect();
        let across: Vec<u32> = rims.iter().flat_map(|rim| rim.across).collect();
        let gaps: Vec<f32> = rims.iter().flat_map(|rim| [rim.reach, rim.least_gap]).collect();
        let moved: Vec<VertexId> = followers.iter().map(|follower| follower.vertex).collect();
        let leaders: Vec<u32> = followers.iter().flat_map(|follower| follower.leaders).collect();
        let weights: Vec<f32> = followers.iter().flat_map(|follower| follower.weights).collect();
        vec![
            Self::u32s("rim_vertices", VertexId::numbers(&vertices), vec![rims.len()]),
            Self::u32s("rim_across", &across, vec![rims.len(), ACROSS]),
            Self::f32s("rim_gaps", &gaps, vec![rims.len(), 2]),
            Self::u32s("rim_followers", VertexId::numbers(&moved), vec![followers.len()]),
            Self::u32s("rim_leaders", &leaders, vec![followers.len(), LEADERS]),
            Self::f32s("rim_leader_weights", &weights, vec![followers.len(), LEADERS]),
        ]
    }

    fn u32s(name: &'static str, numbers: &[u32], shape: Vec<usize>) -> Self {
        let bytes = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        Self { name, dtype: Dtype::U32, shape, bytes }
    }

    fn f32s(name: &'static str, numbers: &[f32], shape: Vec<usize>) -> Self {
        let bytes = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        Self { name, dtype: Dtype::F32, shape, bytes }
    }

    fn ids<I>(name: &'static str, ids: &Table<I>, numbers: fn(&[I]) -> &[u32]) -> Self {
        Self::u32s(name, numbers(ids.as_slice()), vec![ids.height(), ids.columns()])
    }

    fn table(name: &'static str, numbers: &Table<f32>) -> Self {
        Self::f32s(name, numbers.as_slice(), vec![numbers.height(), numbers.columns()])
    }

    fn vectors(name: &'static str, vectors: &Table<[f32; 3]>) -> Self {
        Self::f32s(name, vectors.as_slice().as_flattened(), vec![vectors.height(), vectors.columns(), 3])
    }
}

/// Reads the bytes of a rig file; `name` stands for it in messages.
///
/// # Errors
/// [`Error::Input`], as [`read`].
pub fn decode(bytes: &[u8], name: &str) -> Result<Rig> {
    if version(bytes, name)? == packed::VERSION {
        let packed::Unpacked { metadata, arrays } = packed::unpack(bytes, name)?;
        return of_arrays(metadata, &arrays, name);
    }
    of_arrays(Metadata::of_file(bytes, name)?, bytes, name)
}

/// The rig of a safetensors file's arrays.
fn of_arrays(metadata: Metadata, bytes: &[u8], name: &str) -> Result<Rig> {
    let tensors = SafeTensors::deserialize(bytes).map_err(|e| not_whole(name, &e))?;
    let parts = Arrays { tensors, name }.rig(metadata)?;
    Rig::new(parts).map_err(|error| {
        error.reworded(|what| format!("{name}: {what}; the file is damaged: solve the rig again"))
    })
}

/// The error of a file that is cut short, or no safetensors file at all.
fn not_whole(name: &str, e: &SafeTensorError) -> Error {
    let kind = match e {
        SafeTensorError::HeaderTooSmall
        | SafeTensorError::InvalidHeaderLength
        | SafeTensorError::MetadataIncompleteBuffer => InputErrorKind::CutShort,
        _ => InputErrorKind::Malformed { line: None },
    };
    Error::rig_damaged(format!(
        "{name}: is no whole safetensors file ({e}); it may be cut short: solve or copy it again"
    ))
    .of_kind(kind)
}

/// The version of a rig file.
fn version(bytes: &[u8], name: &str) -> Result<u32> {
    let version: VersionOnly = serde_json::from_str(&json(bytes, name)?).map_err(|e| unreadable(name, &e))?;
    Ok(version.version)
}

/// The text of a rig file's metadata.
fn json(bytes: &[u8], name: &str) -> Result<String> {
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| not_whole(name, &e))?;
    let json = header.metadata().as_ref().and_then(|metadata| metadata.get(METADATA_KEY));
    json.cloned().ok_or_else(|| {
        let what = format!("is a safetensors file, but no rig: it has no `{METADATA_KEY}` in its metadata");
        Error::rig_damaged(format!("{name}: {what}")).of_kind(InputErrorKind::UnsupportedFormat)
    })
}

fn unreadable(name: &str, e: &serde_json::Error) -> Error {
    Error::rig_damaged(format!("{name}: its metadata cannot be read ({e}); solve the rig again"))
}

impl Metadata {
    /// The metadata that a rig's file has.
    fn of_rig(rig: &Rig) -> Self {
        let (surface, handles) = (rig.surface(), rig.handles());
        let beta = rig.influences().beta;
        let list = surface.materials.as_ref().map_or(&[][..], |materials| &materials.list);
        let textures = surface.materials.as_ref().map_or(&[][..], |materials| &materials.textures);
        let has_looks = list.iter().any(|material| *material != Material::new(&material.name));
        let look = |material: &Material| LookMetadata { tissue: material.tissue, stated: material.stated };
        let texture = |texture: &Texture| TextureMetadata {
            name: texture.name.clone(),
            path: texture.path.clone(),
            bytes: texture.bytes.len() as u64,
        };
        Self {
            version: match rig.learned() {
                _ if has_looks => VERSION,
                _ if surface.joined.is_some() => JOINED_VERSION,
                Some(learned) if !learned.contact.is_empty() => CONTACT_VERSION,
                Some(learned) if !learned.prior_lengths.is_empty() => PRIOR_VERSION,
                _ if handles.points.iter().any(|point| point.vertex().is_none()) => POINTS_VERSION,
                _ if handles.rotations => TURNING_VERSION,
                Some(_) => LEARNED_VERSION,
                None => CHAPTER_VERSION,
            },
            name: surface.name.clone(),
            metres_per_unit: surface.metres_per_unit,
            up_axis: surface.up_axis,
            method: if rig.learned().is_some() { "learned" } else { "chapter" }.into(),
            bending_length: rig.bending_length(),
            rotations: handles.rotations,
            beta: beta.is_finite().then_some(beta),
            labels: handles.labels.clone(),
            examples: rig.examples().names.clone(),
            learned: rig.learned().map(|learned| LearnedMetadata {
                share: learned.share,
                ridge: learned.ridge,
                wrinkle_ridge: learned.wrinkle_ridge,
                marker_noise: learned.marker_noise,
                reach: Some(learned.reach).filter(|reach| reach.is_finite()),
                wrinkle_strains: learned.wrinkle_strains,
            }),
            materials: list.iter().map(|material| material.name.clone()).collect(),
            looks: if has_looks { list.iter().map(look).collect() } else { Vec::new() },
            textures: textures.iter().map(texture).collect(),
        }
    }

    /// The metadata of a file of a version that can be read, and is not packed.
    fn of_file(bytes: &[u8], name: &str) -> Result<Self> {
        let fail = |what: String| Error::rig_damaged(format!("{name}: {what}"));
        let version = version(bytes, name)?;
        if !VERSIONS.contains(&version) {
            let [others @ .., last] = VERSIONS.map(|version| version.to_string());
            return Err(fail(format!(
                "is a rig file of version {version}, expected {} or {last}; solve the face again with this \
                 program",
                others.join(", ")
            ))
            .of_kind(InputErrorKind::UnsupportedVersion));
        }
        serde_json::from_str(&json(bytes, name)?).map_err(|e| unreadable(name, &e))
    }
}
