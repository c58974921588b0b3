//! GLB with one morph target per frame.
//!
//! The JSON chunk comes first in the file and holds each target's bounds, which are known only when its frame
//! is. Its length does not depend on them (see [`document`]), so that room is left for it, the binary chunk is
//! streamed behind, and the JSON is written last.

mod document;
mod surface;

use super::{Exporter, Scene};
use document::{Bounds, Document};
use rhytid_core::{Error, Result, WriteBeside};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use surface::Surface;

/// The header, and what stands before each of the two chunks.
const HEADER: u64 = 12;
const CHUNK_HEADER: u64 = 8;

/// The weights are a square matrix whose elements are numbered by `u32`.
const MOST_FRAMES: usize = 65_535;

/// A `.glb` file being written.
pub(super) struct Glb {
    file: WriteBeside,
    document: Document,
    surface: Surface,
    /// Smallest and largest offsets of each frame so far.
    bounds: Vec<Bounds>,
    /// One frame's offsets of positions or normals.
    offsets: Vec<[f32; 3]>,
}

impl Glb {
    pub(super) fn create(path: &Path, scene: &Scene<'_>) -> Result<Self> {
        let surface = Surface::new(scene);
        let document = Document::new(scene, &surface);
        if !fits(&document, scene.frames) {
            return Err(too_large(path, scene, &document));
        }
        let file = WriteBeside::create(path)?;
        let offsets = Vec::with_capacity(surface.positions.len());
        let mut glb = Self { file, document, surface, bounds: Vec::new(), offsets };
        glb.write_static(scene.rate).map_err(glb.file.error())?;
        Ok(glb)
    }

    /// All of the binary chunk before the targets, in the order of the document's buffer views.
    fn write_static(&mut self, rate: f64) -> io::Result<()> {
        let frames = self.document.frames;
        let start = HEADER + CHUNK_HEADER + json_room(&self.document) + CHUNK_HEADER;
        self.file.seek(SeekFrom::Start(start))?;
        for index in &self.surface.indices {
            self.file.write_all(&index.to_le_bytes())?;
        }
        write_floats(&mut self.file, self.surface.positions.as_flattened())?;
        write_floats(&mut self.file, self.surface.normals.as_flattened())?;
        if let Some(uvs) = &self.surface.uvs {
            write_floats(&mut self.file, uvs.as_flattened())?;
        }
        for frame in 0..frames {
            self.file.write_all(&document::time(frame, rate).to_le_bytes())?;
        }
        // Frame k gives target k the weight 1: the weights' diagonal.
        for frame in 0..frames {
            self.file.write_all(&((frame * (frames + 1)) as u32).to_le_bytes())?;
        }
        for _ in 0..frames {
            self.file.write_all(&1_f32.to_le_bytes())?;
        }
        Ok(())
    }

    fn write_tail(&mut self) -> io::Result<()> {
        let room = json_room(&self.document);
        self.file.rewind()?;
        self.file.write_all(b"glTF")?;
        for number in [2, size(&self.document), room] {
            self.file.write_all(&(number as u32).to_le_bytes())?;
        }
        self.file.write_all(b"JSON")?;
        let mut json = Counted { out: &mut self.file, bytes: 0 };
        self.document.write(&mut json, &self.bounds)?;
        while json.bytes < room {
            json.write_all(b" ")?;
        }
        if json.bytes > room {
            return Err(io::Error::other("internal error: the JSON chunk outgrew its room"));
        }
        self.file.write_all(&(self.document.binary_size() as u32).to_le_bytes())?;
        self.file.write_all(b"BIN\0")
    }
}

impl Exporter for Glb {
    fn frame(&mut self, positions: &[f32], normals: &[f32]) -> Result<()> {
        self.surface.position_offsets(positions, &mut self.offsets);
        if let Some(vertex) = super::scene::first_not_finite(self.offsets.as_flattened()) {
            return Err(Error::input(format!(
                "{}: in frame {} (from 0), vertex {vertex} is farther from its rest position than a 32-bit \
                 number holds",
                self.file.path().display(),
                self.bounds.len()
            )));
        }
        self.bounds.push(document::bounds(&self.offsets));
        write_floats(&mut self.file, self.offsets.as_flattened()).map_err(self.file.error())?;
        self.surface.normal_offsets(normals, &mut self.offsets);
        write_floats(&mut self.file, self.offsets.as_flattened()).map_err(self.file.error())
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        self.write_tail().map_err(self.file.error())?;
        self.file.finish()
    }
}

fn write_floats(out: &mut impl Write, numbers: &[f32]) -> io::Result<()> {
    let mut bytes = [0; 4096];
    for block in numbers.chunks(bytes.len() / 4) {
        for (bytes, x) in bytes.chunks_exact_mut(4).zip(block) {
            bytes.copy_from_slice(&x.to_le_bytes());
        }
        out.write_all(&bytes[..block.len() * 4])?;
    }
    Ok(())
}

/// The JSON chunk's length: what the document takes, up to a multiple of four.
fn json_room(document: &Document) -> u64 {
    let mut count = Counted { out: io::sink(), bytes: 0 };
    document.write(&mut count, &[]).expect("a sink takes everything");
    count.bytes.next_multiple_of(4)
}

/// The whole file's length.
fn size(document: &Document) -> u64 {
    HEADER + CHUNK_HEADER + json_room(document) + CHUNK_HEADER + document.binary_size()
}

/// Lengths in a GLB file are 32-bit.
fn fits(document: &Document, frames: usize) -> bool {
    let document = document.with_frames(frames);
    // The cheap test first: the JSON of millions of frames takes a while to measure.
    frames <= MOST_FRAMES
        && document.binary_size() <= u64::from(u32::MAX)
        && size(&document) <= u64::from(u32::MAX)
}

fn too_large(path: &Path, scene: &Scene<'_>, document: &Document) -> Error {
    let (mut fit, mut too_many) = (0, scene.frames);
    while too_many - fit > 1 {
        let middle = fit + (too_many - fit) / 2;
        if fits(document, middle) { fit = middle } else { too_many = middle }
    }
    let advice = match fit {
        0 => "not even one fits: write .usda instead".to_owned(),
        _ => format!("{fit} fit: choose fewer with --frames, or write .usda instead"),
    };
    Error::input(format!(
        "{}: a GLB file ends at 4 GiB and holds at most {MOST_FRAMES} frames, and {} frames of {} vertices do \
         not fit; {advice}",
        path.display(),
        scene.frames,
        scene.rest.len()
    ))
}

/// Counts what passes through.
struct Counted<W> {
    out: W,
    bytes: u64,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
