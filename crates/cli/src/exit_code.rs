//! Exit codes: they say whose fault it is.

use rhytid::{DeviceErrorKind, Error};

/// All went well.
pub(crate) const DONE: u8 = 0;
/// The user's mistake, or something only the user can mend.
pub(crate) const USER: u8 = 2;
/// A fault of Rhytid's own, or of a device.
pub(crate) const OURS: u8 = 1;

/// Whose fault an error is.
pub(crate) fn from_error(error: &Error) -> u8 {
    match error {
        Error::Input(_) | Error::Io { .. } | Error::Cancelled => USER,
        Error::Device { kind: DeviceErrorKind::NotFound, .. } => USER,
        _ => OURS,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::ErrorKind;
    use std::path::Path;

    #[test]
    fn codes_tell_apart_whose_fault_it_is() {
        let device = |kind| Error::Device { kind, device: "cpu:0".into(), message: "gone".into() };
        assert_eq!(from_error(&Error::input("wrong")), 2);
        assert_eq!(from_error(&Error::Cancelled), 2);
        assert_eq!(from_error(&Error::io(Path::new("x"))(ErrorKind::NotFound.into())), 2);
        assert_eq!(from_error(&device(DeviceErrorKind::NotFound)), 2);
        assert_eq!(from_error(&device(DeviceErrorKind::Lost)), 1);
        assert_eq!(from_error(&Error::Internal("oops".into())), 1);
    }
}
