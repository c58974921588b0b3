//! What can be done about an error or a warning, for programs that have their own options.
use crate::listed::listed;

listed! {
    /// What can be done about an [`crate::InputError`] or a [`Warning`]: a setting or a step of the library.
    /// A program says which of its options, commands or buttons this is. The library's sentences name none of
    /// these.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    #[non_exhaustive]
    pub enum Remedy {
        /// Allow pictures of more pixels.
        MostPixels,
        /// Let a file name others outside its folder.
        AllowElsewhere,
        /// Hold a marker where it was last seen.
        HoldMissing,
        /// Say how many frames a second of the take has.
        GiveRate,
        /// Say in which unit and with which axes a take is.
        GiveTakeSpace,
        /// Clean a take as one in world space, which takes the head's motion out.
        CleanAsWorld,
        /// Take the noise of the markers out.
        SoftMarkers,
        /// Give the shapes that curves weigh.
        GiveShapes,
        /// Write fewer frames.
        FewerFrames,
        /// Compress the frames to few morph targets, within an error.
        Compress,
        /// Allow a larger error of the compression.
        LargerError,
        /// Store numbers of 16 bits.
        Quantize,
        /// Do not store numbers of 16 bits.
        DoNotQuantize,
        /// Pack the numbers with meshopt.
        Meshopt,
        /// Say how many morph targets a file may have.
        MostTargets,
        /// Go beyond what viewers are made for.
        Force,
        /// Write frames, and no shapes with curves.
        NoShapes,
        /// Write few shapes with curves.
        FewShapes,
        /// Say which clip of a file is meant.
        ChooseClip,
        /// Bring all takes to one rate.
        OneRate,
        /// Leave the head's motion out.
        DropHead,
        /// Do not refine the frames.
        NoRefinement,
        /// Have the doctor examine the face.
        Examine,
        /// Have the devices run the conformance suite.
        Conform,
        /// List the devices that are here.
        ListDevices,
        /// Keep markers that slid, in the clean-up.
        KeepSlides,
        /// Drop a stretch of a marker by hand.
        DropStretch,
        /// Say which subject of a take is meant.
        ChooseSubject,
        /// Keep the result of a clean-up that no face can have.
        KeepImplausible,
        /// Correct the table that maps markers to handles.
        MarkerTable,
        /// Say which frames are neutral.
        GiveNeutral,
        /// Write a frame as a mesh to be sculpted.
        WriteFrame,
    }
}

/// A warning about a result for a user: a sentence, and what can be done.
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

    /// What can be done. Empty if nothing can.
    pub fn remedies(&self) -> &'static [Remedy] {
        self.remedies
    }

    /// The same warning with the name of the file that it is about.
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
