//! The frames in a file. They are read back in blocks of vertices with all their frames, or in batches of
//! frames with all their vertices.

use super::sketches::Sketches;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;
use rhytid_core::{Error, Progress, Result};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Memory for a block of vertices, in bytes. A block that has all vertices is read once in a search.
const BLOCK_BYTES: usize = 1 << 28;

/// Memory for a batch of frames, in bytes.
const BATCH_BYTES: usize = 1 << 26;

/// Vertices that one task works on. Sums over tasks are taken in order, so that threads do not matter.
pub(super) const TASK: usize = 256;

/// Frames read before they are put in their columns.
const ROWS: usize = 16;

/// The fewest frames of a batch. With fewer, the work is limited by how fast the shapes are read.
const LEAST_BATCH: usize = 16;

/// The frames of an animation, kept in a file: memory does not grow with their number.
#[derive(Debug)]
pub struct Frames {
    spool: File,
    path: PathBuf,
    vertices: usize,
    normals: bool,
    /// Of each other attribute how many of its three numbers count.
    extras: Vec<usize>,
    /// How many frames are in the file.
    all: usize,
    /// The first frame of each clip but the first, in ascending order.
    begins: Vec<usize>,
    /// The frames that are looked at, in ascending order; `None` for all.
    chosen: Option<Vec<usize>>,
    sketches: Sketches,
}

/// The Gram matrix of the frames, summed over all components of all vertices.
pub struct Gram {
    /// F×F, `Σ y_i · y_j` over vertices, y being the positions less their mean over the frames.
    pub matrix: Mat<f64>,
    /// 3V, that mean, as float32.
    pub center: Vec<f32>,
    /// Vertices that move.
    pub moving: usize,
}

/// The positions less their mean. The block that was read last is kept, so an animation of a single block is
/// read once for the whole search.
pub(super) struct Centred<'a> {
    /// The frames.
    pub frames: &'a mut Frames,
    /// Their Gram matrix.
    pub gram: &'a Gram,
    kept: Option<(usize, Block)>,
}

impl<'a> Centred<'a> {
    /// Nothing is read yet.
    pub(super) fn new(frames: &'a mut Frames, gram: &'a Gram) -> Self {
        Self { frames, gram, kept: None }
    }

    /// The block that begins with vertex `first`.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(super) fn block(&mut self, first: usize) -> Result<&Block> {
        // The old block makes room before the new one is read.
        let kept = self.kept.take().filter(|kept| kept.0 == first);
        let block = match kept {
            Some((_, block)) => block,
            None => self.frames.block(Attribute::Positions, first, &self.gram.center)?,
        };
        Ok(&self.kept.insert((first, block)).1)
    }
}

/// Which attribute of the frames to read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Attribute {
    Positions,
    Normals,
    /// One of the others.
    Extra(usize),
}

/// Some vertices in all frames.
pub struct Block {
    /// How many vertices.
    pub count: usize,
    /// Component by component, each with its F frames.
    pub values: Vec<f32>,
}

impl Frames {
    /// Frames of `vertices` vertices, with normals or without.
    ///
    /// `extras` has an entry for each further attribute of three numbers: how many of the three count.
    /// `spool` is an empty file that only this uses (`AtomicFile::spool`). `path` is the output, for
    /// messages.
    pub fn new(spool: File, path: &Path, vertices: usize, normals: bool, extras: Vec<usize>) -> Self {
        let sketches = Sketches::default();
        let path = path.to_owned();
        Self { spool, path, vertices, normals, extras, all: 0, begins: Vec::new(), chosen: None, sketches }
    }

    /// The same, divided into clips of so many frames. Errors are measured for each clip.
    #[must_use]
    pub fn with_clips(mut self, clips: impl Iterator<Item = usize>) -> Self {
        let ends = clips.scan(0, |end, frames| {
            *end += frames;
            Some(*end)
        });
        self.begins = ends.collect();
        // The last one ends where no other begins.
        self.begins.pop();
        self
    }

