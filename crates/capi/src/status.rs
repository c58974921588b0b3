//! What functions return, the sentence of the last error, and the catch of panics.
use rhytid::core::DeviceErrorKind;
use rhytid::{Error, InputErrorKind};
use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What became of a call. Each error also has a sentence for people: rhytid_last_error().
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RhytidStatus {
    /// The call did what it should.
    Ok = 0,
    /// An argument is null, an unknown value, or of a wrong length: a mistake of the calling program.
    Argument = 1,
    /// A file could not be opened or read.
    Io = 2,
    /// The work was stopped on request.
    Cancelled = 3,
    /// A fault in Rhytid itself. Free the object of the call, and report the fault.
    Internal = 4,
    /// This library was built without what the call needs.
    LeftOut = 5,

    /// There is no such device.
    DeviceNotFound = 100,
    /// The device lacks a feature or a limit that the rig needs.
    DeviceUnsupported = 101,
    /// The device's memory does not suffice.
    DeviceOutOfMemory = 102,
    /// The device was reset, unplugged or taken away. Free the animator, and make one on another device.
    DeviceLost = 103,
    /// A kernel did not build.
    DeviceBuild = 104,
    /// Any other error of the driver.
    DeviceDriver = 105,

    /// An input is wrong in a way that has no value of its own. The sentence says how.
    InputOther = 200,
    /// A take has no columns for some of the rig's handles.
    InputMissingMarkers = 201,
    /// Something names handles or markers that are not there.
    InputUnknownMarkers = 202,
    /// Something names an example, a group, a region, a material or a property that is not there.
    InputUnknownName = 203,
    /// A unit of length is unknown.
    InputUnknownUnit = 204,
    /// A file has an unknown key.
    InputUnknownKey = 205,
    /// A file lacks a key or a section.
    InputMissingKey = 206,
    /// A key of a file has a wrong value.
    InputWrongValue = 207,
    /// A file breaks its format's rules.
    InputMalformed = 208,
    /// A file ends too early, or has another length than it announces.
    InputCutShort = 209,
    /// A rig's arrays do not fit together.
    InputRigDamaged = 210,
    /// A file has a format that is not read.
    InputUnsupportedFormat = 211,
    /// A file has a version of its format that is not read.
    InputUnsupportedVersion = 212,
    /// A number is outside what is allowed, such as a position that is not finite.
    InputOutOfRange = 213,
    /// Something is too large, such as a batch of more frames than the animator has room for.
    InputTooLarge = 214,
    /// Two things that belong together differ, such as a batch and the rig's number of handles.
    InputMismatch = 215,
    /// A file that another file names does not exist.
    InputNotThere = 216,
    /// A file names another one outside its own folder.
    InputOutsideFolder = 217,
    /// An output would overwrite an input.
    InputWouldOverwrite = 218,
    /// A path leads to a folder, a device or nowhere.
    InputBadPath = 219,
    /// A take does not say how many frames a second has.
    InputNoFrameRate = 220,
    /// A take lacks the position of a marker in some frames.
    InputMissingSamples = 221,
    /// A mesh is no surface that can be used.
    InputBadTopology = 222,
    /// There is nothing to work with, such as no batch that could be read.
    InputEmpty = 223,
    /// The rig lacks what was asked of it.
    InputRigLacks = 224,
    /// Two settings exclude each other.
    InputConflict = 225,
    /// Markers do not determine where they belong.
    InputNoFit = 226,
    /// The equations have no solution in floating point.
    InputNotSolvable = 227,
    /// A network address cannot be used.
    InputNetwork = 228,
}

/// The status of a device's error. `None` for a kind that C does not have: a test finds none.
pub(crate) fn of_device(kind: DeviceErrorKind) -> Option<RhytidStatus> {
    Some(match kind {
        DeviceErrorKind::NotFound => RhytidStatus::DeviceNotFound,
        DeviceErrorKind::Unsupported => RhytidStatus::DeviceUnsupported,
        DeviceErrorKind::OutOfMemory => RhytidStatus::DeviceOutOfMemory,
        DeviceErrorKind::Lost => RhytidStatus::DeviceLost,
        DeviceErrorKind::Build => RhytidStatus::DeviceBuild,
        DeviceErrorKind::Driver => RhytidStatus::DeviceDriver,
        _ => return None,
    })
}

