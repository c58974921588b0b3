//! The six sections that describe the contents of a crate file.

use super::super::budget::Budget;
use super::super::source::Source;
use super::cursor::Cursor;
use super::value_rep::ValueRep;
use rhytid_core::{InputErrorKind, Result};

/// The header: a mark, the version, where the table of contents is.
const HEADER: u64 = 88;
/// Sections in the table of contents that are looked at; all versions have six.
const MOST_SECTIONS: u64 = 64;

/// What the sections hold. Indices into each other are checked where they are used.
pub(super) struct Structure {
    /// Minor version; the major one is 0.
    pub(super) minor: u8,
    pub(super) tokens: Vec<String>,
    /// Strings are tokens.
    pub(super) strings: Vec<u32>,
    pub(super) fields: Vec<Field>,
    /// Indices into `fields`; each set ends with [`Structure::END_OF_SET`].
    pub(super) field_sets: Vec<u32>,
    /// `None` for a path that the tree does not have.
    pub(super) paths: Vec<Option<Node>>,
    pub(super) specs: Vec<Spec>,
}

/// A name and a value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field {
    pub(super) name: u32,
    pub(super) value: ValueRep,
}

/// A path: the last element and the path before it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// `None` for the root.
    pub(super) parent: Option<u32>,
    pub(super) name: u32,
    pub(super) is_property: bool,
}

/// An object: its path, its fields and its kind.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spec {
    pub(super) path: u32,
    pub(super) field_set: u32,
    /// One of the constants below, or another.
    pub(super) kind: u32,
}

impl Spec {
    pub(super) const ATTRIBUTE: u32 = 1;
    pub(super) const PRIM: u32 = 6;
    pub(super) const ROOT: u32 = 7;
    pub(super) const RELATIONSHIP: u32 = 8;
}

impl Structure {
    pub(super) const END_OF_SET: u32 = u32::MAX;

    pub(super) fn read(source: &mut Source, budget: &mut Budget) -> Result<Self> {
        let mut header = Cursor::new(source, 8, "its header");
        let [major, minor, ..] = header.array::<8>()?;
        // From 0.4 on sections are compressed as they are now; later versions only add types of values.
        if major != 0 || !(4..=14).contains(&minor) {
            return Err(source.wrong(format_args!(
                "is binary USD of version {major}.{minor}, expected 0.4 to 0.14; write it anew with `usdcat`"
            )).of_kind(InputErrorKind::UnsupportedVersion));
        }
        let contents = header.u64()?;
        let mut reader = Sections::find(source, contents, budget)?;
        let tokens = reader.tokens()?;
        let strings = reader.strings()?;
        let fields = reader.fields()?;
        let field_sets = reader.field_sets()?;
        let paths = reader.paths()?;
        let specs = reader.specs()?;
        Ok(Self { minor, tokens, strings, fields, field_sets, paths, specs })
    }
}

/// Where the sections are.
struct Sections<'a> {
    source: &'a mut Source,
    budget: &'a mut Budget,
    /// Name, first byte, end.
    table: Vec<(Vec<u8>, u64, u64)>,
}

impl<'a> Sections<'a> {
    fn find(source: &'a mut Source, at: u64, budget: &'a mut Budget) -> Result<Self> {
        let len = source.len();
        let mut cursor = Cursor::new(source, at, "its table of contents");
        let count = cursor.u64()?;
        if at < HEADER || count > MOST_SECTIONS {
            return Err(cursor.damaged(format_args!("{count} sections listed at byte {at} make no sense")));
        }
        let mut table = Vec::new();
        for _ in 0..count {
            let name: [u8; 16] = cursor.array()?;
            let name: Vec<u8> = name.into_iter().take_while(|&c| c != 0).collect();
            let (start, size) = (cursor.u64()?, cursor.u64()?);
            match start.checked_add(size) {
                Some(end) if start >= HEADER && end <= len => table.push((name, start, end)),
                _ => {
                    let name = String::from_utf8_lossy(&name).into_owned();
                    let fault =
                        format!("section {name} of {size} bytes from byte {start} on is not in the file");
                    return Err(cursor.damaged(fault));
                }
            }
        }
        Ok(Self { source, budget, table })
    }

    /// The section called `name`, and the number of things in it, for each of which `each` bytes are needed.
    fn section(&mut self, name: &'static str, what: &'static str, each: u64) -> Result<(Cursor<'_>, usize)> {
        let Some(&(_, start, end)) = self.table.iter().find(|(n, ..)| n == name.as_bytes()) else {
            return Err(self.source.wrong(format_args!(
                "has no section {name}, expected one; the file is damaged, export it again"
            )));
        };
        let mut cursor = Cursor::section(self.source, start, end, what);
        let count = cursor.u64()?;
        // Nothing compresses better than 255 × 4 to one; integers, for which that is, take no bytes beyond.
        if count > cursor.left().saturating_mul(1020) || !self.budget.take(count.saturating_mul(each)) {
            return Err(cursor.damaged(format_args!("{} bytes cannot hold {count} of them", cursor.left())));
        }
        let count = usize::try_from(count).map_err(|_| cursor.damaged("too many for this machine"))?;
        Ok((cursor, count))
    }

