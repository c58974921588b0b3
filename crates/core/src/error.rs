//! Errors, grouped by who can do something about them.
use crate::Remedy;
use crate::listed::{listed, named};
use std::path::{Path, PathBuf};

/// The result of every fallible function of Rhytid.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong, grouped by who can do something about it.
///
/// Shown with `{}`, an error is one sentence for a person. A program tells errors apart by the variant, and
/// errors of [`Error::Input`] by the kind:
///
/// ```
/// use rhytid_core::{Error, InputErrorKind, Take};
///
/// let take = Take { labels: vec!["chin".into()], ..Take::default() };
/// match take.handle_positions(&["chin".to_owned(), "brow".to_owned()]) {
///     Err(Error::Input(error)) => match error.kind() {
///         InputErrorKind::MissingMarkers { labels } => assert_eq!(labels, &["brow"]),
///         kind => panic!("{kind:?}: {error}"),
///     },
///     other => panic!("{other:?}"),
/// }
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The input is at fault. One sentence says which file, which line or element, what was found, what was
    /// expected and what to do.
    #[error("{0}")]
    Input(InputError),
    /// A file could not be opened, read or written.
    #[error("{}: {}", path.display(), of_system(source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A device failed in a way that its caller could not foresee.
    #[error("{device}: {message}")]
    Device {
        /// What failed.
        kind: DeviceErrorKind,
        /// `backend:index`, or the backend's name where no device was reached.
        device: String,
        /// The driver's words, or a build log.
        message: String,
    },
    /// The caller asked to stop (see [`crate::Progress::cancelled`]). Nothing was written.
    #[error("stopped before the end; nothing was written")]
    Cancelled,
    /// A fault in Rhytid itself.
    #[error("internal error: {0}; please report it")]
    Internal(String),
}

/// What is wrong with an input: a kind for programs, a sentence for people, and which settings would help.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    kind: InputErrorKind,
    sentence: String,
    remedies: &'static [Remedy],
}

named! {
    /// The ways in which an input can be wrong.
    #[derive(Debug, Clone, PartialEq, Eq)]
    #[non_exhaustive]
    pub enum InputErrorKind {
        /// A take has no columns for some of the markers that are needed. Give a take that has them, or say
        /// which of its markers are meant.
        MissingMarkers {
            /// All that are missing, in the order in which they were asked for.
            labels: Vec<String>,
        },
        /// Something names handles or markers that the rig or the take does not have. Mend the names.
        UnknownMarkers {
            /// The names, as they were found.
            labels: Vec<String>,
        },
        /// Something names an example, a group, a region, a material or a property that is not there. Mend
        /// the name.
        UnknownName {
            /// The name, as it was found.
            name: String,
        },
        /// A unit of length is unknown. Give a known one, or its metres.
        UnknownUnit {
            /// The unit, as it was found.
            found: String,
        },
        /// A file has an unknown key, most likely misspelt. Mend or remove it.
        UnknownKey {
            /// The key, without its section.
            key: String,
        },
        /// A file lacks a key or a section that it needs. Add it.
        MissingKey {
            /// The key, without its section; or the section's name.
            key: String,
        },
        /// A key of a file has a value of the wrong type, outside its range, or not among the known values.
        /// Mend the value.
        WrongValue {
            /// The key, without its section.
            key: String,
        },
        /// A file breaks its format's rules, or contradicts itself. Export, copy or mend it.
        Malformed {
            /// The line, counted from 1, of a text file where the line is known.
            line: Option<usize>,
        },
        /// A file ends before what it announces, or has another length than it announces. Copy or export it
        /// again.
        CutShort,
        /// A rig's arrays do not fit together, or its file lacks some. Solve it again.
        RigDamaged,
        /// A file has a format that Rhytid does not read or write, or uses an unsupported part of its format.
        /// Export it another way.
        UnsupportedFormat,
        /// A file has a version of its format that Rhytid does not read. Make it again.
        UnsupportedVersion,
        /// A number, an index, a frame or a vertex is outside what is allowed. The sentence says what is.
        OutOfRange,
        /// Something is larger than a format, a device or the memory holds. Ask for less, or choose another
        /// format or device.
        TooLarge,
        /// Two things that belong together differ: in number, in the order of vertices, in unit, or in what
        /// they were made from.
        Mismatch,
        /// A file that another file names does not exist. Put it there, or mend the path.
        NotThere {
            /// The file, as it was looked for.
            file: PathBuf,
        },
        /// A file names another one outside its own folder. Such a file is read only if the caller trusts the
        /// author.
        OutsideFolder {
            /// The file, as it was named.
            file: PathBuf,
        },
        /// An output would overwrite an input, or a file that has to stay. Choose another name.
        WouldOverwrite {
            /// The file that is there.
            file: PathBuf,
        },
        /// A path leads to a folder, a device, something that may not be written, or nowhere. Choose another
        /// path.
        BadPath,
        /// A take's file does not say how many frames a second has. Give the rate.
        NoFrameRate,
        /// A take lacks the position of a marker in some frames. Fill the gaps, or have the marker held.
        MissingSamples,
        /// A mesh is no surface that can be used: its faces, corners, coordinates or textures do not make
        /// one. Mend and export it.
        BadTopology,
        /// There is nothing to work with: no frame, no marker, no row, no mesh. Export the file with its
        /// contents.
        Empty,
        /// The rig lacks what was asked of it: examples, strain edges, texture coordinates, or the learned
        /// method. Solve it with these.
        RigLacks,
        /// Two settings or entries exclude each other, or one is given twice. Leave one out.
        Conflict,
        /// Markers or landmarks do not determine where they belong: there are too few, they are on one line,
        /// or they have another shape. Say which are which.
        NoFit,
        /// The equations have no solution in floating point. Mend the mesh where the sentence says, or change
        /// the setting.
        NotSolvable,
        /// A network address cannot be used, or nothing usable comes from it. Choose another address, or look
        /// at the sender.
        Network,
        /// None of the others. The sentence says what.
        Other,
    }
}

