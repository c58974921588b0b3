//! The buffers of a glTF document.

use ::gltf::json::Root;
use base64::Engine;
use percent_encoding::percent_decode_str;
use rhytid_core::{Error, InputErrorKind, Result, input_file, is_below};
use rhytid_gltf::meshopt::{self, CompressedView};
use std::cell::{Cell, OnceCell};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::ErrorKind;
use std::path::Path;
use std::rc::Rc;

/// Fetches what a relative URI refers to.
pub(in super::super) type External<'a> = &'a dyn Fn(&str) -> Result<Vec<u8>>;

/// The bytes of every buffer of a document.
pub(super) struct Buffers {
    /// `None` where the document names no source, and for a placeholder of compressed views.
    buffers: Vec<Option<Rc<[u8]>>>,
    /// The bytes of each compressed view, once somebody asked for them.
    unfolded: Vec<OnceCell<Box<[u8]>>>,
    /// All buffers of the file together, in bytes.
    stored: u64,
    /// What was unfolded from them, in bytes.
    spent: Cell<u64>,
}

/// The most unfolded bytes for each byte of the file's data. Many views may name the same bytes.
const MOST_UNFOLDED: u64 = 64;

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
        let mut stored = 0;
        for (i, buffer) in root.buffers.iter().enumerate() {
            let mut counted = |bytes: Vec<u8>| {
                stored += bytes.len() as u64;
                Rc::<[u8]>::from(bytes)
            };
            let data = match &buffer.uri {
                _ if meshopt::is_placeholder(buffer) => None,
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
        let unfolded = root.buffer_views.iter().map(|_| OnceCell::new()).collect();
        Ok(Self { buffers, unfolded, stored, spent: Cell::new(0) })
    }

    /// The bytes of the file's data, with what was unfolded from them.
    pub(super) fn total(&self) -> u64 {
        self.stored + self.spent.get()
    }

    /// How many bytes may still be unfolded.
    pub(super) fn allowed(&self) -> u64 {
        MOST_UNFOLDED.saturating_mul(self.stored).saturating_add(1 << 24).saturating_sub(self.spent.get())
    }

    /// Counts bytes that are unfolded.
    pub(super) fn spend(&self, bytes: u64, name: &str) -> Result<()> {
        if bytes > self.allowed() {
            return Err(self.too_much(name));
        }
        self.spent.set(self.spent.get() + bytes);
        Ok(())
    }

    /// The error of a file that unfolds to more than is allowed.
    pub(super) fn too_much(&self, name: &str) -> Error {
        Error::unsupported_format(format!(
            "{name}: unfolds to more than {} bytes from {} bytes of data, expected one face; export it without \
             compression",
            self.spent.get(),
            self.stored
        ))
    }

    /// Adds a buffer of unfolded bytes, and gives its index.
    pub(super) fn push(&mut self, bytes: Vec<u8>) -> usize {
        self.buffers.push(Some(bytes.into()));
        self.buffers.len() - 1
    }

    /// The bytes of buffer view `index`, and its stride if it has one.
    pub(super) fn view(&self, root: &Root, index: usize, name: &str) -> Result<(&[u8], Option<usize>)> {
        let fail = |what: &str| Error::malformed(format!("{name}: buffer view {index} {what}"));
        let view = root.buffer_views.get(index).ok_or_else(|| {
            fail(&format!(
                "does not exist, expected one of the {}; the file is damaged",
                root.buffer_views.len()
            ))
        })?;
        let stride = view.byte_stride.map(|stride| stride.0);
        let Some(compressed) = CompressedView::of(view).map_err(|what| fail(&what))? else {
            let (start, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
            return Ok((self.slice(view.buffer.value(), start, length, index, name)?, stride));
        };
        // A view that was added here has no place among those of the file, and is never compressed.
        let Some(unfolded) = self.unfolded.get(index) else { return Err(fail("does not exist")) };
        if let Some(bytes) = unfolded.get() {
            return Ok((bytes, stride));
        }
        let encoded =
            self.slice(compressed.buffer, compressed.byte_offset, compressed.byte_length, index, name)?;
        self.spend(compressed.decoded_length(), name)?;
        let bytes = compressed.decode(encoded).map_err(|what| fail(&what))?;
        Ok((unfolded.get_or_init(|| bytes.into()), stride))
    }

    /// A part of a buffer, for buffer view `index`.
    fn slice(&self, buffer: usize, start: u64, length: u64, index: usize, name: &str) -> Result<&[u8]> {
        let Some(Some(bytes)) = self.buffers.get(buffer) else {
            return Err(Error::malformed(format!(
                "{name}: buffer view {index} lies in buffer {buffer}, which has no data here; export the mesh \
                 as GLB without compression"
            )));
        };
        let range =
            usize::try_from(start).ok().zip(start.checked_add(length).and_then(|e| e.try_into().ok()));
        range.and_then(|(start, end): (usize, usize)| bytes.get(start..end)).ok_or_else(|| {
            Error::cut_short(format!(
                "{name}: buffer view {index} takes {length} bytes from byte {start} of buffer {buffer}, which \
                 has {}; the file may be cut short",
                bytes.len()
            ))
        })
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
    match input_file::is_regular(&file) {
        Ok(true) => input_file::read(&file, input_file::LARGEST_MESH_OR_TAKE),
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
