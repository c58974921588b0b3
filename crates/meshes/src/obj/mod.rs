//! Wavefront OBJ: `v`, `vt`, `f` and `usemtl`. An own reader, so that every message has its line and polygons
//! stay whole.

mod lines;
mod notes;

use super::check::representable;
use super::materials::Assigned;
use super::text::{self, is_not_finite, not_a_number, number, shown};
use super::uvs::{self, CornerUvs};
use lines::is_blank;
use notes::Notes;
use rhytid_core::{Error, InputErrorKind, Mesh, Result};

pub(super) use lines::{Statement, statements, words};

/// Statements that say nothing about the surface's shape, or speak of curves, lines and points.
const IGNORED: [&[u8]; 38] = [
    b"vn",
    b"vp",
    b"o",
    b"g",
    b"s",
    b"mg",
    b"l",
    b"p",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"call",
    b"csh",
    b"bsp",
    b"bzp",
    b"cdc",
];

/// Statements that are read.
const READ: [&[u8]; 5] = [b"v", b"vt", b"f", b"fo", b"usemtl"];

pub(super) fn decode(bytes: &[u8], name: &str) -> Result<Mesh> {
    let mut reader = Reader { name, ..Reader::default() };
    for statement in statements(bytes) {
        reader.line = statement.line;
        reader.is_cut = statement.is_cut;
        reader.joined(&statement);
        reader.statement(&statement.text)?;
    }
    reader.finish()
}

/// Whether a statement is a face of the mesh: one of three corners or more.
pub(super) fn is_face(text: &[u8]) -> bool {
    let mut words = words(text);
    matches!(words.next(), Some(b"f" | b"fo")) && words.nth(2).is_some()
}

/// What is behind the keyword of a statement, as a name with blanks in it, without a comment.
pub(super) fn rest_of_line(text: &[u8]) -> &[u8] {
    let text = text.trim_ascii();
    let comment = text.windows(2).position(|pair| is_blank(pair[0]) && pair[1] == b'#');
    let text = &text[..comment.unwrap_or(text.len())];
    let end = text.iter().position(|&byte| is_blank(byte)).unwrap_or(text.len());
    text[end..].trim_ascii()
}

/// The highest index seen and its line, for the check that can only be made at the end: OBJ lets a face stand
/// before its vertices.
#[derive(Default, Clone, Copy)]
struct Highest {
    index: u64,
    line: usize,
}

/// A corner of a face.
struct Corner {
    vertex: u32,
    /// Its entry among the texture coordinates, or one of [`uvs`]'s entries for none.
    uv: u32,
}

#[derive(Default)]
struct Reader<'a> {
    name: &'a str,
    line: usize,
    /// Whether the file ends within the line.
    is_cut: bool,
    mesh: Mesh,
    uvs: CornerUvs,
    materials: Assigned,
    highest_vertex: Highest,
    notes: Notes,
    /// Of the face that is being read.
    corners: Vec<Corner>,
    vertices: Vec<u32>,
}

