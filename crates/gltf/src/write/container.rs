//! The files that a glTF's bytes go to: one `.glb`, or `.gltf` with `.bin` beside it.
//!
//! The JSON is known last but comes first in a `.glb`. So the binary chunk waits in an unnamed file.

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use rhytid_core::{AtomicFile, Error, Progress, Remedy, Result, TextureFormat};
use rhytid_export::companion::Companion;
use rhytid_export::{Options, TextureFiles, companion};
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::Path;

/// The bytes of a GLB's header.
const GLB_HEADER: u64 = 12;
/// The bytes before each of its two chunks.
const CHUNK_HEADER: u64 = 8;

/// The characters that a URI escapes in a file name.
const IN_URI: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'_').remove(b'.').remove(b'~');

/// The numbers beside a `.gltf`.
static BIN: companion::Kind =
    companion::Kind { extension: "bin", namers: &["gltf"], names: |path| std::fs::read(path).ok() };

/// Copies of textures.
static PNG: companion::Kind = companion::Kind { extension: "png", namers: &["gltf", "glb"], names: json_of };
static JPEG: companion::Kind = companion::Kind { extension: "jpg", namers: &["gltf", "glb"], names: json_of };

/// The JSON of a `.gltf` or `.glb` file.
fn json_of(path: &Path) -> Option<Vec<u8>> {
    let mut file = File::open(path).ok()?;
    let mut head = [0; (GLB_HEADER + CHUNK_HEADER) as usize];
    let is_glb = file.read_exact(&mut head).is_ok() && head.starts_with(b"glTF");
    if !is_glb {
        return std::fs::read(path).ok();
    }
    let length = u32::from_le_bytes([head[12], head[13], head[14], head[15]]);
    let mut json = Vec::new();
    file.take(length.into()).read_to_end(&mut json).ok()?;
    Some(json)
}

/// How the JSON refers to a file beside it.
fn uri_of(companion: &Companion) -> String {
    let path = companion.path();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    utf8_percent_encode(&name, IN_URI).to_string()
}

/// The two kinds of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// All in one.
    Glb,
    /// JSON, with its numbers beside it.
    Gltf,
}

impl Kind {
    /// Where textures are if nobody says it.
    pub(super) fn default_textures(self) -> TextureFiles {
        match self {
            Self::Glb => TextureFiles::Embed,
            Self::Gltf => TextureFiles::Copy,
        }
    }
}

/// A `.glb` or a `.gltf` with its `.bin`, being written. Dropped before the end, it leaves nothing behind.
pub(super) struct Container {
    /// The `.glb` or `.gltf`.
    file: AtomicFile,
    bin: Bin,
    /// Bytes of the binary part so far.
    length: u64,
    limit: Limit,
    /// Copies of textures beside it.
    textures: Vec<Companion>,
    /// Bytes of the copies.
    of_textures: u64,
}

enum Bin {
    Chunk(BufWriter<File>),
    File(Box<Companion>),
}

/// How large a file may become.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    /// In bytes; all files together.
    pub bytes: u64,
    /// The size in words, and how to avoid the limit.
    pub sentence: &'static str,
    /// The settings that avoid the limit.
    pub remedies: &'static [Remedy],
}

impl Limit {
    /// The limit that `options` allow and the kind can hold.
    pub(super) fn new(kind: Kind, options: &Options) -> Self {
        match (options.force, kind) {
            (false, _) => Self {
                bytes: 1 << 30,
                sentence: "1 GiB, more than viewers are made for: write .usd, write fewer frames or shapes, \
                           make it smaller (compressed, quantised or with meshopt), or lift the limit",
                remedies: &[
                    Remedy::FewerFrames,
                    Remedy::Compress,
                    Remedy::Quantize,
                    Remedy::Meshopt,
                    Remedy::Force,
                ],
            },
            (true, Kind::Glb) => Self {
                bytes: u64::from(u32::MAX),
                sentence: "4 GiB, the most that a GLB file holds: write .usd or .gltf, write fewer frames or \
                           shapes, or make it smaller (compressed, quantised or with meshopt)",
                remedies: &[Remedy::FewerFrames, Remedy::Compress, Remedy::Quantize, Remedy::Meshopt],
            },
            (true, Kind::Gltf) => Self { bytes: u64::MAX, sentence: "any disk", remedies: &[] },
        }
    }
}

impl Container {
    pub(super) fn create(path: &Path, kind: Kind, limit: Limit) -> Result<Self> {
        let file = AtomicFile::create(path)?;
        let bin = match kind {
            Kind::Glb => Bin::Chunk(BufWriter::with_capacity(1 << 20, file.spool()?)),
            Kind::Gltf => Bin::File(Box::new(Companion::create(path, &BIN)?)),
        };
        Ok(Self { file, bin, length: 0, limit, textures: Vec::new(), of_textures: 0 })
    }

    /// The `.glb` or `.gltf`.
    pub(super) fn path(&self) -> &Path {
        self.file.path()
    }

    /// An unnamed file on the same disk.
    pub(super) fn spool(&self) -> Result<File> {
        self.file.spool()
    }

