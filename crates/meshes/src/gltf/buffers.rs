//! The buffers of a glTF document.

use ::gltf::json::Root;
use base64::Engine;
use percent_encoding::percent_decode_str;
use rhytid_core::{Error, InputErrorKind, Result, input_file, is_below};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::ErrorKind;
use std::path::Path;
use std::rc::Rc;

/// Fetches what a relative URI refers to.
pub(in super::super) type External<'a> = &'a dyn Fn(&str) -> Result<Vec<u8>>;

/// The bytes of every buffer of a document.
pub(super) struct Buffers {
    /// `None` where the document names no source: a placeholder that an unsupported extension would fill.
    buffers: Vec<Option<Rc<[u8]>>>,
    /// All of them together, in bytes.
    pub total: u64,
}

impl Buffers {
    pub(super) fn load(
        root: &Root,
        mut blob: Option<Vec<u8>>,
        name: &str,
        external: External<'_>,
    ) -> Result<Self> {
        let mut buffers: Vec<Option<Rc<[u8]>>> = Vec::new();
        // Each is read once, however many buffers it is.
        let mut files: HashMap<&str, Rc<[u8]>> = HashMap::new();
        let mut total = 0;
        for (i, buffer) in root.buffers.iter().enumerate() {
            let mut counted = |bytes: Vec<u8>| {
                total += bytes.len() as u64;
                Rc::<[u8]>::from(bytes)
            };
            let data = match &buffer.uri {
                Some(uri) if uri.starts_with("data:") => Some(counted(data_uri(uri).ok_or_else(|| {
                    Error::malformed(format!(
                        "{name}: buffer {i} is not valid base64 data; the file may be cut short or damaged"
                    ))
                })?)),
                Some(uri) => Some(match files.entry(uri) {
                    Entry::Occupied(entry) => Rc::clone(entry.get()),
                    Entry::Vacant(entry) => Rc::clone(entry.insert(counted(external(uri)?))),
                }),
                // The first buffer without a source is a GLB's own second half.
                None if i == 0 => blob.take().map(counted),
                None => None,
            };
            let expected = buffer.byte_length.0;
            if let Some(found) = data.as_ref().map(|data| data.len()).filter(|&n| (n as u64) < expected) {
                return Err(Error::cut_short(format!(
                    "{name}: buffer {i} has {found} bytes, expected {expected}; it is cut short"
                )));
            }
            buffers.push(data);
        }
        Ok(Self { buffers, total })
    }

    /// The bytes of buffer view `index`, and its stride if it has one.
    pub(super) fn view(&self, root: &Root, index: usize, name: &str) -> Result<(&[u8], Option<usize>)> {
        let fail = |what: String| Err(Error::malformed(format!("{name}: buffer view {index} {what}")));
        let Some(view) = root.buffer_views.get(index) else {
            return fail(format!(
                "does not exist, expected one of the {}; the file is damaged",
                root.buffer_views.len()
            ));
        };
        let buffer = view.buffer.value();
        let Some(Some(bytes)) = self.buffers.get(buffer) else {
            return fail(format!(
                "lies in buffer {buffer}, which has no data here; export the mesh as GLB without compression"
            ));
        };
        let (start, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
        let range =
            usize::try_from(start).ok().zip(start.checked_add(length).and_then(|e| e.try_into().ok()));
        match range.and_then(|(start, end): (usize, usize)| bytes.get(start..end)) {
            Some(slice) => Ok((slice, view.byte_stride.map(|stride| stride.0))),
            None => Err(Error::cut_short(format!(
                "{name}: buffer view {index} takes {length} bytes from byte {start} of buffer {buffer}, which has {}; the file may be cut \
                 short",
                bytes.len()
            ))),
        }
    }
}

/// Reads a file that the document `name` in `folder` refers to.
pub(in super::super) fn read_beside(folder: &Path, uri: &str, name: &str) -> Result<Vec<u8>> {
    if uri.contains("://") {
        return Err(Error::unsupported_format(format!(
            "{name}: keeps its numbers at {uri}, expected a file beside it; download it and save the mesh as GLB"
        )));
    }
    let decoded = percent_decode_str(uri).decode_utf8_lossy();
    let file = folder.join(&*decoded);
    let wrong =
        |what: &str| Error::bad_path(format!("{name}: keeps its numbers in {}, {what}", file.display()));
    if !is_below(folder, Path::new(&*decoded)) {
        return Err(wrong("expected a file beside it or below; put it there or save the mesh as GLB")
            .of_kind(InputErrorKind::OutsideFolder { file: file.clone() }));
    }
    match file.metadata() {
        Ok(found) if found.is_file() => input_file::read(&file, input_file::LARGEST_MESH_OR_TAKE),
        Ok(_) => Err(wrong("which is no file; save the mesh as GLB")),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            Err(wrong("which does not exist; put the two files together again or save the mesh as GLB")
                .of_kind(InputErrorKind::NotThere { file: file.clone() }))
        }
        Err(error) => Err(Error::io(&file)(error)),
    }
}

/// The bytes in a URI of base64 data.
pub(super) fn data_uri(uri: &str) -> Option<Vec<u8>> {
    let (head, data) = uri.split_once(',')?;
    head.ends_with(";base64").then(|| base64::prelude::BASE64_STANDARD.decode(data).ok())?
}
