//! Packages (`.usdz`): a zip file whose members are stored as they are. The first member is the layer to
//! open.

use super::source::Source;
use rhytid_core::{Error, InputErrorKind, Result};
use zip::{CompressionMethod, ZipArchive};

/// The layer to open.
pub(super) fn first_member(source: Source) -> Result<Source> {
    let len = source.len();
    let (bytes, name) = source.into_inner();
    let wrong = |what: String| Error::malformed(format!("{name}: {what}"));
    let damaged = |error: zip::result::ZipError| {
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
