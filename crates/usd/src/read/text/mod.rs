//! USD text. One pass over the file reads all but the time samples, of which it notes where they begin.

mod bytes;
mod lexer;
mod objects;
mod values;

use super::opened::{Opened, Samples};
use super::source::Source;
use crate::layer::Value;
use bytes::Bytes;
use lexer::Lexer;
use objects::{Parser, Track};
use rhytid_core::Result;

/// Reads all but the time samples.
pub(super) fn open(source: Source) -> Result<Opened> {
    let mut parser = Parser { lexer: Lexer::new(Bytes::new(source)), tracks: Vec::new(), unread: Vec::new() };
    let layer = parser.layer()?;
    let Parser { lexer, tracks, unread } = parser;
    Ok(Opened { layer, samples: Box::new(TextSamples { lexer, tracks }), unread })
}

struct TextSamples {
    lexer: Lexer,
    tracks: Vec<Track>,
}

impl Samples for TextSamples {
    fn times(&self, n: usize) -> &[f64] {
        &self.tracks[n].times
    }

    fn read(&mut self, n: usize, i: usize) -> Result<Value> {
        let Self { lexer, tracks } = self;
        let track = &tracks[n];
        lexer.go_to(track.values[i]);
        values::value(lexer, &track.type_name)?.ok_or_else(|| {
            lexer.wrong(format_args!(
                "a sample of type {} is blocked or of an unexpected type; export the file again",
                track.type_name
            ))
        })
    }
}
