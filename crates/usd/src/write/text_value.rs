//! Values as USD text has them.
use super::numbers::{double, float, shortest};
use crate::layer::{Fields, Reference, Value};
use std::io::{self, Write};

/// One value. Its further lines are indented deeper than `indent`.
pub(super) fn write_value(out: &mut dyn Write, value: &Value, indent: &str) -> io::Result<()> {
    match value {
        Value::Bool(x) => write!(out, "{}", u8::from(*x)),
        Value::Int(x) => write!(out, "{x}"),
        Value::Float(x) => write!(out, "{}", float(*x)),
        Value::Double(x) => write!(out, "{}", double(*x)),
        Value::String(text) | Value::Token(text) => write!(out, "{}", quoted(text)),
        Value::Asset(text) => write!(out, "{}", asset(text)),
        Value::Float3(vector) => write!(out, "({})", vector.map(float).join(", ")),
        Value::Float4(vector) => write!(out, "({})", vector.map(float).join(", ")),
        Value::Double3(vector) => write!(out, "({})", vector.map(double).join(", ")),
        Value::Quatd(quaternion) => write!(out, "({})", quaternion.map(double).join(", ")),
        Value::Matrix4d(rows) => write_matrix(out, rows),
        Value::Tokens(tokens) | Value::PrependedTokens(tokens) => {
            write_list(out, tokens, |out, token| write!(out, "{}", quoted(token)))
        }
        Value::Assets(assets) => write_list(out, assets, |out, path| write!(out, "{}", asset(path))),
        Value::Ints(numbers) => write_list(out, numbers, |out, x| write!(out, "{x}")),
        Value::Floats(numbers) => write_floats(out, numbers),
        Value::Float2s(vectors) => write_float2s(out, vectors),
        Value::Float3s(vectors) => write_float3s(out, vectors),
        Value::Float4s(vectors) => {
            write_list(out, vectors, |out, vector| write!(out, "({})", vector.map(float).join(", ")))
        }
        Value::Double2s(vectors) => {
            write_list(out, vectors, |out, [x, y]| write!(out, "({}, {})", double(*x), double(*y)))
        }
        Value::Double3s(vectors) => {
            write_list(out, vectors, |out, vector| write!(out, "({})", vector.map(double).join(", ")))
        }
        Value::Matrix4ds(matrices) => write_list(out, matrices, |out, rows| write_matrix(out, rows)),
        Value::Dictionary(entries) => write_dictionary(out, entries, indent),
        Value::PrependedReferences(references) => write_list(out, references, write_reference),
    }
}

/// `((a, b, c, d), …)`
pub(super) fn write_matrix(out: &mut dyn Write, rows: &[[f64; 4]; 4]) -> io::Result<()> {
    let rows = rows.map(|row| format!("({})", row.map(double).join(", ")));
    write!(out, "({})", rows.join(", "))
}

/// `[x, …]`.
pub(super) fn write_floats(out: &mut dyn Write, numbers: &[f32]) -> io::Result<()> {
    write_list(out, numbers, |out, &x| write!(out, "{}", float(x)))
}

/// `[(x, y), …]`.
pub(super) fn write_float2s(out: &mut dyn Write, vectors: &[[f32; 2]]) -> io::Result<()> {
    write_list(out, vectors, |out, [x, y]| write!(out, "({}, {})", float(*x), float(*y)))
}

/// `[(x, y, z), …]`. This is where the time goes.
pub(super) fn write_float3s(out: &mut dyn Write, vectors: &[[f32; 3]]) -> io::Result<()> {
    let mut digits = ryu::Buffer::new();
    let mut text = Vec::with_capacity(512);
    out.write_all(b"[")?;
    for (i, few) in vectors.chunks(8).enumerate() {
        text.clear();
        for (j, vector) in few.iter().enumerate() {
            text.extend_from_slice(if i + j == 0 { b"(" } else { b", (" });
            for (k, &x) in vector.iter().enumerate() {
                text.extend_from_slice(if k == 0 { b"" } else { b", " });
                if x.is_finite() {
                    text.extend_from_slice(shortest(&mut digits, x).as_bytes());
                } else {
                    text.extend_from_slice(float(x).as_bytes());
                }
            }
            text.push(b')');
        }
        out.write_all(&text)?;
    }
    out.write_all(b"]")
}

/// Absolute paths: `</a>`, or several in brackets.
pub(super) fn write_path_list(out: &mut dyn Write, paths: &[String]) -> io::Result<()> {
    match paths {
        [path] => write!(out, "<{path}>"),
        _ => write_list(out, paths, |out, path| write!(out, "<{path}>")),
    }
}

/// `[a, b, …]`, on one line: USD's own library writes it so, and three.js reads no other.
fn write_list<T>(
    out: &mut dyn Write,
    items: &[T],
    write_item: impl Fn(&mut dyn Write, &T) -> io::Result<()>,
) -> io::Result<()> {
    out.write_all(b"[")?;
    for (i, item) in items.iter().enumerate() {
        out.write_all(if i == 0 { b"" } else { b", " })?;
        write_item(out, item)?;
    }
    out.write_all(b"]")
}

fn write_dictionary(out: &mut dyn Write, entries: &Fields, indent: &str) -> io::Result<()> {
    let inner = format!("{indent}    ");
    writeln!(out, "{{")?;
    for (key, value) in entries {
        let Some(type_name) = value.type_name() else {
            return Err(io::Error::other(format!("the dictionary entry {key} has no type")));
        };
        write!(out, "{inner}{type_name} {} = ", quoted(key))?;
        write_value(out, value, &inner)?;
        writeln!(out)?;
    }
    write!(out, "{indent}}}")
}

fn write_reference(out: &mut dyn Write, reference: &Reference) -> io::Result<()> {
    write!(out, "{}", asset(&reference.asset))?;
    if reference.prim.is_empty() { Ok(()) } else { write!(out, "<{}>", reference.prim) }
}

/// A path to a file. Three signs stand around one that has a sign in it.
fn asset(path: &str) -> String {
    if path.contains('@') { format!("@@@{}@@@", path.replace("@@@", "\\@@@")) } else { format!("@{path}@") }
}

/// In quotation marks, with what would end the line or the text escaped. Zero cannot be part of it and
/// becomes U+FFFD.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted.push_str("\\n"),
            '\r' => quoted.push_str("\\r"),
            '\t' => quoted.push_str("\\t"),
            '\0' => quoted.push('\u{fffd}'),
            c if c.is_ascii_control() => quoted.push_str(&format!("\\x{:02x}", c as u32)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
