//! Buffer views and accessors: plain, or compressed one by one (EXT_meshopt_compression).

use super::super::meshopt;
use super::container::Container;
use super::surface::{Part, Surface};
use ::gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use ::gltf::json::buffer::{Buffer, Stride, Target, View};
use ::gltf::json::validation::Checked::Valid;
use ::gltf::json::validation::USize64;
use ::gltf::json::{Index, Value, extensions};
use rhytid_core::Result;
use rhytid_export::morphs::Values;
use serde_json::{Map, json};

/// The binary part of a file, and its description in the JSON.
pub(super) struct Buffers {
    pub container: Container,
    /// Whether it is compressed.
    pub meshopt: bool,
    pub views: Vec<View>,
    pub accessors: Vec<Accessor>,
    /// The length of the buffer that the compressed views decompress to.
    unfolded: u64,
}

/// The type of an accessor's elements.
#[derive(Clone, Copy)]
pub(super) struct Element {
    pub component: ComponentType,
    pub type_: Type,
    /// Whether integers stand for fractions of their largest value.
    pub normalized: bool,
}

impl Element {
    pub(super) const SCALAR: Self =
        Self { component: ComponentType::F32, type_: Type::Scalar, normalized: false };
    pub(super) const VEC2: Self = Self { type_: Type::Vec2, ..Self::SCALAR };
    pub(super) const VEC3: Self = Self { type_: Type::Vec3, ..Self::SCALAR };
    pub(super) const VEC4: Self = Self { type_: Type::Vec4, ..Self::SCALAR };

    pub(super) fn normalized(self, component: ComponentType) -> Self {
        Self { component, normalized: true, ..self }
    }

    /// Bytes of an element, up to the multiple of four at which the next one begins.
    fn stride(self) -> usize {
        (self.component.size() * self.type_.multiplicity()).next_multiple_of(4)
    }
}

/// A component of an element.
pub(super) trait Number: Copy {
    /// Appends its bytes as glTF orders them.
    fn put(self, out: &mut Vec<u8>);
}

macro_rules! numbers {
    ($($number:ty),+) => {
        $(impl Number for $number {
            fn put(self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }
        })+
    };
}

numbers!(f32, u32, u16, i16, i8);

impl Buffers {
    pub(super) fn new(container: Container, meshopt: bool) -> Self {
        Self { container, meshopt, views: Vec::new(), accessors: Vec::new(), unfolded: 0 }
    }

    /// The corners of a part's triangles.
    pub(super) fn triangles(&mut self, part: &Part) -> Result<Index<Accessor>> {
        let corners = &part.indices;
        let bytes: Vec<u8> = corners.iter().flat_map(|i| i.to_le_bytes()).collect();
        let compressed = match self.meshopt {
            true => Some(("INDICES", meshopt::encode_indices(corners)?)),
            false => None,
        };
        let view = self.view(&bytes, 4, compressed, Some(Target::ElementArrayBuffer))?;
        let element = Element { component: ComponentType::U32, ..Element::SCALAR };
        Ok(Index::push(&mut self.accessors, accessor(view, element, corners.len())))
    }

    /// An attribute of vertices or of a morph target: V×3 `values`, and those of the copied vertices.
    /// Accessors of positions need bounds.
    pub(super) fn vectors(
        &mut self,
        values: &Values,
        surface: &Surface,
        bounds: bool,
    ) -> Result<Index<Accessor>> {
        match values {
            Values::F32(values) => self.vectors_of(values, surface, Element::VEC3, bounds),
            Values::I16(values) => {
                self.vectors_of(values, surface, Element::VEC3.normalized(ComponentType::I16), bounds)
            }
            Values::I8(values) => {
                self.vectors_of(values, surface, Element::VEC3.normalized(ComponentType::I8), bounds)
            }
        }
    }

    fn vectors_of<T>(
        &mut self,
        values: &[T],
        surface: &Surface,
        element: Element,
        bounds: bool,
    ) -> Result<Index<Accessor>>
    where
        T: Number + PartialOrd + Into<f64>,
    {
        let vectors: Vec<[T; 3]> = surface.spread(values.as_chunks().0).collect();
        let index = self.attribute(&vectors, element)?;
        if let (true, Some(&first)) = (bounds, vectors.first()) {
            let [mut low, mut high] = [first; 2];
            for vector in &vectors {
                for (axis, &x) in vector.iter().enumerate() {
                    if x < low[axis] {
                        low[axis] = x;
                    }
                    if x > high[axis] {
                        high[axis] = x;
                    }
                }
            }
            let numbers = |vector: [T; 3]| Some(Value::from(vector.map(Into::<f64>::into).to_vec()));
            let accessor = &mut self.accessors[index.value()];
            (accessor.min, accessor.max) = (numbers(low), numbers(high));
        }
        Ok(index)
    }

