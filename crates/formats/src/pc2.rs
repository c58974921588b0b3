//! PC2, the point cache of 3ds Max, which Blender, Houdini and plug-ins of Maya also read. It holds positions
//! of vertices, frame after frame, and nothing else. The other program needs the mesh already, with the
//! vertices in the order of the neutral.
//!
//! All numbers are little endian. The header has 32 bytes:
//!
//! - the 12 bytes `POINTCACHE2\0`,
//! - the version 1 and the number of points (i32),
//! - the number of the first frame, and the samples in a frame, 1 (f32),
//! - the number of samples (i32).
//!
//! Then each sample has x, y and z of its points (f32), in mesh units along the mesh's own axes.

use rhytid_core::{AtomicFile, Error, Progress, Result};
use rhytid_export::{Exporter, Frame, Scene, Written};
use std::io::Write;
use std::path::Path;

const MAGIC: &[u8; 12] = b"POINTCACHE2\0";
const HEADER: usize = 32;

/// A point cache being written.
pub(crate) struct PointCache {
    file: AtomicFile,
    /// Bytes written so far.
    bytes: u64,
    frame: Vec<u8>,
}

impl PointCache {
    /// Writes the header.
    ///
    /// # Errors
    /// [`Error::Input`] if the header cannot hold the number of points or frames, or the folder does not
    /// exist; [`Error::Io`].
    pub(crate) fn create(path: &Path, scene: &Scene<'_>) -> Result<Self> {
        let number = |what: &str, n: usize| {
            i32::try_from(n).map_err(|_| {
                let most = i32::MAX;
                Error::too_large(format!(
                    "{}: has {n} {what}, and a point cache holds at most {most}",
                    path.display()
                ))
            })
        };
        let mut header = MAGIC.to_vec();
        header.extend(1_i32.to_le_bytes());
        header.extend(number("vertices", scene.rest.len())?.to_le_bytes());
        header.extend((scene.first_time_code as f32).to_le_bytes());
        header.extend(1_f32.to_le_bytes());
        header.extend(number("frames", scene.frames)?.to_le_bytes());
        let mut file = AtomicFile::create(path)?;
        file.write_all(&header).map_err(file.error())?;
        Ok(Self { file, bytes: HEADER as u64, frame: Vec::new() })
    }
}

impl Exporter for PointCache {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        self.frame.clear();
        self.frame.extend(frame.positions().iter().flat_map(|x| x.to_le_bytes()));
        let name_path = self.file.error();
        self.file.write_all(&self.frame).map_err(name_path)?;
        self.bytes += self.frame.len() as u64;
        Ok(())
    }

    fn finish(self: Box<Self>, _progress: &dyn Progress) -> Result<Written> {
        self.file.finish()?;
        Ok(Written { bytes: self.bytes, targets: None, errors: Vec::new() })
    }
}