    /// C, how many clips the frames are divided into; at least 1.
    pub(super) fn clips(&self) -> usize {
        self.begins.len() + 1
    }

    /// The clip of the frame that is counted as `frame` among those that are there.
    pub(super) fn clip(&self, frame: usize) -> usize {
        let number = self.number(frame);
        self.begins.partition_point(|&begin| begin <= number)
    }

    /// The first frame of a clip, counted among all.
    pub(super) fn begin(&self, clip: usize) -> usize {
        clip.checked_sub(1).map_or(0, |further| self.begins[further])
    }

    /// Adds the next frame: `positions` in mesh units, V×3 and finite; `normals` of length 1 (or 0) and
    /// `extras`, V×3 each, if and only if they were announced.
    ///
    /// # Errors
    /// [`Error::Internal`] if a length is wrong; [`Error::Io`].
    pub fn push(&mut self, positions: &[f32], normals: Option<&[f32]>, extras: &[Vec<f32>]) -> Result<()> {
        let numbers = self.vertices * 3;
        let has_normals = normals.map(<[f32]>::len) == self.normals.then_some(numbers);
        let has_extras =
            extras.len() == self.extras.len() && extras.iter().all(|extra| extra.len() == numbers);
        if positions.len() != numbers || !has_normals || !has_extras {
            return Err(Error::Internal("a frame has another number of vertices than its mesh".into()));
        }
        let extras = extras.iter().map(Vec::as_slice);
        for values in [Some(positions), normals].into_iter().flatten().chain(extras) {
            self.spool.write_all(bytemuck::cast_slice(values)).map_err(Error::io(&self.path))?;
        }
        self.sketches.push(positions);
        self.all += 1;
        Ok(())
    }

    /// From now on, only these frames are there: ascending numbers of frames that were pushed.
    pub(super) fn choose(&mut self, frames: Vec<usize>) {
        self.chosen = Some(frames);
    }

    /// From now on, all frames are there again.
    pub(super) fn choose_all(&mut self) {
        self.chosen = None;
    }

    /// A small vector for each frame that was pushed.
    pub(super) fn sketches(&self) -> &Sketches {
        &self.sketches
    }

    /// The number, counted among all, of the frame that is counted as `frame` among those that are there.
    fn number(&self, frame: usize) -> usize {
        self.chosen.as_ref().map_or(frame, |chosen| chosen[frame])
    }

    /// The output's name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// V.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// F, the frames that are there.
    pub fn frames(&self) -> usize {
        self.chosen.as_ref().map_or(self.all, Vec::len)
    }

    /// Whether the frames have normals.
    pub fn has_normals(&self) -> bool {
        self.normals
    }

    /// Of each other attribute how many of its three numbers count.
    pub fn extras(&self) -> &[usize] {
        &self.extras
    }

    /// How many vertices a block has; the last one may have fewer.
    pub fn block_vertices(&self) -> usize {
        (BLOCK_BYTES / (12 * self.frames().max(1))).next_multiple_of(TASK).min(self.vertices.max(1))
    }

    /// Reads the block that begins with vertex `first`, less `center` (3V).
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn block(&mut self, attribute: Attribute, first: usize, center: &[f32]) -> Result<Block> {
        let count = self.block_vertices().min(self.vertices - first);
        let (frames, columns) = (self.frames(), 3 * count);
        let center = &center[3 * first..][..columns];
        let mut values = vec![0.0_f32; frames * columns];
        let mut rows = vec![0.0_f32; ROWS * columns];
        for frame in (0..frames).step_by(ROWS) {
            let some = ROWS.min(frames - frame);
            for (i, row) in rows.chunks_mut(columns).take(some).enumerate() {
                self.read(attribute, frame + i, first, row)?;
            }
            values.par_chunks_mut(frames).zip(center).enumerate().for_each(|(column, (values, &center))| {
                for (i, value) in values[frame..frame + some].iter_mut().enumerate() {
                    *value = rows[i * columns + column] - center;
                }
            });
        }
        Ok(Block { count, values })
    }