    /// Bytes of the binary part so far.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Adds a copy of a texture beside the file, and returns how the JSON refers to it.
    ///
    /// # Errors
    /// As [`Companion::create`] and [`Companion::write`].
    pub(super) fn add_texture(&mut self, bytes: &[u8], format: TextureFormat) -> Result<String> {
        let kind = match format {
            TextureFormat::Png => &PNG,
            TextureFormat::Jpeg => &JPEG,
        };
        let mut copy = Companion::create(self.path(), kind)?;
        copy.write(bytes)?;
        let uri = uri_of(&copy);
        self.textures.push(copy);
        self.of_textures += bytes.len() as u64;
        Ok(uri)
    }

    /// How the JSON refers to the binary part that was written so far; `None` in a `.glb`.
    pub(super) fn uri(&self) -> Option<String> {
        match &self.bin {
            Bin::File(bin) => Some(uri_of(bin)),
            Bin::Chunk(_) => None,
        }
    }

    /// Adds to the binary part.
    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.length += bytes.len() as u64;
        self.check(self.length)?;
        match &mut self.bin {
            Bin::Chunk(spool) => spool.write_all(bytes).map_err(self.file.error()),
            Bin::File(bin) => bin.write(bytes),
        }
    }

    fn check(&self, bytes: u64) -> Result<()> {
        if bytes <= self.limit.bytes {
            return Ok(());
        }
        Err(Error::too_large(format!(
            "{}: becomes larger than {}",
            self.path().display(),
            self.limit.sentence
        ))
        .with_remedies(self.limit.remedies))
    }

    /// Adds the JSON and gives the file (or both) its name. Returns the bytes written in all.
    pub(super) fn finish(mut self, mut json: Vec<u8>, progress: &dyn Progress) -> Result<u64> {
        // Both parts of a GLB are multiples of four bytes; the binary part's are so already.
        json.resize(json.len().next_multiple_of(4), b' ');
        let headers = match self.bin {
            Bin::Chunk(_) => GLB_HEADER + 2 * CHUNK_HEADER,
            Bin::File(_) => 0,
        };
        let bytes = headers + json.len() as u64 + self.length;
        self.check(bytes)?;
        let error = self.file.error();
        let mut companions = self.textures;
        // Everything that can fail is done before the first file gets its name.
        match self.bin {
            Bin::Chunk(spool) => {
                let spool = spool.into_inner().map_err(|e| self.file.error()(e.into_error()))?;
                glb(&mut self.file, bytes, &json, spool, self.length, progress)?;
            }
            Bin::File(bin) => {
                self.file.write_all(&json).and_then(|()| self.file.flush()).map_err(error)?;
                companions.push(*bin);
            }
        }
        companion::finish_all(companions, || self.file.finish())?;
        Ok(bytes + self.of_textures)
    }
}

/// Writes all of a GLB. `length` of the `bytes` are its binary chunk's.
fn glb(
    file: &mut AtomicFile,
    bytes: u64,
    json: &[u8],
    mut spool: File,
    length: u64,
    progress: &dyn Progress,
) -> Result<()> {
    let u32 = |number: u64| {
        u32::try_from(number).map(u32::to_le_bytes).map_err(|_| {
            Error::Internal(format!("a GLB file of {bytes} bytes was begun, which is more than it can hold"))
        })
    };
    let (total, json_length, bin_length) = (u32(bytes)?, u32(json.len() as u64)?, u32(length)?);
    let head = [b"glTF", &2_u32.to_le_bytes(), &total, &json_length, b"JSON", json, &bin_length, b"BIN\0"];
    file.write_all(&head.concat()).and_then(|()| spool.rewind()).map_err(file.error())?;
    let mut buffer = vec![0; 1 << 20];
    let mut left = length;
    loop {
        progress.report("writing", length - left, length);
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        if left == 0 {
            return Ok(());
        }
        let part = &mut buffer[..left.min(1 << 20) as usize];
        spool.read_exact(part).and_then(|()| file.write_all(part)).map_err(file.error())?;
        left -= part.len() as u64;
    }
}

/// A spool that was written, to be read from its start.
pub(super) fn rewound(mut spool: BufWriter<File>) -> io::Result<io::BufReader<File>> {
    spool.rewind()?;
    let file = spool.into_inner().map_err(io::IntoInnerError::into_error)?;
    Ok(io::BufReader::with_capacity(1 << 20, file))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    #[test]
    fn a_file_does_not_become_larger_than_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        for (name, kind) in [("face.glb", Kind::Glb), ("face.gltf", Kind::Gltf)] {
            let path = folder.path().join(name);
            let container = |bytes| {
                let limit = Limit { bytes, sentence: "that; write less", remedies: &[] };
                let mut container = Container::create(&path, kind, limit).unwrap();
                container.write(&[0; 60]).map(|()| container)
            };
            let sentence = |error: Error| match error {
                Error::Input(message) => message,
                other => panic!("{other:?}"),
            };
            let message = sentence(container(59).err().unwrap());
            assert!(
                message.sentence().ends_with(&format!("{name}: becomes larger than that; write less")),
                "{message}"
            );
            // The JSON, up to a multiple of four, and the headers count.
            let whole = if kind == Kind::Glb { 60 + 8 + 28 } else { 60 + 8 };
            let finish = |bytes| container(bytes).unwrap().finish(b"{     }".to_vec(), &NoProgress);
            assert!(sentence(finish(whole - 1).unwrap_err()).sentence().contains("becomes larger"));
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
            assert_eq!(finish(whole).unwrap(), whole);
            for entry in std::fs::read_dir(folder.path()).unwrap() {
                std::fs::remove_file(entry.unwrap().path()).unwrap();
            }
        }
    }
}