/// The status of an input's error, by [`InputErrorKind::name`]. `None` for a kind that C does not have: a
/// test finds none.
pub(crate) fn of_input(name: &str) -> Option<RhytidStatus> {
    Some(match name {
        "Other" => RhytidStatus::InputOther,
        "MissingMarkers" => RhytidStatus::InputMissingMarkers,
        "UnknownMarkers" => RhytidStatus::InputUnknownMarkers,
        "UnknownName" => RhytidStatus::InputUnknownName,
        "UnknownUnit" => RhytidStatus::InputUnknownUnit,
        "UnknownKey" => RhytidStatus::InputUnknownKey,
        "MissingKey" => RhytidStatus::InputMissingKey,
        "WrongValue" => RhytidStatus::InputWrongValue,
        "Malformed" => RhytidStatus::InputMalformed,
        "CutShort" => RhytidStatus::InputCutShort,
        "RigDamaged" => RhytidStatus::InputRigDamaged,
        "UnsupportedFormat" => RhytidStatus::InputUnsupportedFormat,
        "UnsupportedVersion" => RhytidStatus::InputUnsupportedVersion,
        "OutOfRange" => RhytidStatus::InputOutOfRange,
        "TooLarge" => RhytidStatus::InputTooLarge,
        "Mismatch" => RhytidStatus::InputMismatch,
        "NotThere" => RhytidStatus::InputNotThere,
        "OutsideFolder" => RhytidStatus::InputOutsideFolder,
        "WouldOverwrite" => RhytidStatus::InputWouldOverwrite,
        "BadPath" => RhytidStatus::InputBadPath,
        "NoFrameRate" => RhytidStatus::InputNoFrameRate,
        "MissingSamples" => RhytidStatus::InputMissingSamples,
        "BadTopology" => RhytidStatus::InputBadTopology,
        "Empty" => RhytidStatus::InputEmpty,
        "RigLacks" => RhytidStatus::InputRigLacks,
        "Conflict" => RhytidStatus::InputConflict,
        "NoFit" => RhytidStatus::InputNoFit,
        "NotSolvable" => RhytidStatus::InputNotSolvable,
        "Network" => RhytidStatus::InputNetwork,
        _ => return None,
    })
}

/// Why a call fails: its status and its sentence.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) status: RhytidStatus,
    pub(crate) sentence: String,
}

/// The outcome within the library, before it becomes a status.
pub(crate) type Result<T = ()> = std::result::Result<T, Failure>;

impl Failure {
    /// A mistake in the arguments of a call.
    pub(crate) fn argument(sentence: impl Into<String>) -> Self {
        Self { status: RhytidStatus::Argument, sentence: sentence.into() }
    }

    /// The call needs a feature without which this library was built.
    #[cfg_attr(all(feature = "takes", feature = "vulkan"), expect(dead_code, reason = "nothing is left out"))]
    pub(crate) fn left_out(feature: &str) -> Self {
        let sentence =
            format!("this library was built without {feature}: build it with --features {feature}");
        Self { status: RhytidStatus::LeftOut, sentence }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match &error {
            Error::Input(input) => {
                of_input(InputErrorKind::name(input.kind())).unwrap_or(RhytidStatus::InputOther)
            }
            Error::Io { .. } => RhytidStatus::Io,
            Error::Device { kind, .. } => of_device(*kind).unwrap_or(RhytidStatus::DeviceDriver),
            Error::Cancelled => RhytidStatus::Cancelled,
            _ => RhytidStatus::Internal,
        };
        Self { status, sentence: error.to_string() }
    }
}

thread_local! {
    /// The sentence of the last error of this thread.
    static LAST: RefCell<CString> = RefCell::default();
}

/// The sentence of the last call on this thread that failed: what was found, what was expected, what to do.
/// It is UTF-8, and empty if no call has failed. A call that succeeds keeps it. It stays valid until the next
/// call on this thread that fails. Other threads have their own.
#[unsafe(no_mangle)]
pub extern "C" fn rhytid_last_error() -> *const c_char {
    // While a thread ends, its memory may be gone.
    LAST.try_with(|last| last.try_borrow().map_or(c"".as_ptr(), |last| last.as_ptr())).unwrap_or(c"".as_ptr())
}

/// A text for C, which ends at its first 0.
pub(crate) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
}

/// Runs a function of the interface. Keeps the sentence of its error, and turns a panic into an error.
pub(crate) fn guarded(run: impl FnOnce() -> Result) -> RhytidStatus {
    // A panic may leave an object half changed. Its documentation says that it can only be freed then.
    let failure = match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(())) => return RhytidStatus::Ok,
        Ok(Err(failure)) => failure,
        Err(panic) => {
            let said = panic.downcast_ref::<&str>().map(|said| (*said).to_owned());
            let said = said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
            Error::Internal(said).into()
        }
    };
    let _ = LAST.try_with(|last| {
        if let Ok(mut last) = last.try_borrow_mut() {
            *last = c_text(&failure.sentence);
        }
    });
    failure.status
}

/// Runs a function that only tells a fact, or frees something. `otherwise` stands for a fact that is not
/// there.
pub(crate) fn told<T>(otherwise: T, run: impl FnOnce() -> Option<T>) -> T {
    catch_unwind(AssertUnwindSafe(run)).ok().flatten().unwrap_or(otherwise)
}
