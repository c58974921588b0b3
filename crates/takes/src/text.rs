//! The text of tables, however a program wrote it: in UTF-8 or UTF-16, with tabs, commas, semicolons or
//! blanks between its cells, and with points or commas in its numbers.
use std::borrow::Cow;

/// A text in UTF-8 without a byte order mark. A text that is not UTF-16 stays as it is.
pub(crate) fn utf_8(bytes: &[u8]) -> Cow<'_, [u8]> {
    if let Some(text) = bytes.strip_prefix(b"\xEF\xBB\xBF") {
        return Cow::Borrowed(text);
    }
    let unit: fn([u8; 2]) -> u16 = match bytes {
        [0xFF, 0xFE, ..] => u16::from_le_bytes,
        [0xFE, 0xFF, ..] => u16::from_be_bytes,
        // Without the mark, the zeros beside the letters of the first words tell it.
        [a, 0, b, 0, c, 0, d, 0, ..] if [a, b, c, d].iter().all(|&&byte| byte != 0) => u16::from_le_bytes,
        [0, a, 0, b, 0, c, 0, d, ..] if [a, b, c, d].iter().all(|&&byte| byte != 0) => u16::from_be_bytes,
        _ => return Cow::Borrowed(bytes),
    };
    let units = bytes.as_chunks().0.iter().map(|&pair| unit(pair));
    let letters = char::decode_utf16(units).map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER));
    let text: String = letters.filter(|&letter| letter != '\u{FEFF}').collect();
    Cow::Owned(text.into_bytes())
}

/// A table whose cells have one byte between them, and points in their numbers.
pub(crate) struct Table<'a> {
    pub(crate) bytes: Cow<'a, [u8]>,
    /// The byte between two cells.
    pub(crate) separator: u8,
    /// Whether the file has blanks between its cells. Such a file cannot have empty cells.
    pub(crate) has_blanks: bool,
}

impl<'a> Table<'a> {
    /// The table in `text`. What follows `word` tells what lies between its cells. `word` begins a line in
    /// letters of either case. If no line begins so, or nothing follows the word, tabs lie between the cells.
    ///
    /// If numbers have commas in them and no number has a point, the commas become points.
    pub(crate) fn new(text: Cow<'a, [u8]>, word: &str) -> Self {
        let separator = separator(&text, word);
        let mut out = Self { bytes: text, separator: separator.unwrap_or(b'\t'), has_blanks: false };
        if separator == Some(b' ') {
            out.bytes = Cow::Owned(with_tabs(&out.bytes));
            out.separator = b'\t';
            out.has_blanks = true;
        }
        if out.separator != b','
            && !has_between_digits(&out.bytes, b'.')
            && has_between_digits(&out.bytes, b',')
        {
            let commas: Vec<usize> = between_digits(&out.bytes, b',').collect();
            let bytes = out.bytes.to_mut();
            for comma in commas {
                bytes[comma] = b'.';
            }
        }
        out
    }
}

/// The first line that begins with `word`, from there to the end of the text.
pub(crate) fn line_with<'t>(text: &'t [u8], word: &str) -> Option<&'t [u8]> {
    let mut rest = text;
    loop {
        let line = &rest[rest.iter().take_while(|byte| matches!(byte, b' ' | b'"' | b'\t')).count()..];
        if line.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word.as_bytes())) {
            return Some(line);
        }
        let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'))?;
        rest = &rest[end + 1..];
    }
}

/// What lies between the first two cells of the line that begins with `word`.
fn separator(text: &[u8], word: &str) -> Option<u8> {
    let line = line_with(text, word)?;
    let line = &line[..line.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(line.len())];
    let behind = line.iter().skip(word.len());
    let mut found = None;
    for &byte in behind {
        match byte {
            b'\t' | b',' | b';' => return Some(byte),
            b' ' => found = Some(b' '),
            // The second cell begins.
            _ if found.is_some() && byte.is_ascii_alphanumeric() => return found,
            _ => {}
        }
    }
    found
}

