//! Numbers as USD has them: as text, and integers with a sign.

use rhytid_core::{Error, Result};

/// The shortest text of a finite `x` that reads back as the same bits, -0 included. At most 16 characters. It
/// also reads back the same by way of `f64`, which USD and most JSON readers use.
pub(super) fn shortest(digits: &mut ryu::Buffer, x: f32) -> &str {
    /// Of all `f32`, only this number and its negative have a shortest text (7.038531e-26) that fails by way
    /// of `f64`. The `f64` lies just between the number and its neighbour, and rounds to the neighbour. One
    /// more digit helps.
    const ROUNDED_TWICE: u32 = 0x15ae_43fd;
    match x.to_bits() {
        ROUNDED_TWICE => "7.0385307e-26",
        bits if bits == ROUNDED_TWICE | 1 << 31 => "-7.0385307e-26",
        _ => digits.format_finite(x),
    }
}

/// The shortest text that reads back as the same `f64`; whole numbers without a point.
pub(super) fn double(x: f64) -> String {
    if x.is_nan() {
        return "nan".into();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf" } else { "-inf" }.into();
    }
    let mut digits = ryu::Buffer::new();
    let text = digits.format_finite(x);
    text.strip_suffix(".0").unwrap_or(text).to_owned()
}

/// [`shortest`], also of a number that is not finite.
pub(super) fn float(x: f32) -> String {
    if !x.is_finite() {
        return double(f64::from(x));
    }
    shortest(&mut ryu::Buffer::new(), x).to_owned()
}

/// USD's integers have a sign.
pub(super) fn integer(x: usize) -> Result<i32> {
    i32::try_from(x).map_err(|_| {
        Error::too_large(format!(
            "the mesh has the number {x} in its faces, expected at most {} in USD",
            i32::MAX
        ))
    })
}
