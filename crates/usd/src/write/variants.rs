//! Variants of a prim, as text.
use super::text::write_metadata;
use crate::layer::{Fields, Prim};
use rhytid_core::{AtomicFile, Result};
use std::io::{self, Write};
use std::path::Path;

/// Writes a layer with one prim, which has a variant set: the name and the metadata of each variant. Returns
/// the size in bytes.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if the folder does not exist; [`rhytid_core::Error::Io`].
pub(crate) fn write_variants(
    path: &Path,
    metadata: &Fields,
    prim: &Prim,
    set: &str,
    variants: &[(String, Fields)],
) -> Result<u64> {
    let mut text = Vec::new();
    let mut file = AtomicFile::create(path)?;
    let name_path = file.error();
    text_of(&mut text, metadata, prim, set, variants)
        .and_then(|()| file.write_all(&text))
        .map_err(name_path)?;
    file.finish()?;
    Ok(text.len() as u64)
}

fn text_of(
    out: &mut dyn Write,
    metadata: &Fields,
    prim: &Prim,
    set: &str,
    variants: &[(String, Fields)],
) -> io::Result<()> {
    write!(out, "#usda 1.0")?;
    write_metadata(out, "", metadata)?;
    write!(out, "\n\ndef {} \"{}\"", prim.type_name, prim.name)?;
    write_metadata(out, "", &prim.metadata)?;
    writeln!(out, "\n{{\n    variantSet \"{set}\" = {{")?;
    for (name, metadata) in variants {
        write!(out, "        \"{name}\"")?;
        write_metadata(out, "        ", metadata)?;
        writeln!(out, " {{\n        }}")?;
    }
    writeln!(out, "    }}\n}}")
}