/// The text with one tab in place of blanks and tabs that lie beside each other, and none at the ends of
/// lines.
fn with_tabs(text: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(text.len());
    let mut is_apart = false;
    for &byte in text {
        let ends_line = matches!(byte, b'\n' | b'\r');
        if matches!(byte, b' ' | b'\t') {
            is_apart = true;
            continue;
        }
        let begins_line = matches!(out.last(), None | Some(b'\n' | b'\r'));
        if is_apart && !ends_line && !begins_line {
            out.push(b'\t');
        }
        is_apart = false;
        out.push(byte);
    }
    out
}

/// Whether a cell that is no number stands for “no number”.
pub(crate) fn says_missing(cell: &[u8]) -> bool {
    const WORDS: [&[u8]; 8] = [b"", b"-", b"na", b"n/a", b"null", b"none", b"missing", b"nil"];
    // Libraries of Windows print `1.#QNAN`, and newer ones `-nan(ind)`.
    let unsigned = cell.strip_prefix(b"-").unwrap_or(cell);
    let is_nan = unsigned.get(..4).is_some_and(|start| start.eq_ignore_ascii_case(b"nan("));
    is_nan || cell.contains(&b'#') || WORDS.iter().any(|word| cell.eq_ignore_ascii_case(word))
}

fn has_between_digits(text: &[u8], mark: u8) -> bool {
    between_digits(text, mark).next().is_some()
}

/// The places of a mark between two digits, in lines that do not begin with a letter.
fn between_digits(text: &[u8], mark: u8) -> impl Iterator<Item = usize> {
    let mut start = 0;
    let lines = text.split(|byte| matches!(byte, b'\n' | b'\r')).map(move |line| {
        let at = start;
        start += line.len() + 1;
        (at, line)
    });
    let lines = lines.filter(|(_, line)| {
        line.iter().find(|byte| !matches!(byte, b' ' | b'"')).is_some_and(|byte| !byte.is_ascii_alphabetic())
    });
    lines.flat_map(move |(at, line)| {
        let between =
            move |three: &[u8]| three[1] == mark && three[0].is_ascii_digit() && three[2].is_ascii_digit();
        line.windows(3).enumerate().filter(move |(_, three)| between(three)).map(move |(i, _)| at + i + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_in_any_encoding_is_one_text() {
        let text = "Frame#\tTime\tZähne\n1\t0\t2\n";
        let units = |to: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(to).collect::<Vec<u8>>();
        let (little, big) = (units(u16::to_le_bytes), units(u16::to_be_bytes));
        let with = |mark: &[u8], rest: &[u8]| [mark, rest].concat();
        for bytes in [
            text.as_bytes().to_vec(),
            with(b"\xEF\xBB\xBF", text.as_bytes()),
            with(b"\xFF\xFE", &little),
            with(b"\xFE\xFF", &big),
            little,
            big,
        ] {
            assert_eq!(utf_8(&bytes), text.as_bytes());
        }
        // Latin-1 is no UTF-8, and the readers know what to do with it.
        assert_eq!(*utf_8(b"Z\xE4hne"), *b"Z\xE4hne");
        assert_eq!(*utf_8(b""), *b"");
        assert_eq!(utf_8(b"\xFF\xFEa\0\x00\xD8b\0c"), "a\u{FFFD}b".as_bytes());
    }

    #[test]
    fn what_lies_between_cells_is_told_by_the_header() {
        let table = |text: &'static str| {
            let table = Table::new(Cow::Borrowed(text.as_bytes()), "Frame");
            (String::from_utf8(table.bytes.into_owned()).unwrap(), table.separator, table.has_blanks)
        };
        let same = |text: &'static str, separator| assert_eq!(table(text), (text.into(), separator, false));
        same("x,y z\nFrame#\tTime\ta,b\n1\t0.5\t2\n", b'\t');
        same("x;y\nFrame#,Time,a;b\n1,0.5,2\n", b',');
        same("frame;time;a,b\n1;0.5;2\n", b';');
        same("Frame#\t Time\ta b\n1\t0,5\t2.5\n", b'\t');
        same("nothing, here\n", b'\t');
        assert_eq!(
            table("Frame#  Time   a  b \n 1 0.5   2   3 \n"),
            ("Frame#\tTime\ta\tb\n1\t0.5\t2\t3\n".into(), b'\t', true)
        );
        assert_eq!(
            table("key;1,5\nFrame;Time;a\n1;-0,5;,5\n"),
            ("key;1,5\nFrame;Time;a\n1;-0.5;,5\n".into(), b';', false)
        );
    }
}
