//! The three kinds of processors that C3D files come from, and how each stores numbers.

/// The processor that a file was written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Processor {
    /// Little endian, IEEE floats.
    Intel,
    /// Little endian, VAX floats.
    Dec,
    /// Big endian, IEEE floats.
    Sgi,
}

impl Processor {
    /// By the code in the parameter section's fourth byte.
    pub(super) fn from_code(code: u8) -> Option<Self> {
        match code {
            84 => Some(Self::Intel),
            85 => Some(Self::Dec),
            86 => Some(Self::Sgi),
            _ => None,
        }
    }

    /// A 16-bit word without sign.
    pub(super) fn word(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Intel | Self::Dec => u16::from_le_bytes(bytes),
            Self::Sgi => u16::from_be_bytes(bytes),
        }
    }

    /// A 32-bit float. VAX floats go beyond `f32`'s range by no more than `f64` holds; their reserved operand
    /// is NaN.
    pub(super) fn float(self, bytes: [u8; 4]) -> f64 {
        match self {
            Self::Intel => f64::from(f32::from_le_bytes(bytes)),
            Self::Sgi => f64::from(f32::from_be_bytes(bytes)),
            Self::Dec => vax_float(bytes),
        }
    }
}

/// VAX F: two little-endian words, the high one first; the exponent is biased by 128 and the mantissa lies in
/// [0.5, 1).
fn vax_float([b0, b1, b2, b3]: [u8; 4]) -> f64 {
    let bits = u32::from_be_bytes([b1, b0, b3, b2]);
    let negative = bits >> 31 != 0;
    let exponent = (bits >> 23 & 0xFF) as i32;
    if exponent == 0 {
        return if negative { f64::NAN } else { 0.0 };
    }
    let mantissa = f64::from(bits & 0x7F_FFFF | 0x80_0000) / f64::from(1 << 24);
    let value = mantissa * f64::from(exponent - 128).exp2();
    if negative { -value } else { value }
}

#[cfg(test)]
mod tests {
    use super::Processor::{Dec, Intel, Sgi};

    #[test]
    fn numbers_of_each_processor() {
        assert_eq!([Intel, Dec, Sgi].map(|p| p.word([0x01, 0x80])), [0x8001, 0x8001, 0x0180]);
        // From the VAX architecture's handbook: 1 is 4080 hexadecimal in the first word, −1 is C080, 0.5 is
        // 4000.
        assert_eq!(Dec.float([0x80, 0x40, 0, 0]), 1.0);
        assert_eq!(Dec.float([0x80, 0xC0, 0, 0]), -1.0);
        assert_eq!(Dec.float([0x00, 0x40, 0, 0]), 0.5);
        assert_eq!(Dec.float([0x49, 0x41, 0xDB, 0x0F]), f64::from(std::f32::consts::PI));
        assert_eq!(Dec.float([0, 0, 0xFF, 0xFF]), 0.0);
        assert!(Dec.float([0, 0x80, 0, 0]).is_nan());
        assert_eq!(Intel.float([0, 0, 0x80, 0x3F]), 1.0);
        assert_eq!(Sgi.float([0x3F, 0x80, 0, 0]), 1.0);
    }
}
