//! Numbers behind accessors.

use super::buffers::Buffers;
use ::gltf::json::Root;
use ::gltf::json::accessor::{Accessor, ComponentType, Type};
use ::gltf::json::validation::Checked;
use rhytid_core::{Error, Result};

/// Reads accessors without trust: every range is checked against its buffer.
pub(super) struct Accessors<'a> {
    pub root: &'a Root,
    pub buffers: &'a Buffers,
    pub name: &'a str,
}

impl Accessors<'_> {
    /// The elements of accessor `index`, N components each, as the file's numbers mean them (integers marked
    /// as normalised are divided by their largest value). At most as many as the file has bytes.
    pub(super) fn vectors<const N: usize>(&self, index: usize) -> Result<Vec<[f64; N]>> {
        let accessor = self.accessor(index)?;
        let expected = match N {
            1 => Type::Scalar,
            2 => Type::Vec2,
            3 => Type::Vec3,
            4 => Type::Vec4,
            _ => Type::Mat4,
        };
        if accessor.type_ != Checked::Valid(expected) {
            return self.fail(index, format!("does not have {N} components, expected type {expected:?}"));
        }
        let component = self.component(index, accessor)?;
        let count = accessor.count.0;
        let mut out = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                self.strided::<N>(index, view.value(), offset, count, component)?
                    .map(|b| vector(b, component))
                    .collect()
            }
            None if count <= self.buffers.total() => vec![[0.0; N]; count as usize],
            None => {
                return self
                    .fail(index, format!("announces {count} elements and has none; the file is damaged"));
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let (at, values) = (&sparse.indices, &sparse.values);
            let Checked::Valid(at_type) = at.component_type else {
                return self.fail(index, "has sparse indices of an unknown type; the file is damaged".into());
            };
            let count = sparse.count.0;
            let at = self.strided::<1>(index, at.buffer_view.value(), at.byte_offset.0, count, at_type.0)?;
            let values =
                self.strided::<N>(index, values.buffer_view.value(), values.byte_offset.0, count, component)?;
            for (at, value) in at.zip(values) {
                let [at]: [f64; 1] = vector(at, at_type.0);
                match out.get_mut(at as usize) {
                    Some(element) => *element = vector(value, component),
                    None => {
                        return self
                            .fail(index, format!("replaces its element {at}, which it does not have"));
                    }
                }
            }
        }
        if accessor.normalized {
            let largest = match component {
                ComponentType::I8 => 127.0,
                ComponentType::U8 => 255.0,
                ComponentType::I16 => 32767.0,
                ComponentType::U16 => 65535.0,
                ComponentType::U32 => f64::from(u32::MAX),
                ComponentType::F32 => return Ok(out),
            };
            // Two's complement has one more number below 0 than above.
            out.iter_mut().flatten().for_each(|x| *x = (*x / largest).max(-1.0));
        }
        Ok(out)
    }

    /// The elements of accessor `index` as vertex indices.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>> {
        match self.component(index, self.accessor(index)?)? {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => {
                Ok(self.vectors::<1>(index)?.into_iter().map(|[x]| x as u32).collect())
            }
            found => self.fail(index, format!("holds indices as {found:?}, expected U8, U16 or U32")),
        }
    }

    /// Number of elements, as the file announces it.
    pub(super) fn count(&self, index: usize) -> Result<u64> {
        Ok(self.accessor(index)?.count.0)
    }

    /// Whether its elements are stored in the plain way, not by an extension.
    pub(super) fn is_stored(&self, index: usize) -> Result<bool> {
        Ok(is_stored(self.accessor(index)?))
    }

    /// Whether its elements are integers that stand for themselves.
    pub(super) fn is_integers(&self, index: usize) -> Result<bool> {
        let accessor = self.accessor(index)?;
        Ok(!accessor.normalized && self.component(index, accessor)? != ComponentType::F32)
    }

    fn accessor(&self, index: usize) -> Result<&Accessor> {
        match self.root.accessors.get(index) {
            Some(accessor) => Ok(accessor),
            None => self.fail(
                index,
                format!(
                    "does not exist, expected one of the {}; the file is damaged",
                    self.root.accessors.len()
                ),
            ),
        }
    }

    fn component(&self, index: usize, accessor: &Accessor) -> Result<ComponentType> {
        match accessor.component_type {
            Checked::Valid(component) => Ok(component.0),
            Checked::Invalid => self.fail(index, "has an unknown component type; the file is damaged".into()),
        }
    }

    /// The bytes of each of `count` elements of N components, from `offset` in buffer view `view`.
    fn strided<const N: usize>(
        &self,
        index: usize,
        view: usize,
        offset: u64,
        count: u64,
        component: ComponentType,
    ) -> Result<impl Iterator<Item = &[u8]>> {
        let (bytes, stride) = self.buffers.view(self.root, view, self.name)?;
        let size = N * component.size();
        let stride = stride.unwrap_or(size);
        if stride < size {
            return self.fail(index, format!("has a stride of {stride} bytes, expected at least {size}"));
        }
        // The last element need not be followed by the rest of a stride.
        let length = match count {
            0 => Some(0),
            _ => (stride as u64).checked_mul(count - 1).and_then(|n| n.checked_add(size as u64)),
        };
        let range = length.and_then(|n| Some((usize::try_from(offset).ok()?, offset.checked_add(n)?)));
        let slice = range.and_then(|(start, end)| bytes.get(start..usize::try_from(end).ok()?));
        match slice {
            Some(slice) => Ok(slice.chunks(stride).map(move |chunk| &chunk[..size])),
            None => self.fail(
                index,
                format!(
                    "takes {count} elements of {stride} bytes from byte {offset} of buffer view {view}, which has \
                     {}; the file may be cut short",
                    bytes.len()
                ),
            ),
        }
    }

    fn fail<T>(&self, index: usize, what: String) -> Result<T> {
        Err(Error::malformed(format!("{}: accessor {index} {what}", self.name)))
    }
}

/// Whether the elements of an accessor are stored in the plain way, not by an extension.
pub(super) fn is_stored(accessor: &Accessor) -> bool {
    accessor.buffer_view.is_some() || accessor.sparse.is_some()
}

/// `bytes` holds N components.
fn vector<const N: usize>(bytes: &[u8], component: ComponentType) -> [f64; N] {
    let size = component.size();
    std::array::from_fn(|i| {
        let b = &bytes[i * size..(i + 1) * size];
        match component {
            ComponentType::I8 => i8::from_le_bytes([b[0]]).into(),
            ComponentType::U8 => b[0].into(),
            ComponentType::I16 => i16::from_le_bytes([b[0], b[1]]).into(),
            ComponentType::U16 => u16::from_le_bytes([b[0], b[1]]).into(),
            ComponentType::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]).into(),
            ComponentType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]).into(),
        }
    })
}
