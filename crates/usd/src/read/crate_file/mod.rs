//! Binary USD, also called crate files: values anywhere, then sections that say what they are.

mod compression;
mod cursor;
mod objects;
mod structure;
mod value_rep;
mod values;

use super::budget::Budget;
use super::opened::{Opened, Samples};
use super::source::Source;
use crate::layer::Value;
use rhytid_core::Result;
use structure::Structure;
use values::{Reader, Track};

/// Reads all but the time samples.
pub(super) fn open(mut source: Source) -> Result<Opened> {
    let mut budget = Budget::of_file(source.len());
    let structure = Structure::read(&mut source, &mut budget)?;
    let mut reader = Reader { source, structure, budget };
    let (layer, tracks, unread) = objects::layer(&mut reader)?;
    Ok(Opened { layer, samples: Box::new(CrateSamples { reader, tracks }), unread })
}

struct CrateSamples {
    reader: Reader,
    tracks: Vec<Track>,
}

impl Samples for CrateSamples {
    fn times(&self, n: usize) -> &[f64] {
        &self.tracks[n].times
    }

    fn read(&mut self, n: usize, i: usize) -> Result<Value> {
        let rep = self.tracks[n].values[i];
        // Each value is gone before the next is read.
        self.reader.budget = Budget::of_file(self.reader.source.len());
        self.reader.value(rep)?.ok_or_else(|| {
            let time = self.tracks[n].times[i];
            self.reader.damaged(format_args!(
                "a sample at time code {time} is blocked or of the unexpected type {}",
                rep.kind()
            ))
        })
    }
}
