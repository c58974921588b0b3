//! USD packages: a zip archive with a binary layer and the images that it names. Each is not compressed and
//! begins at a multiple of 64 bytes, so that USD can map it into memory.
use super::crate_file::CrateWriter;
use super::layer_writer::Member;
use super::sample::Sample;
use crate::layer::Layer;
use rhytid_core::{AtomicFile, Error, Remedy, Result};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// USD reads archives whose numbers have 32 bits; all headers together are smaller than what this leaves for
/// them.
const LARGEST_LAYER: u64 = u32::MAX as u64 - (1 << 20);

/// A `.usdz` file being written. Its layer is spooled, since the archive tells its size and checksum first.
pub(super) struct PackageWriter {
    file: AtomicFile,
    layer: CrateWriter<BufWriter<File>>,
    /// The files behind the layer.
    members: Vec<Member>,
    /// Their bytes.
    of_members: u64,
}

impl PackageWriter {
    /// Writes everything of `layer` but samples.
    pub(super) fn create(file: AtomicFile, layer: &Layer, members: Vec<Member>) -> Result<Self> {
        let spool = BufWriter::with_capacity(1 << 20, file.spool()?);
        let layer = CrateWriter::create(spool, layer).map_err(file.error())?;
        let of_members = members.iter().map(|member| member.bytes.len() as u64).sum();
        check_size(&file, layer.position() + of_members)?;
        Ok(Self { file, layer, members, of_members })
    }

    /// Adds a sample to the attribute that has the number; its times ascend.
    pub(super) fn sample(&mut self, number: usize, time: f64, sample: Sample<'_>) -> Result<()> {
        self.layer.sample(number, time, sample).map_err(self.file.error())?;
        check_size(&self.file, self.layer.position() + self.of_members)
    }

    /// Packs the layer and the other files, and returns the package's size in bytes.
    pub(super) fn finish(self) -> Result<u64> {
        let (spool, size) = self.layer.finish().map_err(self.file.error())?;
        check_size(&self.file, size + self.of_members)?;
        let name_path = self.file.error();
        let (file, size) = pack(self.file, spool, &self.members).map_err(name_path)?;
        file.finish()?;
        Ok(size)
    }
}

fn check_size(file: &AtomicFile, size: u64) -> Result<()> {
    if size <= LARGEST_LAYER {
        return Ok(());
    }
    Err(Error::too_large(format!(
        "{}: a USD package holds at most 4 GiB, and this is more; write .usd, or fewer frames",
        file.path().display()
    ))
    .with_remedies(&[Remedy::FewerFrames]))
}

/// The archive with its size.
fn pack(file: AtomicFile, mut layer: BufWriter<File>, members: &[Member]) -> io::Result<(AtomicFile, u64)> {
    // Without the crate's clock, the date is that of zip's beginning.
    let options =
        SimpleFileOptions::default().compression_method(CompressionMethod::Stored).with_alignment(64);
    let mut archive = ZipWriter::new(file);
    archive.start_file("scene.usdc", options)?;
    layer.rewind()?;
    io::copy(layer.get_mut(), &mut archive)?;
    for member in members {
        archive.start_file(&*member.name, options)?;
        archive.write_all(&member.bytes)?;
    }
    let mut file = archive.finish()?;
    let size = file.stream_position()?;
    Ok((file, size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_usd_could_not_read_is_refused_with_advice() {
        let folder = tempfile::tempdir().unwrap();
        let file = AtomicFile::create(&folder.path().join("face.usdz")).unwrap();
        check_size(&file, LARGEST_LAYER).unwrap();
        let message = check_size(&file, LARGEST_LAYER + 1).unwrap_err().to_string();
        assert!(message.contains("face.usdz: ") && message.contains("write .usd"), "{message}");
    }
}
