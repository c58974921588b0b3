//! Pieces of text files (OBJ, MTL and ASCII PLY): names, numbers, and both in messages.

/// A name or a file name. Bytes that are not UTF-8 become `%` and two hexadecimal digits each, so that two
/// names in an old encoding stay two names.
pub(super) fn name(bytes: &[u8]) -> String {
    let mut name = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        name.push_str(chunk.valid());
        for byte in chunk.invalid() {
            name.push_str(&format!("%{byte:02X}"));
        }
    }
    name
}

/// The number that a word is.
pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Whether a word stands for a number that is none or infinite, in the spelling of any C library: `nan`,
/// `-nan(ind)`, `1.#QNAN`, `-1.#IND`, `inf`.
pub(super) fn is_not_finite(word: &[u8]) -> bool {
    let word = word.strip_prefix(b"-").or_else(|| word.strip_prefix(b"+")).unwrap_or(word);
    let begins = |with: &[u8]| word.get(..with.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(with));
    begins(b"nan") || begins(b"inf") || begins(b"1.#")
}

/// A phrase that says what a word is where a number was expected, and what to do.
pub(super) fn not_a_number(word: &[u8]) -> String {
    let found = shown(word);
    let has_digits = word.iter().any(u8::is_ascii_digit);
    match word.iter().filter(|&&byte| byte == b',').count() {
        1 if has_digits && !word.ends_with(b",") => format!(
            "{found}, expected a number with a decimal point; the file has decimal commas: export it again with \
             the numbers of the English language"
        ),
        0 => format!("{found}, expected a number; the file may be damaged"),
        _ => format!(
            "{found}, expected numbers with blanks between them, not commas; replace each comma by a blank, or \
             export the mesh again"
        ),
    }
}

/// A piece of the file for a message: quoted, escaped, not too long.
pub(super) fn shown(piece: &[u8]) -> String {
    format!("{:?}", String::from_utf8_lossy(&piece[..piece.len().min(40)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_old_encodings_stay_apart() {
        assert_eq!(name(b"\xba\xc3"), "%BA%C3");
        assert_eq!(name(b"\xc4\xe3 skin"), "%C4%E3 skin");
        assert_eq!(name("Köpfe".as_bytes()), "Köpfe");
    }

    #[test]
    fn commas_are_told_apart() {
        assert!(not_a_number(b"0,5").contains("decimal commas"));
        assert!(not_a_number(b"1,2,3").contains("not commas"));
        assert!(not_a_number(b"1,").contains("not commas"));
        assert!(not_a_number(b"1.0D+00").contains("may be damaged"));
    }
}