listed! {
    /// The ways in which a device can fail.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    #[non_exhaustive]
    pub enum DeviceErrorKind {
        /// No such device here.
        NotFound,
        /// The device lacks a feature or a limit that the rig needs.
        Unsupported,
        /// The device's memory does not suffice.
        OutOfMemory,
        /// The device was reset, unplugged or taken away.
        Lost,
        /// A kernel did not build.
        Build,
        /// Any other error of the driver.
        Driver,
    }
}

impl InputError {
    /// What is wrong, for programs.
    pub fn kind(&self) -> &InputErrorKind {
        &self.kind
    }

    /// What is wrong, for people. It names no option of any program; see [`InputError::remedies`].
    pub fn sentence(&self) -> &str {
        &self.sentence
    }

    /// The settings that would avoid the error if they were changed. Empty where there are none.
    pub fn remedies(&self) -> &'static [Remedy] {
        self.remedies
    }
}

impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.sentence)
    }
}

impl std::error::Error for InputError {}

/// Constructors of [`Error::Input`], one for each kind without data of its own.
macro_rules! constructors {
    ($($name:ident => $kind:expr, $of:literal;)*) => {
        impl Error {
            $(
                #[doc = concat!("An [`Error::Input`] of the kind [`InputErrorKind::", $of, "`], with its sentence.")]
                pub fn $name(sentence: impl Into<String>) -> Self {
                    Self::Input(InputError { kind: $kind, sentence: sentence.into(), remedies: &[] })
                }
            )*
        }
    };
}

constructors! {
    input => InputErrorKind::Other, "Other";
    malformed => InputErrorKind::Malformed { line: None }, "Malformed";
    cut_short => InputErrorKind::CutShort, "CutShort";
    rig_damaged => InputErrorKind::RigDamaged, "RigDamaged";
    unsupported_format => InputErrorKind::UnsupportedFormat, "UnsupportedFormat";
    unsupported_version => InputErrorKind::UnsupportedVersion, "UnsupportedVersion";
    out_of_range => InputErrorKind::OutOfRange, "OutOfRange";
    too_large => InputErrorKind::TooLarge, "TooLarge";
    mismatch => InputErrorKind::Mismatch, "Mismatch";
    bad_path => InputErrorKind::BadPath, "BadPath";
    no_frame_rate => InputErrorKind::NoFrameRate, "NoFrameRate";
    missing_samples => InputErrorKind::MissingSamples, "MissingSamples";
    bad_topology => InputErrorKind::BadTopology, "BadTopology";
    empty => InputErrorKind::Empty, "Empty";
    rig_lacks => InputErrorKind::RigLacks, "RigLacks";
    conflict => InputErrorKind::Conflict, "Conflict";
    no_fit => InputErrorKind::NoFit, "NoFit";
    not_solvable => InputErrorKind::NotSolvable, "NotSolvable";
    network => InputErrorKind::Network, "Network";
}

impl Error {
    /// The same error with another kind, such as a kind with data. Errors other than [`Error::Input`] stay as
    /// they are.
    #[must_use]
    pub fn of_kind(self, kind: InputErrorKind) -> Self {
        match self {
            Self::Input(error) => Self::Input(InputError { kind, ..error }),
            other => other,
        }
    }

    /// The same error with the settings that would avoid it. Errors other than [`Error::Input`] stay as they
    /// are.
    #[must_use]
    pub fn with_remedies(self, remedies: &'static [Remedy]) -> Self {
        match self {
            Self::Input(error) => Self::Input(InputError { remedies, ..error }),
            other => other,
        }
    }

    /// The kind of an [`Error::Input`]. `None` for other errors.
    pub fn input_kind(&self) -> Option<&InputErrorKind> {
        match self {
            Self::Input(error) => Some(error.kind()),
            _ => None,
        }
    }

