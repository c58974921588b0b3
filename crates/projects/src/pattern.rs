//! Patterns in names of files and shapes.

/// Whether a text has signs of a pattern: `*` or `#`.
pub(crate) fn is_pattern(text: &str) -> bool {
    text.contains(['*', '#'])
}

/// Whether `text` is as `pattern` says: `*` is any number of characters, each `#` is a digit, and a row of
/// `#` is that many digits or more.
pub fn fits(pattern: &str, text: &str) -> bool {
    let (pattern, text): (Vec<char>, Vec<char>) = (pattern.chars().collect(), text.chars().collect());
    // Of each length of the text's beginning: whether the pattern so far fits it.
    let mut begins = vec![false; text.len() + 1];
    begins[0] = true;
    for (i, sign) in pattern.iter().enumerate() {
        let mut next = vec![false; text.len() + 1];
        // Of a row of `#`, the last stands for all digits to come.
        let is_last_digit = *sign == '#' && pattern.get(i + 1) != Some(&'#');
        for end in 0..=text.len() {
            next[end] = match *sign {
                '*' => begins[end] || end > 0 && next[end - 1],
                '#' => {
                    end > 0
                        && text[end - 1].is_ascii_digit()
                        && (begins[end - 1] || is_last_digit && next[end - 1])
                }
                sign => end > 0 && begins[end - 1] && text[end - 1] == sign,
            };
        }
        begins = next;
    }
    begins[text.len()]
}

#[cfg(test)]
mod tests {
    use super::fits;

    #[test]
    fn signs_stand_for_characters_and_digits() {
        for (pattern, text, expected) in [
            ("*", "", true),
            ("*", "smile", true),
            ("mouth*", "mouthSmile", true),
            ("mouth*", "eyeMouth", false),
            ("*Left", "eyeBlinkLeft", true),
            ("m*S*e", "mouthSmile", true),
            ("scan.####.obj", "scan.0012.obj", true),
            ("scan.####.obj", "scan.012.obj", false),
            ("scan.####.obj", "scan.12345.obj", true),
            ("scan_#.obj", "scan_12.obj", true),
            ("scan_#.obj", "scan_.obj", false),
            ("scan_#.obj", "scan_a.obj", false),
            ("##*#", "123", true),
            ("smile", "smile", true),
            ("smile", "smiles", false),
            ("é*", "éa", true),
        ] {
            assert_eq!(fits(pattern, text), expected, "{pattern} {text}");
        }
        // No time that grows with a power of the length.
        assert!(!fits(&"*a".repeat(500), &"a".repeat(499)));
    }
}
