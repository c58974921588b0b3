//! Accessors, one at a time: plain or compressed, floats or normalised integers.

use super::super::meshopt::CompressedView;
use super::source::Source;
use ::gltf::json::Root;
use ::gltf::json::accessor::{Accessor, ComponentType, Type};
use ::gltf::json::validation::Checked::Valid;
use rhytid_core::{Error, Result};

/// The numbers of a file.
pub(super) struct Arrays {
    pub root: Root,
    pub source: Source,
    /// The file, for messages.
    pub name: String,
}

impl Arrays {
    /// The elements of accessor `index`, N components each, as the numbers that they stand for.
    pub(super) fn vectors<const N: usize>(&mut self, index: usize) -> Result<Vec<[f64; N]>> {
        let (view, offset, count, component, normalized) = self.layout::<N>(index)?;
        let (bytes, stride) = self.view(view)?;
        let vectors = elements::<N>(&bytes, stride, offset, count, component)
            .ok_or_else(|| self.fault(index, &format!("announces {count} elements and has fewer")))?;
        if !vectors.as_flattened().iter().all(|x| x.is_finite()) {
            return Err(self.fault(index, "has numbers that are not finite"));
        }
        let largest = match (component, normalized) {
            (_, false) => return Ok(vectors),
            (ComponentType::I8, _) => 127.0,
            (ComponentType::U8, _) => 255.0,
            (ComponentType::I16, _) => 32_767.0,
            (ComponentType::U16, _) => 65_535.0,
            (found, _) => return Err(self.fault(index, &format!("marks {found:?} as normalised"))),
        };
        // Two's complement has one more number below 0 than above.
        Ok(vectors.into_iter().map(|v| v.map(|x| (x / largest).max(-1.0))).collect())
    }

    /// How many elements accessor `index` announces.
    pub(super) fn count(&self, index: usize) -> Result<u64> {
        Ok(self.accessor(index)?.count.0)
    }

    /// The vertices' numbers in accessor `index`: single numbers in older files, else the first of three.
    pub(super) fn vertex_ids(&mut self, index: usize) -> Result<Vec<f64>> {
        if self.accessor(index)?.type_ == Valid(Type::Scalar) {
            return Ok(self.vectors::<1>(index)?.into_flattened());
        }
        Ok(self.vectors::<3>(index)?.into_iter().map(|[id, _, _]| id).collect())
    }

    /// The elements of accessor `index`, `count` integers.
    pub(super) fn indices(&mut self, index: usize) -> Result<Vec<u32>> {
        let integers = self.vectors::<1>(index)?;
        match self.accessor(index)?.component_type {
            Valid(found) if found.0 == ComponentType::U32 => {}
            _ => return Err(self.fault(index, "does not hold 32-bit integers, as expected")),
        }
        Ok(integers.into_iter().map(|[x]| x as u32).collect())
    }

    /// The numbers other than 0 of accessor `index`, which has `expected` elements, with their places in
    /// ascending order.
    pub(super) fn nonzero(&mut self, index: usize, expected: u64) -> Result<Vec<(u64, f64)>> {
        let accessor = self.accessor(index)?;
        let found = accessor.count.0;
        if found != expected {
            return Err(self.fault(index, &format!("has {found} elements, expected {expected}")));
        }
        let Some(sparse) = accessor.sparse.clone() else {
            let dense = self.vectors::<1>(index)?;
            let places = dense.into_iter().enumerate().map(|(place, [x])| (place as u64, x));
            return Ok(places.filter(|&(_, x)| x != 0.0).collect());
        };
        let plain = accessor.buffer_view.is_none()
            && accessor.type_ == Valid(Type::Scalar)
            && matches!(accessor.component_type, Valid(c) if c.0 == ComponentType::F32)
            && matches!(sparse.indices.component_type, Valid(c) if c.0 == ComponentType::U32);
        if !plain {
            return Err(self.fault(index, "is sparse in another way than Rhytid writes"));
        }
        let count = sparse.count.0;
        let mut part = |view: usize, offset: u64, component| {
            let (bytes, stride) = self.view(view)?;
            elements::<1>(&bytes, stride, offset, count, component)
                .ok_or_else(|| self.fault(index, &format!("announces {count} numbers and has fewer")))
        };
        let places =
            part(sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0, ComponentType::U32)?;
        let numbers =
            part(sparse.values.buffer_view.value(), sparse.values.byte_offset.0, ComponentType::F32)?;
        let pairs: Vec<_> = places.iter().zip(&numbers).map(|([p], [x])| (*p as u64, *x)).collect();
        let ascending = pairs.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if !ascending || pairs.last().is_some_and(|&(place, _)| place >= expected) {
            return Err(
                self.fault(index, &format!("replaces elements beyond its {expected}, or not in order"))
            );
        }
        Ok(pairs)
    }

