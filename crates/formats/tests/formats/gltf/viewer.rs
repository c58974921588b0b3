//! What a viewer shows of a plain GLB file, computed from its numbers in `f64`.

use gltf::accessor::{DataType, Dimensions};
use gltf::animation::Property;
use gltf::{Accessor, Document, Semantic};
use serde_json::Value;
use std::path::Path;

/// A vector, and a 4×4 matrix by columns.
pub(super) type Vector = [f64; 3];
pub(super) type Matrix = [[f64; 4]; 4];

pub(super) struct Viewer {
    pub document: Document,
    pub bin: Vec<u8>,
    /// W×3.
    pub positions: Vec<Vector>,
    pub normals: Option<Vec<Vector>>,
    pub uvs: Option<Vec<[f64; 2]>>,
    /// W.
    pub ids: Vec<f64>,
    /// The corners of the triangles of all primitives, one after the other.
    pub indices: Vec<usize>,
    /// For each triangle the name of its material.
    pub materials: Vec<String>,
    /// The weights of the targets where nothing is animated.
    pub weights_at_rest: Vec<f64>,
    /// The offsets of each target's positions and normals.
    pub targets: Vec<(Vec<Vector>, Option<Vec<Vector>>)>,
    pub times: Vec<f64>,
    /// Frames × targets.
    pub weights: Vec<f64>,
    /// The mesh's own node.
    pub node: Matrix,
    /// Rotation and translation of each frame.
    pub head: Option<(Vec<[f64; 4]>, Vec<Vector>)>,
}

impl Viewer {
    pub(super) fn open(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(&bytes).unwrap();
        let bin = blob.unwrap();
        let mesh_node = document.nodes().find(|node| node.mesh().is_some()).unwrap();
        let mesh = mesh_node.mesh().unwrap();
        let primitive = mesh.primitives().next().unwrap();
        let vectors = |accessor: Accessor<'_>| numbers::<3>(&accessor, &bin);
        let attribute = |semantic| primitive.get(&semantic);
        let (mut indices, mut materials) = (Vec::new(), Vec::new());
        for part in mesh.primitives() {
            // All primitives have the same vertices and targets.
            assert!(
                part.attributes()
                    .map(|(semantic, accessor)| (semantic, accessor.index()))
                    .eq(primitive.attributes().map(|(semantic, accessor)| (semantic, accessor.index())))
            );
            let of_targets = |primitive: &gltf::Primitive<'_>| -> Vec<_> {
                let index = |accessor: Option<Accessor<'_>>| accessor.map(|accessor| accessor.index());
                primitive.morph_targets().map(|t| [index(t.positions()), index(t.normals())]).collect()
            };
            assert_eq!(of_targets(&part), of_targets(&primitive));
            let corners = numbers::<1>(&part.indices().unwrap(), &bin).into_flattened();
            let name = part.material().name().unwrap().to_owned();
            materials.resize(materials.len() + corners.len() / 3, name);
            indices.extend(corners.into_iter().map(|corner| corner as usize));
        }
        let targets = primitive.morph_targets().map(|target| {
            assert!(target.tangents().is_none());
            (vectors(target.positions().unwrap()), target.normals().map(vectors))
        });
        let (mut times, mut weights, mut rotations, mut translations) = (vec![], vec![], None, None);
        for channel in document.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>()) {
            let (sampler, target) = (channel.sampler(), channel.target());
            assert_eq!(sampler.interpolation(), gltf::animation::Interpolation::Linear);
            times = numbers::<1>(&sampler.input(), &bin).into_flattened();
            let output = sampler.output();
            let on_mesh = target.node().index() == mesh_node.index();
            assert_eq!(on_mesh, target.property() == Property::MorphTargetWeights);
            match target.property() {
                Property::MorphTargetWeights => weights = numbers::<1>(&output, &bin).into_flattened(),
                Property::Rotation => rotations = Some(numbers::<4>(&output, &bin)),
                Property::Translation => translations = Some(vectors(output)),
                Property::Scale => panic!("a scale is animated"),
            }
        }
        Self {
            positions: vectors(attribute(Semantic::Positions).unwrap()),
            normals: attribute(Semantic::Normals).map(vectors),
            uvs: attribute(Semantic::TexCoords(0)).map(|accessor| numbers::<2>(&accessor, &bin)),
            ids: ids(&document, attribute(Semantic::Extras("VERTEX_ID".into())).map(vectors)),
            indices,
            materials,
            weights_at_rest: mesh.weights().unwrap_or_default().iter().map(|&x| x.into()).collect(),
            targets: targets.collect(),
            times,
            weights,
            node: mesh_node.transform().matrix().map(|column| column.map(f64::from)),
            head: rotations.zip(translations),
            document: document.clone(),
            bin,
        }
    }

    /// W positions of frame `k` in the space of the head: metres, with Y up.
    pub(super) fn frame(&self, k: usize) -> Vec<Vector> {
        let weights = self.weights_of(k);
        let sum = |w: usize| {
            let mut sum = self.positions[w];
            for ((positions, _), weight) in self.targets.iter().zip(weights) {
                sum.iter_mut().zip(positions[w]).for_each(|(sum, x)| *sum += weight * x);
            }
            transform(&self.node, sum)
        };
        (0..self.positions.len()).map(sum).collect()
    }

    /// W normals of frame `k`, of length 1, along the mesh's axes.
    pub(super) fn normals(&self, k: usize) -> Vec<Vector> {
        let weights = self.weights_of(k);
        let sum = |w: usize| {
            let mut sum = self.normals.as_ref().unwrap()[w];
            for ((_, normals), weight) in self.targets.iter().zip(weights) {
                let normals = normals.as_ref().unwrap();
                sum.iter_mut().zip(normals[w]).for_each(|(sum, x)| *sum += weight * x);
            }
            let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
            sum.map(|x| x / length)
        };
        (0..self.positions.len()).map(sum).collect()
    }

    fn weights_of(&self, k: usize) -> &[f64] {
        &self.weights[k * self.targets.len()..][..self.targets.len()]
    }

    pub(super) fn scene_extras(&self) -> Value {
        let scene = self.document.default_scene().unwrap();
        serde_json::from_str(scene.extras().as_ref().unwrap().get()).unwrap()
    }
}

