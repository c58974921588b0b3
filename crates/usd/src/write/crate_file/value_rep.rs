//! The crate format's representation of a value in 8 bytes: its type, a few flags, and either the value
//! itself or where in the file it stands.

/// The types by their numbers in the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Type {
    Bool = 1,
    Int = 3,
    Float = 8,
    Double = 9,
    String = 10,
    Token = 11,
    Asset = 12,
    Matrix4d = 15,
    Quatd = 16,
    Vec2d = 19,
    Vec2f = 20,
    Vec3d = 23,
    Vec3f = 24,
    Vec4f = 28,
    Dictionary = 31,
    TokenListOp = 32,
    PathListOp = 34,
    ReferenceListOp = 35,
    TokenVector = 41,
    Specifier = 42,
    Variability = 44,
    TimeSamples = 46,
    DoubleVector = 48,
}

/// A value's representation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct ValueRep(pub(super) u64);

impl ValueRep {
    const ARRAY: u64 = 1 << 63;
    const INLINED: u64 = 1 << 62;
    const COMPRESSED: u64 = 1 << 61;

    /// A single value that stands in the file; [`ValueRep::at`] says where.
    pub(super) fn single(of: Type) -> Self {
        Self((of as u64) << 48)
    }

    /// An array of such values; without a place, the empty one.
    pub(super) fn array(of: Type) -> Self {
        Self(Self::single(of).0 | Self::ARRAY)
    }

    /// An array whose numbers are compressed.
    pub(super) fn compressed_array(of: Type) -> Self {
        Self(Self::array(of).0 | Self::COMPRESSED)
    }

    /// The value itself.
    pub(super) fn inlined(of: Type, value: u32) -> Self {
        Self(Self::single(of).0 | Self::INLINED | u64::from(value))
    }

    /// With the place in the file, which has 48 bits.
    pub(super) fn at(self, offset: u64) -> Self {
        Self(self.0 | offset)
    }

    /// A double, if it is short enough to stand for itself: one that is a float.
    pub(super) fn inlined_double(x: f64) -> Option<Self> {
        let short = x as f32;
        (f64::from(short).to_bits() == x.to_bits()).then(|| Self::inlined(Type::Double, short.to_bits()))
    }

    /// A matrix, if it is short enough to stand for itself: whole numbers of 8 bits on the diagonal, and
    /// zeros.
    pub(super) fn inlined_matrix(rows: &[[f64; 4]; 4]) -> Option<Self> {
        let mut diagonal = [0_i8; 4];
        for (i, row) in rows.iter().enumerate() {
            diagonal[i] = row[i] as i8;
            for (j, x) in row.iter().enumerate() {
                let expected = if i == j { f64::from(diagonal[i]) } else { 0.0 };
                if x.to_bits() != expected.to_bits() {
                    return None;
                }
            }
        }
        Some(Self::inlined(Type::Matrix4d, u32::from_le_bytes(diagonal.map(|x| x as u8))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_keeps_every_bit_stands_for_itself() {
        assert_eq!(ValueRep::inlined_double(0.5), Some(ValueRep(0x4009_0000_3f00_0000)));
        assert_eq!(ValueRep::inlined_double(-0.0), Some(ValueRep(0x4009_0000_8000_0000)));
        assert_eq!(ValueRep::inlined_double(0.1), None);
        assert_eq!(ValueRep::inlined_double(1e300), None);
        let mut matrix =
            [[1.0, 0.0, 0.0, 0.0], [0.0, -2.0, 0.0, 0.0], [0.0, 0.0, 3.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        assert_eq!(ValueRep::inlined_matrix(&matrix), Some(ValueRep(0x400f_0000_0103_fe01)));
        for (row, column, x) in [(0, 1, -0.0), (3, 0, 1.0), (2, 2, 1.5), (2, 2, -0.0), (1, 1, 128.0)] {
            let before = std::mem::replace(&mut matrix[row][column], x);
            assert_eq!(ValueRep::inlined_matrix(&matrix), None);
            matrix[row][column] = before;
        }
    }
}
