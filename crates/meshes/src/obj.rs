//! Wavefront OBJ: `v`, `vt`, `f` and `usemtl`. An own reader, so that every message has its line and polygons
//! stay whole.

use super::check::representable;
use super::materials::Assigned;
use super::uvs::{uvs_from_corners, warn_partial_uvs};
use rhytid_core::{Error, InputErrorKind, Mesh, Result};
use std::borrow::Cow;

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

pub(super) fn decode(bytes: &[u8], name: &str) -> Result<Mesh> {
    let mut reader = Reader { name, line: 0, ..Reader::default() };
    let mut lines = Lines { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), next_number: 1 };
    while let Some((number, line)) = lines.next() {
        reader.line = number;
        reader.statement(&line)?;
    }
    reader.finish()
}

/// The statements of a file.
pub(super) fn statements(bytes: &[u8]) -> impl Iterator<Item = Cow<'_, [u8]>> {
    let mut lines = Lines { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), next_number: 1 };
    std::iter::from_fn(move || lines.next().map(|(_, statement)| statement))
}

/// Statements: lines, joined where one ends with a backslash.
struct Lines<'a> {
    rest: &'a [u8],
    next_number: usize,
}

impl<'a> Lines<'a> {
    /// The next statement and the number of its first line.
    fn next(&mut self) -> Option<(usize, Cow<'a, [u8]>)> {
        let number = self.next_number;
        let mut line = Cow::Borrowed(self.physical()?);
        // A comment is never continued: it may end with the name of a Windows folder.
        if line.trim_ascii_start().first() == Some(&b'#') {
            return Some((number, line));
        }
        while line.last() == Some(&b'\\') {
            let joined = line.to_mut();
            joined.pop();
            joined.push(b' ');
            let Some(next) = self.physical() else { break };
            joined.extend_from_slice(next);
        }
        Some((number, line))
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|&b| b == b'\n').unwrap_or(self.rest.len());
        let line = &self.rest[..end];
        self.rest = self.rest.get(end + 1..).unwrap_or_default();
        self.next_number += 1;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

/// The highest index seen and its line, for the check that can only be made at the end: OBJ lets a face stand
/// before its vertices.
#[derive(Default, Clone, Copy)]
struct Highest {
    index: u64,
    line: usize,
}

#[derive(Default)]
struct Reader<'a> {
    name: &'a str,
    line: usize,
    mesh: Mesh,
    uvs: Vec<[f32; 2]>,
    /// As long as every corner so far has one.
    uv_corners: Vec<u32>,
    corners_without_uv: usize,
    materials: Assigned,
    highest_vertex: Highest,
    highest_uv: Highest,
    unknown: usize,
    first_unknown: (usize, String),
    face: Vec<u32>,
}

