//! The units of length that have names.

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthUnit {
    /// Its name in files, options and sentences, such as `mm`.
    pub name: &'static str,
    /// Its length in metres.
    pub metres: f64,
}

impl LengthUnit {
    /// The units that faces and takes come in.
    pub const ALL: [Self; 5] = [
        Self { name: "mm", metres: 1e-3 },
        Self { name: "cm", metres: 1e-2 },
        Self { name: "m", metres: 1.0 },
        Self { name: "in", metres: 0.0254 },
        Self { name: "ft", metres: 0.3048 },
    ];

    /// The unit of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.name == name)
    }

    /// The unit of so many metres. Files may have rounded it to single precision.
    pub fn of_metres(metres: f64) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| (metres / unit.metres - 1.0).abs() < 1e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_by_name_and_by_length() {
        // A yard has 3 feet, a foot has 12 inches, and a yard has 0.9144 m.
        let metres = |name: &str| LengthUnit::named(name).unwrap().metres;
        assert!((3.0 * metres("ft") - 0.9144).abs() < 1e-12);
        assert!((36.0 * metres("in") - 0.9144).abs() < 1e-12);
        assert_eq!(["m", "cm", "mm"].map(|name| 1000.0 * metres(name)), [1000.0, 10.0, 1.0]);
        assert_eq!(LengthUnit::named("yd"), None);
        for unit in LengthUnit::ALL {
            assert_eq!(LengthUnit::of_metres(f64::from(unit.metres as f32)), Some(unit));
        }
        assert_eq!(LengthUnit::of_metres(0.1), None);
        assert_eq!(LengthUnit::of_metres(f64::NAN), None);
    }
}