    /// Where accessor `index` of vectors of N components has its elements: view, offset, count, and of what.
    fn layout<const N: usize>(&self, index: usize) -> Result<(usize, u64, u64, ComponentType, bool)> {
        let accessor = self.accessor(index)?;
        let expected = match N {
            1 => Type::Scalar,
            2 => Type::Vec2,
            3 => Type::Vec3,
            _ => Type::Vec4,
        };
        if accessor.type_ != Valid(expected) {
            return Err(self.fault(index, &format!("does not have {N} components, as expected")));
        }
        let (Valid(component), Some(view), None) =
            (accessor.component_type, accessor.buffer_view, &accessor.sparse)
        else {
            return Err(self.fault(index, "has no elements of a known type in a buffer view"));
        };
        let offset = accessor.byte_offset.unwrap_or_default().0;
        Ok((view.value(), offset, accessor.count.0, component.0, accessor.normalized))
    }

    fn accessor(&self, index: usize) -> Result<&Accessor> {
        let accessors = &self.root.accessors;
        accessors
            .get(index)
            .ok_or_else(|| self.fault(index, &format!("does not exist, expected one of {}", accessors.len())))
    }

    /// The bytes of buffer view `index`, unfolded.
    pub(super) fn bytes(&mut self, index: usize) -> Result<Vec<u8>> {
        Ok(self.view(index)?.0)
    }

    /// The bytes of buffer view `index`, unfolded, and its stride if it has one.
    fn view(&mut self, index: usize) -> Result<(Vec<u8>, Option<usize>)> {
        let name = &self.name;
        let fault = |what: &str| Error::malformed(format!("{name}: buffer view {index} {what}"));
        let Some(view) = self.root.buffer_views.get(index) else {
            return Err(fault("does not exist; the file is damaged"));
        };
        let stride = view.byte_stride.map(|stride| stride.0);
        let what = format!("buffer view {index}");
        let Some(compressed) = CompressedView::of(view).map_err(|what| fault(&what))? else {
            if view.buffer.value() != 0 {
                return Err(fault("lies in a buffer without data; the file is damaged"));
            }
            let offset = view.byte_offset.unwrap_or_default().0;
            return Ok((self.source.read(offset, view.byte_length.0, &what)?, stride));
        };
        if compressed.buffer != 0 {
            return Err(fault(
                "is compressed in another way than Rhytid does; expected a file that Rhytid has written",
            ));
        }
        let encoded = self.source.read(compressed.byte_offset, compressed.byte_length, &what)?;
        match compressed.decode(&encoded).map_err(|what| fault(&what))? {
            bytes if bytes.len() as u64 == view.byte_length.0 => Ok((bytes, stride)),
            bytes => Err(fault(&format!(
                "has {} bytes once it is unfolded, expected {}; the file is damaged",
                bytes.len(),
                view.byte_length.0
            ))),
        }
    }

    fn fault(&self, index: usize, what: &str) -> Error {
        Error::malformed(format!("{}: accessor {index} {what}; the file is damaged", self.name))
    }
}

/// `count` vectors of N components from `offset` in `bytes`; `None` if they are not all there.
fn elements<const N: usize>(
    bytes: &[u8],
    stride: Option<usize>,
    offset: u64,
    count: u64,
    component: ComponentType,
) -> Option<Vec<[f64; N]>> {
    let size = component.size();
    let stride = stride.unwrap_or(N * size);
    let bytes = bytes.get(usize::try_from(offset).ok()?..)?;
    let count = usize::try_from(count).ok()?;
    if stride < N * size {
        return None;
    }
    // The last element need not be followed by the rest of a stride.
    let length = match count {
        0 => 0,
        _ => stride.checked_mul(count - 1)?.checked_add(N * size)?,
    };
    let bytes = bytes.get(..length)?;
    let vector = |bytes: &[u8]| std::array::from_fn(|i| number(&bytes[i * size..(i + 1) * size], component));
    Some(bytes.chunks(stride).map(vector).collect())
}

/// The number that `bytes` hold, as many as `component` has.
fn number(bytes: &[u8], component: ComponentType) -> f64 {
    match (component, bytes) {
        (ComponentType::I8, &[a]) => f64::from(a as i8),
        (ComponentType::U8, &[a]) => f64::from(a),
        (ComponentType::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (ComponentType::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (ComponentType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (_, bytes) => bytes.first_chunk().map_or(f64::NAN, |b| f64::from(f32::from_le_bytes(*b))),
    }
}
