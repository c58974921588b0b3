//! What is said about an OBJ file once it is read: each kind of oddity once, with its count and first line.

/// A kind of oddity.
#[derive(Default)]
pub(super) struct Seen {
    pub count: usize,
    /// The first line that has it, from 1.
    pub line: usize,
    /// A piece of that line.
    pub piece: String,
}

impl Seen {
    pub(super) fn add(&mut self, line: usize, piece: impl FnOnce() -> String) {
        if self.count == 0 {
            (self.line, self.piece) = (line, piece());
        }
        self.count += 1;
    }
}

/// All kinds.
#[derive(Default)]
pub(super) struct Notes {
    /// Statements that are not OBJ's.
    pub unknown: Seen,
    /// Lines that begin as statements do, but belong to the statement before. The piece is such a line.
    pub swallowed: Seen,
    /// Faces with fewer than three corners.
    pub short_faces: Seen,
    /// Corners with more than three indices.
    pub long_corners: Seen,
}

impl Notes {
    /// Logs a warning for each kind that was seen in the file `name`.
    pub(super) fn say(&self, name: &str) {
        let Self { unknown, swallowed, short_faces, long_corners } = self;
        if unknown.count > 0 {
            log::warn!(
                "{name}: {} lines have statements that are not OBJ and were skipped, the first is line {}: {}",
                unknown.count,
                unknown.line,
                unknown.piece
            );
        }
        if swallowed.count > 0 {
            log::warn!(
                "{name}: {} lines end with a backslash and so take the next statement as a part of their own; the \
                 first is line {}, which takes {}: if a name ends with the backslash, as of a Windows folder, \
                 remove it",
                swallowed.count,
                swallowed.line,
                swallowed.piece
            );
        }
        if short_faces.count > 0 {
            log::warn!(
                "{name}: {} faces have fewer than 3 corners and were left out, the first is line {}: {}; the file \
                 may be cut short there",
                short_faces.count,
                short_faces.line,
                short_faces.piece
            );
        }
        if long_corners.count > 0 {
            log::warn!(
                "{name}: {} face corners have more than vertex/texture/normal, and the further indices were \
                 skipped; the first is in line {}: {}",
                long_corners.count,
                long_corners.line,
                long_corners.piece
            );
        }
    }
}