    /// An attribute of vertices.
    pub(super) fn attribute<T: Number, const N: usize>(
        &mut self,
        vectors: &[[T; N]],
        element: Element,
    ) -> Result<Index<Accessor>> {
        self.elements(vectors, element, Some(Target::ArrayBuffer))
    }

    /// Numbers that do not belong to vertices, such as those of an animation.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        vectors: &[[f32; N]],
        element: Element,
    ) -> Result<Index<Accessor>> {
        self.elements(vectors, element, None)
    }

    fn elements<T: Number, const N: usize>(
        &mut self,
        vectors: &[[T; N]],
        element: Element,
        target: Option<Target>,
    ) -> Result<Index<Accessor>> {
        let view = self.view_of(vectors, element.stride(), target)?;
        Ok(Index::push(&mut self.accessors, accessor(view, element, vectors.len())))
    }

    /// `n` × `n` weights: 1 on the diagonal and 0 elsewhere. All of them are stored, because several programs
    /// cannot read a sparse accessor without a buffer view.
    pub(super) fn identity(&mut self, n: usize) -> Result<Index<Accessor>> {
        let mut weights = vec![[0.0_f32]; n * n];
        weights.iter_mut().step_by(n + 1).for_each(|weight| *weight = [1.0]);
        self.numbers(&weights, Element::SCALAR)
    }

    /// An image file.
    pub(super) fn image(&mut self, bytes: &[u8]) -> Result<Index<View>> {
        let view = View {
            buffer: Index::new(0),
            byte_length: bytes.len().into(),
            byte_offset: Some(USize64(self.container.length())),
            byte_stride: None,
            name: None,
            target: None,
            extensions: None,
            extras: None,
        };
        self.container.write(bytes)?;
        // What comes next begins at a multiple of four bytes.
        self.container.write(&[0; 3][..bytes.len().next_multiple_of(4) - bytes.len()])?;
        Ok(Index::push(&mut self.views, view))
    }

    fn view_of<T: Number, const N: usize>(
        &mut self,
        vectors: &[[T; N]],
        stride: usize,
        target: Option<Target>,
    ) -> Result<Index<View>> {
        let mut bytes = Vec::with_capacity(vectors.len() * stride);
        for vector in vectors {
            vector.iter().for_each(|number| number.put(&mut bytes));
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let compressed = match self.meshopt {
            true => Some(("ATTRIBUTES", meshopt::encode_elements(&bytes, stride)?)),
            false => None,
        };
        self.view(&bytes, stride, compressed, target)
    }

    /// Adds `bytes`, or their compressed form in the extension's `mode`.
    fn view(
        &mut self,
        bytes: &[u8],
        stride: usize,
        compressed: Option<(&str, Vec<u8>)>,
        target: Option<Target>,
    ) -> Result<Index<View>> {
        let mut view = View {
            buffer: Index::new(u32::from(self.meshopt)),
            byte_length: bytes.len().into(),
            byte_offset: Some(USize64(self.container.length())),
            // Views of indices and of numbers without vertices must have no stride.
            byte_stride: matches!(target, Some(Target::ArrayBuffer)).then_some(Stride(stride)),
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: None,
        };
        match compressed {
            None => self.container.write(bytes)?,
            Some((mode, mut compressed)) => {
                let description = json!({
                    "buffer": 0, "byteOffset": self.container.length(), "byteLength": compressed.len(),
                    "byteStride": stride, "count": bytes.len() / stride, "mode": mode,
                });
                view.extensions = Some(extensions::buffer::View { others: named(description) });
                view.byte_offset = Some(USize64(self.unfolded));
                self.unfolded += bytes.len() as u64;
                compressed.resize(compressed.len().next_multiple_of(4), 0);
                self.container.write(&compressed)?;
            }
        }
        Ok(Index::push(&mut self.views, view))
    }

    /// The buffers: the file's own, and the one that readers decompress into.
    pub(super) fn buffers(&self) -> Vec<Buffer> {
        let stored = Buffer {
            byte_length: USize64(self.container.length()),
            name: None,
            uri: self.container.uri(),
            extensions: None,
            extras: None,
        };
        let unfolded = Buffer {
            byte_length: USize64(self.unfolded),
            uri: None,
            extensions: Some(extensions::buffer::Buffer { others: named(json!({ "fallback": true })) }),
            ..stored.clone()
        };
        match self.meshopt {
            true => vec![stored, unfolded],
            false => vec![stored],
        }
    }
}

/// `value` under the extension's name.
fn named(value: Value) -> Map<String, Value> {
    Map::from_iter([(meshopt::EXTENSION.to_owned(), value)])
}

fn accessor(view: Index<View>, element: Element, count: usize) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: count.into(),
        component_type: Valid(GenericComponentType(element.component)),
        extensions: None,
        extras: None,
        type_: Valid(element.type_),
        min: None,
        max: None,
        name: None,
        normalized: element.normalized,
        sparse: None,
    }
}
