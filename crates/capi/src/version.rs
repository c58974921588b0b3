//! The versions of the library and of its binary interface.
use std::ffi::c_char;

/// The version of the binary interface that this header describes. It rises if a function, a structure or the
/// value of a constant changes or goes. It stays if something is only added. A program compares it with
/// rhytid_abi_version(), which is the library's.
pub const RHYTID_ABI_VERSION: u32 = 1;

/// The version of the binary interface of the library that is loaded: RHYTID_ABI_VERSION of its own header.
#[unsafe(no_mangle)]
pub extern "C" fn rhytid_abi_version() -> u32 {
    RHYTID_ABI_VERSION
}

/// The version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn rhytid_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
