//! Packages (`.usdz`): a zip file whose members are stored as they are. The first member is the layer to
//! open.

use super::source::Source;
use rhytid_core::{Error, InputErrorKind, Result};
use std::io::{Cursor, Read, Seek};
use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

/// The bytes of the file `asset` in a package, a path that the package's first member names: relative to that
/// member or, without `./`, to the package. `None` if the package has no such file. `name` is for messages.
///
/// # Errors
/// [`Error::Input`] if the package is damaged.
pub fn package_member(bytes: &[u8], name: &str, asset: &str) -> Result<Option<Vec<u8>>> {
    // The members of a package are stored as they are, so that none is larger than the package.
    member_of(Cursor::new(bytes), name, asset, bytes.len() as u64)
}

/// As [`package_member`], and at most `limit` bytes of the file.
pub(super) fn member_of(
    package: impl Read + Seek,
    name: &str,
    asset: &str,
    limit: u64,
) -> Result<Option<Vec<u8>>> {
    let damaged = |error: &dyn std::fmt::Display| {
        Error::malformed(format!("{name}: {asset} cannot be read ({error}); export it again"))
    };
    let mut archive = ZipArchive::new(package).map_err(|error| damaged(&error))?;
    let first = match archive.by_index_raw(0) {
        Ok(first) => first.name().map_err(|error| damaged(&error))?.into_owned(),
        Err(error) => return Err(damaged(&error)),
    };
    let folder = first.rsplit_once('/').map_or("", |(folder, _)| folder);
    for candidate in [normal(&format!("{folder}/{asset}")), normal(asset)] {
        let mut member = match archive.by_name(&candidate) {
            Ok(member) => member,
            Err(ZipError::FileNotFound) => continue,
            Err(error) => return Err(damaged(&error)),
        };
        let mut found = Vec::new();
        member.by_ref().take(limit).read_to_end(&mut found).map_err(|error| damaged(&error))?;
        return Ok(Some(found));
    }
    Ok(None)
}

/// A path without `.` and `..`.
fn normal(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// The layer to open.
pub(super) fn first_member(source: Source) -> Result<Source> {
    let len = source.len();
    let (bytes, name) = source.into_inner();
    let wrong = |what: String| Error::malformed(format!("{name}: {what}"));
    let damaged = |error: ZipError| {
        wrong(format!(
            "its list of members cannot be read ({error}); the file is cut short or damaged, export it again"
        ))
    };
    let mut archive = ZipArchive::new(bytes).map_err(damaged)?;
    if archive.is_empty() {
        return Err(wrong("has no members, expected a USD layer as the first; export it again".into())
            .of_kind(InputErrorKind::Empty));
    }
    let (member, start, size) = {
        let member = archive.by_index_raw(0).map_err(damaged)?;
        let named = member.name().map_err(damaged)?.into_owned();
        if member.compression() != CompressionMethod::Stored || member.encrypted() {
            return Err(wrong(format!(
                "its first member {named} is compressed or encrypted, expected it stored as a USD package has it; \
                 export it again"
            )).of_kind(InputErrorKind::UnsupportedFormat));
        }
        (named, member.data_start(), member.size())
    };
    let start = start.filter(|start| start.checked_add(size).is_some_and(|end| end <= len));
    let start = start.ok_or_else(|| {
        wrong(format!("its first member {member} of {size} bytes goes beyond its end; the file is damaged, export it again"))
    })?;
    if member.to_ascii_lowercase().ends_with(".usdz") {
        return Err(wrong(format!(
            "its first member {member} is a package, expected a USD layer; export it again"
        ))
        .of_kind(InputErrorKind::UnsupportedFormat));
    }
    let inner = format!("{name}[{member}]");
    Ok(Source::new(archive.into_inner(), name.clone())?.part(start, size, inner))
}
