//! What can be done about an error or a warning, as a program that has options of its own needs to know it.
use crate::listed::listed;

listed! {
    /// What can be done about an [`crate::InputError`] or a [`Warning`]: which setting or which step of the library it is. A program says which of
    /// its own options, commands or buttons that is; the sentences of the library name none.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    #[non_exhaustive]
    pub enum Remedy {
        /// Let a file name others outside its folder.
        AllowElsewhere,
        /// Hold a marker where it was last seen.
        HoldMissing,
        /// Say how many frames a second of the take has.
        GiveRate,
        /// Write fewer frames.
        FewerFrames,
        /// Make few morph targets of the frames, within an error.
        Compress,
        /// Allow a larger error to what is compressed.
        LargerError,
        /// Store numbers of 16 bits.
        Quantize,
        /// Do not store numbers of 16 bits.
        DoNotQuantize,
        /// Pack the numbers with meshopt.
        Meshopt,
        /// Go beyond what viewers are made for.
        Force,
        /// Write frames, and no shapes with curves.
        NoShapes,
        /// Do not refine the frames.
        NoRefinement,
        /// Have the doctor examine the face.
        Examine,
        /// Have the devices run the conformance suite.
        Conform,
        /// List the devices that are here.
        ListDevices,
        /// Keep what slid in the clean-up.
        KeepSlides,
        /// Drop a stretch of a marker by hand.
        DropStretch,
        /// Look at the table of which marker is which handle's, and give it back as it should be.
        MarkerTable,
        /// Write a frame as a mesh to be sculpted.
        WriteFrame,
    }
}

/// What a person should know of a result: a sentence, and what can be done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    sentence: String,
    remedies: &'static [Remedy],
}

impl Warning {
    /// The same warning, with what can be done.
    #[must_use]
    pub fn with_remedies(self, remedies: &'static [Remedy]) -> Self {
        Self { remedies, ..self }
    }

    /// For people. It names no option of any program.
    pub fn sentence(&self) -> &str {
        &self.sentence
    }

    /// What can be done; empty where there is nothing.
    pub fn remedies(&self) -> &'static [Remedy] {
        self.remedies
    }

    /// The same warning of what is in a file, which it does not name yet.
    #[must_use]
    pub fn in_file(self, name: impl std::fmt::Display) -> Self {
        Self { sentence: format!("{name}: {}", self.sentence), ..self }
    }
}

impl From<String> for Warning {
    fn from(sentence: String) -> Self {
        Self { sentence, remedies: &[] }
    }
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.sentence)
    }
}

/// As its sentence.
impl serde::Serialize for Warning {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.sentence)
    }
}