    /// The same error in other words, which `reword` makes from its sentence. Errors other than
    /// [`Error::Input`] stay as they are.
    #[must_use]
    pub fn reworded(self, reword: impl FnOnce(String) -> String) -> Self {
        match self {
            Self::Input(error) => Self::Input(InputError { sentence: reword(error.sentence), ..error }),
            other => other,
        }
    }

    /// The same error with the name of the file in which it was found. Errors other than [`Error::Input`]
    /// stay as they are.
    #[must_use]
    pub fn in_file(self, name: impl std::fmt::Display) -> Self {
        self.reworded(|sentence| format!("{name}: {sentence}"))
    }

    /// For `map_err`: an [`Error::Io`] that names `path`.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }
}

/// The operating system's reason in words, without its number.
fn of_system(source: &std::io::Error) -> String {
    let text = source.to_string();
    let words = text.split(" (os error").next().unwrap_or_default();
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_reason_has_no_number() {
        let source = std::io::Error::from_raw_os_error(5);
        let said = Error::io(Path::new("face.obj"))(source).to_string();
        assert!(said.starts_with("face.obj: ") && !said.contains("os error"), "{said}");
    }

    fn input(error: Error) -> InputError {
        match error {
            Error::Input(error) => error,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_kind_and_the_remedies_stay_when_the_sentence_grows() {
        let kind = InputErrorKind::MissingMarkers { labels: vec!["chin".into()] };
        let error = Error::input("lacks chin").of_kind(kind.clone()).with_remedies(&[Remedy::MarkerTable]);
        let error = error.in_file("take.csv").reworded(|said| said + "; look at it");
        assert_eq!(error.to_string(), "take.csv: lacks chin; look at it");
        assert_eq!(error.input_kind(), Some(&kind));
        let error = input(error);
        assert_eq!((error.kind(), error.remedies()), (&kind, &[Remedy::MarkerTable][..]));
        assert_eq!(error.sentence(), error.to_string());
    }

    #[test]
    fn each_constructor_gives_its_kind_and_its_sentence_as_it_is() {
        for (error, kind) in [
            (Error::input("said"), InputErrorKind::Other),
            (Error::malformed("said"), InputErrorKind::Malformed { line: None }),
            (Error::cut_short("said"), InputErrorKind::CutShort),
            (Error::rig_damaged("said"), InputErrorKind::RigDamaged),
            (Error::unsupported_format("said"), InputErrorKind::UnsupportedFormat),
            (Error::unsupported_version("said"), InputErrorKind::UnsupportedVersion),
            (Error::out_of_range("said"), InputErrorKind::OutOfRange),
            (Error::too_large("said"), InputErrorKind::TooLarge),
            (Error::mismatch("said"), InputErrorKind::Mismatch),
            (Error::bad_path("said"), InputErrorKind::BadPath),
            (Error::no_frame_rate("said"), InputErrorKind::NoFrameRate),
            (Error::missing_samples("said"), InputErrorKind::MissingSamples),
            (Error::bad_topology("said"), InputErrorKind::BadTopology),
            (Error::empty("said"), InputErrorKind::Empty),
            (Error::rig_lacks("said"), InputErrorKind::RigLacks),
            (Error::conflict("said"), InputErrorKind::Conflict),
            (Error::no_fit("said"), InputErrorKind::NoFit),
            (Error::not_solvable("said"), InputErrorKind::NotSolvable),
            (Error::network("said"), InputErrorKind::Network),
        ] {
            let error = input(error);
            assert_eq!((error.kind(), error.sentence(), error.remedies()), (&kind, "said", &[][..]));
        }
    }

    #[test]
    fn each_kind_has_the_name_of_its_variant() {
        let of_debug =
            |kind: &InputErrorKind| format!("{kind:?}").split(' ').next().map(str::to_owned).expect("a name");
        for kind in [
            InputErrorKind::MissingMarkers { labels: Vec::new() },
            InputErrorKind::Malformed { line: None },
            InputErrorKind::CutShort,
            InputErrorKind::Other,
        ] {
            assert_eq!(kind.name(), of_debug(&kind));
            assert!(InputErrorKind::NAMES.contains(&kind.name()));
        }
        let (first, last) =
            (InputErrorKind::NAMES[0], InputErrorKind::NAMES[InputErrorKind::NAMES.len() - 1]);
        assert_eq!([first, last], ["MissingMarkers", "Other"]);
    }

    #[test]
    fn what_is_no_input_stays_as_it_is() {
        let lost =
            Error::Device { kind: DeviceErrorKind::Lost, device: "cpu:0".into(), message: "gone".into() };
        let same = lost.in_file("take.csv").of_kind(InputErrorKind::Other).with_remedies(&[Remedy::Force]);
        assert_eq!((same.to_string(), same.input_kind()), ("cpu:0: gone".to_owned(), None));
        assert!(matches!(same, Error::Device { kind: DeviceErrorKind::Lost, .. }));
    }
}
