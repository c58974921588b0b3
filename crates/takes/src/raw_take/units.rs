//! The names of units of length.

/// Metres in one `unit`, however that is spelt; `None` for what is no unit of length.
pub(crate) fn metres(unit: &str) -> Option<f64> {
    Some(match unit.trim().to_ascii_lowercase().as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => 1.0,
        "dm" | "decimeter" | "decimeters" | "decimetre" | "decimetres" => 0.1,
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => 0.01,
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => 0.001,
        "in" | "inch" | "inches" => 0.0254,
        "ft" | "foot" | "feet" => 0.3048,
        _ => return None,
    })
}

/// The warning for a `unit`, found in `place`, that [`metres`] does not know.
pub(super) fn unknown(unit: &str, place: &str) -> String {
    if unit.is_empty() {
        format!(
            "{place} names no unit of length; unless you give a unit, it is guessed from the size of the face"
        )
    } else {
        format!(
            "{place} is {}, expected mm, cm, m, in or ft; unless you give a unit, it is guessed from the \
             size of the face",
            rhytid_core::text::quoted(unit)
        )
    }
}
