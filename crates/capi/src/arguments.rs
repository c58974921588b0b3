//! The arguments of C programs, checked as far as they can be.
use crate::status::{Failure, Result};
use std::ffi::{CStr, c_char};
use std::path::PathBuf;

/// The object behind a pointer. `made_by` is the function that makes such an object.
///
/// # Safety
/// `pointer` is null, or leads to a live object that nobody changes meanwhile.
pub(crate) unsafe fn object<'a, T>(pointer: *const T, name: &str, made_by: &str) -> Result<&'a T> {
    // SAFETY: the caller guarantees this.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(name, made_by))
}

/// As [`object`], to change it.
///
/// # Safety
/// `pointer` is null, or leads to a live object that nobody else uses meanwhile.
pub(crate) unsafe fn object_mut<'a, T>(pointer: *mut T, name: &str, made_by: &str) -> Result<&'a mut T> {
    // SAFETY: the caller guarantees this.
    unsafe { pointer.as_mut() }.ok_or_else(|| null(name, made_by))
}

fn null(name: &str, made_by: &str) -> Failure {
    Failure::argument(format!("{name} is null, expected what {made_by} gave"))
}

/// A place for a result, filled with `first`.
///
/// # Safety
/// `pointer` is null, or leads to memory for a `T` that nobody else uses meanwhile.
pub(crate) unsafe fn out<'a, T>(pointer: *mut T, name: &str, first: T) -> Result<&'a mut T> {
    if pointer.is_null() {
        return Err(Failure::argument(format!(
            "{name} is null, expected the address of a variable for the result"
        )));
    }
    // SAFETY: the caller guarantees the memory, which may hold no value yet.
    unsafe {
        pointer.write(first);
        Ok(&mut *pointer)
    }
}

/// `length` elements from `pointer` on, which may be null if there are none.
///
/// # Safety
/// From `pointer` on there are so many elements, or it is null. Nobody changes them meanwhile.
pub(crate) unsafe fn array<'a, T>(pointer: *const T, length: usize, name: &str) -> Result<&'a [T]> {
    check_array(pointer, length, name)?;
    if length == 0 {
        return Ok(&[]);
    }
    // SAFETY: the pointer is not null and aligned, the size is within bounds, and the caller guarantees the
    // rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// As [`array`], to write into it.
///
/// # Safety
/// From `pointer` on there are so many elements, or it is null. Nobody else uses them meanwhile.
pub(crate) unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize, name: &str) -> Result<&'a mut [T]> {
    check_array(pointer, length, name)?;
    if length == 0 {
        return Ok(&mut []);
    }
    // SAFETY: as in `array`.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

fn check_array<T>(pointer: *const T, length: usize, name: &str) -> Result {
    if length > 0 && pointer.is_null() {
        return Err(Failure::argument(format!("{name} is null, expected {length} elements")));
    }
    if length > 0 && !pointer.is_aligned() {
        let bytes = align_of::<T>();
        return Err(Failure::argument(format!(
            "{name} is at an odd address, expected a multiple of {bytes} bytes"
        )));
    }
    if length.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Failure::argument(format!("{name} has {length} elements, which no memory holds")));
    }
    Ok(())
}

/// A text. `None` for null.
///
/// # Safety
/// `pointer` is null, or leads to a text that ends with 0.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<Option<&'a str>> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller guarantees this.
    let text = unsafe { CStr::from_ptr(pointer) }.to_str();
    text.map(Some).map_err(|_| Failure::argument(format!("{name} is no UTF-8 text, expected one")))
}

/// A path. On Unix any bytes are one; elsewhere it is UTF-8.
///
/// # Safety
/// `pointer` is null, or leads to a text that ends with 0.
pub(crate) unsafe fn path(pointer: *const c_char) -> Result<PathBuf> {
    if pointer.is_null() {
        return Err(Failure::argument("path is null, expected the name of a file"));
    }
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        // SAFETY: the caller guarantees this.
        let bytes = unsafe { CStr::from_ptr(pointer) }.to_bytes();
        Ok(std::ffi::OsStr::from_bytes(bytes).into())
    }
    #[cfg(not(unix))]
    {
        // SAFETY: the caller guarantees this.
        Ok(unsafe { text(pointer, "path") }?.unwrap_or_default().into())
    }
}

/// Gives an object to the C program.
pub(crate) fn give<T>(object: T) -> *mut T {
    Box::into_raw(Box::new(object))
}

/// Frees what [`give`] gave. Null is ignored.
///
/// # Safety
/// `pointer` is null, or came from [`give`] and is not used any more.
pub(crate) unsafe fn free<T>(pointer: *mut T) {
    crate::status::told((), || {
        // SAFETY: the caller guarantees this.
        (!pointer.is_null()).then(|| drop(unsafe { Box::from_raw(pointer) }))
    });
}
