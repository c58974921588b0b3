//! A file's JSON and its numbers. Numbers are read only when they are asked for.

use super::super::attributes::{self, Accessors};
use ::gltf::json::Root;
use ::gltf::json::mesh::Semantic;
use ::gltf::json::validation::Checked::{self, Valid};
use percent_encoding::percent_decode_str;
use rhytid_core::input_file::{self, InputFile};
use rhytid_core::{Error, InputErrorKind, Result, folder_of, is_below};

use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The binary part of a file.
pub(super) struct Source {
    file: InputFile,
    /// Of the binary part in `file`.
    start: u64,
    /// Of the binary part.
    length: u64,
    path: PathBuf,
}

/// A file's JSON.
pub(super) struct Document {
    pub root: Root,
    /// As [`attributes::of_targets`]; empty where no mesh has attributes of the application's own but
    /// vertices' numbers.
    pub targets: Vec<Vec<Accessors>>,
    /// Its text.
    pub json: Vec<u8>,
}

/// The JSON and the binary part of the `.glb` or `.gltf` file `path`.
pub(super) fn open(path: &Path) -> Result<(Document, Source)> {
    let file = input_file::open(path)?;
    let mut whole = Source::whole(file, path)?;
    let length = whole.length;
    if length >= 4 && whole.read(0, 4, "its first bytes")? == b"glTF" {
        return glb(whole);
    }
    if length > input_file::LARGEST_MESH_OR_TAKE {
        return Err(whole
            .fault("is far too large for the JSON of a .gltf".into())
            .of_kind(InputErrorKind::TooLarge));
    }
    let json = whole.read(0, length, "its JSON")?;
    let root = root(json, path)?;
    let bin = beside(&root.root, path)?;
    let wrong = |what: &str| {
        Err(Error::input(format!("{}: keeps its numbers in {}, {what}", path.display(), bin.display()))
            .of_kind(InputErrorKind::NotThere { file: bin.clone() }))
    };
    match input_file::is_regular(&bin) {
        Ok(true) if is_below(folder_of(path), Path::new(bin.file_name().unwrap_or_default())) => {}
        Ok(_) => return wrong("which is no file beside it; put the two files together again"),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            return wrong("which does not exist; put the two files together again");
        }
        Err(error) => return Err(Error::io(&bin)(error)),
    }
    let file = input_file::open(&bin)?;
    Ok((root, Source::whole(file, &bin)?))
}

/// A header of 12 bytes, then the chunks, of which the first two count.
fn glb(mut whole: Source) -> Result<(Document, Source)> {
    let header = whole.read(0, 12, "its header")?;
    let [_, version, announced] = words(&header);
    if version != 2 {
        return Err(whole
            .fault(format!("is a GLB file of version {version}, expected 2"))
            .of_kind(InputErrorKind::UnsupportedVersion));
    }
    if u64::from(announced) != whole.length {
        return Err(whole.fault(format!(
            "has {} bytes, expected the {announced} that its header announces; it is cut short or damaged",
            whole.length
        )).of_kind(InputErrorKind::CutShort));
    }
    let (json, next) = whole.chunk(12, *b"JSON")?;
    let json = whole.read(json.0, json.1, "its JSON")?;
    let ((start, length), _) = whole.chunk(next, *b"BIN\0")?;
    let root = root(json, &whole.path)?;
    if let Some(uri) = root.root.buffers.first().and_then(|buffer| buffer.uri.as_ref()) {
        return Err(whole.fault(format!("keeps its numbers in {uri}, expected all of them within the file")));
    }
    Ok((root, Source { start, length, ..whole }))
}

/// Three numbers of four bytes each.
fn words(bytes: &[u8]) -> [u32; 3] {
    let (words, _) = bytes.as_chunks::<4>();
    std::array::from_fn(|i| words.get(i).copied().map_or(0, u32::from_le_bytes))
}

impl Source {
    fn whole(mut file: InputFile, path: &Path) -> Result<Self> {
        let length = file.seek(SeekFrom::End(0)).map_err(Error::io(path))?;
        Ok(Self { file, start: 0, length, path: path.to_owned() })
    }