/// The number of each vertex in the neutral, as the scene's extras state it. An attribute says the same.
fn ids(document: &Document, attribute: Option<Vec<Vector>>) -> Vec<f64> {
    let extras = document.default_scene().unwrap().extras().clone().unwrap();
    let extras: Value = serde_json::from_str(extras.get()).unwrap();
    let copies = extras["copies"].as_array().cloned().unwrap_or_default();
    let originals = (0..extras["vertices"].as_u64().unwrap()).map(|id| id as f64);
    let ids: Vec<f64> = originals.chain(copies.iter().map(|id| id.as_f64().unwrap())).collect();
    if let Some(attribute) = attribute {
        assert!(attribute.iter().copied().eq(ids.iter().map(|&id| [id, 0.0, 0.0])));
    }
    ids
}

pub(super) fn transform(matrix: &Matrix, [x, y, z]: Vector) -> Vector {
    std::array::from_fn(|i| matrix[0][i] * x + matrix[1][i] * y + matrix[2][i] * z + matrix[3][i])
}

/// The values of an accessor's numbers, for every way of storing them.
fn numbers<const N: usize>(accessor: &Accessor<'_>, bin: &[u8]) -> Vec<[f64; N]> {
    let expected = [Dimensions::Scalar, Dimensions::Vec2, Dimensions::Vec3, Dimensions::Vec4][N - 1];
    assert_eq!(accessor.dimensions(), expected);
    let at = |view: gltf::buffer::View<'_>, offset: usize| &bin[view.offset() + offset..];
    let Some(view) = accessor.view() else {
        let sparse = accessor.sparse().unwrap();
        let (indices, values) = (at(sparse.indices().view(), 0), at(sparse.values().view(), 0));
        let mut out = vec![[0.0; N]; accessor.count()];
        for k in 0..sparse.count() {
            let place = number(&indices[4 * k..], DataType::U32) as usize;
            out[place][0] = number(&values[4 * k..], DataType::F32);
        }
        return out;
    };
    let size = accessor.data_type().size();
    let stride = view.stride().unwrap_or(N * size);
    let bytes = at(view, accessor.offset());
    let largest = match (accessor.normalized(), accessor.data_type()) {
        (false, _) => 1.0,
        (true, DataType::I8) => 127.0,
        (true, DataType::I16) => 32767.0,
        (true, DataType::U16) => 65535.0,
        (true, other) => panic!("{other:?} is normalised"),
    };
    let element = |k: usize| {
        std::array::from_fn(|i| number(&bytes[k * stride + i * size..], accessor.data_type()) / largest)
    };
    (0..accessor.count()).map(element).collect()
}

fn number(b: &[u8], kind: DataType) -> f64 {
    match kind {
        DataType::I8 => (b[0] as i8).into(),
        DataType::U8 => b[0].into(),
        DataType::I16 => i16::from_le_bytes([b[0], b[1]]).into(),
        DataType::U16 => u16::from_le_bytes([b[0], b[1]]).into(),
        DataType::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]).into(),
        DataType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]).into(),
    }
}
