//! Numbers as people read them, for sentences, tables and reports.

use crate::LengthUnit;
use std::time::Duration;

/// `1234567` as `1,234,567`.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A count and its noun: `1 frame`, `2 frames`.
pub fn counted(n: usize, noun: &str) -> String {
    format!("{} {noun}{}", count(n), if n == 1 { "" } else { "s" })
}

/// Bytes, decimal: `8.3 MB`.
pub fn bytes(n: u64) -> String {
    let units = [(1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    match units.iter().find(|(size, _)| n as f64 >= *size) {
        Some((size, unit)) => format!("{:.1} {unit}", n as f64 / size),
        None => format!("{n} bytes"),
    }
}

/// A duration: `0.12 s`, `3.4 s`, `75 s`, `3 min 20 s`.
pub fn duration(d: Duration) -> String {
    match d.as_secs_f64() {
        s if s < 1.0 => format!("{s:.2} s"),
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 100.0 => format!("{s:.0} s"),
        s => format!("{} min {:02} s", s as u64 / 60, s as u64 % 60),
    }
}

/// A number with up to four significant decimals, without trailing zeros.
pub fn number(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// A ratio in percent with so many decimals: `12.5 %`. A ratio of more than 10, which no face has, is only
/// `over 1,000 %`.
pub fn percent(ratio: f64, decimals: usize) -> String {
    match ratio {
        r if r > 10.0 => "over 1,000 %".to_owned(),
        r if r.is_nan() => "an unknown part".to_owned(),
        r => format!("{:.decimals$} %", 100.0 * r),
    }
}

/// A factor with one decimal: `2.5 times`. Beyond 1,000 it is only `over 1,000 times`.
pub fn times(factor: f64) -> String {
    if factor <= 1000.0 { format!("{factor:.1} times") } else { "over 1,000 times".to_owned() }
}

/// The unit's name where it has one: `cm`; else `units of 0.3 m`.
pub fn unit(metres_per_unit: f64) -> String {
    match LengthUnit::of_metres(metres_per_unit) {
        Some(unit) => unit.name.to_owned(),
        None => format!("units of {} m", number(metres_per_unit)),
    }
}

/// Bounds as `-8.1 … 8.1 × -10 … 12 × 0 … 9`.
pub fn bounds([lo, hi]: [[f64; 3]; 2]) -> String {
    let axis = |i: usize| format!("{} … {}", number(lo[i]), number(hi[i]));
    format!("x {}, y {}, z {}", axis(0), axis(1), axis(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_people_read_them() {
        assert_eq!(
            [percent(0.125, 1), percent(9.0, 0), percent(1e30, 0)],
            ["12.5 %", "900 %", "over 1,000 %"]
        );
        assert_eq!([times(2.0), times(f64::INFINITY)], ["2.0 times", "over 1,000 times"]);
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(1_000), "1,000");
        assert_eq!(count(1_234_567), "1,234,567");
        assert_eq!(bytes(999), "999 bytes");
        assert_eq!(bytes(8_300_000), "8.3 MB");
        assert_eq!(duration(Duration::from_millis(120)), "0.12 s");
        assert_eq!(duration(Duration::from_secs(200)), "3 min 20 s");
        assert_eq!(number(3.0), "3");
        assert_eq!(number(-0.00001), "0");
        assert_eq!(number(29.97), "29.97");
        assert_eq!(unit(0.01), "cm");
        assert_eq!(unit(0.5), "units of 0.5 m");
    }
}