    /// `length` bytes from `offset` on; `what` they are.
    pub(super) fn read(&mut self, offset: u64, length: u64, what: &str) -> Result<Vec<u8>> {
        if offset.checked_add(length).is_none_or(|end| end > self.length) {
            return Err(self.fault(format!(
                "has {} bytes, and {what} would be {length} from byte {offset} on; the file is cut short or damaged",
                self.length
            )).of_kind(InputErrorKind::CutShort));
        }
        let mut bytes = vec![0; length as usize];
        let from = SeekFrom::Start(self.start + offset);
        let read = self.file.seek(from).and_then(|_| self.file.read_exact(&mut bytes));
        read.map_err(Error::io(&self.path))?;
        Ok(bytes)
    }

    /// The bytes of the file `uri` beside this one, at most one more than `expected`; `None` if there is no
    /// such file, or it is elsewhere.
    pub(super) fn beside(&self, uri: &str, expected: u64) -> Option<Vec<u8>> {
        let name = percent_decode_str(uri).decode_utf8_lossy();
        let name = Path::new(&*name);
        // Nothing outside the folder is opened.
        if uri.contains(':')
            || name.file_name() != Some(name.as_os_str())
            || !is_below(folder_of(&self.path), name)
        {
            return None;
        }
        let file = input_file::open(&self.path.with_file_name(name)).ok()?;
        let mut bytes = Vec::new();
        file.take(expected + 1).read_to_end(&mut bytes).ok()?;
        Some(bytes)
    }

    /// Where a chunk that begins at `at` has its data (start and length), and where the next chunk begins.
    fn chunk(&mut self, at: u64, kind: [u8; 4]) -> Result<((u64, u64), u64)> {
        let name = String::from_utf8_lossy(&kind[..3]).into_owned();
        let header = self.read(at, 8, &format!("the header of its {name} chunk"))?;
        if header[4..] != kind {
            return Err(self.fault(format!("has no {name} chunk at byte {at}; the file is damaged")));
        }
        let [length, ..] = words(&header);
        Ok(((at + 8, u64::from(length)), at + 8 + u64::from(length)))
    }

    fn fault(&self, what: String) -> Error {
        Error::malformed(format!("{}: {what}", self.path.display()))
    }
}

fn root(json: Vec<u8>, path: &Path) -> Result<Document> {
    let root = Root::from_slice(&json).map_err(|error| {
        Error::malformed(format!(
            "{}: its JSON is not that of a glTF file: {error}; the file may be cut short",
            path.display()
        ))
    })?;
    // Most files have none, and are not read twice.
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut semantics = primitives.flat_map(|primitive| primitive.attributes.keys());
    let is_own = |semantic: &Checked<Semantic>| matches!(semantic, Valid(Semantic::Extras(name)) if name != attributes::VERTEX_ID);
    let targets = if semantics.any(is_own) { attributes::of_targets(&json) } else { Vec::new() };
    Ok(Document { root, targets, json })
}

/// The file that a `.gltf` keeps its numbers in.
fn beside(root: &Root, path: &Path) -> Result<PathBuf> {
    let uri = root.buffers.first().and_then(|buffer| buffer.uri.as_deref());
    // A colon would be percent-encoded; as it is, it ends a scheme.
    let name = uri.filter(|uri| !uri.contains(':')).map(|uri| percent_decode_str(uri).decode_utf8_lossy());
    match name {
        // The `.bin` that Rhytid writes is in the same folder, and nothing else is opened.
        Some(name) if Path::new(&*name).file_name().is_some_and(|last| last == &*name) => {
            Ok(path.with_file_name(&*name))
        }
        _ => Err(Error::unsupported_format(format!(
            "{}: keeps its numbers in {}, expected a file beside it",
            path.display(),
            uri.map_or("no file".into(), |uri| format!("“{}”", uri.chars().take(80).collect::<String>()))
        ))),
    }
}