    /// Fills `numbers` with an attribute of a frame, from vertex `first` on.
    fn read(&mut self, attribute: Attribute, frame: usize, first: usize, numbers: &mut [f32]) -> Result<()> {
        let others = 1 + usize::from(self.normals);
        let place = match attribute {
            Attribute::Positions => 0,
            Attribute::Normals => 1,
            Attribute::Extra(extra) => others + extra,
        };
        let part = self.number(frame) * (others + self.extras.len()) + place;
        let offset = 12 * (part as u64 * self.vertices as u64 + first as u64);
        self.spool.seek(SeekFrom::Start(offset)).map_err(Error::io(&self.path))?;
        self.spool.read_exact(bytemuck::cast_slice_mut(numbers)).map_err(Error::io(&self.path))
    }

    /// The batches that the frames are read in. The frames of a batch belong to one clip.
    pub fn batches(&self) -> Vec<Range<usize>> {
        let size = (BATCH_BYTES / (12 * self.vertices.max(1))).max(LEAST_BATCH);
        let frames = self.frames();
        let mut batches: Vec<Range<usize>> = Vec::new();
        for frame in 0..frames {
            match batches.last_mut() {
                Some(last) if last.len() < size && self.clip(last.start) == self.clip(frame) => {
                    last.end = frame + 1;
                }
                _ => batches.push(frame..frame + 1),
            }
        }
        batches
    }

    /// Reads a batch into `values`, which then has 3V numbers of each frame.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn batch(&mut self, attribute: Attribute, frames: Range<usize>, values: &mut Vec<f32>) -> Result<()> {
        let numbers = 3 * self.vertices;
        values.resize(frames.len() * numbers, 0.0);
        for (frame, row) in frames.zip(values.chunks_mut(numbers)) {
            self.read(attribute, frame, 0, row)?;
        }
        Ok(())
    }

    /// The first vertices of all blocks.
    pub fn blocks(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.vertices).step_by(self.block_vertices())
    }

    /// The Gram matrix of the frames.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Cancelled`].
    pub fn gram(&mut self, progress: &dyn Progress) -> Result<Gram> {
        let frames = self.frames();
        let mut matrix = Mat::zeros(frames, frames);
        let mut center = Vec::with_capacity(3 * self.vertices);
        let mut moving = 0;
        let zero = vec![0.0; 3 * self.vertices];
        for first in self.blocks() {
            progress.step("compare the frames", first as u64, self.vertices as u64)?;
            let block = self.block(Attribute::Positions, first, &zero)?;
            let mean = |column: &[f32]| column.iter().copied().map(f64::from).sum::<f64>() / frames as f64;
            let means: Vec<f32> = block.values.par_chunks(frames).map(|column| mean(column) as f32).collect();
            let still = |column: &[f32]| column.iter().all(|x| *x == column[0]);
            moving += block.values.par_chunks(3 * frames).filter(|v| !v.chunks(frames).all(still)).count();
            let columns = TASK * 3;
            // Few sums at a time are in memory, and they are added in order.
            for (values, means) in block.values.chunks(16 * columns * frames).zip(means.chunks(16 * columns))
            {
                let sums: Vec<Mat<f64>> = values
                    .par_chunks(columns * frames)
                    .zip(means.par_chunks(columns))
                    .map(|(values, means)| {
                        let y: Vec<f64> = values
                            .chunks(frames)
                            .zip(means)
                            .flat_map(|(column, &m)| column.iter().map(move |&x| f64::from(x - m)))
                            .collect();
                        let y = MatRef::from_column_major_slice(&y, frames, y.len() / frames);
                        let mut sum = Mat::zeros(frames, frames);
                        matmul(sum.as_mut(), Accum::Replace, y, y.transpose(), 1.0, Par::Seq);
                        sum
                    })
                    .collect();
                for sum in &sums {
                    matrix += sum;
                }
            }
            center.extend(means);
        }
        progress.step("compare the frames", self.vertices as u64, self.vertices as u64)?;
        Ok(Gram { matrix, center, moving })
    }
}
