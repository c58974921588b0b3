//! A target for each frame, as integers. Their grid is known only when all frames are.

use super::animation::Weights;
use super::clips::Clips;
use super::container::rewound;
use super::document::Document;
use super::exact::{OtherTargets, first_of_all};
use super::grid::{Extent, Grid, normal_offsets, offsets, snap_normals};
use super::measure::Measure;
use super::targets::{frame_name, unit_normals};
use crate::attributes::Attribute;
use rhytid_core::{Error, Progress, Remedy, Result, channel};
use rhytid_export::morphs::Values;
use rhytid_export::{Exporter, Frame, Options, Scene, Written};
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};

/// Like [`super::exact::Exact`], with every position on a [`Grid`].
pub(super) struct Quantized {
    document: Document,
    clips: Clips,
    first_time_code: f64,
    normals: bool,
    attributes: Vec<Attribute>,
    /// The first frame.
    base: Vec<f32>,
    base_normals: Vec<f32>,
    extent: Option<Extent>,
    /// Positions, then normals and the attributes, of each frame so far.
    spool: BufWriter<File>,
    frames: usize,
}

impl Quantized {
    pub(super) fn new(
        document: Document,
        scene: &Scene<'_>,
        attributes: Vec<Attribute>,
        options: &Options,
    ) -> Result<Self> {
        let spool = BufWriter::with_capacity(1 << 20, document.buffers.container.spool()?);
        Ok(Self {
            document,
            clips: Clips::new(scene, options),
            first_time_code: scene.first_time_code,
            normals: scene.rest_normals.is_some(),
            attributes,
            base: Vec::new(),
            base_normals: Vec::new(),
            extent: None,
            spool,
            frames: 0,
        })
    }
}

impl Exporter for Quantized {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        let (positions, normals) = (frame.positions(), frame.get(&channel::NORMALS));
        if self.frames == 0 {
            self.base = positions.to_vec();
            self.base_normals = normals.map(unit_normals).unwrap_or_default();
        }
        self.extent.get_or_insert_with(|| Extent::new(&self.base)).add(&self.base, positions);
        let changes = |attribute: &&Attribute| self.frames == 0 || !attribute.is_constant();
        let others: Vec<Vec<f32>> =
            self.attributes.iter().filter(changes).map(|attribute| attribute.of_frame(frame)).collect();
        self.frames += 1;
        let others = others.iter().map(Vec::as_slice);
        for numbers in [Some(positions), normals].into_iter().flatten().chain(others) {
            let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
            self.spool.write_all(&bytes).map_err(Error::io(self.document.path()))?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        let Self {
            mut document,
            clips,
            first_time_code,
            normals,
            attributes,
            base,
            base_normals,
            extent,
            spool,
            frames,
        } = *self;
        let path = document.path().to_owned();
        let grid = extent.and_then(|extent| extent.grid()).ok_or_else(|| {
            Error::out_of_range(format!(
                "{}: has positions too large to be quantised; export it without quantising",
                path.display()
            ))
            .with_remedies(&[Remedy::DoNotQuantize])
        })?;
        let numbers = base.len();
        let base = grid.snap(&base);
        let base_normals = snap_normals(&base_normals);
        let shown = normals.then(|| Values::I8(base_normals.clone()));
        document.base(&Values::I16(base.clone()), shown.as_ref())?;

        let mut spool = rewound(spool).map_err(Error::io(&path))?;
        let mut measure = Measure::default();
        let changing = attributes.iter().filter(|attribute| !attribute.is_constant()).count();
        let all = attributes.len();
        let mut others = OtherTargets::new(attributes);
        for k in 0..frames {
            progress.report("quantising", k as u64, frames as u64);
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            let positions = read_floats(&mut spool, numbers).map_err(Error::io(&path))?;
            let snapped = grid.snap(&positions);
            let points = offsets(&base, &snapped);
            add(&mut measure, &grid, k, &positions, [&base, &points]);
            let normals = match normals {
                true => {
                    let to = read_floats(&mut spool, numbers).map_err(Error::io(&path))?;
                    Some(normal_offsets(&base_normals, &to))
                }
                false => None,
            };
            document.target(frame_name(first_time_code, k), &Values::I16(points), normals.as_ref())?;
            let there = if k == 0 { all } else { changing };
            let of_frame = (0..there).map(|_| read_floats(&mut spool, numbers).map_err(Error::io(&path)));
            others.write(&mut document, of_frame.collect::<Result<_>>()?)?;
        }
        progress.report("quantising", frames as u64, frames as u64);
        let clips = clips.of_one(Weights::OneHot, measure.deviation(grid.reach()));
        document.finish(grid.placement(), Some(first_of_all(frames)), clips, progress)
    }
}

/// Compares frame `k` with the sum of the base and its offsets.
fn add(measure: &mut Measure, grid: &Grid, k: usize, positions: &[f32], [base, points]: [&[i16]; 2]) {
    let vectors = |points| <[i16]>::as_chunks::<3>(points).0;
    let stored = vectors(base).iter().zip(vectors(points));
    for (v, (given, (base, offset))) in positions.as_chunks::<3>().0.iter().zip(stored).enumerate() {
        let point = std::array::from_fn(|axis| i32::from(base[axis]) + i32::from(offset[axis]));
        measure.add(k, v, given.map(f64::from), grid.position(point));
    }
}

fn read_floats(file: &mut impl Read, count: usize) -> io::Result<Vec<f32>> {
    let mut bytes = vec![0; 4 * count];
    file.read_exact(&mut bytes)?;
    Ok(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
}
