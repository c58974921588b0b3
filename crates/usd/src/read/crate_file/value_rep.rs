//! The representation of a value in 8 bytes.

/// Where a value is and of which type: 16 bits of flags and type, 48 bits of place, or the value itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct ValueRep(pub(super) u64);

impl ValueRep {
    /// One of the numbers of [`kind`].
    pub(super) fn kind(self) -> u8 {
        (self.0 >> 48) as u8
    }

    pub(super) fn is_array(self) -> bool {
        self.0 >> 63 & 1 == 1
    }

    /// Whether the payload is the value.
    pub(super) fn is_inlined(self) -> bool {
        self.0 >> 62 & 1 == 1
    }

    pub(super) fn is_compressed(self) -> bool {
        self.0 >> 61 & 1 == 1
    }

    /// The place in the file, or the value.
    pub(super) fn payload(self) -> u64 {
        self.0 & 0xffff_ffff_ffff
    }

    /// The value where it is in the payload; it has at most 32 bits.
    pub(super) fn inlined(self) -> u32 {
        self.0 as u32
    }
}

/// The numbers of types in a crate file, as far as they are read.
pub(super) mod kind {
    pub(crate) const BOOL: u8 = 1;
    pub(crate) const INT: u8 = 3;
    pub(crate) const HALF: u8 = 7;
    pub(crate) const FLOAT: u8 = 8;
    pub(crate) const DOUBLE: u8 = 9;
    pub(crate) const STRING: u8 = 10;
    pub(crate) const TOKEN: u8 = 11;
    pub(crate) const ASSET: u8 = 12;
    pub(crate) const MATRIX4D: u8 = 15;
    pub(crate) const QUATD: u8 = 16;
    pub(crate) const QUATF: u8 = 17;
    pub(crate) const QUATH: u8 = 18;
    pub(crate) const DOUBLE2: u8 = 19;
    pub(crate) const FLOAT2: u8 = 20;
    pub(crate) const HALF2: u8 = 21;
    pub(crate) const DOUBLE3: u8 = 23;
    pub(crate) const FLOAT3: u8 = 24;
    pub(crate) const HALF3: u8 = 25;
    pub(crate) const FLOAT4: u8 = 28;
    pub(crate) const HALF4: u8 = 29;
    pub(crate) const DICTIONARY: u8 = 31;
    pub(crate) const TOKEN_LIST_OP: u8 = 32;
    pub(crate) const PATH_LIST_OP: u8 = 34;
    pub(crate) const REFERENCE_LIST_OP: u8 = 35;
    pub(crate) const TOKEN_VECTOR: u8 = 41;
    pub(crate) const SPECIFIER: u8 = 42;
    pub(crate) const VARIABILITY: u8 = 44;
    pub(crate) const TIME_SAMPLES: u8 = 46;
    pub(crate) const DOUBLE_VECTOR: u8 = 48;
}
