//! The header of a PLY file.

use rhytid_core::{Error, InputErrorKind, Result};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// In bytes, in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

pub(super) struct Property {
    pub name: String,
    /// The type of a list's length; `None` for a single number.
    pub list: Option<Scalar>,
    pub scalar: Scalar,
}

pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// Elements of a file, and properties of an element.
const MOST: usize = 256;

pub(super) struct Header {
    pub encoding: Encoding,
    /// In the file's order; distinct names.
    pub elements: Vec<Element>,
    /// Bytes before the first element.
    pub bytes: usize,
    /// Lines before the first element.
    pub lines: usize,
}

impl Header {
    pub(super) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|e| e.name == name)
    }

    pub(super) fn parse(file: &[u8], name: &str) -> Result<Self> {
        let mut statements = Statements::default();
        let (mut bytes, mut lines) = (0, 0);
        let mut ends_with_return = false;
        let mut remark = None;
        loop {
            let rest = file.get(bytes..).unwrap_or_default();
            let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let line = rest[..end.unwrap_or(rest.len())].trim_ascii();
            let is_magic = |line: &[u8]| line.eq_ignore_ascii_case(b"ply");
            if lines == 0 && !is_magic(line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line)) {
                return Err(Error::unsupported_format(format!(
                    "{name}: does not begin with a line \"ply\", so it is not a PLY file; check its extension"
                )));
            }
            let Some(end) = end else {
                return Err(Error::cut_short(format!(
                    "{name}: ends within its header, after line {lines}, expected a line \"end_header\"; the \
                     file is cut short"
                )));
            };
            let is_return = rest[end] == b'\r';
            let is_pair = is_return && rest.get(end + 1) == Some(&b'\n');
            if lines == 0 {
                ends_with_return = is_return && !is_pair;
            }
            // Behind a header whose lines end with CR alone, a binary file may begin with the byte of LF.
            bytes += if is_pair && !ends_with_return { end + 2 } else { end + 1 };
            lines += 1;
            // Comments may be in any encoding; all else is ASCII.
            let text = String::from_utf8_lossy(line);
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            match words.as_slice() {
                _ if lines == 1 => {}
                ["end_header"] => break,
                words if statements.is_remark(words) => remark = remark.or(Some(lines)),
                words => statements.add(words).map_err(|expected| {
                    let line = String::from_utf8_lossy(&line[..line.len().min(60)]).into_owned();
                    Error::malformed(format!("{name}, line {lines}: found {line:?}, {expected}"))
                        .of_kind(InputErrorKind::Malformed { line: Some(lines) })
                })?,
            }
        }
        if let Some(line) = remark {
            log::warn!(
                "{name}, line {line}: this line of the header says nothing that PLY knows, so it was taken for a \
                 comment; if it is one, write \"comment\" before it"
            );
        }
        let Statements { encoding: Some(encoding), elements } = statements else {
            return Err(Error::malformed(format!(
                "{name}: its header has no line \"format\", expected one such as \"format ascii 1.0\"; export \
                 the mesh again"
            )));
        };
        Ok(Self { encoding, elements, bytes, lines })
    }
}

/// What the lines of a header have said so far.
#[derive(Default)]
struct Statements {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
}

/// Nothing, or what was expected of a line.
type Stated = std::result::Result<(), &'static str>;

impl Statements {
    /// Adds what a line says, in its words.
    fn add(&mut self, words: &[&str]) -> Stated {
        match words {
            [] | ["comment" | "obj_info", ..] => Ok(()),
            ["format", kind, "1.0"] => self.add_format(kind),
            ["format", ..] => Err("expected a format of version 1.0"),
            ["element", name, count] => self.add_element(name, count),
            ["property", types @ .., name] => self.add_property(types, name),
            _ => Err("expected a PLY header line; the file may be damaged"),
        }
    }

    /// Whether a line is a comment of which an old exporter left out the keyword. Where no element is known
    /// yet, no line with another keyword changes how numbers are read.
    fn is_remark(&self, words: &[&str]) -> bool {
        let known = ["format", "element", "property", "comment", "obj_info"];
        self.elements.is_empty() && words.first().is_some_and(|word| !known.contains(word))
    }

    fn add_format(&mut self, kind: &str) -> Stated {
        self.encoding = Some(match kind {
            "ascii" => Encoding::Ascii,
            "binary_little_endian" => Encoding::LittleEndian,
            "binary_big_endian" => Encoding::BigEndian,
            _ => return Err("expected ascii, binary_little_endian or binary_big_endian"),
        });
        Ok(())
    }

    fn add_element(&mut self, name: &str, count: &str) -> Stated {
        let Ok(count) = count.parse() else { return Err("expected a whole number at the end") };
        if self.elements.iter().any(|e| e.name == name) {
            return Err("but there is such an element already");
        }
        if self.elements.len() == MOST {
            return Err("expected at most 256 elements; the header may be damaged");
        }
        self.elements.push(Element { name: name.into(), count, properties: Vec::new() });
        Ok(())
    }

    /// Adds a property to the last element.
    fn add_property(&mut self, types: &[&str], name: &str) -> Stated {
        let Some(element) = self.elements.last_mut() else {
            return Err("expected an element before its properties");
        };
        let (list, scalar) = match *types {
            [scalar] => (None, Scalar::parse(scalar)),
            ["list", count, scalar] => (Some(Scalar::parse(count)), Scalar::parse(scalar)),
            _ => (None, None),
        };
        let (Some(scalar), false) = (scalar, list == Some(None)) else {
            return Err("expected known types, as in \"property float x\"");
        };
        if matches!(list, Some(Some(Scalar::F32 | Scalar::F64))) {
            return Err("expected a whole number's type for the length of a list");
        }
        if element.properties.len() == MOST {
            return Err("expected at most 256 properties of an element; the header may be damaged");
        }
        element.properties.push(Property { name: name.into(), list: list.flatten(), scalar });
        Ok(())
    }
}
