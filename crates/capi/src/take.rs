//! Clean takes: the positions of a rig's handles over time.
use crate::arguments::{array, free, give, out, path as path_of};
use crate::rig::{RhytidRig, rig_of};
use crate::status::{RhytidStatus, guarded, told};
use std::ffi::c_char;
use std::ptr::{null, null_mut};

/// The positions of a rig's handles over time. It never changes, so any number of threads may use it at the
/// same time. It keeps nothing of the rig.
pub struct RhytidTake {
    times: Vec<f64>,
    /// frames × H × 3.
    positions: Vec<f32>,
}

/// Reads a clean take (CSV) for a rig: columns time, LABEL_x, LABEL_y and LABEL_z, in seconds and mesh units.
/// A raw take of a capture system has to be cleaned first.
///
/// missing is a RhytidMissing. *take becomes the take, to be freed by rhytid_take_free(), or NULL after an
/// error: RHYTID_STATUS_IO, RHYTID_STATUS_INPUT_…, or RHYTID_STATUS_LEFT_OUT.
///
/// # Safety
/// `path` leads to a text that ends with 0, `rig` to a rig, and `take` to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_take_open(
    path: *const c_char,
    rig: *const RhytidRig,
    missing: u32,
    take: *mut *mut RhytidTake,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees all of them.
        let (take, path, rig) = unsafe { (out(take, "take", null_mut())?, path_of(path)?, rig_of(rig)?) };
        #[cfg(feature = "takes")]
        {
            let labels = &rig.rig.handles().labels;
            let missing = crate::enums::missing(missing)?;
            *take = give(read(rhytid_takes::take::read(&path, Some(labels), missing)?, labels)?);
            Ok(())
        }
        #[cfg(not(feature = "takes"))]
        {
            let _ = (take, path, rig, missing, give::<RhytidTake>);
            Err(crate::status::Failure::left_out("takes"))
        }
    })
}

/// As rhytid_take_open(), from the bytes of a take. The bytes may be freed or changed after the call.
///
/// # Safety
/// From `bytes` on there are `length` bytes, `rig` leads to a rig, and `take` to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_take_from_memory(
    bytes: *const u8,
    length: usize,
    rig: *const RhytidRig,
    missing: u32,
    take: *mut *mut RhytidTake,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees all of them.
        let (take, bytes, rig) =
            unsafe { (out(take, "take", null_mut())?, array(bytes, length, "bytes")?, rig_of(rig)?) };
        #[cfg(feature = "takes")]
        {
            let labels = &rig.rig.handles().labels;
            let missing = crate::enums::missing(missing)?;
            let decoded = rhytid_takes::take::decode(bytes, "a take in memory", Some(labels), missing)?;
            *take = give(read(decoded, labels)?);
            Ok(())
        }
        #[cfg(not(feature = "takes"))]
        {
            let _ = (take, bytes, rig, missing);
            Err(crate::status::Failure::left_out("takes"))
        }
    })
}

#[cfg(feature = "takes")]
fn read(take: rhytid::Take, labels: &[String]) -> crate::status::Result<RhytidTake> {
    Ok(RhytidTake { positions: take.handle_positions(labels)?, times: take.times })
}

/// Frees a take. NULL is ignored.
///
/// # Safety
/// `take` is null or a take that nobody uses any more, nor memory that it lent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_take_free(take: *mut RhytidTake) {
    // SAFETY: the caller guarantees this.
    unsafe { free(take) };
}

/// The number of frames. 0 for NULL.
///
/// # Safety
/// `take` is null or a live take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_take_frames(take: *const RhytidTake) -> usize {
    // SAFETY: the caller guarantees this.
    told(0, || Some(unsafe { take.as_ref() }?.times.len()))
}

/// The time of each frame, in seconds, rising. The memory is the take's. NULL for NULL.
///
/// # Safety
/// `take` is null or a live take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_take_times(take: *const RhytidTake) -> *const f64 {
    // SAFETY: the caller guarantees this.
    told(null(), || Some(unsafe { take.as_ref() }?.times.as_ptr()))
}

/// The positions of the handles, frames × H × 3, in the rig's order: what rhytid_animator_evaluate() takes.
/// The memory is the take's. NULL for NULL.
///
/// # Safety
/// `take` is null or a live take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_take_positions(take: *const RhytidTake) -> *const f32 {
    // SAFETY: the caller guarantees this.
    told(null(), || Some(unsafe { take.as_ref() }?.positions.as_ptr()))
}