impl Reader<'_> {
    fn statement(&mut self, line: &[u8]) -> Result<()> {
        let mut tokens = line
            .split(u8::is_ascii_whitespace)
            .filter(|token| !token.is_empty())
            .take_while(|token| token[0] != b'#');
        match tokens.next() {
            None => Ok(()),
            Some(b"v") => self.vertex(tokens),
            Some(b"vt") => self.uv(tokens),
            Some(b"f" | b"fo") => self.face(tokens),
            Some(b"usemtl") => {
                self.material(line);
                Ok(())
            }
            Some(keyword) if IGNORED.contains(&keyword) => Ok(()),
            Some(keyword) => {
                if self.unknown == 0 {
                    self.first_unknown = (self.line, shown(keyword));
                }
                self.unknown += 1;
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

    fn uv<'t>(&mut self, mut tokens: impl Iterator<Item = &'t [u8]>) -> Result<()> {
        let Some(first) = tokens.next() else {
            return self
                .fail("a texture coordinate has no numbers, expected 2; the file may be cut short".into());
        };
        let mut uv = [0.0; 2];
        // OBJ allows one-dimensional textures; their v is 0.
        for (x, token) in uv.iter_mut().zip(std::iter::once(first).chain(tokens)) {
            *x = number::<f32>(token).ok_or_else(|| self.not_a_number(token))?;
            if !x.is_finite() {
                return self.fail(format!(
                    "a texture coordinate is {}, expected a finite number; repair the texture map or export the \
                     mesh without it",
                    shown(token)
                ));
            }
        }
        self.uvs.push(uv);
        Ok(())
    }

    /// Names may have blanks in them.
    fn material(&mut self, line: &[u8]) {
        let text = String::from_utf8_lossy(line);
        let text = text.split_once(" #").map_or(&*text, |(before, _comment)| before);
        let name = text.trim().strip_prefix("usemtl").unwrap_or_default().trim();
        self.materials.choose((!name.is_empty()).then(|| name.to_owned()));
    }

    fn face<'t>(&mut self, tokens: impl Iterator<Item = &'t [u8]>) -> Result<()> {
        let mut face = std::mem::take(&mut self.face);
        face.clear();
        for token in tokens {
            let mut parts = token.split(|&b| b == b'/');
            let (vertex, uv) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
            if token.ends_with(b"/") {
                return self.fail(format!(
                    "a face corner is {}, expected an index after the slash; the file may be cut short",
                    shown(token)
                ));
            }
            // What follows is the index of a normal, which is not used.
            if parts.nth(1).is_some() {
                return self.fail(format!(
                    "a face corner is {}, expected at most vertex/texture/normal",
                    shown(token)
                ));
            }
            let (index, highest) =
                self.index(vertex, "vertex", self.mesh.positions.len(), self.highest_vertex)?;
            self.highest_vertex = highest;
            face.push(index);
            if uv.is_empty() {
                self.corners_without_uv += 1;
            } else {
                let (index, highest) = self.index(uv, "texture", self.uvs.len(), self.highest_uv)?;
                self.highest_uv = highest;
                if self.corners_without_uv == 0 {
                    self.uv_corners.push(index);
                }
            }
        }
        if face.len() < 3 {
            return self.fail(format!(
                "a face has {} corners, expected at least 3; the file may be cut short",
                face.len()
            ));
        }
        self.mesh.faces.push(&face);
        self.materials.fill(self.mesh.faces.len());
        self.face = face;
        Ok(())
    }

    /// An index counted from 0, from one that counts from 1, or back from the last of the `count` so far.
    fn index(&self, token: &[u8], what: &str, count: usize, highest: Highest) -> Result<(u32, Highest)> {
        let Some(given) = number::<i64>(token) else {
            return self.fail(format!(
                "a face corner has the {what} index {}, expected a whole number",
                shown(token)
            ));
        };
        if given > 0 {
            let index = given.unsigned_abs();
            let highest = if index > highest.index { Highest { index, line: self.line } } else { highest };
            // One that u32 cannot hold is above any count: `finish` reports it.
            return Ok((u32::try_from(index - 1).unwrap_or(u32::MAX), highest));
        }
        let back = given.unsigned_abs();
        match u32::try_from((count as u64).wrapping_sub(back)) {
            Ok(index) if back != 0 && back <= count as u64 => Ok((index, highest)),
            _ => self.fail(format!(
                "{what} index {given}, expected 1 or above, or -1 to -{count} (back from the last one before \
                 this line)"
            )),
        }
    }

    fn finish(mut self) -> Result<Mesh> {
        self.past_the_end("vertex", "vertex", self.highest_vertex, self.mesh.positions.len())?;
        self.past_the_end("texture", "texture coordinate", self.highest_uv, self.uvs.len())?;
        if self.unknown > 0 {
            log::warn!(
                "{}: {} lines have statements that are not OBJ and were skipped, the first is line {}: {}",
                self.name,
                self.unknown,
                self.first_unknown.0,
                self.first_unknown.1
            );
        }
        let corners = self.mesh.faces.indices.len();
        if self.corners_without_uv == 0 && corners > 0 {
            let vertices = self.mesh.positions.len();
            let uvs = uvs_from_corners(self.uvs, self.uv_corners, vertices, &self.mesh.faces.indices);
            self.mesh.uvs = Some(uvs);
        } else if self.corners_without_uv < corners {
            warn_partial_uvs(self.name, self.corners_without_uv, corners);
        }
        self.mesh.materials = self.materials.finish();
        Ok(self.mesh)
    }

    fn past_the_end(&self, what: &str, thing: &str, highest: Highest, count: usize) -> Result<()> {
        let Highest { index, line } = highest;
        let name = self.name;
        match count {
            _ if index <= count as u64 => Ok(()),
            0 => Err(Error::malformed(format!(
                "{name}, line {line}: {what} index {index}, but the file has no {thing} at all; it may be cut \
                 short"
            )).of_kind(InputErrorKind::Malformed { line: Some(line) })),
            _ => Err(Error::malformed(format!(
                "{name}, line {line}: {what} index {index} is past the last {thing} ({count}), expected 1 to \
                 {count}; the file may be cut short"
            )).of_kind(InputErrorKind::Malformed { line: Some(line) })),
        }
    }

    fn not_a_number(&self, token: &[u8]) -> Error {
        self.error(format!("found {}, expected a number; the file may be damaged", shown(token)))
    }

    fn fail<T>(&self, what: String) -> Result<T> {
        Err(self.error(what))
    }

    fn error(&self, what: String) -> Error {
        Error::malformed(format!("{}, line {}: {what}", self.name, self.line))
            .of_kind(InputErrorKind::Malformed { line: Some(self.line) })
    }
}

fn number<T: std::str::FromStr>(token: &[u8]) -> Option<T> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// A piece of the file for a message: quoted, escaped, not too long.
fn shown(token: &[u8]) -> String {
    format!("{:?}", String::from_utf8_lossy(&token[..token.len().min(40)]))
}