impl Reader<'_> {
    /// Notes a line that a backslash made a part of the statement before.
    fn joined(&mut self, statement: &Statement<'_>) {
        for (before, line) in statement.joined.iter().enumerate() {
            let keyword = words(line).next();
            if keyword.is_some_and(|word| READ.contains(&word) || IGNORED.contains(&word)) {
                self.notes.swallowed.add(statement.line + before, || shown(line));
            }
        }
    }

    fn statement(&mut self, text: &[u8]) -> Result<()> {
        let mut words = words(text);
        match words.next() {
            None => Ok(()),
            Some(b"v") => self.vertex(words),
            Some(b"vt") => self.uv(words),
            Some(b"f" | b"fo") => self.face(words, text),
            Some(b"usemtl") => {
                let name = text::name(rest_of_line(text));
                self.materials.choose((!name.is_empty()).then_some(name));
                Ok(())
            }
            Some(keyword) => {
                if !IGNORED.contains(&keyword) {
                    self.notes.unknown.add(self.line, || shown(keyword));
                }
                Ok(())
            }
        }
    }

    fn vertex<'t>(&mut self, mut tokens: impl Iterator<Item = &'t [u8]>) -> Result<()> {
        let mut position = [0.0; 3];
        for (found, x) in position.iter_mut().enumerate() {
            let Some(token) = tokens.next() else {
                return self
                    .fail(format!("a vertex has {found} numbers, expected 3; the file may be cut short"));
            };
            *x = number(token).ok_or_else(|| self.not_a_number(token))?;
            if !representable(*x) {
                return self.fail(format!(
                    "a vertex has the coordinate {}, expected a finite number below 3.4e38; repair the mesh or \
                     export it again",
                    shown(token)
                ));
            }
        }
        self.mesh.positions.push(position);
        Ok(())
    }

    /// A coordinate that is no number becomes NaN, which [`CornerUvs`] takes for none: the positions count.
    fn uv<'t>(&mut self, tokens: impl Iterator<Item = &'t [u8]>) -> Result<()> {
        let mut uv = [0.0; 2];
        let mut found = 0;
        // OBJ allows one-dimensional textures; their v is 0.
        for (x, token) in uv.iter_mut().zip(tokens) {
            *x = match number::<f32>(token) {
                Some(x) => x,
                None if is_not_finite(token) => f32::NAN,
                None => return Err(self.not_a_number(token)),
            };
            found += 1;
        }
        self.uvs.values.push(if found == 0 { [f32::NAN; 2] } else { uv });
        Ok(())
    }

    fn face<'t>(&mut self, tokens: impl Iterator<Item = &'t [u8]>, text: &[u8]) -> Result<()> {
        self.corners.clear();
        for token in tokens {
            let corner = self.corner(token)?;
            self.corners.push(corner);
        }
        if self.corners.len() < 3 && self.is_cut {
            return self.fail(format!(
                "the file ends in a face with {} corners, expected at least 3; it is cut short, export or copy it again",
                self.corners.len()
            ));
        }
        if self.corners.len() < 3 {
            self.notes.short_faces.add(self.line, || shown(text.trim_ascii()));
            return Ok(());
        }
        self.vertices.clear();
        for corner in &self.corners {
            self.vertices.push(corner.vertex);
            self.uvs.push(corner.uv);
        }
        self.mesh.faces.push(&self.vertices);
        self.materials.fill(self.mesh.faces.len());
        Ok(())
    }

    /// A corner: `vertex`, `vertex/texture`, `vertex//normal` or `vertex/texture/normal`. An index behind a
    /// slash may be missing, as some programs write it. That of the normal is not used.
    fn corner(&mut self, token: &[u8]) -> Result<Corner> {
        let mut parts = token.split(|&b| b == b'/');
        let (vertex, uv) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
        if parts.nth(1).is_some() {
            self.notes.long_corners.add(self.line, || shown(token));
        }
        let vertex = self.vertex_index(vertex)?;
        let uv = if uv.is_empty() { uvs::NONE } else { self.uv_index(uv)? };
        Ok(Corner { vertex, uv })
    }

    /// A vertex counted from 0, from one that counts from 1, or back from the last one so far.
    fn vertex_index(&mut self, token: &[u8]) -> Result<u32> {
        let given = self.whole_number(token, "vertex")?;
        let count = self.mesh.positions.len();
        if given > 0 {
            let index = given.unsigned_abs();
            if index > self.highest_vertex.index {
                self.highest_vertex = Highest { index, line: self.line };
            }
            // One that u32 cannot hold is above any count: `finish` reports it.
            return Ok(u32::try_from(index - 1).unwrap_or(u32::MAX));
        }
        back_from_the_last(given, count).ok_or_else(|| {
            self.error(format!(
                "vertex index {given}, expected 1 or above, or -1 to -{count} (back from the last one before \
                 this line)"
            ))
        })
    }

    /// The same for a texture coordinate. Whether it is there shows at the end.
    fn uv_index(&self, token: &[u8]) -> Result<u32> {
        let given = self.whole_number(token, "texture")?;
        let index = match given > 0 {
            true => u32::try_from(given - 1).ok(),
            false => back_from_the_last(given, self.uvs.values.len()),
        };
        Ok(index.unwrap_or(uvs::MISSING).min(uvs::MISSING))
    }

    fn whole_number(&self, token: &[u8], what: &str) -> Result<i64> {
        number(token).ok_or_else(|| {
            self.error(format!(
                "a face corner has the {what} index {}, expected a whole number",
                shown(token)
            ))
        })
    }

    fn finish(mut self) -> Result<Mesh> {
        self.past_the_last_vertex()?;
        let Notes { unknown, .. } = &self.notes;
        if unknown.count > 0 && self.mesh.positions.is_empty() {
            return Err(Error::unsupported_format(format!(
                "{}, line {}: found {}, expected statements of OBJ such as \"v 0 0 0\", but the file has no \
                 vertex; check that it is an OBJ file, and export it again",
                self.name, unknown.line, unknown.piece
            )));
        }
        self.notes.say(self.name);
        self.uvs.finish(&mut self.mesh, self.name);
        self.mesh.materials = self.materials.finish();
        Ok(self.mesh)
    }

    fn past_the_last_vertex(&self) -> Result<()> {
        let Highest { index, line } = self.highest_vertex;
        let (name, count) = (self.name, self.mesh.positions.len());
        let found = match count {
            _ if index <= count as u64 => return Ok(()),
            0 => format!("vertex index {index}, but the file has no vertex at all; it may be cut short"),
            _ => format!(
                "vertex index {index} is past the last vertex ({count}), expected 1 to {count}; the file may be \
                 cut short"
            ),
        };
        Err(Error::malformed(format!("{name}, line {line}: {found}"))
            .of_kind(InputErrorKind::Malformed { line: Some(line) }))
    }

    fn not_a_number(&self, token: &[u8]) -> Error {
        self.error(format!("found {}", not_a_number(token)))
    }

    fn fail<T>(&self, what: String) -> Result<T> {
        Err(self.error(what))
    }

    fn error(&self, what: String) -> Error {
        Error::malformed(format!("{}, line {}: {what}", self.name, self.line))
            .of_kind(InputErrorKind::Malformed { line: Some(self.line) })
    }
}

/// An index counted from 0, from one that counts back: -1 is the last of `count`.
fn back_from_the_last(given: i64, count: usize) -> Option<u32> {
    let back = given.unsigned_abs();
    u32::try_from((count as u64).checked_sub(back)?).ok().filter(|_| back != 0)
}