    fn tokens(&mut self) -> Result<Vec<String>> {
        let (mut cursor, count) = self.section("TOKENS", "section TOKENS", 32)?;
        let len = cursor.u64()?;
        if !Budget::of_file(cursor.left()).take(len) {
            return Err(cursor.damaged(format_args!("{} bytes cannot hold {len} of text", cursor.left())));
        }
        let text = cursor.compressed(len)?;
        let mut tokens = Vec::with_capacity(count);
        for token in text.split_inclusive(|&c| c == 0).take(count) {
            let token = token.strip_suffix(&[0]).and_then(|token| str::from_utf8(token).ok());
            let token = token.ok_or_else(|| {
                cursor.damaged(format_args!("token {} is not UTF-8 with a zero behind it", tokens.len()))
            })?;
            tokens.push(token.to_owned());
        }
        if tokens.len() != count {
            return Err(cursor.damaged(format_args!("holds {} tokens, expected {count}", tokens.len())));
        }
        Ok(tokens)
    }

    fn strings(&mut self) -> Result<Vec<u32>> {
        let (mut cursor, count) = self.section("STRINGS", "section STRINGS", 8)?;
        Ok(cursor.elements(count as u64)?.into_iter().map(u32::from_le_bytes).collect())
    }

    fn fields(&mut self) -> Result<Vec<Field>> {
        let (mut cursor, count) = self.section("FIELDS", "section FIELDS", 32)?;
        let names = cursor.integers(count)?;
        let values = cursor.compressed(count as u64 * 8)?;
        let values = values.as_chunks().0.iter().map(|bytes| ValueRep(u64::from_le_bytes(*bytes)));
        Ok(names.into_iter().zip(values).map(|(name, value)| Field { name: name as u32, value }).collect())
    }

    fn field_sets(&mut self) -> Result<Vec<u32>> {
        let (mut cursor, count) = self.section("FIELDSETS", "section FIELDSETS", 8)?;
        Ok(cursor.integers(count)?.into_iter().map(|i| i as u32).collect())
    }

    fn specs(&mut self) -> Result<Vec<Spec>> {
        let (mut cursor, count) = self.section("SPECS", "section SPECS", 24)?;
        let [paths, field_sets, kinds] =
            [cursor.integers(count)?, cursor.integers(count)?, cursor.integers(count)?];
        let specs = paths.into_iter().zip(field_sets).zip(kinds);
        let spec = |((path, field_set), kind)| Spec {
            path: path as u32,
            field_set: field_set as u32,
            kind: kind as u32,
        };
        Ok(specs.map(spec).collect())
    }

    /// The tree of paths, depth first. Each entry has three numbers: its path, its last element (negative for
    /// a property) and a jump.
    ///
    /// The jump −2 ends a branch. −1 means that the entry has children only, which come next. 0 means that it
    /// has a sibling only, which comes next. A jump above 0 means both: the children come next, and the
    /// sibling is that many entries further.
    fn paths(&mut self) -> Result<Vec<Option<Node>>> {
        let (mut cursor, count) = self.section("PATHS", "section PATHS", 48)?;
        let entries = cursor.u64()?;
        let entries = usize::try_from(entries).ok().filter(|&n| n <= count).ok_or_else(|| {
            cursor.damaged(format_args!("{entries} entries for {count} paths, expected no more than these"))
        })?;
        let indices = cursor.integers(entries)?;
        let names = cursor.integers(entries)?;
        let jumps = cursor.integers(entries)?;
        let mut nodes = vec![None; count];
        // Entries still to be visited, with their parents.
        let mut open = if entries > 0 { vec![(0, None)] } else { Vec::new() };
        while let Some((entry, parent)) = open.pop() {
            let fault = |what: &str| cursor.damaged(format_args!("entry {entry} {what}"));
            let Some((&index, &jump)) = indices.get(entry).zip(jumps.get(entry)) else {
                return Err(fault("is referred to and not there"));
            };
            let node = nodes
                .get_mut(index as u32 as usize)
                .ok_or_else(|| fault("names a path that is not there"))?;
            // This check also prevents cycles: no path is visited twice.
            if node.is_some() {
                return Err(fault("names a path that another one names"));
            }
            let name = names[entry];
            *node = Some(Node { parent, name: name.unsigned_abs(), is_property: name < 0 });
            let child = Some(index as u32);
            match jump {
                -2 => {}
                -1 => open.push((entry + 1, child)),
                0 => open.push((entry + 1, parent)),
                1.. => open.extend([(entry + jump as usize, parent), (entry + 1, child)]),
                _ => return Err(fault("has a jump below −2")),
            }
        }
        Ok(nodes)
    }
}
