//! Words for findings: counts, lengths and lists for use in sentences.

/// A count for a sentence: `1 vertex`, `2 vertices`.
pub(super) fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// A length for a sentence: three significant digits, or a whole number.
pub(super) fn length(x: f64) -> String {
    if x != 0.0 && !(1e-6..1e9).contains(&x.abs()) {
        return format!("{x:.2e}");
    }
    let digits = 2 - x.abs().max(1e-6).log10().floor() as i32;
    let rounded = format!("{x:.*}", digits.max(0) as usize);
    match rounded.contains('.') {
        true => rounded.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => rounded,
    }
}

/// The first few items of a list, and the number of the others.
pub(super) fn first_few<T: ToString>(items: &[T]) -> String {
    const FEW: usize = 5;
    let mut out = items.iter().take(FEW).map(T::to_string).collect::<Vec<_>>().join(", ");
    if items.len() > FEW {
        out += &format!(" and {} more", items.len() - FEW);
    }
    out
}
